"""The report on disk: written in one step, never over a file that is no report."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from photizon_cl.atomic import reason, replacing
from photizon_cl.errors import ArgumentError, ResultError, show

__all__ = ["Written", "write_report"]

NAME: Final = "report.html"
_AGAIN: Final = "run the scene again, into another directory, to have a whole one"
_MOST_RECIPE: Final = 100_000  # characters of a token that a page shows


@dataclass(frozen=True)
class Written:
    """What `write_report` wrote.

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


def write_report(
    folder: str | os.PathLike[str], out: str | os.PathLike[str] | None = None
) -> Written:
    """Write the report of a saved result, and those of its PNG figures that are missing.

    Parameters
    ----------
    folder : str or path
        The directory that a run wrote, or the ``result.nc`` in it.
    out : str or path, optional
        The file; default ``report.html`` in the directory of the result.

    Raises
    ------
    ResultError
        Where there is no result, or it is damaged.
    ArgumentError
        Where the file cannot be written, or is something else than a report.
    """
    from photizon_cl.result.directory import ARRAYS
    from photizon_cl.result.result import open_result
    from photizon_cl.views.report import figures as drawing
    from photizon_cl.views.report.page import render

    given = Path(os.fsdecode(folder))
    try:
        result = open_result(given)
    except ResultError as error:
        if given.is_file() or (given / ARRAYS).is_file():  # there, and not whole
            raise ResultError(f"{error}; {_AGAIN}") from error
        raise
    home = given if given.is_dir() else given.parent
    page = home / NAME if out is None else Path(os.fsdecode(out))
    _check_page(page)

    there = _names(home / "figures")
    figures = drawing.draw(result, there)
    made, warnings = _complete(home / "figures", figures.files)
    warnings += [
        f"the figure {show(name)} could not be drawn: {why}" for name, why in figures.failed
    ]
    text = render(result, figures, result.recipe[:_MOST_RECIPE])
    try:
        with replacing(page) as temporary:
            temporary.write_text(text, encoding="utf-8", errors="replace")
    except OSError as error:
        raise ArgumentError(
            f"{show(str(page))} cannot be written ({reason(error)}): give another file with --out"
        ) from None
    return Written(page, tuple(made), tuple(warnings))


def is_report(page: Path) -> bool:
    """Say whether a file is a report that was written here."""
    from photizon_cl.views.report.page import GENERATOR

    with page.open("rb") as file:
        return f'content="{GENERATOR}'.encode() in file.read(2000)


def _check_page(page: Path) -> None:
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
            if (folder / name).exists():
                continue
            with replacing(folder / name) as temporary:
                temporary.write_bytes(png)
            made.append(folder / name)
    except OSError as error:
        return made, [f"figures cannot be written to {show(str(folder))} ({reason(error)})"]
    return made, []
