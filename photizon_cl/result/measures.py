"""What a sweep measures at each point: a quantity, a ratio of two, a point source transmittance.

PST, the point source transmittance of stray-light engineers, is the mean irradiance of a detector
over the irradiance of the beam in its own cross-section, E_detector/E_beam (E. Fest, Stray Light
Analysis and Control, SPIE Press, 2013). The irradiance of the beam is taken across the beam and not
on the tilted entrance: no cosine of the angle of incidence stands in it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.compile.quantities import quantity_of, scalars
from photizon_cl.errors import ArgumentError, Problem, ResultError, join, key, show, with_article
from photizon_cl.result.comparison import error_of_mean
from photizon_cl.scene.parameter_paths import quoted
from photizon_cl.scene.registry import ELEMENTS, SOURCES

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.result.estimates import Estimates
    from photizon_cl.scene.model import Scene

__all__ = ["Measure", "Measured", "measured_by", "measures_of"]

_FORMS: Final = (
    '"detectors.NAME.power", { ratio = [Q, Q] } or { pst = "DETECTOR", source = "SOURCE" }'
)
_MOST_SCALARS: Final = 1000
"""Scalars that a sweep without measures takes down; of more it has to be told which."""


@dataclass(frozen=True, eq=False)
class Measured:
    """What a measure says at a point.

    Parameters
    ----------
    value : float or None
        None where it has none: a ratio to nothing.
    sigma : float or None
        Its standard error; None with a single batch.
    count : int or None
        Arrivals, where they are counted.
    batches : ndarray, shape (batches,), or None
        Values by batch whose mean is the value and whose scatter its standard error, of a ratio to
        first order: with those of another point of the same stream they give paired differences.
    """

    value: float | None
    sigma: float | None
    count: int | None = None
    batches: NDArray[np.float64] | None = None


class Measure(ABC):
    """Something that each point of a sweep is asked for.

    Parameters
    ----------
    name : str
        Of its column.
    """

    unit: str = "1"

    def __init__(self, name: str) -> None:
        self.name = name

    @property
    @abstractmethod
    def meaning(self) -> str:
        """What it is, in one line; of a PST its normalisation."""

    @abstractmethod
    def check(self, scene: Scene, layout: TallyLayout) -> None:
        """See that a scene has it.

        Raises
        ------
        ArgumentError
            Where it has not, and why.
        """

    @abstractmethod
    def of(self, result: Estimates) -> Measured:
        """Return what a result says."""


def _scalar(name: str, scene: Scene, layout: TallyLayout) -> None:
    found = quantity_of(name, scene, layout)
    if found.bins:
        raise ArgumentError(f"{name}: found {found.bins} bins, expected a scalar")


def _batches(result: Estimates, name: str) -> NDArray[np.float64] | None:
    try:
        return result.batch_values(name)
    except ResultError:  # single batches were not kept
        return None


class Single(Measure):
    """A quantity as it is, in watts."""

    unit = "W"

    def __init__(self, name: str, quantity: str) -> None:
        super().__init__(name)
        self.quantity = quantity

    @property
    def meaning(self) -> str:
        """Name the quantity."""
        return self.quantity

    def check(self, scene: Scene, layout: TallyLayout) -> None:
        """See that there is such a scalar."""
        _scalar(self.quantity, scene, layout)

    def of(self, result: Estimates) -> Measured:
        """Return value, σ and count."""
        found = result.quantity(self.quantity)
        return Measured(float(found), found.sigma, found.count, _batches(result, self.quantity))


class Ratio(Measure):
    """One quantity over another of the same run, whose common noise cancels."""

    def __init__(self, name: str, above: str, below: str) -> None:
        super().__init__(name)
        self.above, self.below = above, below

    @property
    def meaning(self) -> str:
        """Name both."""
        return f"{self.above} / {self.below}"

    def check(self, scene: Scene, layout: TallyLayout) -> None:
        """See that there are such scalars."""
        _scalar(self.above, scene, layout)
        _scalar(self.below, scene, layout)

    def of(self, result: Estimates) -> Measured:
        """Return the ratio of the means, and its σ to first order."""
        a, b = result.quantity(self.above), result.quantity(self.below)
        if not float(b):
            return Measured(None, None, a.count)
        ratio = float(a) / float(b)
        x, y = _batches(result, self.above), _batches(result, self.below)
        if x is None or y is None:
            if a.sigma is None or b.sigma is None:
                return Measured(ratio, None, a.count)
            # how they go together is not known: no more than this
            return Measured(ratio, (a.sigma + abs(ratio) * b.sigma) / abs(float(b)), a.count)
        first_order = ratio + (x - ratio * y) / float(b)
        sigma = error_of_mean(first_order) if len(x) > 1 else None
        return Measured(ratio, sigma, a.count, first_order)


class Pst(Measure):
    """Mean irradiance of a detector over the irradiance of a beam in its own cross-section."""

    def __init__(self, name: str, detector: str, source: str) -> None:
        super().__init__(name)
        self.detector, self.source = detector, source

    @property
    def meaning(self) -> str:
        """State the normalisation."""
        return (
            f"(P/A)/(Φ/S): mean irradiance of {self.detector!r}, its power P over the area A "
            f"of the side that it counts, over the irradiance of the beam of {self.source!r}, its "
            "flux Φ over its own cross-section S (across the beam, no cosine)"
        )

    def check(self, scene: Scene, layout: TallyLayout) -> None:
        """See that both are there, that the source is a beam, and that nothing else shines."""
        source = scene.source[self.source]
        beams = ", ".join(kind for kind, cls in SOURCES.items() if cls.is_beam)
        if source.beam_area is None:
            raise ArgumentError(
                f"source: found {show(self.source)}, {with_article(source.kind)}, expected a "
                f"source with a beam ({beams}): the light of others has no cross-section of its "
                "own to be normalised by"
            )
        others = [s.name for s in scene.source if s.name != self.source]
        if others:
            raise ArgumentError(
                f"source: found {show(self.source)} beside {', '.join(map(show, others))}, "
                "expected it alone: a detector does not tell whose light arrives"
            )
        _scalar(self._power(scene), scene, layout)
        element = scene.element[self.detector]
        if not element.has_map:
            kinds = ", ".join(kind for kind, cls in ELEMENTS.items() if cls.has_map)
            raise ArgumentError(
                f"pst: found {show(self.detector)}, {with_article(element.kind)}, expected a "
                f"detector with an irradiance ({kinds})"
            )

    def _power(self, scene: Scene) -> str:
        element = scene.element[self.detector]  # says what there is where it is not there
        return f"detectors.{quoted(element.name)}.power"

    def factor(self, scene: Scene) -> float:
        """Return S/(A Φ), by which a power in watts becomes the PST."""
        source, element = scene.source[self.source], scene.element[self.detector]
        assert source.beam_area is not None
        return source.beam_area / element.area / source.flux

    def of(self, result: Estimates) -> Measured:
        """Return the detector's power, normalised."""
        name, factor = self._power(result.scene), self.factor(result.scene)
        power, values = result.quantity(name), _batches(result, name)
        return Measured(
            float(power) * factor,
            None if power.sigma is None else power.sigma * factor,
            power.count,
            None if values is None else values * factor,
        )


