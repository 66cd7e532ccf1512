"""The directory of a result: summary, scene, tables, arrays and figures.

``result.nc`` is the result, see `photizon_cl.result.file`; all else there is made from it. While a
run is under way ``checkpoint.nc`` stands there as well, see `photizon_cl.run.checkpoint`.
"""

from __future__ import annotations

import json
import os
import time
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from photizon_cl.atomic import in_any_locale, reason, replacing
from photizon_cl.errors import ResultError, RunWarning, show
from photizon_cl.result.engine import engine_digest
from photizon_cl.result.file import read_file, read_made_by, read_scene, write_arrays
from photizon_cl.result.sweep_file import SWEEP_FILE
from photizon_cl.run.memory import check_room
from photizon_cl.run.ours import (
    ARRAYS,
    CHECKPOINT,
    DERIVED,
    FIGURES,
    REPORT,
    is_figure,
    is_report,
    not_ours,
    tally_file,
)
from photizon_cl.run.target import check_target, held, refuse
from photizon_cl.scene.model import same_stream
from photizon_cl.scene.writing import to_toml

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.scene.model import Scene

__all__ = [
    "ARRAYS",
    "CHECKPOINT",
    "REPORT",
    "check_there",
    "open_directory",
    "read",
    "save",
    "steady",
    "unfinished",
    "what_is_lost",
]

_T = TypeVar("_T")
_FREE: Final = "free some and save it again"
_LATER: Final = "`photizon report` draws them later, where more is free"
_TRIES: Final = 40
"""Times that a directory is read again which changed meanwhile."""


# -- writing -------------------------------------------------------------------------------------


def check_there(folder: Path, result: Estimates) -> Estimates | None:
    """Return the result in a directory that may be replaced by another one; None without one.

    The directory is held by the caller. What is there is read this once: it may be large.

    Parameters
    ----------
    folder : Path
        An existing directory.
    result : Estimates
        What is to be written there; its own checkpoint may be there.

    Raises
    ------
    ResultError
        Where files of these names are not ours, or there is the checkpoint of another run.
    """
    # something else of that name is not ours to replace
    old = read(folder) if os.path.lexists(folder / ARRAYS) else None
    if os.path.lexists(folder / CHECKPOINT):
        _check_unfinished(folder, result)
    figures = _figures(result) if os.path.lexists(folder / FIGURES) else []
    refuse(folder, not_ours(folder, old, figures))
    return old


def _figures(result: Estimates) -> list[str]:
    """Return the names of all figures that a result may come to have."""
    from photizon_cl.views.figures.style import FORMATS
    from photizon_cl.views.figures.table import figure_names, possible_names

    if not result.batches:  # of a run that begins: it has no numbers yet
        return possible_names(element.name for element in result.scene.element)
    return figure_names(result, FORMATS)


def _check_unfinished(folder: Path, result: Estimates) -> None:
    """Refuse to lose the batches of a run that was killed."""
    left = read_file(folder / CHECKPOINT)
    own = left.stream == result.stream and left.batches <= result.batches
    if left.batches and not own:
        raise ResultError(
            f"{show(str(folder))} holds an unfinished run of {left.scene.name!r} with "
            f"{left.batches} batches: `photizon resume` goes on with it; to start anew, give "
            f"another directory or remove {CHECKPOINT} there"
        )


def _check_longer(folder: Path, old: Estimates, result: Estimates) -> None:
    """Refuse to lose batches of the very stream that is written."""
    # another engine's batches of the stream may have other bits: the new ones may replace them
    same = old.stream == result.stream and old.info.engine == result.info.engine
    if same and old.batches > result.batches:
        # what is kept holds the batches of this run's checkpoint too: nothing is left unfinished
        (folder / CHECKPOINT).unlink(missing_ok=True)
        raise ResultError(
            f"{show(str(folder))} holds {old.batches} batches of this run, more than these "
            f"{result.batches}, and is kept: give another directory, or remove {ARRAYS} there"
        )


def what_is_lost(path: str | os.PathLike[str], scene: Scene, precision: str) -> str:
    """Return which other run's finished result a directory holds, empty where it holds none.

    Parameters
    ----------
    path : str or path
        The directory; it need not be there.
    scene : Scene
        What will be run, as run.
    precision : str
        In which mode.

    Raises
    ------
    ResultError
        Where what is there is damaged or no result.
    """
    folder = Path(os.fsdecode(path))
    try:
        if not (folder / ARRAYS).is_file():
            return ""
    except (OSError, ValueError):  # what is wrong with the path, `check_target` tells
        return ""
    there, (engine, mode) = steady(
        folder, lambda: (read_scene(folder / ARRAYS), read_made_by(folder / ARRAYS))
    )
    return _other(there, engine, scene, "" if mode == precision else mode)


