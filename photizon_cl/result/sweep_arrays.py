"""A sweep as labelled arrays and as a table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.result.csv_tables import csv_text
from photizon_cl.scene.sweep_values import value_text

if TYPE_CHECKING:
    import xarray as xr

    from photizon_cl.result.ledger import Estimate
    from photizon_cl.result.sweep import SweepTable
    from photizon_cl.scene.sweeps import Axis

__all__ = ["SWEEP_RESULT_SCHEMA", "dataset", "table"]

SWEEP_RESULT_SCHEMA: Final = "photizon-sweep-result/1"


def dataset(sweep: SweepTable) -> xr.Dataset:
    """Return the arrays, see `photizon_cl.Sweep.to_dataset`."""
    import xarray as xr

    plan, points = sweep.plan, sweep.points
    dims = tuple(group[0].name for group in plan.groups)
    coords: dict[str, Any] = {}
    for group, dim in zip(plan.groups, dims, strict=True):
        for axis in group:
            about = {"long_name": axis.name, "path": axis.path}
            about |= {"units": axis.unit} if axis.unit else {}
            coords[axis.name] = ((dim,), _along(axis), about)

    def over(values: list[Any], kind: Any, **about: str) -> tuple[Any, ...]:
        return dims, np.array(values, kind).reshape(plan.shape), about

    arrays: dict[str, Any] = {}
    for measure in sweep.measured:
        name, unit = measure.name, measure.unit
        found = [point.measures.get(name) for point in points]
        moved = [point.change.get(name) for point in points]
        arrays[name] = over(
            _values(found), float, units=unit, long_name=name, comment=measure.meaning
        )
        said = f"standard error of {name}"
        arrays[f"{name}.sigma"] = over(_sigmas(found), float, units=unit, long_name=said)
        said = f"{name} less that of point 0, paired where both share a stream"
        arrays[f"{name}.change"] = over(_values(moved), float, units=unit, long_name=said)
        said = f"standard error of {name}.change"
        arrays[f"{name}.change_sigma"] = over(_sigmas(moved), float, units=unit, long_name=said)
    arrays["digest"] = over([p.digest for p in points], object, long_name="tally digest")
    arrays["stopped"] = over([p.stopped for p in points], object, long_name="what ended the point")
    arrays["batches"] = over([p.batches for p in points], np.int64, units="1", long_name="batches")
    arrays["rays"] = over([p.rays for p in points], np.int64, units="1", long_name="rays launched")
    arrays["seconds"] = over([p.seconds for p in points], float, units="s", long_name="tracing")
    attrs = {"schema": SWEEP_RESULT_SCHEMA, "title": plan.heading, "scene": plan.scene.name}
    return xr.Dataset(arrays, coords, attrs)


def _along(axis: Axis) -> Any:
    if axis.numeric:
        return np.array(axis.values, float)
    return np.array([value_text(value) for value in axis.values], object)


def _values(found: list[Estimate | None]) -> list[float]:
    return [math.nan if one is None else one.value for one in found]


def _sigmas(found: list[Estimate | None]) -> list[float]:
    return [math.nan if one is None or one.sigma is None else one.sigma for one in found]


def table(sweep: SweepTable) -> str:
    """Return the table as CSV, see `photizon_cl.Sweep.to_csv`."""
    head = ["point", *(axis.name for axis in sweep.plan.axes)]
    for name in sweep.names:
        head += [name, f"{name}_sigma", f"{name}_change", f"{name}_change_sigma"]
    head += ["batches", "rays", "seconds", "stopped", "digest"]
    rows = []
    for point in sweep.points:
        row: list[object] = [point.number]
        for axis in sweep.plan.axes:
            value = point.values[axis.name]
            row.append(value if axis.numeric else value_text(value))
        for name in sweep.names:
            row += [*_cells(point.measures.get(name)), *_cells(point.change.get(name))]
        row += [point.batches, point.rays, point.seconds, point.stopped, point.digest]
        rows.append(row)
    return csv_text(head, rows)


def _cells(found: Estimate | None) -> tuple[object, object]:
    if found is None or math.isnan(found.value):
        return "", ""
    return found.value, "" if found.sigma is None else found.sigma
