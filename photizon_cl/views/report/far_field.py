"""The far field in tables and words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.result.text import lit_percent
from photizon_cl.views.report.numbers import amount, brief, integer, pair, plain_amount
from photizon_cl.views.report.tables import Table, peak

if TYPE_CHECKING:
    from photizon_cl.result.far_field import FarFieldResult
    from photizon_cl.result.ledger import Estimate

__all__ = ["far_field_tables", "place_of", "row_name", "row_of", "span_of"]

_MOST_ROWS: Final = 200
"""So many rows of intensity over θ are written out; more are in the file."""


def row_name(far: FarFieldResult) -> str:
    """Return what rows are bins in."""
    return "θ" if far.by_theta else "cos θ"


def row_of(far: FarFieldResult, j: int) -> str:
    """Say where the middle of a row is."""
    if far.by_theta:
        low, high = far.bins.edges_deg[j : j + 2]
        return f"θ = {plain_amount(0.5 * (low + high))}°"
    return f"cos θ = {plain_amount(float(0.5 * (far.mu_edges[j] + far.mu_edges[j + 1])))}"


def place_of(far: FarFieldResult, j: int, i: int) -> str:
    """Say where the middle of a bin is."""
    if far.by_theta and far.count.shape[1] == 1:
        return row_of(far, j)
    phi = float(np.degrees(0.5 * (far.phi_edges[i] + far.phi_edges[i + 1])))
    return f"{row_of(far, j)}, φ = {plain_amount(phi)}°"


def span_of(far: FarFieldResult) -> str:
    """Say from where to where bins in θ reach."""
    edges = far.bins.edges_deg
    return f"{edges[0]:.9g}° to {edges[-1]:.9g}°"


def far_field_tables(far: FarFieldResult, escaped: Estimate) -> list[Table]:
    """Return the key figures of the far field, and the intensity over θ where that is one curve."""
    found = [_key_figures(far, escaped)]
    if far.by_theta and far.count.shape[1] == 1:
        found.append(_curve(far))
    return found


def _key_figures(far: FarFieldResult, escaped: Estimate) -> Table:
    rows, columns = far.count.shape
    whole = 4.0 * np.pi
    sigma = None if escaped.sigma is None else escaped.sigma / whole
    lit = ~far.hatched
    said: list[tuple[str, str]] = []
    if far.whole:
        mean = brief(escaped.value / whole, sigma, "W/sr")
        said += [
            ("power in all bins (what escaped)", brief(escaped.value, escaped.sigma, "W")),
            ("intensity, mean over all directions", mean),
        ]
    else:
        said += [
            ("what escaped", brief(escaped.value, escaped.sigma, "W")),
            (f"of it in the bins, θ from {span_of(far)}", amount(far.power) + " W"),
        ]
    said.append(("bins", f"{integer(rows)} in {row_name(far)} × {integer(columns)} in φ"))
    if far.by_theta:
        low, high = (amount(float(of(far.solid_angle))) for of in (np.min, np.max))
        said.append(("solid angle of a bin", low + " sr to " + high + " sr"))
    else:
        said.append(("solid angle of a bin", amount(float(np.max(far.solid_angle))) + " sr"))
    if far.bins.turned or far.by_theta:
        u, v, axis = far.axis_words
        said.append(("θ from", axis))
        if columns > 1:
            said.append(("φ from", f"{u} towards {v}"))
    said.append(("bins with 10 or more rays", lit_percent(float(np.mean(lit)))))
    if lit.any():
        value, error, at = peak(far.intensity, far.sigma, lit)
        text = brief(value, error, "W/sr") + f", at {place_of(far, *at)}"
        said.append(("highest of these bins", text))
    return Table(
        "table-far-field",
        "Far field: key figures",
        (("quantity", False), ("value", False)),
        said,
    )


def _curve(far: FarFieldResult) -> Table:
    edges = far.bins.edges_deg
    sigmas = [None if np.isnan(s) else float(s) for s in far.sigma[:, 0]]
    rows = [
        (
            f"{edges[j]:.9g} – {edges[j + 1]:.9g}",
            *pair(float(far.intensity[j, 0]), sigmas[j]),
            integer(int(far.count[j, 0])),
        )
        for j in range(min(len(sigmas), _MOST_ROWS))
    ]
    left = len(sigmas) - len(rows)
    return Table(
        "table-far-field-theta",
        f"Intensity over the angle from {far.axis_words[2]}",
        (("θ in degrees", False), ("W/sr", True), ("± σ", True), ("rays", True)),
        rows,
        f"{integer(left)} more rows are in result.nc." if left else "",
    )
