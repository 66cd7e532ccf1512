"""What the parts of a path table share: the detector's sums by path, and how they become watts."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from photizon_cl.result.ledger import watts
from photizon_cl.result.trails import Step

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import DetectorCells
    from photizon_cl.result.keyed_sums import KeyedSums
    from photizon_cl.result.path_rows import PathRow
    from photizon_cl.result.statistics import Accumulator

__all__ = ["PathSums", "strongest"]


def strongest(sums: KeyedSums, detector: int, most: int) -> NDArray[np.int64]:
    """Return which keys are a detector's strongest paths, by falling power, then by example."""
    mine = np.flatnonzero(sums.about >> 32 == detector)
    limbs = sums.limbs[mine]
    rank = np.lexsort(
        (sums.keys[mine], sums.first[mine], -limbs[:, 3], -limbs[:, 2], -limbs[:, 1], -limbs[:, 0])
    )
    return np.asarray(mine[rank[:most]], np.int64)


class PathSums:
    """The sums of all paths to a detector, by its number among the scene's detectors."""

    def __init__(
        self, compiled: CompiledScene, tally: Accumulator, d: DetectorCells, number: int
    ) -> None:
        self.compiled, self.batches = compiled, tally.batches
        assert tally.keyed is not None
        self.sums = tally.keyed
        self.name = compiled.scene.element[d.element].name
        self.power_exact = tally.exact(d.power)
        self.power_count = int(tally.counts(d.power, 1)[0])
        self.power_values = tally.batch_values.of(d.power)
        self.power_sigma = float(tally.standard_error(d.power, 1)[0])
        self.total_paths = int(np.count_nonzero(self.sums.about >> 32 == number))
        self.complete = not self.sums.full(number)
        self.nothing = 0.0 if tally.batches > 1 else None

    def watts(self, exact: int) -> float:
        """Return W of a power in units of 2^-95 launched weights."""
        return watts(self.compiled, exact, self.batches)

    @property
    def table(self) -> NDArray[np.float64]:
        """What each batch gave by the paths that are followed, shape (batches, paths)."""
        return self.sums.table()

    @cached_property
    def places(self) -> dict[str, frozenset[tuple[str, str]]]:
        """What `via` may name: elements and faces."""
        found: dict[str, set[tuple[str, str]]] = {}
        for element in self.compiled.scene.element:
            for face in element.face_names:
                step = Step(element.name, face, "", refracting=False)
                plain = f"{element.name}.{face}"
                for name in (element.name, plain, step.place):
                    found.setdefault(name, set()).add((element.name, face))
        return {name: frozenset(pairs) for name, pairs in found.items()}

    @property
    def refracting(self) -> list[str]:
        """Every refracting face, in file order."""
        return [
            Step(element.name, face, "", refracting=True).place
            for element in self.compiled.scene.element
            for face in dict.fromkeys(
                face.name for n, face in enumerate(element.faces) if element.surface_of(n).refracts
            )
        ]

    def _split(self, columns: NDArray[np.int64]) -> tuple[NDArray[np.float64], float]:
        """Return the batches' sums of the paths that are followed, and a bound for the others."""
        followed = columns[columns < self.table.shape[1]]
        others = columns[columns >= self.table.shape[1]]
        n = self.batches
        bound = float(np.sqrt(self.sums.m2[others] / (n - 1) / n).sum())
        return self.table[:, followed].sum(axis=1), bound

    def _error(self, values: NDArray[np.float64], bound: float) -> float:
        own = float(values.std(ddof=1)) / math.sqrt(self.batches)
        return (own + bound) * self.compiled.unit_power

    def sigma(self, columns: NDArray[np.int64], rows: tuple[PathRow, ...]) -> float | None:
        """Return the standard error of a sum of paths."""
        if self.batches < 2:
            return None
        if len(rows) == 1:
            return rows[0].sigma
        return self._error(*self._split(columns))

    def is_bounded(self, columns: NDArray[np.int64]) -> bool:
        """Say whether the σ of a sum of paths is an upper bound."""
        single = self.batches < 2 or len(columns) == 1
        return not single and bool((columns >= self.table.shape[1]).any())

    def rest_is_bounded(self, columns: NDArray[np.int64]) -> bool:
        """Say whether the σ of the power without some paths is an upper bound."""
        if self.batches < 2:
            return False
        return self.power_values is None or bool((columns >= self.table.shape[1]).any())

    def rest_sigma(self, columns: NDArray[np.int64], rows: tuple[PathRow, ...]) -> float | None:
        """Return the standard error of the power without some paths."""
        if self.batches < 2:
            return None
        values, bound = self._split(columns)
        if self.power_values is None:
            own = self.sigma(columns, rows) or 0.0
            return own + self.power_sigma * self.compiled.unit_power
        return self._error(self.power_values - values, bound)
