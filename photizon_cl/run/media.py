"""Whether the faces that light goes between agree about the medium that lies there.

Which index the light is in, the side says on which a face is met; media are tracked only where the
scene names some, and then counted (`counted_by_pilot`). A face that is the wrong way round
therefore bends light as if it came out of glass where it goes in, and nothing fails. Some rays are
followed, and the index behind each segment's start is compared with the one before its end. Of
light that comes from a source, nothing says which medium that is in where the scene names none; but
where it is met as from glass and also ends in glass, all of it would have to be in glass.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.result.paths import ENDINGS
from photizon_cl.run.pathing import paths
from photizon_cl.run.pilot import without_bins
from photizon_cl.run.probing import probe
from photizon_cl.scene.faces import Ball

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hostcode.device.device import DeviceRecord
    from photizon_cl.result.paths import Paths
    from photizon_cl.scene.model import Scene

__all__ = ["clashing_media"]

_RAYS: Final = 4096
_SEED: Final = 0x6D65646961
_CAP: Final = 64
_SEGMENTS: Final = 64
_MOST_ELEMENTS: Final = 1000
"""Beyond these a probe of all segments takes long, as where very many faces lie in one place."""
_PART: Final = 0.2
"""Part of the light that meets a face, by faces that say its medium, before a clash is told: what
is left in a body after two reflections may well leave it where its side was not modelled."""
_THROUGHOUT: Final = 0.9
"""Part of the light that ends in glass where all of the scene seems to be in it."""
_LEAST: Final = 3
"""Segments that show it."""
_NAMED: Final = 3
_SHORT: Final = 2.0**-44
"""Part of its ends' coordinates that a segment must be long."""
_SAME: Final = 1e-6
"""Relative difference of indices that are taken as equal: that of tables to six digits."""


@dataclass
class _Meeting:
    """What meets a face, with segments of each kind."""

    weight: float = 0.0
    segments: int = 0


def clashing_media(scene: Scene, device: DeviceRecord | str | None = None) -> list[str]:
    """Return a sentence for each pair of faces between which light is in two media at once.

    Parameters
    ----------
    scene : Scene
        Any; nothing is traced where nothing refracts, or of more than 1000 elements.
    device : DeviceRecord or str, optional
        As in `photizon_cl.trace`.

    Raises
    ------
    ArgumentError, RunError
        Where there is no usable device, or it fails.
    """
    if (
        not any(s.refracts for e in scene.element for s in e.surfaces)
        or len(scene.element) > _MOST_ELEMENTS
    ):
        return []
    run = dataclasses.replace(scene.run, roulette_floor=0.0)
    found = paths(
        without_bins(dataclasses.replace(scene, run=run)),
        max(_RAYS, scene.fewest_rays),
        _SEED,
        generation_cap=min(run.generation_cap, _CAP),
        max_segments=_SEGMENTS,
        device=device,
    )
    return _Walk(scene, found, device).sentences()