def _other(there: Scene, engine: str, scene: Scene, mode: str) -> str:
    """Return what a result is that is none of a scene by this engine, empty where it is one.

    `mode` is its precision, where that is another one.
    """
    if same_stream(there, scene):
        if mode:
            return f"{there.name!r} in {mode}"
        alike = engine in ("", engine_digest())
        return "" if alike else f"{there.name!r} by another version of the engine"
    found, mine = (f"{s.name!r} with seed {s.run.seed}" for s in (there, scene))
    return f"{found}, of other settings or an older scene" if found == mine else found


def save(
    result: Estimates,
    path: str | os.PathLike[str],
    *,
    figures: bool = True,
    formats: str | Sequence[str] = ("png",),
    replace: bool = False,
) -> None:
    """Write a result, see `photizon_cl.Result.save`."""
    shown = show(os.fsdecode(path))
    check_room(result, f"{shown} cannot be written: the result", _FREE, saved=True)
    if figures:
        from photizon_cl.views.figures import figure_names

        figure_names(result, formats)  # an unknown format is told before anything is written
    folder = check_target(path)
    with held(folder):
        stale: set[str] = set()
        old = check_there(folder, result)
        if old is not None:
            mode = "" if old.info.precision == result.info.precision else old.info.precision
            lost = "" if replace else _other(old.scene, old.info.engine, result.scene, mode)
            if lost:
                raise ResultError(
                    f"{show(str(folder))} holds the result of {lost}, and is kept: give another "
                    "directory, or replace=True"
                )
            _check_longer(folder, old, result)
            stale = _figures_of(old, folder / FIGURES)
            del old  # two large results at a time are one too many
        try:
            _write_all(result, folder)
            if is_report(folder / REPORT):  # of the result before; nobody else's page
                (folder / REPORT).unlink()
            drawn = set()
            if figures and _can_be_drawn(result, shown):
                drawn = _draw(result, folder / FIGURES, formats)
            for name in stale - drawn:
                file = folder / FIGURES / in_any_locale(name)
                if is_figure(file):
                    file.unlink(missing_ok=True)
        except OSError as error:
            raise ResultError(f"{show(str(folder))} cannot be written: {reason(error)}") from error
        except MemoryError as error:
            raise ResultError(
                f"{show(str(folder))} cannot be written: no memory is left for its arrays and "
                "figures; where result.nc is there, `photizon report` draws them later"
            ) from error


def _can_be_drawn(result: Estimates, shown: str) -> bool:
    """Say whether there is room for drawing, and warn where not: the result itself is there."""
    try:
        check_room(result, "drawing them", _LATER, drawn=True)
    except ResultError as error:
        warnings.warn(f"no figures are drawn for {shown}: {error}", RunWarning, stacklevel=4)
        return False
    return True


def _figures_of(result: Estimates, folder: Path) -> set[str]:
    """Return the names that the figures of a result have, where there may be some."""
    if not folder.is_dir():
        return set()
    from photizon_cl.views.figures import FORMATS, figure_names  # matplotlib

    return set(figure_names(result, FORMATS))


