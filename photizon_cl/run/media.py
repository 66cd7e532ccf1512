"""Whether the faces that light goes between agree about the medium that lies there.

Media are not tracked: the side on which a face is met says which index the light is in. A face that
is the wrong way round therefore bends light as if it came out of glass where it goes in, and
nothing fails. Some rays are followed, and the index behind each segment's start is compared with
the one before its end. Of light that comes from a source, nothing says which medium that is in; but
where it is met as from glass and also ends in glass, all of it would have to be in glass.
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

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
    if not any(e.surface.refracts for e in scene.element) or len(scene.element) > _MOST_ELEMENTS:
        return []
    run = dataclasses.replace(scene.run, roulette_floor=0.0)
    found = paths(
        without_bins(dataclasses.replace(scene, run=run)),
        max(_RAYS, len(scene.source)),
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
        self.indices = [e.surface.indices for e in scene.element]
        self.clashes: dict[tuple[int, float, int, float], _Meeting] = defaultdict(_Meeting)
        self.met: dict[int, float] = defaultdict(float)
        """Weight that meets each refracting element in a medium that is known."""
        self.launched: dict[tuple[int, float], _Meeting] = defaultdict(_Meeting)
        """What comes from the sources, by the element that it meets first and the index there."""
        self.ends: dict[float, float] = defaultdict(float)
        """Weight that ends, by the index of the medium."""
        self._go(*_sides(scene, found, device))

    def _go(self, start_side: NDArray[np.int64], end_side: NDArray[np.int64]) -> None:
        found = self.found
        at = np.full(len(found), np.nan)  # index that the segment is in, where a face said it
        said_by = np.full(len(found), -1)
        for n, (parent, met, weight) in enumerate(
            zip(found.parent.tolist(), found.element.tolist(), found.weight.tolist(), strict=True)
        ):
            if parent >= 0:
                left = int(found.element[parent])
                both = self.indices[left]
                if both is None:  # reflected, or it passed
                    at[n], said_by[n] = at[parent], said_by[parent]
                elif start_side[n]:
                    at[n], said_by[n] = both[int(start_side[n] > 0)], left
            both = self.indices[met] if met >= 0 else None
            if both is None:
                if not np.isnan(at[n]) and ENDINGS[found.ending[n]] in ("escaped", "absorbed"):
                    self.ends[float(at[n])] += weight
                continue
            if not end_side[n]:
                continue
            index = both[int(end_side[n] > 0)]
            if np.isnan(at[n]):
                self.launched[met, index].weight += weight
                self.launched[met, index].segments += 1
                continue
            self.met[met] += weight
            if abs(index - at[n]) > _SAME * index:
                clash = self.clashes[int(said_by[n]), float(at[n]), met, index]
                clash.weight += weight
                clash.segments += 1

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
        a, b = self.scene.element[left], self.scene.element[met]
        return (
            f'light that leaves "{a.name}" in a medium of index {index:.9g} meets "{b.name}" as '
            f"from one of {other:.9g} ({100.0 * part:.3g} % of what meets it, by a pilot): "
            + self._causes(left, index, met, other)
        )

    def _causes(self, left: int, index: float, met: int, other: float) -> str:
        # one that has these two indices fits the other way round; a body is its own inside
        fits = []
        for n in (left, met):
            face, both = self.scene.element[n].sole_face, self.indices[n]
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
        names = " or ".join(f'"{self.scene.element[n].name}"' for n in fits)
        return f"{names} is the wrong way round, and the opposite axis turns it; or an {indices}"

    def _in_glass_throughout(self) -> list[str]:
        """Ask where light comes in as from glass and ends in glass."""
        ends = sum(self.ends.values())
        first = max(self.launched.items(), key=lambda row: row[1].weight, default=None)
        if first is None or not ends:
            return []
        (met, index), meeting = first
        if index == 1.0 or meeting.segments < _LEAST or self.ends[index] < _THROUGHOUT * ends:
            return []
        name = self.scene.element[met].name
        said = (
            f'light of the sources meets "{name}" as from a medium of index {index:.9g}, and most '
            "of it ends in that too: unless all of the scene is in it, faces are the wrong way "
            "round, and the opposite axis turns them"
        )
        return [said]


def _sides(
    scene: Scene, found: Paths, device: DeviceRecord | str | None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return on which side of the faces at its ends each segment lies.

    1 on the side of the normal, -1 behind it, 0 where that is not known. Seen from the middle of
    the segment, where no face is near.
    """
    along = found.end - found.start
    middle = found.start + 0.5 * along
    inside = np.flatnonzero((along != 0.0).any(axis=1))
    before = np.where(found.parent >= 0, found.element[found.parent], -1)
    sides = []
    for towards, wanted in ((-along, before), (along, found.element)):
        side = np.zeros(len(found), np.int64)
        seen = probe(scene, middle[inside], towards[inside], device)
        known = (seen.element == wanted[inside]) & (seen.element >= 0)
        facing = -(towards[inside] * seen.normal).sum(axis=1)
        side[inside[known]] = np.sign(facing[known])
        sides.append(side)
    return sides[0], sides[1]
