"""What the cells of a batch's tally mean."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from photizon_cl.scene.detectors.detector import BY_WAVELENGTH

if TYPE_CHECKING:
    from collections.abc import Iterable

    from photizon_cl.scene.filters.base import Filter
    from photizon_cl.scene.model import Scene

__all__ = [
    "ABSORBED_IN",
    "MOST_ABSORBING",
    "ROWS",
    "CellGroup",
    "DetectorCells",
    "LedgerRow",
    "Quantity",
    "TallyCells",
    "TallyLayout",
    "lay_out",
]


MOST_ABSORBING: Final = 1024
"""Elements of a scene of which each one's absorbed power is kept batch by batch."""

ABSORBED_IN: Final = "absorbed_in"
"""The group of the ledger's rows that have what media absorb."""


@dataclass(frozen=True)
class LedgerRow:
    """A row of the ledger behind the elements'.

    Parameters
    ----------
    name : str
        ``ROW_<NAME>`` in the kernels; ``group.row`` where it is one of several.
    sign : int
        How it counts in the balance: 1 where emitted weight ended, −1 where weight was added.
    title : str
        What people call it.
    signed : bool
        Whether it may be negative: weight that comes and goes.
    macro : str
        ``ROW_<MACRO>`` in the kernels instead, where the name holds what a person chose.
    """

    name: str
    sign: int
    title: str
    signed: bool = False
    macro: str = ""


ROWS: Final[tuple[LedgerRow, ...]] = (
    LedgerRow("escaped", 1, "escaped"),
    LedgerRow("killed", 1, "roulette killed"),
    LedgerRow("boosted", -1, "roulette boosted"),
    LedgerRow("capped", 1, "depth-capped"),
)
"""The rows that every ledger has."""


@dataclass(frozen=True)
class TallyCells:
    """Cells of one tally of a detector: the product of its filters.

    Parameters
    ----------
    name : str
        ``ladder`` or ``map``.
    first : int
        Its first cell in a batch's tally.
    filters : tuple of Filter
        The first one changes fastest.
    """

    name: str
    first: int
    filters: tuple[Filter, ...]

    @property
    def size(self) -> int:
        """Number of its cells."""
        return math.prod(f.bins for f in self.filters)


