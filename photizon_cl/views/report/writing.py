"""The report on disk: written in one step, never over a file that is no report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import in_any_locale, reason, replacing, sweep
from photizon_cl.errors import ArgumentError, show
from photizon_cl.result.cost_file import COST_NUMBERS, read_study
from photizon_cl.result.recipe import RecipeText
from photizon_cl.views.report import figures as drawing
from photizon_cl.views.report.page import GENERATOR, render

if TYPE_CHECKING:
    from pathlib import Path

    from photizon_cl.result.cost import CostStudy
    from photizon_cl.result.estimates import Estimates

__all__ = ["Written", "beside", "check_page", "is_report", "write_page", "write_text"]

_MOST_RECIPE: Final = 100_000  # characters of a token that a page shows


@dataclass(frozen=True)
class Written:
    """What `write_page` wrote.

    Parameters
    ----------
    page : Path
        The page.
    figures : tuple of Path
        PNG figures that were missing beside the result.
    warnings : tuple of str
        What could not be done, one sentence each.
    """

    page: Path
    figures: tuple[Path, ...]
    warnings: tuple[str, ...]


def write_page(result: Estimates, home: Path, page: Path) -> Written:
    """Write the report of a result, and those of its PNG figures that are missing beside it.

    Parameters
    ----------
    result : Estimates
        The result.
    home : Path
        The directory in which it was saved.
    page : Path
        The file.

    Raises
    ------
    ArgumentError
        Where the file cannot be written, or is something else than a report.
    """
    check_page(page)
    there = _names(home / "figures")
    figures = drawing.draw(result, there)
    study, remarks = beside(home)
    if study is not None:
        figures = drawing.with_cost(figures, study)
    made, warnings = _complete(home / "figures", figures.files)
    warnings += remarks
    warnings += [
        f"the figure {show(name)} could not be drawn: {why}" for name, why in figures.failed
    ]
    write_text(page, render(result, figures, RecipeText.of(result).token[:_MOST_RECIPE], study))
    return Written(page, tuple(made), tuple(warnings))


def write_text(page: Path, text: str) -> None:
    """Write a page in one step.

    Raises
    ------
    ArgumentError
        Where it cannot be written.
    """
    try:
        sweep(page.parent, held=False)
        with replacing(page) as temporary:
            temporary.write_text(text, encoding="utf-8", errors="replace")
    except OSError as error:
        raise ArgumentError(
            f"{show(str(page))} cannot be written ({reason(error)}): give another file with --out"
        ) from None


def beside(home: Path) -> tuple[CostStudy | None, list[str]]:
    """Return the cost study beside a result, and what is to be said where it is none."""
    path = home / COST_NUMBERS
    try:
        return (read_study(path) if path.is_file() else None), []
    except (OSError, ValueError) as error:
        return None, [f"{show(str(path))} is left out of the report: {error}"]


def is_report(page: Path) -> bool:
    """Say whether a file is a report that was written here."""
    with page.open("rb") as file:
        return f'content="{GENERATOR}'.encode() in file.read(2000)


def check_page(page: Path) -> None:
    """See that a page may be written: a new file, or a report that is replaced."""
    shown = show(str(page))
    try:
        if page.is_dir():
            raise ArgumentError(f"--out: {shown} is a directory: give the name of a file in it")
        if not page.parent.is_dir():
            raise ArgumentError(
                f"--out: the directory of {shown} does not exist: make it, or give another"
            )
        if not page.exists():
            return
        if page.is_file() and (not page.stat().st_size or is_report(page)):
            return
    except (OSError, ValueError) as error:
        if isinstance(error, ArgumentError):
            raise
        raise ArgumentError(f"--out: {shown} cannot be used ({reason(error)})") from None
    raise ArgumentError(
        f"{shown} is there and no photizon report, and is not replaced: "
        "give another file with --out, or move it away"
    )


def _names(folder: Path) -> frozenset[str]:
    try:
        return frozenset(entry.name for entry in folder.iterdir())
    except OSError:
        return frozenset()


def _complete(folder: Path, files: dict[str, bytes]) -> tuple[list[Path], list[str]]:
    """Write those figures that are missing; the page has them all, so a failure is a remark."""
    made: list[Path] = []
    try:
        folder.mkdir(exist_ok=True)
        for name, png in files.items():
            file = folder / in_any_locale(name)
            if file.exists():
                continue
            with replacing(file) as temporary:
                temporary.write_bytes(png)
            made.append(file)
    except OSError as error:
        return made, [f"figures cannot be written to {show(str(folder))} ({reason(error)})"]
    return made, []
