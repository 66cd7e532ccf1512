"""What the cells of a batch's tally mean."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

__all__ = ["DetectorCells", "TallyLayout", "lay_out"]


@dataclass(frozen=True)
class DetectorCells:
    """Where a detector's cells stand in a batch's tally.

    Parameters
    ----------
    element : int
        Number of its element in the scene.
    power : int
        Its power cell.
    ladder, n_generations : int
        First cell of the ladder and its number of entries, 0 without one.
    map, nx, ny : int
        First cell of the map (row-major, v then u) and its bins, 0 without one.
    """

    element: int
    power: int
    ladder: int
    n_generations: int
    map: int
    nx: int
    ny: int


@dataclass(frozen=True)
class TallyLayout:
    """Meaning of the cells of a batch's tally.

    Cells ``0 … n_elements − 1`` are absorbed by the elements; then escaped, roulette killed,
    roulette boosted, depth-capped; then the detectors' cells and the far field's.
    """

    n_elements: int
    detectors: tuple[DetectorCells, ...]
    far_field: int
    n_mu: int
    n_phi: int
    n_cells: int

    @property
    def escaped(self) -> int:
        """Cell of what leaves the scene."""
        return self.n_elements

    @property
    def killed(self) -> int:
        """Cell of the weight that roulette ended."""
        return self.n_elements + 1

    @property
    def boosted(self) -> int:
        """Cell of the weight that roulette added."""
        return self.n_elements + 2

    @property
    def depth_capped(self) -> int:
        """Cell of the weight alive at the generation cap; its count is the batch's interactions."""
        return self.n_elements + 3

    @property
    def n_rows(self) -> int:
        """Cells of the ledger."""
        return self.n_elements + 4


def lay_out(scene: Scene) -> TallyLayout:
    """Give every quantity of a scene its cells."""
    cell = len(scene.element) + 4
    found = []
    for n, element in enumerate(scene.element):
        if element.detector is None:
            continue
        power = cell
        cell += 1
        generations = element.detector.generations or 0
        ladder = cell if generations else 0
        cell += generations
        nx, ny = element.detector.map or (0, 0)
        first = cell if nx else 0
        cell += nx * ny
        found.append(DetectorCells(n, power, ladder, generations, first, nx, ny))
    far_field = cell
    n_mu, n_phi = (scene.far_field.n_mu, scene.far_field.n_phi) if scene.far_field else (0, 0)
    cell += n_mu * n_phi
    return TallyLayout(len(scene.element), tuple(found), far_field, n_mu, n_phi, cell)
