"""The directory of a result: summary, scene, tables, arrays and figures.

``result.nc`` is the result, see `photizon_cl.result.file`; all else there is made from it. While a
run is under way ``checkpoint.nc`` stands there as well, see `photizon_cl.run.checkpoint`.
"""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import TEMPORARY, in_any_locale, reason, replacing
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.errors import ResultError, show
from photizon_cl.result.file import read_file, read_scene, write_arrays
from photizon_cl.scene.model import same_stream
from photizon_cl.scene.writing import to_toml

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.scene.model import Scene

__all__ = [
    "ARRAYS",
    "CHECKPOINT",
    "REPORT",
    "open_directory",
    "prepare_target",
    "read",
    "save",
    "unfinished",
    "what_is_lost",
]

ARRAYS: Final = "result.nc"
"""The file that is the result."""
CHECKPOINT: Final = "checkpoint.nc"
"""The file of a run that is under way, or was killed."""
REPORT: Final = "report.html"
"""The file of the report, where it is one of ours."""


def _tally_file(effect: str) -> str:
    """Return the file of what an effect counts."""
    return f"tally-{effect}.csv"


_TABLES: Final = ("ledger.csv", "detectors.csv", *(_tally_file(effect.name) for effect in EFFECTS))
_OURS: Final = frozenset(
    {
        "summary.json",
        "scene.toml",
        ARRAYS,
        CHECKPOINT,
        "figures",
        "recipe.txt",
        *_TABLES,
    }
)


def _check_target(path: str | os.PathLike[str], result: Estimates) -> tuple[Path, Estimates | None]:
    """Return the directory that a result may be written into, and the result that is there.

    Makes nothing. What is there is read this once: it may be large.

    Parameters
    ----------
    path : str or path
        The directory.
    result : Estimates
        What is to be written there; its own checkpoint may be there.

    Raises
    ------
    ResultError
        Where it is a file, or a directory that holds something and no result, or one with the
        checkpoint of another run.
    """
    folder = Path(os.fsdecode(path))
    shown = show(str(folder))
    try:
        if folder.is_symlink() and not folder.exists():
            raise ResultError(f"{shown} is a link that leads nowhere: give another directory")
        if not folder.exists():
            return folder, None
        if not folder.is_dir():
            raise ResultError(f"{shown} is a file: give a directory to write the result into")
        there = {e.name for e in folder.iterdir() if not e.name.startswith(TEMPORARY)}
    except (OSError, ValueError) as error:
        if isinstance(error, ResultError):
            raise
        raise ResultError(f"{shown} cannot be used: {reason(error)}") from None
    others = there - _OURS if ARRAYS not in there else set()
    if REPORT in others and _is_report(folder / REPORT):
        others.remove(REPORT)
    if others:
        raise ResultError(
            f"{shown} holds files and no photizon result: give a new or empty directory, so that "
            "nothing is overwritten"
        )
    # something else of that name is not ours to replace
    old = read(folder) if ARRAYS in there else None
    if CHECKPOINT in there:
        _check_unfinished(folder, result)
    return folder, old


def _check_unfinished(folder: Path, result: Estimates) -> None:
    """Refuse to lose the batches of a run that was killed."""
    left = read_file(folder / CHECKPOINT)
    own = same_stream(left.scene, result.scene) and left.batches <= result.batches
    if left.batches and not own:
        raise ResultError(
            f"{show(str(folder))} holds an unfinished run of {left.scene.name!r} with "
            f"{left.batches} batches: `photizon resume` goes on with it; to start anew, give "
            f"another directory or remove {CHECKPOINT} there"
        )


def _check_longer(folder: Path, old: Estimates, result: Estimates) -> None:
    """Refuse to lose batches of the very stream that is written."""
    # another engine's batches of the stream may have other bits: the new ones may replace them
    same = same_stream(old.scene, result.scene) and old.info.engine == result.info.engine
    if same and old.batches > result.batches:
        # what is kept holds the batches of this run's checkpoint too: nothing is left unfinished
        (folder / CHECKPOINT).unlink(missing_ok=True)
        raise ResultError(
            f"{show(str(folder))} holds {old.batches} batches of this run, more than these "
            f"{result.batches}, and is kept: give another directory, or remove {ARRAYS} there"
        )


