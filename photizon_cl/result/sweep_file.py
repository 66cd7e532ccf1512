"""A sweep on disk: ``sweep.json`` says what it is, ``point.json`` what came out at a point."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.atomic import reason
from photizon_cl.errors import ResultError, SceneError, printable, show
from photizon_cl.result.ledger import Estimate
from photizon_cl.result.sweep import SweepPoint
from photizon_cl.scene.sweep_reader import read_sweep

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from photizon_cl.scene.sweeps import SweepPlan

__all__ = [
    "POINT_FILE",
    "SWEEP_ARRAYS",
    "SWEEP_FILE",
    "SWEEP_TABLE",
    "differs",
    "plan_text",
    "point_text",
    "read_plan",
    "read_point",
]

SWEEP_FILE: Final = "sweep.json"
SWEEP_ARRAYS: Final = "sweep.nc"
SWEEP_TABLE: Final = "sweep.csv"
POINT_FILE: Final = "point.json"
_POINT_SCHEMA: Final = "photizon-sweep-point/1"
_MOST: Final = 1 << 24
"""Bytes of a point's file that are read; some of a thousand measures has half a million."""
_STOPPED: Final = ("batches", "target", "time", "memory")


def plan_text(plan: SweepPlan) -> str:
    """Return a sweep as the text of its file, which is a sweep file that holds its scene."""
    return json.dumps(plan.to_dict(), indent=2, ensure_ascii=True, allow_nan=False) + "\n"


def read_plan(file: Path) -> SweepPlan:
    """Return what the file of a sweep's directory says.

    Raises
    ------
    ResultError
        Where it is damaged.
    """
    try:
        return read_sweep(file)
    except SceneError as error:
        first = str(error).split("\n")[0]
        raise ResultError(f"{show(str(file))} is damaged: {printable(first)}") from None


def differs(there: SweepPlan, given: SweepPlan) -> str:
    """Return in what a sweep is another one than that of a directory; empty where it is the same.

    Titles and notes may differ.
    """
    a, b = there.to_dict(), given.to_dict()
    for tables in (a, b):
        for name in ("title", "notes"):
            tables.pop(name, None)
            tables["scene"].pop(name, None)
    what = {"scene": "the scene", "vary": "[[vary]]", "run": "[run]", "measure": "[measure]"}
    found = [text for name, text in what.items() if _text(a.get(name)) != _text(b.get(name))]
    return " and ".join(found)


def _text(table: Any) -> str:
    return json.dumps(table, sort_keys=True)


def point_text(point: SweepPoint) -> str:
    """Return a point as the text of its file."""
    out = {"schema": _POINT_SCHEMA, **point.summary(), "engine": point.engine}
    return json.dumps(out, indent=2, ensure_ascii=True, allow_nan=False) + "\n"


def read_point(
    file: Path, number: int, values: Mapping[str, Any], names: tuple[str, ...]
) -> SweepPoint:
    """Return the point that a file holds.

    Parameters
    ----------
    file : Path
        The file.
    number : int
        Of the point that it should be.
    values : mapping
        What it sets.
    names : tuple of str
        What is measured.

    Raises
    ------
    ResultError
        Where it cannot be read, is damaged, or is of another point.
    """
    try:
        if file.stat().st_size > _MOST:
            raise ValueError("it is too large")
        found = json.loads(file.read_text(encoding="utf-8"))
        return _point(found, number, values, names)
    except OSError as error:
        raise ResultError(f"{show(str(file))} cannot be read: {reason(error)}") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ResultError(
            f"{show(str(file))} is damaged or of another sweep ({printable(str(error))[:200]}): "
            "remove it, and `photizon resume` makes it again from the result beside it"
        ) from None


def _point(
    found: dict[str, Any], number: int, values: Mapping[str, Any], names: tuple[str, ...]
) -> SweepPoint:
    if found["schema"] != _POINT_SCHEMA or found["number"] != number:
        raise ValueError("it is no such point")
    texts = ("digest", "scene_digest", "stopped", "engine")
    if not all(isinstance(found[key], str) for key in texts) or found["stopped"] not in _STOPPED:
        raise TypeError("a text is missing")
    integers = ("seed", "rays_per_batch", "batches")
    if not all(type(found[key]) is int and found[key] >= 0 for key in integers):
        raise TypeError("a number is missing")
    if set(found["measures"]) != set(names) or not set(found["change"]) <= set(names):
        raise ValueError("other measures")
    return SweepPoint(
        number=number,
        values=values,
        **{key: found[key] for key in (*texts, *integers)},
        measures={name: _estimate(found["measures"][name]) for name in names},
        change={name: _estimate(one) for name, one in found["change"].items()},
        seconds=_number(found["seconds"]),
        advisories=tuple(map(_text_of, found["advisories"])),
    )


def _estimate(found: dict[str, Any]) -> Estimate:
    value = math.nan if found["value"] is None else _number(found["value"])
    sigma = None if found["sigma"] is None else _number(found["sigma"])
    count = found.get("count")
    if count is not None and type(count) is not int:
        raise TypeError("count")
    return Estimate(value, sigma, count)


def _text_of(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError("a text is missing")
    return value


def _number(value: object) -> float:
    if type(value) not in (int, float):
        raise TypeError("a number is missing")
    return float(value)  # type: ignore[arg-type]
