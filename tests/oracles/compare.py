"""Compares an engine's tally with that of the reference tracer, cell by cell."""

from __future__ import annotations

from math import fsum
from typing import TYPE_CHECKING, Any

from oracles import tracer

if TYPE_CHECKING:
    from collections.abc import Iterator
    from fractions import Fraction

    from oracles.engine import Traced


def differences(traced: Traced, tables: dict[str, Any], tolerance: float) -> list[str]:
    """Return a line for each cell in which the engine differs from the reference.

    Parameters
    ----------
    traced : Traced
        One batch.
    tables : dict
        The scene as a file's tables, with the run settings that were used.
    tolerance : float
        Allowed difference, as a fraction of the emitted power; counts must agree exactly.
    """
    made = traced.compiled
    rays, seed = list(made.rays_of_source), made.settings.seed
    reference = tracer.trace(tables, rays, seed, traced.first)
    flux = fsum(source["flux"] for source in tables["source"])
    found = []
    for name, weight, count, want in _cells(traced, tables, reference):
        watts = float(weight) * made.unit_power
        wanted = fsum(want) if isinstance(want, list) else want
        if abs(watts - wanted) > tolerance * flux:
            found.append(f"{name}: {watts!r} W, the reference has {wanted!r} W")
        if isinstance(want, list) and count != len(want):
            found.append(f"{name}: {count} arrivals, the reference has {len(want)}")
    if traced.interactions != reference.interactions:
        found.append(f"{traced.interactions} interactions, not {reference.interactions}")
    return found


def _cells(
    traced: Traced, tables: dict[str, Any], reference: tracer.Tally
) -> Iterator[tuple[str, Fraction, int, float | list[float]]]:
    for row in tables.get("element", []):
        name = row["name"]
        yield f"absorbed {name}", traced.absorbed(name), 0, reference.absorbed[name]
        if "detector" not in row:
            continue
        d = traced.detector(name)
        yield f"power {name}", d.power, d.count, reference.power[name]
        for g, (weight, count) in enumerate(zip(d.ladder, d.ladder_counts, strict=True)):
            yield f"ladder {name} {g}", weight, count, reference.ladder[name, g]
        for i in range(d.cells.nx):
            for j in range(d.cells.ny):
                cell = d.cells.map + j * d.cells.nx + i
                wanted = reference.map[name, i, j]
                yield f"map {name} {i} {j}", traced.amount(cell), traced.count(cell), wanted
    layout = traced.compiled.layout
    for row in tables.get("medium", []):
        name = row["name"]
        weight = traced.amount(layout.row(f"absorbed_in.{name}"))
        yield f"absorbed in {name}", weight, 0, reference.absorbed_in[name]
    yield "escaped", traced.escaped, 0, reference.escaped
    yield "killed", traced.killed, 0, reference.killed
    yield "boosted", traced.boosted, 0, reference.boosted
    yield "depth-capped", traced.depth_capped, 0, reference.depth_capped
    counts = traced.far_field_counts
    for k, weight in enumerate(traced.far_field):
        place = divmod(k, traced.compiled.layout.n_phi)
        yield f"far field {place}", weight, int(counts[place]), reference.far_field[place]
