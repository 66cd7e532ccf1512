"""Which files of a directory were written here: only these may be replaced or removed.

A file of a name that this tool uses may be anybody's. It is ours where it says what a result beside
it says: the result in ``result.nc`` or, where that was removed, the summary. What was changed since
by hand is no longer ours.
"""

from __future__ import annotations

import csv
import io
import json
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.errors import PhotizonError
from photizon_cl.result.csv_tables import (
    detectors_csv,
    ledger_csv,
    paths_csv,
    spectrum_csv,
    tally_csv,
)
from photizon_cl.result.estimates import RESULT_SCHEMA
from photizon_cl.result.file import read_scene_text
from photizon_cl.result.recipe import RecipeText
from photizon_cl.scene.files import load
from photizon_cl.scene.writing import to_toml

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from photizon_cl.result.estimates import Estimates

__all__ = [
    "ARRAYS",
    "CHECKPOINT",
    "DERIVED",
    "FIGURES",
    "REPORT",
    "is_figure",
    "is_report",
    "not_ours",
    "tally_file",
]

ARRAYS: Final = "result.nc"
"""The file that is the result."""
CHECKPOINT: Final = "checkpoint.nc"
"""The file of a run that is under way, or was killed."""
REPORT: Final = "report.html"
"""The file of the report, where it is one of ours."""
FIGURES: Final = "figures"
"""The directory of the figures."""


def tally_file(effect: str) -> str:
    """Return the file of what an effect counts."""
    return f"tally-{effect}.csv"


_HEADS: Final = {
    "ledger.csv": "row,value_W,sigma_W,share",
    "detectors.csv": "detector,generation,value_W,sigma_W,count",
    "paths.csv": "detector,rank,sequence,value_W",
    "spectrum.csv": "what,name,generation,wavelength_nm",
    **{tally_file(effect.name): "label,value_" for effect in EFFECTS},
}
"""The tables, and how each begins."""
DERIVED: Final = ("scene.toml", "summary.json", "recipe.txt", *_HEADS)
"""Files that are made from the result beside them."""


def not_ours(folder: Path, old: Estimates | None, figures: Iterable[str]) -> list[str]:
    """Return the names of files there that a result would replace and that are not ours.

    Parameters
    ----------
    folder : Path
        An existing directory.
    old : Estimates or None
        The result in its ``result.nc``.
    figures : iterable of str
        Names of the figures that would be written or removed.
    """
    summary = _summary(folder / "summary.json", old)
    found = [
        name for name in DERIVED if _there(folder / name) and not _ours(folder / name, old, summary)
    ]
    drawn = folder / FIGURES
    found += [
        f"{FIGURES}/{name}"
        for name in sorted(set(figures))
        if _there(drawn / name) and not is_figure(drawn / name)
    ]
    if _there(drawn) and not drawn.is_dir():
        found.append(FIGURES)
    return found


def is_figure(path: Path) -> bool:
    """Say whether a file is there and one of our figures."""
    if not _there(path):
        return False
    from photizon_cl.views.figures.style import is_figure as marked

    return _told(lambda: path.is_file() and marked(path))


def is_report(page: Path) -> bool:
    """Say whether a file is there and one of our reports."""
    if not _there(page):
        return False
    from photizon_cl.views.report.writing import is_report as marked

    return _told(lambda: page.is_file() and marked(page))


def _there(path: Path) -> bool:
    return path.is_symlink() or path.exists()


def _told(question: Callable[[], bool]) -> bool:
    """Answer a question about a file; what cannot be read, or is damaged, is not ours."""
    try:
        return question()
    except (OSError, ValueError, KeyError, TypeError, RecursionError, StopIteration, PhotizonError):
        return False


def _ours(path: Path, old: Estimates | None, summary: dict[str, Any]) -> bool:
    if path.name == "summary.json":
        return bool(summary)
    if path.name == "scene.toml":
        return _told(lambda: _is_scene(path, old, summary))
    if path.name == "recipe.txt":
        digest = summary.get("tally_digest", "") if old is None else old.tally_digest
        return _told(lambda: RecipeText.read(path.read_text("ascii")).tally_digest == digest)
    return _told(lambda: _is_table(path, old, summary))


def _summary(path: Path, old: Estimates | None) -> dict[str, Any]:
    """Return the summary in a file, empty where it is none of ours."""
    try:
        text = path.read_text(encoding="utf-8")
        content = json.loads(text)
        same = old is None or content["tally_digest"] == old.tally_digest
        untouched = json.dumps(content, indent=2, ensure_ascii=False) + "\n" == text
        ours = content["schema"] == RESULT_SCHEMA and "scene_digest" in content
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {}
    return content if same and untouched and ours else {}


def _is_scene(path: Path, old: Estimates | None, summary: dict[str, Any]) -> bool:
    text = path.read_text(encoding="utf-8")
    if old is not None:  # another version may have written the same scene in other words
        return text in (to_toml(old.scene), read_scene_text(path.parent / ARRAYS))
    scene = load(path)
    return scene.digest() == summary.get("scene_digest") and to_toml(scene) == text


def _is_table(path: Path, old: Estimates | None, summary: dict[str, Any]) -> bool:
    with path.open(encoding="utf-8", newline="") as file:
        text = file.read()
    if old is None:  # nothing to compare it with
        return bool(summary) and text.startswith(_HEADS[path.name])
    return _cells(text) == _cells(_table(path.name, old))


def _table(name: str, result: Estimates) -> str:
    if name == "ledger.csv":
        return ledger_csv(result)
    if name == "detectors.csv":
        return detectors_csv(result)
    if name == "paths.csv":
        return paths_csv(result)
    if name == "spectrum.csv":
        return spectrum_csv(result)
    return next(tally_csv(cells) for e, cells in result.tallies.items() if tally_file(e) == name)


def _cells(text: str) -> list[list[str]]:
    """Return a table's cells; earlier versions wrote no apostrophe before some of them."""
    return [[cell.removeprefix("'") for cell in row] for row in csv.reader(io.StringIO(text))]
