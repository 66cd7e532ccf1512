"""Whether the faces that light goes between agree about the medium that lies there.

Media are not tracked: the side on which a face is met says which index the light is in. A face that
is the wrong way round therefore bends light as if it came out of glass where it goes in, and
nothing fails. A few rays are followed, and the index behind each segment's start is compared with
the one before its end.
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.run.pathing import paths
from photizon_cl.run.pilot import without_bins
from photizon_cl.run.probing import probe

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hostcode.device.device import DeviceRecord
    from photizon_cl.result.paths import Paths
    from photizon_cl.scene.model import Scene

__all__ = ["clashing_media"]

_RAYS: Final = 256
_SEED: Final = 0x6D65646961
_CAP: Final = 16
_SEGMENTS: Final = 128
_NOTED: Final = 0.01
"""Part of the emitted power that meets a clash before it is worth a word: what is left in a body
after two reflections may well leave it where its side was not modelled."""
_NAMED: Final = 3


def clashing_media(scene: Scene, device: DeviceRecord | str | None = None) -> list[str]:
    """Return a sentence for each pair of faces between which light is in two media at once.

    Parameters
    ----------
    scene : Scene
        Any; nothing is traced where fewer than two elements refract.
    device : DeviceRecord or str, optional
        As in `photizon_cl.trace`.

    Raises
    ------
    ArgumentError, RunError
        Where there is no usable device, or it fails.
    """
    if sum(e.surface.refracts for e in scene.element) < 2:
        return []
    run = scene.run
    found = paths(
        without_bins(dataclasses.replace(scene, run=dataclasses.replace(run, roulette_floor=0.0))),
        max(_RAYS, len(scene.source)),
        _SEED,
        generation_cap=min(run.generation_cap, _CAP),
        max_segments=_SEGMENTS,
        device=device,
    )
    emitted = float(found.weight[found.parent < 0].sum())
    clashes = sorted(_clashes(scene, found, device).items(), key=lambda item: -item[1])
    return [
        _sentence(scene, *clash, weight / emitted)
        for clash, weight in clashes[:_NAMED]
        if weight > _NOTED * emitted
    ]


def _sentence(scene: Scene, left: int, index: float, met: int, other: float, part: float) -> str:
    a, b = (scene.element[n].name for n in (left, met))
    return (
        f'light that leaves "{a}" in a medium of index {index:g} meets "{b}" as from one of '
        f"{other:g} ({100.0 * min(part, 1.0):.2g} % of the power, by {_RAYS} rays): one of the two "
        "is the wrong way round, and the opposite axis turns it; or an index is not the one that "
        "is meant; or the body between them is open at its side"
    )


def _clashes(
    scene: Scene, found: Paths, device: DeviceRecord | str | None
) -> dict[tuple[int, float, int, float], float]:
    """Return the weight that goes between two faces that say another index each."""
    start_side, end_side = _sides(scene, found, device)
    indices = [e.surface.indices for e in scene.element]
    at = np.full(len(found), np.nan)  # index that the segment is in, where a face said it
    said_by = np.full(len(found), -1)
    clashes: dict[tuple[int, float, int, float], float] = defaultdict(float)
    for n, (parent, met) in enumerate(zip(found.parent.tolist(), found.element.tolist(),
                                          strict=True)):  # fmt: skip
        if parent >= 0:
            left = int(found.element[parent])
            both = indices[left]
            if both is None:  # reflected, or it passed
                at[n], said_by[n] = at[parent], said_by[parent]
            elif start_side[n]:
                at[n], said_by[n] = both[int(start_side[n] > 0)], left
        both = indices[met] if met >= 0 else None
        if both is None or not end_side[n] or np.isnan(at[n]):
            continue
        index = both[int(end_side[n] > 0)]
        if index != at[n]:
            clashes[int(said_by[n]), float(at[n]), met, index] += float(found.weight[n])
    return dict(clashes)


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
