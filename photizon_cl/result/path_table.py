"""The path table of a detector: which sequences of faces and events bring how much light to it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, overload

import numpy as np

from photizon_cl.errors import ArgumentError, show
from photizon_cl.result.data_frame import data_frame_of
from photizon_cl.result.ghosts import Ghosts
from photizon_cl.result.path_rows import PathGroup, PathRest, PathRow
from photizon_cl.result.path_sums import PathSums, strongest
from photizon_cl.result.trails import EVENTS, Step, sequence, words
from photizon_cl.scene.names import unknown_name

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd
    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import DetectorCells
    from photizon_cl.result.statistics import Accumulator
    from photizon_cl.result.trails import Trails

__all__ = ["OTHER_PATHS", "PathTable"]

OTHER_PATHS: Final = "all other paths"
"""Where the sequence stands of what has no row."""
_SHOWN: Final = 10
_UNKNOWN: Final = "(its example ray was not followed)"


class PathTable(Sequence[PathRow]):
    """The strongest paths to a detector, ranked by power, and what the rest brings.

    Rows and `rest` together are the detector's power to the last bit of its exact tally.

    Parameters
    ----------
    detector : str
        Name of its element.
    rows : tuple of PathRow
        The strongest first; of equal power the one with the lower example ray.
    """

    def __init__(
        self,
        detector: str,
        rows: tuple[PathRow, ...],
        exact: tuple[int, ...],
        columns: NDArray[np.int64],
        about: PathSums,
        *,
        whole: bool = True,
    ) -> None:
        self.detector, self.rows, self._whole = detector, rows, whole
        self._exact, self._columns, self._about = exact, columns, about

    # -- a sequence of rows ----------------------------------------------------------------------

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, at: int, /) -> PathRow: ...

    @overload
    def __getitem__(self, at: slice, /) -> tuple[PathRow, ...]: ...

    def __getitem__(self, at: int | slice, /) -> PathRow | tuple[PathRow, ...]:
        return self.rows[at]

    def __repr__(self) -> str:
        rest = self._about.total_paths - len(self.rows)
        more = "" if self.complete else " or more"
        return (
            f"<PathTable {show(self.detector)}: {len(self.rows)} paths"
            + (f" of {self._about.total_paths}{more}" if rest > 0 else "")
            + f", {self.power:.6g} W>"
        )

    @property
    def complete(self) -> bool:
        """Whether every path that was met was looked at: else there were more than are kept.

        A path that was first met when there were as many as are kept is in `rest`, however strong.
        """
        return self._about.complete

    # -- sums ------------------------------------------------------------------------------------

    @property
    def power(self) -> float:
        """W of all rows together."""
        return self._about.watts(self.exact)

    @property
    def exact(self) -> int:
        """All rows together in units of 2^-95 launched weights, over all batches: no rounding."""
        return sum(self._exact)

    @cached_property
    def sigma(self) -> float | None:
        """Standard error of `power`."""
        return self._about.sigma(self._columns, self.rows)

    @cached_property
    def rest(self) -> PathRest:
        """What is left of the detector's power: paths that are not in the table."""
        about = self._about
        left = about.power_exact - self.exact
        count = about.power_count - sum(row.count for row in self.rows)
        sigma = about.rest_sigma(self._columns, self.rows) if count else about.nothing
        paths = max(about.total_paths - len(self.rows), 1 if count else 0)
        bounded = bool(count) and about.rest_is_bounded(self._columns)
        return PathRest(about.watts(left), sigma, count, paths, left, bounded)

    # -- parts -----------------------------------------------------------------------------------

    def filter(
        self,
        *,
        via: str | Sequence[str] = (),
        avoiding: str | Sequence[str] = (),
        event: str | None = None,
        ghost_order: int | None = None,
        interactions: int | None = None,
    ) -> PathTable:
        """Return the rows that match all of what is given; `rest` is then all that does not.

        Parameters
        ----------
        via : str or sequence of str, optional
            Elements (``window``) or faces (``window.back``), perhaps with an event
            (``window.back r``), that the path must all meet.
        avoiding : str or sequence of str, optional
            Such that it must not meet.
        event : str, optional
            A letter that must occur: ``r``, ``t``, ``i`` or ``s``.
        ghost_order, interactions : int, optional
            Exactly so many.

        Raises
        ------
        ArgumentError
            Where something is named that no row meets because the scene has no such thing.
        """
        if event is not None and event not in EVENTS.values():
            raise ArgumentError(f"event: found {show(event)}, expected one of r, t, i, s")
        with_all = [self._test(name) for name in _names(via)]
        with_none = [self._test(name) for name in _names(avoiding)]
        asked = with_all or with_none or event is not None or ghost_order is not None
        kept = [
            n
            for n, row in enumerate(self.rows)
            if (row.known or not asked)
            and all(any(map(test, row.steps)) for test in with_all)
            and not any(any(map(test, row.steps)) for test in with_none)
            and (event is None or event in row.events)
            and (ghost_order is None or row.ghost_order == ghost_order)
            and (interactions is None or row.interactions == interactions)
        ]
        return self._some(kept)

    def _some(self, kept: list[int]) -> PathTable:
        rows = tuple(self.rows[n] for n in kept)
        exact = tuple(self._exact[n] for n in kept)
        return PathTable(self.detector, rows, exact, self._columns[kept], self._about, whole=False)

    def _test(self, name: str) -> Callable[[Step], bool]:
        known = self._about.places
        place, _, letter = name.strip().rpartition(" ")
        if name.strip() in known or letter not in EVENTS.values():
            place, letter = name.strip(), ""
        if place not in known:
            raise unknown_name("elements and faces (an event may follow: r, t, i, s)", name, known)
        matching = known[place]

        def test(step: Step) -> bool:
            return (step.element, step.face) in matching and letter in ("", step.event)

        return test

    def grouped(self, by: str = "events") -> tuple[PathGroup, ...]:
        """Return the rows in groups, the strongest group first.

        Parameters
        ----------
        by : str
            ``"events"`` (``tt``, ``trrt``), ``"ghost_order"``, ``"elements"`` (the elements met, in
            order of first meeting) or ``"last"`` (the last element before the detector).

        Raises
        ------
        ArgumentError
            Where `by` is something else.
        """
        keys: dict[str, Callable[[PathRow], str]] = {
            "events": lambda row: row.events or "direct",
            "ghost_order": lambda row: str(row.ghost_order),
            "elements": lambda row: (
                " > ".join(dict.fromkeys(step.element for step in row.steps)) or "direct"
            ),
            "last": lambda row: row.steps[-1].element if row.steps else "direct",
        }
        if by not in keys:
            raise ArgumentError(f"by: found {show(by)}, expected one of {', '.join(keys)}")
        found: dict[str, list[int]] = {}
        for n, row in enumerate(self.rows):
            label = keys[by](row) if row.known else _UNKNOWN
            found.setdefault(label, []).append(n)
        parts = [(label, self._some(numbers)) for label, numbers in found.items()]
        groups = [
            PathGroup(
                label,
                part.power,
                part.sigma,
                sum(r.count for r in part),
                part.rows,
                self._about.is_bounded(part._columns),
            )
            for label, part in parts
        ]
        return tuple(sorted(groups, key=lambda g: (-g.power, g.label)))

    def ghosts(self) -> Ghosts:
        """Return the two-reflection ghosts as a matrix over pairs of refracting faces."""
        pairs: dict[tuple[str, str], list[int]] = {}
        for n, row in enumerate(self.rows):
            if row.ghost_order == 2:
                first, second = (s.place for s in row.steps if s.refracting and s.event == "r")
                pairs.setdefault((first, second), []).append(n)
        faces = list(dict.fromkeys(self._about.refracting))
        return Ghosts(
            faces,
            {
                pair: (part.power, part.sigma, sum(row.count for row in part))
                for pair, numbers in pairs.items()
                for part in [self._some(numbers)]
            },
        )

    # -- other forms -----------------------------------------------------------------------------

    def to_dataframe(self) -> pd.DataFrame:
        """Return the rows as a data frame of pandas, and behind those of a whole table the rest.

        Columns ``sequence``, ``power``, ``sigma`` (W; NaN with a single batch), ``count``,
        ``interactions``, ``ghost_order``, ``example_ray``; the last three are unknown
        (``pandas.NA``) of the rest, which is there where something arrived by other paths.

        Raises
        ------
        PhotizonError
            Where pandas is not installed.
        """
        names = (
            "sequence",
            "power",
            "sigma",
            "count",
            "interactions",
            "ghost_order",
            "example_ray",
        )
        columns = {name: [getattr(row, name) for row in self.rows] for name in names}
        if self._whole and self.rest.count:
            rest = {"sequence": OTHER_PATHS, **vars(self.rest)}
            for name, column in columns.items():
                column.append(rest.get(name))
        columns["sigma"] = [math.nan if s is None else s for s in columns["sigma"]]
        made = data_frame_of(columns)
        # numbers stay whole beside one that is not known
        whole = dict.fromkeys(names[3:], "Int64")
        return made.astype({"sequence": object, "power": float, "sigma": float, **whole})

    def summary(self) -> dict[str, Any]:
        """Return what the summary says: how many, the strongest, and the rest."""
        return {
            "rows": len(self.rows),
            "strongest": [row.summary() for row in self.rows[:_SHOWN]],
            "rest": self.rest.summary(),
            "complete": self.complete,
        }

    @classmethod
    def of(
        cls,
        compiled: CompiledScene,
        tally: Accumulator,
        d: DetectorCells,
        number: int,
        trails: Trails | None,
    ) -> PathTable:
        """Return the table of a detector, by its number among the scene's detectors."""
        sums = tally.keyed
        assert sums is not None
        mine = strongest(sums, number, d.paths)
        about = PathSums(compiled, tally, d, number)
        known = {} if trails is None else trails.by_key
        made: dict[int, Step] = {}
        errors = np.sqrt(sums.m2[mine] / max(tally.batches - 1, 1) / max(tally.batches, 1))
        rows, exact = [], []
        for at, error in zip(mine.tolist(), errors.tolist(), strict=True):
            exact.append(sums.exact(at))
            interactions = int(sums.about[at] & 0xFFFFFFFF)
            steps = known.get(int(sums.keys[at]))
            found = () if steps is None else words(compiled.scene, steps, made)
            told = steps is not None or not interactions
            rows.append(
                PathRow(
                    sequence(found, about.name) if told else f"{_UNKNOWN} > {about.name}",
                    about.watts(exact[-1]),
                    error * compiled.unit_power if tally.batches > 1 else None,
                    int(sums.count[at]),
                    interactions,
                    sum(s.refracting and s.event == "r" for s in found) if told else None,
                    int(sums.first[at]),
                    found,
                )
            )
        return cls(about.name, tuple(rows), tuple(exact), mine, about)


def _names(given: str | Sequence[str]) -> tuple[str, ...]:
    return (given,) if isinstance(given, str) else tuple(given)