class _Walk:
    """The segments of some rays, and what their ends say of the media that they are in."""

    def __init__(self, scene: Scene, found: Paths, device: DeviceRecord | str | None) -> None:
        self.scene, self.found = scene, found
        self.places = _Places(scene)
        self.indices = self.places.indices
        index_of = scene.index_of(scene.reference_nm)
        of_sources = {index_of[s.medium] for s in scene.source} if scene.names_media else ()
        self.launched_in = next(iter(of_sources)) if len(of_sources) == 1 else None
        """Index of the medium that all sources are in, where the scene says so."""
        self.clashes: dict[tuple[int, float, int, float], _Meeting]
        self.met: NDArray[np.float64]
        """Weight that meets each refracting element in a medium that is known."""
        self.launched: dict[tuple[int, float], _Meeting]
        """What comes from the sources, by the element that it meets first and the index there."""
        self.ends: dict[float, float]
        """Weight that ends, by the index of the medium."""
        self._go(*_sides(scene, found, device))

    def _go(
        self,
        start_side: NDArray[np.int64],
        end_side: NDArray[np.int64],
        start_face: NDArray[np.int64],
        end_face: NDArray[np.int64],
    ) -> None:
        found, weight = self.found, self.found.weight
        met = self.places.of(found.element, end_face)
        # the last row is that of no element, which is number -1
        both = np.array([*(pair or (np.nan, np.nan) for pair in self.indices), (np.nan, np.nan)])
        bends = ~np.isnan(both[:, 0])
        goes_on = found.parent >= 0
        before = np.where(goes_on, found.element[found.parent], -1)
        left = self.places.of(before, start_face)
        told = bends[left] & (start_side != 0)
        at = np.where(told, both[left, (start_side > 0).astype(int)], np.nan)
        said_by = np.where(told, left, -1)
        if self.launched_in is not None:
            at[~goes_on] = self.launched_in
        # what is reflected, or passes, is where the segment before it was
        origin = np.where(goes_on & ~bends[left], found.parent, np.arange(len(found)))
        while (further := origin[origin]).tolist() != origin.tolist():
            origin = further
        at, said_by = at[origin], said_by[origin]
        known = ~np.isnan(at)

        over = np.isin(found.ending, (ENDINGS.index("escaped"), ENDINGS.index("absorbed")))
        ends = _grouped(known & over & ~bends[met], weight, at)
        self.ends = {index: meeting.weight for (index,), meeting in ends.items()}
        seen = bends[met] & (end_side != 0)
        index = both[met, (end_side > 0).astype(int)]
        self.launched = _grouped(seen & ~known, weight, met, index)
        seen &= known
        n = len(self.indices)
        self.met = np.bincount(met[seen], weight[seen], n).astype(np.float64)
        other = np.abs(index - at) > _SAME * index
        # a wrong medium before a face that names its own is counted: see counted_by_pilot
        other &= (said_by >= 0) | ~np.array([*self.places.named, False])[met]
        self.clashes = _grouped(seen & other, weight, said_by, at, met, index)

    def sentences(self) -> list[str]:
        """Return what is worth a word, the strongest first, each pair of faces once."""
        pairs: dict[frozenset[int], tuple[float, str]] = {}
        for (left, index, met, other), clash in self.clashes.items():
            if clash.segments < _LEAST or clash.weight < _PART * self.met[met]:
                continue
            pair = frozenset((left, met))
            if pair not in pairs or pairs[pair][0] < clash.weight:
                part = clash.weight / self.met[met]
                pairs[pair] = clash.weight, self._sentence(left, index, met, other, part)
        strongest = sorted(pairs.values(), key=lambda row: -row[0])
        return [text for _, text in strongest[:_NAMED]] or self._in_glass_throughout()

    def _sentence(self, left: int, index: float, met: int, other: float, part: float) -> str:
        a = self.places.names[left] if left >= 0 else "the sources"
        b = self.places.names[met]
        return (
            f"light that leaves {a} in a medium of index {index:.9g} meets {b} as "
            f"from one of {other:.9g} ({100.0 * part:.3g} % of what meets it, by a pilot): "
            + self._causes(left, index, met, other)
        )

    def _causes(self, left: int, index: float, met: int, other: float) -> str:
        # one that has these two indices fits the other way round; a body is its own inside
        fits = []
        for n in (left, met) if left >= 0 else (met,):
            face, both = self.scene.element[self.places.owner[n]].sole_face, self.indices[n]
            if face is None or isinstance(face, Ball) or both is None:
                continue
            if np.allclose(sorted(both), sorted((index, other)), rtol=_SAME, atol=0.0):
                fits.append(n)
        indices = (
            "index or index_outside of one is not what is meant, or the body between them is open "
            "at its side, or bodies overlap"
        )
        if not fits:
            return f"an {indices}"
        names = " or ".join(self.places.names[n] for n in fits)
        return f"{names} is the wrong way round, and the opposite axis turns it; or an {indices}"

    def _in_glass_throughout(self) -> list[str]:
        """Ask where light comes in as from glass and ends in glass."""
        ends = sum(self.ends.values())
        first = max(self.launched.items(), key=lambda row: row[1].weight, default=None)
        if first is None or not ends:
            return []
        (met, index), meeting = first
        if (
            self.scene.names_media
            or index == 1.0
            or meeting.segments < _LEAST
            or self.ends.get(index, 0.0) < _THROUGHOUT * ends
        ):
            return []
        name = self.places.names[met]
        said = (
            f"light of the sources meets {name} as from a medium of index {index:.9g}, and most "
            "of it ends in that too: unless all of the scene is in it, faces are the wrong way "
            "round, and the opposite axis turns them"
        )
        return [said]


