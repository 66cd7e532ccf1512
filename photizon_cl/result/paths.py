"""The paths that a few rays took: every segment, as arrays and as polylines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.compile.rays import beams_of, share_rays
from photizon_cl.errors import counted

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from photizon_cl.scene.model import Scene

__all__ = ["ENDINGS", "Paths", "Polyline"]

ENDINGS: Final = ("goes on", "absorbed", "escaped", "depth-capped", "roulette", "not followed")
"""How a segment ends, by its code in `Paths.ending`."""

_ESCAPED: Final = ENDINGS.index("escaped")


@dataclass(frozen=True, eq=False)
class Polyline:
    """A ray from where it is launched, or splits off another one, to where it ends.

    Parameters
    ----------
    ray : int
        Number of the launched ray.
    points : ndarray, shape (k, 3), float64
        In metres; the last one of a ray that escapes is where drawing it ends.
    weight : ndarray, shape (k − 1,), float64
        Of each segment, relative to the heaviest launched ray of the scene.
    generation : ndarray, shape (k − 1,), int64
        Surface interactions before each segment.
    element : ndarray, shape (k − 1,), int64
        Number of the element that each segment ends on; −1 where it meets none.
    ending : str
        How it ends: one of `ENDINGS`.
    parent : int
        Segment of `Paths` that it splits off, −1 for a launched ray.
    line : int or None
        Number of the line or band of the scene's spectrum that it is of; None without one.
    wavelength_nm : float or None
        Wavelength of its line in nanometres; None in a band, where each ray has its own, and
        without a spectrum.
    """

    ray: int
    points: NDArray[np.float64]
    weight: NDArray[np.float64]
    generation: NDArray[np.int64]
    element: NDArray[np.int64]
    ending: str
    parent: int
    line: int | None = None
    wavelength_nm: float | None = None


@dataclass(frozen=True, eq=False)
class Paths:
    """Every segment of some rays and their children, ray by ray, depth first.

    Iterating gives a `Polyline` for every launched ray and every child that split off.

    Parameters
    ----------
    scene : Scene
        The scene as run: the rays are of its batches, with its seed and generation cap in
        ``[run]``.
    ray : ndarray, shape (n,), int64
        Number of the launched ray that each segment belongs to.
    start, end : ndarray, shape (n, 3), float64
        In metres. A segment that meets nothing ends after `escape_length`; one that a medium
        absorbs on its way to a face ends there.
    weight : ndarray, shape (n,), float64
        Relative to the heaviest launched ray.
    generation : ndarray, shape (n,), int64
        Surface interactions before the segment.
    path : ndarray, shape (n,), uint64
        Place in the ray's tree of children: 1 for the launched ray, and for what a split gives
        2p (transmitted) and 2p + 1 (reflected), hashed where that no longer fits.
    element : ndarray, shape (n,), int64
        Number of the element that it ends on, −1 where it meets none.
    parent : ndarray, shape (n,), int64
        The segment that it continues or splits off, −1 for a launched ray.
    begins : ndarray, shape (n,), bool
        Whether a polyline begins here: a launch, or a reflected child.
    ending : ndarray, shape (n,), int64
        How it ends, an index into `ENDINGS`.
    unit_power : float
        Watts of weight 1.
    escape_length : float
        Metres that escaping segments are given for drawing.
    ledger : dict of str to float
        Watts by row of what was followed: ``absorbed by NAME``, escaped, roulette killed, roulette
        boosted, depth-capped, and those that effects bring, as ``absorbed in MEDIUM``. These are
        the rows of one batch of a trace, bit for bit, where nothing was cut. Empty where only some
        paths were picked.
    cut : ndarray of int64
        Numbers of the rays that have more segments than were asked for.
    """

    scene: Scene
    ray: NDArray[np.int64]
    start: NDArray[np.float64]
    end: NDArray[np.float64]
    weight: NDArray[np.float64]
    generation: NDArray[np.int64]
    path: NDArray[np.uint64]
    element: NDArray[np.int64]
    parent: NDArray[np.int64]
    begins: NDArray[np.bool_]
    ending: NDArray[np.int64]
    unit_power: float
    escape_length: float
    ledger: dict[str, float]
    cut: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.ray)

    def __iter__(self) -> Iterator[Polyline]:
        firsts = np.flatnonzero(self.begins)
        lines, spectrum = self.line, self.scene.spectrum
        single = spectrum.wavelengths_nm if spectrum is not None else None
        for a, b in zip(firsts, [*firsts, len(self.ray)][1:], strict=True):
            line = None if lines is None else int(lines[a])
            yield Polyline(
                ray=int(self.ray[a]),
                points=np.vstack([self.start[a:b], self.end[b - 1 : b]]),
                weight=self.weight[a:b],
                generation=self.generation[a:b],
                element=self.element[a:b],
                ending=ENDINGS[self.ending[b - 1]],
                parent=int(self.parent[a]),
                line=line,
                wavelength_nm=None if line is None or single is None else single[line],
            )

    @property
    def line(self) -> NDArray[np.int64] | None:
        """Number of the line or band of the spectrum of each segment's ray; None without one."""
        if self.scene.spectrum is None:
            return None
        rays = self.scene.run.rays_per_batch
        ends = np.cumsum(share_rays(self.scene, rays))
        lines = np.array([beam.line for beam in beams_of(self.scene)], np.int64)
        return lines[np.searchsorted(ends, self.ray % rays, side="right")]

    @property
    def power(self) -> NDArray[np.float64]:
        """Power that each segment carries, in watts.

        All rays of a batch of the scene as run together launch the sources' flux.
        """
        return self.weight * self.unit_power

    @property
    def launched(self) -> int:
        """How many launched rays have segments here."""
        return len(np.unique(self.ray))

    @property
    def escaped(self) -> NDArray[np.bool_]:
        """Which segments leave the scene."""
        return np.asarray(self.ending == _ESCAPED)

    @property
    def advisories(self) -> list[str]:
        """What was left out, one sentence each; empty where nothing was."""
        said = []
        if len(self.cut):
            numbers = ", ".join(map(str, self.cut[:5])) + (" …" if len(self.cut) > 5 else "")
            said.append(
                f"{len(self.cut)} of {counted(self.launched, 'ray')} (number {numbers}) have "
                "more segments than max_segments and are not shown to their ends"
            )
        capped = self.ledger.get("depth-capped", 0.0)
        if capped > 0.0:
            said.append(
                f"{capped:.3g} W reached the generation cap of {self.scene.run.generation_cap} "
                "and is not followed further"
            )
        return said
