"""What a report says of path tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from photizon_cl.views.report.numbers import amount, integer, number, pair, percent
from photizon_cl.views.report.tables import Table

if TYPE_CHECKING:
    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.maps import DetectorResult

__all__ = ["describe_ghosts", "describe_paths", "paths_table"]

_MOST: Final = 25


def paths_table(name: str, element: str, detector: DetectorResult, emitted: float) -> Table | None:
    """Return a detector's strongest paths and what the rest brings; None without a path table."""
    table = detector.paths
    if table is None:
        return None
    rows = [
        (
            row.sequence,
            *pair(row.power, row.sigma),
            percent(row.power / emitted, 3),
            integer(row.count),
            "–" if row.ghost_order is None else integer(row.ghost_order),
            integer(row.example_ray),
        )
        for row in table[:_MOST]
    ]
    more, rest = len(table) - len(rows), table.rest
    if rest.count:
        share = percent(rest.power / emitted, 3)
        text = f"all paths that are not in the table ({integer(rest.paths)})"
        text += "; its σ is an upper bound" * rest.at_most
        power = pair(rest.power, rest.sigma)
        rows.append((text, *power, share, integer(rest.count), number(""), number("")))
    note = "r reflected, t transmitted, i totally reflected, s scattered."
    if more > 0:
        note += f" {integer(more)} weaker paths are in paths.csv."
    columns = (
        ("path", False), ("power in W", True), ("± σ in W", True), ("share of emitted", True),
        ("arrivals", True), ("ghost order", True), ("example ray", True),
    )  # fmt: skip
    return Table(name, f"Strongest paths to {element}", columns, rows, note)


def describe_paths(result: Estimates, element: str) -> tuple[str, str]:
    """Return what the figure of the strongest paths shows, in words, and its caption."""
    table = result.detectors[element].paths
    named = [f"{row.sequence}, {amount(row.power, 3)} W" for row in list(table or ())[:3]]
    alt = f"The strongest paths to {element} by power: {'; '.join(named) or 'nothing arrived'}."
    return alt, f"Strongest paths to {element} with ± σ, each with its faces and events."


def describe_ghosts(result: Estimates, element: str) -> tuple[str, str]:
    """Return what the matrix of ghosts shows, in words, and its caption."""
    table = result.detectors[element].paths
    pairs = () if table is None else table.ghosts().pairs()
    named = [f"{ghost}, {amount(ghost.power, 3)} W" for ghost in pairs[:3]]
    alt = f"Ghosts of two reflections on {element} by pair of faces, the strongest: "
    return alt + f"{'; '.join(named) or 'none'}.", (
        f"Ghosts on {element}: power of light reflected at one face (row) and then at another "
        "(column)."
    )