class _Places:
    """What has indices of its own: elements, and the faces of those with several surfaces.

    Attributes
    ----------
    owner : list of int
        Number of each one's element.
    indices : list of (float, float) or None
        As `Surface.indices` gives them.
    names : list of str
        For sentences.
    named : list of bool
        Whether its surface names media.
    """

    def __init__(self, scene: Scene) -> None:
        self.owner: list[int] = []
        self.indices: list[tuple[float, float] | None] = []
        self.names: list[str] = []
        self.named: list[bool] = []
        first, several = [], []
        for n, element in enumerate(scene.element):
            first.append(len(self.owner))
            several.append(len(element.surfaces) > 1)
            for k in range(len(element.faces) if several[-1] else 1):
                self.owner.append(n)
                surface = element.surface_of(k)
                self.indices.append(scene.optics[surface].indices)
                self.named.append(surface.media is not None)
                of = f"{element.face_name(k)} of " if several[-1] else ""
                self.names.append(f'{of}"{element.name}"')
        # the last ones are for no element, which is number -1
        self._first, self._several = np.array([*first, -1]), np.array([*several, False])

    def of(self, element: NDArray[np.int64], face: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the numbers of the places that faces of elements are, -1 of none."""
        known = self._several[element] & (face >= 0)
        return np.asarray(self._first[element] + np.where(known, face, 0))


def _sides(
    scene: Scene, found: Paths, device: DeviceRecord | str | None
) -> tuple[NDArray[np.int64], ...]:
    """Return on which side of the faces at its ends each segment lies, and which faces those are.

    1 on the side of the normal, -1 behind it, 0 where that is not known; of faces the numbers, -1
    where they are not known. Seen from the middle of the segment, where no face is near.
    """
    along = found.end - found.start
    middle = found.start + 0.5 * along
    # what is no longer than the rounding of its ends, between faces in one place, has no direction
    size = np.maximum(np.abs(found.start), np.abs(found.end)).max(axis=1)
    inside = np.flatnonzero(np.abs(along).max(axis=1) > _SHORT * size)
    before = np.where(found.parent >= 0, found.element[found.parent], -1)
    sides = np.zeros((2, len(found)), np.int64)
    faces = np.full((2, len(found)), -1, np.int64)
    towards = np.concatenate([-along[inside], along[inside]])
    seen = probe(scene, np.tile(middle[inside], (2, 1)), towards, device)
    facing = np.sign(-(towards * seen.normal).sum(axis=1))
    wanted = np.concatenate([before[inside], found.element[inside]])
    known = (seen.element == wanted) & (seen.element >= 0)
    sides[:, inside] = np.where(known, facing, 0.0).reshape(2, -1)
    numbers = [
        _face_number(scene, n, name) for n, name in zip(seen.element, seen.face, strict=True)
    ]
    faces[:, inside] = np.where(known, numbers, -1).reshape(2, -1)
    return sides[0], sides[1], faces[0], faces[1]


def _face_number(scene: Scene, element: int, name: str) -> int:
    """Return the number of an element's first face of a name, -1 where that makes no difference."""
    met = scene.element[element] if element >= 0 else None
    if met is None or len(met.surfaces) == 1:
        return -1
    return [face.name for face in met.faces].index(name)


def _grouped(
    chosen: NDArray[np.bool_], weight: NDArray[np.float64], *columns: NDArray[Any]
) -> dict[tuple[Any, ...], _Meeting]:
    """Return weight and number of chosen segments by what columns hold, in order of the first."""
    keys = np.zeros(int(chosen.sum()), np.int64)
    for column in columns:
        values, codes = np.unique(column[chosen], return_inverse=True)
        keys = keys * max(len(values), 1) + codes
    _, first, group = np.unique(keys, return_index=True, return_inverse=True)
    weights, segments = np.bincount(group, weight[chosen]), np.bincount(group)
    rows = [column[chosen][first].tolist() for column in columns]
    return {
        tuple(row[n] for row in rows): _Meeting(float(weights[n]), int(segments[n]))
        for n in np.argsort(first).tolist()
    }
