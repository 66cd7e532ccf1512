"""A cost study as a file: ``cost.json``."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.result.cost import COST_SCHEMA, TARGETS, CostSetting, CostStudy, TargetTime

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["COST_FIGURE", "COST_NUMBERS", "is_study", "read_study", "study_text"]

COST_NUMBERS: Final = "cost.json"
COST_FIGURE: Final = "cost.png"

_MOST: Final = 1 << 24
"""Bytes of a file that is read; a study has some tens of thousands."""
_SETTING: Final = {
    "name": str, "knob": str, "value": object, "written": str, "batches": int, "rays": int,
    "seconds": float, "pace_error": float, "build_seconds": float, "interactions_per_s": float,
    "estimate": float, "sigma": None, "bias": None, "bias_sigma": None, "paired": bool,
    "bias_batches": int, "closure": float,
}  # fmt: skip
"""Keys of a setting and their types; None: a number or none."""


def study_text(study: CostStudy) -> str:
    """Return a study as the text of its file."""
    return json.dumps(study.summary(), indent=2, ensure_ascii=True, allow_nan=False) + "\n"


def _tables(path: Path) -> dict[str, Any]:
    if path.stat().st_size > _MOST:
        raise ValueError("it is too large")
    found = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(found, dict) or found.get("schema") != COST_SCHEMA:
        raise ValueError(f"it has not the schema {COST_SCHEMA}")
    return found


def is_study(path: Path) -> bool:
    """Say whether a file is a cost study."""
    try:
        _tables(path)
    except (ValueError, RecursionError):
        return False
    return True


def read_study(path: Path) -> CostStudy:
    """Return the study that a file holds.

    Raises
    ------
    OSError
        Where it cannot be read.
    ValueError
        Where it holds none.
    """
    try:
        found = _tables(path)
        rows = tuple(_setting(row) for row in found["settings"])
        study = CostStudy(
            **{
                key: _is(found[key], str, key)
                for key in ("scene", "scene_digest", "device", "quantity", "given", "reference")
            },
            rays_per_batch=_is(found["rays_per_batch"], int, "rays_per_batch"),
            seed=_is(found["seed"], int, "seed"),
            seconds=_is(found["seconds"], float, "seconds"),
            settings=rows,
            left_out=tuple(
                (_is(item["name"], str, "name"), _is(item["why"], str, "why"))
                for item in found["left_out"]
            ),
            advice=tuple(_is(text, str, "advice") for text in found["advice"]),
        )
    except (KeyError, TypeError, AttributeError, RecursionError, UnicodeDecodeError) as error:
        raise ValueError(f"it lacks {error}, or has it in another form") from None
    if {study.given, study.reference} - {row.name for row in rows}:
        raise ValueError("its settings lack the reference")
    return study


def _is(value: Any, kind: Any, key: str) -> Any:
    """Return a value of a type; a whole number is a float where one is wanted."""
    if kind is float and type(value) in (int, float) and math.isfinite(value):
        return float(value)
    if kind is None:
        return None if value is None else _is(value, float, key)
    if kind is object or (kind is not float and type(value) is kind):
        return value
    raise TypeError(key)


def _setting(row: dict[str, Any]) -> CostSetting:
    given = {key: _is(row[key], kind, key) for key, kind in _SETTING.items()}
    targets = tuple(
        TargetTime(
            _is(t["target"], float, "target"),
            _is(t["predicted_seconds"], None, "predicted_seconds"),
            _is(t["measured_seconds"], None, "measured_seconds"),
        )
        for t in row["targets"]
    )
    points = tuple((_is(t, float, "points"), _is(s, float, "points")) for t, s in row["points"])
    if tuple(t.target for t in targets) != TARGETS or not all(t > 0.0 < s for t, s in points):
        raise TypeError("targets and points that can be")
    return CostSetting(**given, targets=targets, points=points)