def measures_of(
    given: Mapping[str, Any], scene: Scene, layout: TallyLayout, problems: list[Problem]
) -> list[Measure]:
    """Return the measures that a sweep file names; every scalar where it names none.

    Parameters
    ----------
    given : mapping
        Of the file, by name.
    scene, layout : Scene, TallyLayout
        Of a point: what every scalar is.
    problems : list of Problem
        What is no measure is added.
    """
    if not given:
        names = [q.name for q in scalars(scene, layout)]
        if len(names) > _MOST_SCALARS:
            expected = "a [measure] that names some: a column each is too many"
            problems.append(Problem("measure", f"none, and {len(names)} scalars", expected))
            return []
        return [Single(name, name) for name in names]
    return [made for name, value in given.items() if (made := _read(name, value, problems))]


def _read(name: str, value: object, problems: list[Problem]) -> Measure | None:
    where = join("measure", key(name))
    if isinstance(value, str):
        return Single(name, value)
    keys = set(value) if isinstance(value, dict) else set()
    if isinstance(value, dict) and keys == {"ratio"}:
        pair = value["ratio"]
        if isinstance(pair, list | tuple) and len(pair) == 2 and _texts(*pair):
            return Ratio(name, *pair)
        expected = "two quantities, [above, below]"
        problems.append(Problem(f"{where}.ratio", show(pair), expected))
        return None
    if isinstance(value, dict) and keys == {"pst", "source"} and _texts(*value.values()):
        return Pst(name, value["pst"], value["source"])
    hint = "a PST names its source" if keys == {"pst"} else ""
    problems.append(Problem(where, show(value), _FORMS, hint=hint))
    return None


def _texts(*values: object) -> bool:
    return all(isinstance(value, str) for value in values)


def measured_by(measures: Iterable[Measure], result: Estimates) -> dict[str, Measured]:
    """Return what measures say of a result, by name."""
    return {measure.name: measure.of(result) for measure in measures}
