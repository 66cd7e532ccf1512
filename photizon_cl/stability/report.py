"""The stability report: one table over all families, and a figure."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hostcode.program.precision import FP64, PRECISIONS
from photizon_cl.atomic import reason
from photizon_cl.errors import ArgumentError, show
from photizon_cl.stability import (
    families,
    families_lens,
    families_local,
    families_mixed,
    families_round,
)
from photizon_cl.stability.fresnel import measure_fresnel
from photizon_cl.stability.measure import Measured, measure
from photizon_cl.stability.oracle import FIRM

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from os import PathLike

    from hostcode.device.device import OpenDevice
    from photizon_cl.stability.case import Case

__all__ = ["BOUND", "FAMILIES", "Row", "stability_report", "table", "write_figure"]

BOUND: Final = 8.0
"""Largest error allowed, in units of u·K."""

_LEGEND: Final = """\
ulps: error / (u K), the largest of distance, point and normal (Fresnel: weights, directions);
u = {unit} and K = sum of |d output / d input| * |input| + |output| over the case's own doubles:
an exact solution of inputs that are each one unit roundoff off has at most 1. condition: the
largest K relative to its output. firm: no inputs within {firm:.0f} such roundoffs change the hit;
elsewhere any answer that they give is right. wrong: a decision that is not among the right
ones, or not a number."""
_LOST: Final = """\
lost: cases of which single precision cannot hold the scene, an element, a length or a gap below its
rounding, and those that come out wrong of rays that start nearer to a face, or see it from so far,
that rounding hides it. A family with any does not survive whole. All inputs are rounded to single
precision before the oracle sees them."""

FAMILIES: Final[dict[str, Callable[[], Iterator[Case]]]] = {
    "sphere, tangent": families.sphere_tangent,
    "sphere, far and near": families.sphere_near_far,
    "sphere, origin on it": families.sphere_surface,
    "sphere, chord": families.sphere_chord,
    "sphere, port rim": families.sphere_port,
    "flat, near-parallel": families.flat_grazing,
    "flat, edge": families.flat_edge,
    "flat, hole": families.flat_hole,
    "flat, tilt": families.flat_tilt,
    "cpc, inside": families_local.cpc_inside,
    "cpc, outside": families_local.cpc_outside,
    "cpc, rims": families_local.cpc_rims,
    "cpc, origin on it": families_local.cpc_wall,
    "tube, holes": families_local.tube_holes,
    "tube, corners": families_local.tube_corners,
    "lens, shapes": families_local.lens_shapes,
    "lens, rim": families_local.lens_rim,
    "lens, tangent": families_local.lens_tangent,
    "lens, inside": families_local.lens_inside,
    "round, inside": families_round.round_inside,
    "round, outside": families_round.round_outside,
    "round, tangent": families_round.round_tangent,
    "round, rims": families_round.round_rims,
    "round, origin on it": families_round.round_wall,
    "round, departed": families_round.round_departed,
    "round, far and near": families_round.round_far,
    "round, axis": families_round.round_axis,
    "glass, faces": families_lens.glass_faces,
    "glass, rims": families_lens.glass_rims,
    "glass, tangent": families_lens.glass_tangent,
    "glass, vertex": families_lens.glass_vertex,
    "glass, inside": families_lens.glass_inside,
    "glass, chord": families_lens.glass_chord,
    "glass, origin on it": families_lens.glass_on_it,
    "glass, far and near": families_lens.glass_far,
    "nearly coincident": families_mixed.nearly_coincident,
    "touching": families_mixed.touching,
    "shared edges": families_mixed.shared_edges,
    "shared rims": families_mixed.shared_rims,
}
"""Families of rays; `fresnel` comes besides."""


@dataclass(frozen=True)
class Row:
    """A family's outcome.

    Parameters
    ----------
    family : str
        Its name.
    measured : tuple of Measured
        Every case.
    seconds : float
        Time that its cases and the oracle took.
    """

    family: str
    measured: tuple[Measured, ...]
    seconds: float

    @property
    def cases(self) -> int:
        """Number of cases."""
        return len(self.measured)

    @property
    def firm(self) -> int:
        """Cases with just one right decision."""
        return sum(m.firm for m in self.measured)

    @property
    def wrong(self) -> tuple[Measured, ...]:
        """Cases whose decision was not among the right ones, or whose answer was not a number."""
        return tuple(m for m in self.measured if not m.right)

    @property
    def lost(self) -> tuple[Measured, ...]:
        """Cases that the precision cannot hold."""
        return tuple(m for m in self.measured if m.lost)

    @property
    def worst(self) -> float:
        """Largest error in units of u·K."""
        return max(m.worst for m in self.measured)

    @property
    def worst_case(self) -> Measured:
        """The case with the largest error."""
        return max(self.measured, key=lambda m: m.worst)

    @property
    def condition(self) -> float:
        """Largest condition number."""
        return max(m.condition for m in self.measured)

    @property
    def passed(self) -> bool:
        """Whether no decision is wrong and no error beyond the bound, and something was asked."""
        return not self.wrong and self.worst <= BOUND and len(self.lost) < self.cases

    @property
    def verdict(self) -> str:
        """What to say of it, empty where all is well."""
        if self.wrong or self.worst > BOUND:
            return "FAILED"
        if not self.lost:
            return ""
        return "LOST" if len(self.lost) == self.cases else f"{len(self.lost)} lost"


def stability_report(
    device: OpenDevice, only: Sequence[str] = (), precision: str = FP64.name
) -> list[Row]:
    """Measure the families.

    Parameters
    ----------
    device : OpenDevice
        Where.
    only : sequence of str, optional
        Names of families; default all of them.
    precision : str
        In which mode.

    Raises
    ------
    RunError
        Where mpmath is not installed.
    """
    rows = []
    for name in (*FAMILIES, "fresnel"):
        if only and name not in only:
            continue
        started = time.perf_counter()
        if name in FAMILIES:
            found = measure(device, FAMILIES[name](), precision=precision)
        else:
            found = measure_fresnel(device, precision=precision)
        rows.append(Row(name, tuple(found), time.perf_counter() - started))
    return rows


def table(rows: Sequence[Row], precision: str = FP64.name) -> str:
    """Return the report of a mode as text."""
    mode = PRECISIONS[precision]
    head = (
        f"{'family':22} {'cases':>6} {'firm':>6} {'wrong':>6} {'worst ulps':>11} {'bound':>6} "
        f"{'condition':>10}  worst case"
    )
    lines = [head, "-" * len(head)]
    for row in rows:
        mark = f"  {row.verdict}" if row.verdict else ""
        lines.append(
            f"{row.family:22} {row.cases:6d} {row.firm:6d} {len(row.wrong):6d} {row.worst:11.2f} "
            f"{BOUND:6.0f} {row.condition:10.1e}  {row.worst_case.label}{mark}"
        )
        lines += [f"    wrong: {m.label}: {m.note}" for m in row.wrong[:5]]
        reasons = dict.fromkeys(m.lost for m in row.lost)
        lines += [f"    lost: {reason}" for reason in list(reasons)[:3]]
    total, wrong = sum(r.cases for r in rows), sum(len(r.wrong) for r in rows)
    worst = max((r.worst for r in rows), default=0.0)
    lines.append(f"{'all':22} {total:6d} {sum(r.firm for r in rows):6d} {wrong:6d} {worst:11.2f}")
    if mode.single:
        gone = sum(len(r.lost) for r in rows)
        survive = sum(not r.verdict for r in rows)
        some = sum(r.passed and bool(r.lost) for r in rows)
        lines.append(
            f"in {mode.name} {survive} of {len(rows)} families survive whole, {some} in part, with "
            f"{gone} cases lost"
        )
    unit = f"2^{math.frexp(mode.roundoff)[1] - 1}"
    lines += ["", _LEGEND.format(unit=unit, firm=FIRM)] + ([_LOST] if mode.single else [])
    return "\n".join(lines)


def write_figure(rows: Sequence[Row], path: str | PathLike[str]) -> None:
    """Draw every case's error by family.

    Parameters
    ----------
    rows : sequence of Row
        The report.
    path : path
        Where the figure goes; its suffix says the format, see `photizon_cl.views.figures.FORMATS`.

    Raises
    ------
    ArgumentError
        Where it is another format, the file is no figure that was written here, or cannot be
        written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from photizon_cl.views.figures.style import metadata, replace_figure

    figure = Figure(figsize=(11.0, 6.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for x, row in enumerate(rows):
        errors = sorted(max(m.worst, 1e-3) for m in row.measured if m.errors)
        across = [x - 0.35 + 0.7 * k / max(len(errors) - 1, 1) for k in range(len(errors))]
        axes.plot(across, errors, ".", markersize=3, color="tab:blue")
        axes.plot([x - 0.35, x + 0.35], [row.worst] * 2, color="tab:orange", linewidth=1.5)
    axes.axhline(BOUND, color="tab:red", linewidth=1.0, label=f"bound, {BOUND:g}")
    axes.set_yscale("log")
    axes.set_xticks(range(len(rows)), [row.family for row in rows], rotation=60, ha="right")
    axes.set_ylabel("error / (u K): ulps of a backward-stable solution")
    axes.set_title(
        "Hard cases against 60-digit arithmetic; each point is a case, cases sorted by error"
    )
    axes.grid(axis="y", alpha=0.3)
    axes.legend(loc="upper left")
    target = Path(path)
    kind = target.suffix.lower()[1:]
    try:
        replace_figure(
            target, lambda file: figure.savefig(file, format=kind, dpi=150, metadata=metadata(kind))
        )
    except OSError as error:
        raise ArgumentError(f"{show(str(path))} cannot be written ({reason(error)})") from None