@dataclass(frozen=True)
class DetectorCells:
    """Where a detector's cells stand in a batch's tally.

    Parameters
    ----------
    element : int
        Number of its element in the scene.
    power : int
        Its power cell.
    tallies : tuple of TallyCells
        What it divides arrivals by.
    paths : int
        Rows of its path table, 0 without one.
    """

    element: int
    power: int
    tallies: tuple[TallyCells, ...]
    paths: int = 0

    def tally(self, name: str) -> TallyCells | None:
        """Return a tally by name, None without one."""
        return next((tally for tally in self.tallies if tally.name == name), None)

    def _cells(self, name: str) -> tuple[int, tuple[int, ...]]:
        tally = self.tally(name)
        return (tally.first, tuple(f.bins for f in tally.filters)) if tally else (0, (0, 0))

    @property
    def wavelengths(self) -> int:
        """Lines by which all is told, 0 where it is not."""
        tally = self.tally(f"power{BY_WAVELENGTH}")
        return tally.size if tally else 0

    def by_wavelength(self, name: str, line: int) -> int:
        """Return the first cell of what a line brings to the power, the ladder or the map."""
        tally = self.tally(f"{name}{BY_WAVELENGTH}")
        assert tally is not None
        return tally.first + line * (tally.size // self.wavelengths)

    @property
    def ladder(self) -> int:
        """First cell of the ladder, 0 without one."""
        return self._cells("ladder")[0]

    @property
    def n_generations(self) -> int:
        """Entries of the ladder, 0 without one."""
        return self._cells("ladder")[1][0]

    @property
    def map(self) -> int:
        """First cell of the map (row-major, v then u), 0 without one."""
        return self._cells("map")[0]

    @property
    def nx(self) -> int:
        """Bins of the map along u, 0 without one."""
        return self._cells("map")[1][0]

    @property
    def ny(self) -> int:
        """Bins of the map along v, 0 without one."""
        return self._cells("map")[1][1]


@dataclass(frozen=True)
class CellGroup:
    """Cells that an effect brings.

    Parameters
    ----------
    effect : str
        Its name.
    first : int
        Its first cell in a batch's tally.
    shape : tuple of int
        Row-major.
    labels : tuple of str
        What each cell is, where results show them by name; all different.
    unit : str
        Of what they show.
    scale : float
        What a counted 1 stands for, in `unit` per watt.
    counted_as : str
        What the summary calls the number of all that they counted; empty where it does not.

    Raises
    ------
    ValueError
        Where there are labels, and not one of its own for each cell.
    """

    effect: str
    first: int
    shape: tuple[int, ...]
    labels: tuple[str, ...] = ()
    unit: str = "W"
    scale: float = 1.0
    counted_as: str = ""

    def __post_init__(self) -> None:
        """See that no cell would be shown under another's label."""
        different = len(set(self.labels))
        if self.labels and not different == len(self.labels) == self.size:
            raise ValueError(
                f"the effect {self.effect!r} has {self.size} cells and {len(self.labels)} labels, "
                f"{different} of them different: give each cell a label of its own, or no labels"
            )

    @property
    def size(self) -> int:
        """Number of its cells."""
        return math.prod(self.shape)


@dataclass(frozen=True)
class Quantity:
    """A quantity that results have by its name, see `photizon_cl.compile.quantities`.

    Parameters
    ----------
    name : str
        For example ``detectors."wall -x".power``.
    first : int
        Its cell, or the first of its bins, in a batch's tally.
    bins : int
        Number of its bins; 0 for a scalar, which is one cell.
    """

    name: str
    first: int
    bins: int = 0


@dataclass(frozen=True)
class TallyLayout:
    """Meaning of the cells of a batch's tally.

    Where an effect divides the ledger's rows, the parts of each stand behind the cells that effects
    bring, those of the first row first.

    Cells ``0 … n_elements − 1`` are absorbed by the elements; then come the named rows of the
    ledger, the detectors' cells, the cells that effects bring, and last the row of interactions, of
    which only the count is used.

    `watched` are the quantities that must each meet a run's target, where it names any.
    """

    n_elements: int
    rows: tuple[LedgerRow, ...]
    detectors: tuple[DetectorCells, ...]
    groups: tuple[CellGroup, ...]
    n_cells: int
    watched: tuple[Quantity, ...] = ()
    parts: int = 0
    """Parts of each row of the ledger, 0 where they are not divided."""
    divided: int = 0
    """First cell of the first row's parts."""

    def part(self, row: int, number: int) -> int:
        """Return the cell of a part of a row of the ledger, given the row's cell."""
        return self.divided + row * self.parts + number

    def counts_arrivals(self, cell: int) -> bool:
        """Say whether a cell counts what comes to it, as those of the ledger do not."""
        first = self.divided
        return cell >= self.n_rows and not first <= cell < first + self.n_rows * self.parts

    def row(self, name: str) -> int:
        """Return the cell of a row of the ledger."""
        return self.n_elements + [row.name for row in self.rows].index(name)

    def group(self, effect: str) -> CellGroup | None:
        """Return the cells that an effect brings, None where it brings none."""
        return next((group for group in self.groups if group.effect == effect), None)

    @property
    def labelled(self) -> tuple[CellGroup, ...]:
        """The effects' cells that results show by name."""
        return tuple(group for group in self.groups if group.labels)

    @property
    def escaped(self) -> int:
        """Cell of what leaves the scene."""
        return self.row("escaped")

    @property
    def killed(self) -> int:
        """Cell of the weight that roulette ended."""
        return self.row("killed")

    @property
    def boosted(self) -> int:
        """Cell of the weight that roulette added."""
        return self.row("boosted")

    @property
    def depth_capped(self) -> int:
        """Cell of the weight alive at the generation cap."""
        return self.row("capped")

    @property
    def interactions(self) -> int:
        """Cell whose count is the batch's interactions."""
        return self.n_cells - 1

    @property
    def n_rows(self) -> int:
        """Cells of the ledger."""
        return self.n_elements + len(self.rows)

    @property
    def pieces(self) -> dict[str, tuple[int, int]]:
        """First cell and number of the cells of each piece, by names that layouts share.

        Two programs of a scene have a piece of the same name in common, wherever it stands.
        """
        found = {"absorbed": (0, self.n_elements)}
        found |= {f"row {row.name}": (self.row(row.name), 1) for row in self.rows}
        for d in self.detectors:
            found[f"detector {d.element}"] = (d.power, 1)
            found |= {f"detector {d.element} {t.name}": (t.first, t.size) for t in d.tallies}
        found |= {f"effect {group.effect}": (group.first, group.size) for group in self.groups}
        if self.parts:
            found["absorbed in parts"] = (self.divided, self.n_elements * self.parts)
            found |= {
                f"row {row.name} in parts": (self.part(self.row(row.name), 0), self.parts)
                for row in self.rows
            }
        return {**found, "interactions": (self.interactions, 1)}

    @property
    def scalars(self) -> tuple[tuple[int, int], ...]:
        """First cell and number of the cells whose batches are kept one by one, ascending.

        The ledger, powers and ladders of detectors; not what single elements absorb where they are
        more than `MOST_ABSORBING`.
        """
        first = 0 if self.n_elements <= MOST_ABSORBING else self.n_elements
        found = [(first, self.n_rows - first)]
        for d in self.detectors:
            found.append((d.power, 1))
            if d.n_generations:
                found.append((d.ladder, d.n_generations))
            for name in (f"power{BY_WAVELENGTH}", f"ladder{BY_WAVELENGTH}"):
                tally = d.tally(name)
                if tally is not None:
                    found.append((tally.first, tally.size))
        if self.parts:
            few = self.n_elements * self.parts <= MOST_ABSORBING
            first = 0 if few else self.n_elements
            found.append((self.part(first, 0), (self.n_rows - first) * self.parts))
        joined: list[tuple[int, int]] = []
        for start, n in sorted(found):
            if joined and sum(joined[-1]) == start:
                start, n = joined[-1][0], joined.pop()[1] + n
            joined.append((start, n))
        return tuple(joined)

    @property
    def most_paths(self) -> int:
        """Rows of the path tables together, 0 where no detector has one."""
        return sum(d.paths for d in self.detectors)

    @property
    def far_field(self) -> int:
        """First cell of the far field; meaningless where the scene bins none."""
        group = self.group("far-field")
        return group.first if group else self.interactions

    @property
    def n_mu(self) -> int:
        """Rows of the far field, by θ or cos θ; 0 without one."""
        group = self.group("far-field")
        return group.shape[0] if group else 0

    @property
    def n_phi(self) -> int:
        """Columns of the far field, by φ; 0 without one."""
        group = self.group("far-field")
        return group.shape[1] if group else 0


def lay_out(
    scene: Scene,
    rows: Iterable[LedgerRow] = (),
    groups: Iterable[tuple[str, tuple[int, ...], tuple[str, ...], str, float, str]] = (),
    parts: int = 0,
) -> TallyLayout:
    """Give every quantity of a scene its cells.

    Parameters
    ----------
    scene : Scene
        Whose elements and detectors.
    rows : iterable of LedgerRow
        That effects add to the ledger.
    groups : iterable of (str, tuple of int, tuple of str, str, float, str)
        Effect, shape, labels, unit, scale and name of the count of the cells that effects bring,
        see `CellGroup`.
    parts : int
        Into which each row of the ledger is divided, 0 where they are not.
    """
    named = (*ROWS, *rows)
    cell = len(scene.element) + len(named)
    found = []
    for n, element in enumerate(scene.element):
        if element.detector is None:
            continue
        power = cell
        cell += 1
        tallies = []
        for name, filters in element.detector.tallies(element, scene.spectrum):
            tallies.append(TallyCells(name, cell, filters))
            cell += tallies[-1].size
        paths = element.detector.paths or 0
        found.append(DetectorCells(n, power, tuple(tallies), paths))
    brought = []
    for effect, shape, labels, unit, scale, counted_as in groups:
        brought.append(CellGroup(effect, cell, shape, labels, unit, scale, counted_as))
        cell += brought[-1].size
    n, divided = len(scene.element), cell if parts else 0
    cell += (n + len(named)) * parts
    return TallyLayout(
        n, named, tuple(found), tuple(brought), cell + 1, parts=parts, divided=divided
    )