def _write_all(result: Estimates, folder: Path) -> None:
    """Write every file but the figures; what is made from a result is never beside another's."""
    from photizon_cl.result.csv_tables import (
        detectors_csv,
        ledger_csv,
        paths_csv,
        spectrum_csv,
        tally_csv,
    )
    from photizon_cl.result.recipe import RecipeText

    with replacing(folder / ARRAYS) as temporary:
        write_arrays(result, temporary)
        for name in DERIVED:
            (folder / name).unlink(missing_ok=True)
    (folder / CHECKPOINT).unlink(missing_ok=True)  # the result holds as much and more
    with replacing(folder / "scene.toml") as temporary:
        temporary.write_text(to_toml(result.scene), encoding="utf-8")
    with replacing(folder / "recipe.txt") as temporary:
        temporary.write_text(RecipeText.of(result).token + "\n", encoding="ascii")
    tables = {"ledger.csv": ledger_csv(result)}
    if result.detectors:
        tables["detectors.csv"] = detectors_csv(result)
    if result.compiled.layout.most_paths:
        tables["paths.csv"] = paths_csv(result)
    if result.scene.spectrum is not None:
        tables["spectrum.csv"] = spectrum_csv(result)
    tables |= {tally_file(effect): tally_csv(cells) for effect, cells in result.tallies.items()}
    for name, text in tables.items():
        with replacing(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="")
    with replacing(folder / "summary.json") as temporary:
        text = json.dumps(result.summary(), indent=2, ensure_ascii=False, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")


def _draw(result: Estimates, folder: Path, formats: str | Sequence[str]) -> set[str]:
    from photizon_cl.views.figures import draw_all

    folder.mkdir(exist_ok=True)
    names = set()
    for name, draw in draw_all(result, formats):
        with replacing(folder / in_any_locale(name)) as temporary:
            draw(temporary)
        names.add(name)
    return names


# -- reading -------------------------------------------------------------------------------------


def steady(path: str | os.PathLike[str], look: Callable[[], _T]) -> _T:
    """Read a directory that a run may be writing to: again, where it changed and gave an error.

    Each file is replaced in one step, but a reader opens several, and one more than once.

    Parameters
    ----------
    path : str or path
        The directory, or a file in it.
    look : callable
        What reads it.
    """
    given = Path(os.fsdecode(path))
    for _ in range(_TRIES):
        before = _marks(given)
        try:
            return look()
        except ResultError:
            if _marks(given) == before:
                raise
        time.sleep(0.01)
    return look()


def _marks(given: Path) -> list[tuple[int, int, int] | None]:
    """Return what changes where a file of a result is replaced."""
    marks: list[tuple[int, int, int] | None] = []
    for file in (given, given / ARRAYS, given / CHECKPOINT):
        try:
            found = file.stat()
            marks.append((found.st_ino, found.st_size, found.st_mtime_ns))
        except (OSError, ValueError):
            marks.append(None)
    return marks


def open_directory(path: str | os.PathLike[str]) -> Estimates:
    """Return what a result says that was saved, see `photizon_cl.open_result`."""
    opened = steady(path, lambda: _open_directory(path))
    if not opened.batches:
        raise ResultError(
            f"{show(os.fspath(path))}: found no batch, expected one at least: the run that wrote "
            "it had made none yet, and photizon resume goes on with it"
        )
    return opened


def _open_directory(path: str | os.PathLike[str]) -> Estimates:
    given = Path(os.fsdecode(path))
    left = unfinished(given) if given.name != ARRAYS else None
    if left is None:
        return read(given)
    check_room(left, show(str(given)))
    if (given / ARRAYS).is_file():
        found = read(given)
        if found.stream == left.stream:
            return left if left.batches > found.batches else found
        raise ResultError(
            f"{show(str(given))} holds a result of {found.scene.name!r} and an unfinished run of "
            f"{left.scene.name!r} (seed {left.scene.run.seed}) over it: `photizon resume` ends the "
            f"run; the {ARRAYS} in it is the older result"
        )
    if not left.batches:
        raise ResultError(
            f"{show(str(given))} holds a run that was ended before its first batch: `photizon "
            "resume` starts it again"
        )
    return left


def unfinished(path: str | os.PathLike[str]) -> Estimates | None:
    """Return what the checkpoint in a directory holds, perhaps no batch; None without one.

    Raises
    ------
    ResultError
        Where it is damaged.
    """
    file = Path(os.fsdecode(path)) / CHECKPOINT
    try:
        there = file.is_file()
    except (OSError, ValueError):  # what is wrong with the path, `read` tells
        there = False
    return read_file(file) if there else None


def read(path: str | os.PathLike[str]) -> Estimates:
    """Return the result in a directory, or in the ``result.nc`` of one."""
    given = Path(os.fsdecode(path))
    shown = show(str(given))
    try:
        file = given / ARRAYS if given.is_dir() else given
        if not file.is_file():
            if (given / SWEEP_FILE).is_file():
                raise ResultError(
                    f"{shown} holds a sweep: pz.open_sweep opens it, and each of the directories "
                    "in its points holds the result of one"
                )
            what = f"holds no {ARRAYS}" if given.is_dir() else "is not there"
            raise ResultError(
                f"{shown} {what}: give the directory that a run wrote, or the {ARRAYS} in it"
            )
    except (OSError, ValueError) as error:
        if isinstance(error, ResultError):
            raise
        raise ResultError(f"{shown} cannot be read: {reason(error)}") from None
    found = read_file(file)
    check_room(found, shown)
    return found