def what_is_lost(path: str | os.PathLike[str], scene: Scene) -> str:
    """Return which other run's finished result a directory holds, empty where it holds none.

    Parameters
    ----------
    path : str or path
        The directory; it need not be there.
    scene : Scene
        What will be run, as run.

    Raises
    ------
    ResultError
        Where what is there is damaged or no result.
    """
    folder = Path(os.fsdecode(path))
    try:
        if not (folder / ARRAYS).is_file():
            return ""
    except (OSError, ValueError):  # what is wrong with the path, `prepare_target` tells
        return ""
    there = read_scene(folder / ARRAYS)
    if same_stream(there, scene):
        return ""
    found, mine = (f"{s.name!r} with seed {s.run.seed}" for s in (there, scene))
    return f"{found}, of other settings or an older scene" if found == mine else found


def prepare_target(path: str | os.PathLike[str], result: Estimates) -> Path:
    """Make the directory that a result will be written into, and see that it can be.

    Raises
    ------
    ResultError
        Where it is a file, or a directory that holds something and no result, or one with the
        checkpoint of another run, or nothing can be written there.
    """
    folder, _ = _check_target(path, result)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ResultError(
            f"{show(str(folder))} cannot be written: {reason(error)}; give another directory"
        ) from None
    return folder


def save(
    result: Estimates,
    path: str | os.PathLike[str],
    *,
    figures: bool = True,
    formats: str | Sequence[str] = ("png",),
) -> None:
    """Write a result, see `photizon_cl.Result.save`."""
    from photizon_cl.result.csv_tables import detectors_csv, ledger_csv, tally_csv
    from photizon_cl.result.recipe import RecipeText

    folder, old = _check_target(path, result)
    stale: set[str] = set()
    if old is not None:
        _check_longer(folder, old, result)
        stale = _figures_of(old, folder / "figures")
        del old  # two large results at a time are one too many
    if figures:
        from photizon_cl.views.figures import figure_names

        figure_names(result, formats)  # an unknown format is told before anything is written
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(folder / "scene.toml") as temporary:
            temporary.write_text(to_toml(result.scene), encoding="utf-8")
        with replacing(folder / ARRAYS) as temporary:
            write_arrays(result, temporary)
            # never beside another run's arrays
            for name in ("summary.json", "recipe.txt", *_TABLES):
                (folder / name).unlink(missing_ok=True)
        (folder / CHECKPOINT).unlink(missing_ok=True)  # the result holds as much and more
        with replacing(folder / "recipe.txt") as temporary:
            temporary.write_text(RecipeText.of(result).token + "\n", encoding="ascii")
        with replacing(folder / "ledger.csv") as temporary:
            temporary.write_text(ledger_csv(result), encoding="utf-8", newline="")
        if result.detectors:
            with replacing(folder / "detectors.csv") as temporary:
                temporary.write_text(detectors_csv(result), encoding="utf-8", newline="")
        for effect, cells in result.tallies.items():
            with replacing(folder / _tally_file(effect)) as temporary:
                temporary.write_text(tally_csv(cells), encoding="utf-8", newline="")
        with replacing(folder / "summary.json") as temporary:
            text = json.dumps(result.summary(), indent=2, ensure_ascii=False, allow_nan=False)
            temporary.write_text(text + "\n", encoding="utf-8")
        if _is_report(folder / REPORT):  # of the result before; nobody else's page
            (folder / REPORT).unlink()
        drawn = _draw(result, folder / "figures", formats) if figures else set()
        for name in stale - drawn:
            (folder / "figures" / in_any_locale(name)).unlink(missing_ok=True)
    except OSError as error:
        raise ResultError(f"{show(str(folder))} cannot be written: {reason(error)}") from error


def _figures_of(result: Estimates, folder: Path) -> set[str]:
    """Return the names that the figures of a result have, where there may be some."""
    if not folder.is_dir():
        return set()
    from photizon_cl.views.figures import FORMATS, figure_names  # matplotlib

    return set(figure_names(result, FORMATS))


def _is_report(page: Path) -> bool:
    """Say whether a file is there and one of our reports."""
    if not page.is_file():
        return False
    from photizon_cl.views.report.writing import is_report

    return is_report(page)


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


def open_directory(path: str | os.PathLike[str]) -> Estimates:
    """Return what a result says that was saved, see `photizon_cl.open_result`."""
    given = Path(os.fsdecode(path))
    left = unfinished(given) if given.name != ARRAYS else None
    if left is None:
        return read(given)
    if (given / ARRAYS).is_file():
        found = read(given)
        if same_stream(found.scene, left.scene):
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
            what = f"holds no {ARRAYS}" if given.is_dir() else "is not there"
            raise ResultError(
                f"{shown} {what}: give the directory that a run wrote, or the {ARRAYS} in it"
            )
    except (OSError, ValueError) as error:
        if isinstance(error, ResultError):
            raise
        raise ResultError(f"{shown} cannot be read: {reason(error)}") from None
    return read_file(file)
