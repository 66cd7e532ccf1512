"""Chambers of touching and crossing walls, by the way in which they meet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from oracles.corners import across, box, named
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import frame
from photizon_cl.scene.surfaces.absorber import Absorber
from photizon_cl.stability.families_mixed import room

if TYPE_CHECKING:
    from oracles.corners import Chamber

__all__ = ["KINDS", "walls"]


def walls(kind: str, low: Any, high: Any, tilt: Any, surface: Any, r: Any) -> Chamber:
    """Return a chamber of a box, and what else stands in and around it."""
    size = high - low
    cut = low + size * r.choice([0.5, 0.3, 0.37123], 3)
    wide = low - 0.25 * size, high + 0.25 * size
    outer = list(room(low.tolist(), high.tolist(), tilt, surface))
    if kind == "room":
        elements, low_end, high_end = outer, low, high
    elif kind == "plates that cross":
        elements = outer + [across(low, high, a, cut[a], tilt, surface) for a in range(3)]
        low_end, high_end = low, cut
    elif kind == "plates that go on beyond the room":
        elements = outer + [across(*wide, a, cut[a], tilt, surface) for a in range(3)]
        low_end, high_end = cut, high
    elif kind == "plates that end on plates":
        outer[4] = across(*wide, 2, low[2], tilt, surface)
        elements, low_end, high_end = outer, low.copy(), high
        for a in range(3):
            elements.append(across(low_end, high, a, cut[a], tilt, surface))
            low_end[a] = cut[a]
    elif kind == "walls of two pieces":
        elements, low_end, high_end = [], low, high
        for a in range(3):
            first, second = high.copy(), low.copy()
            first[(a + 1) % 3] = second[(a + 1) % 3] = cut[(a + 1) % 3]
            for at in (low[a], high[a]):
                elements += [
                    across(low, first, a, at, tilt, surface),
                    across(second, high, a, at, tilt, surface),
                ]
    elif kind == "a row of touching boxes":
        a = int(r.integers(3))
        at = low[a] + size[a] * np.array([0.0, 0.3, 0.7123, 1.0])
        ends = [(low.copy(), high.copy()) for _ in range(3)]
        for n in range(3):
            ends[n][0][a], ends[n][1][a] = at[n], at[n + 1]
        elements = [w for lo, hi in ends for w in room(lo.tolist(), hi.tolist(), tilt, surface)]
        low_end, high_end = ends[1]
    elif kind.startswith("eight cells"):
        ends = np.array([low, cut, high])
        cells = [np.array([k >> a & 1 for a in range(3)]) for k in range(8)]
        axes = np.arange(3)
        corners = [(ends[c, axes].tolist(), ends[c + 1, axes].tolist()) for c in cells]
        elements = [w for lo, hi in corners for w in room(lo, hi, tilt, surface)]
        if kind == "eight cells with common walls":
            elements = list({w.position: w for w in elements}.values())
        elements = [elements[n] for n in r.permutation(len(elements))]
        low_end, high_end = low, cut
    else:  # a box in the corner of a box; the rays are in the inner one
        elements = outer + list(room(cut.tolist(), high.tolist(), tilt, surface))
        low_end, high_end = cut, high
    # what gets out anywhere ends on an absorber, and is counted
    middle = tuple(((low + high) / 2 @ np.array(frame("+z", tilt))).tolist())
    black = Sphere(
        name="black",
        position=middle,
        axis="+z",
        radius=2.0 * float(np.linalg.norm(size)),
        surface=Absorber(),
    )
    return box((*named(elements), black), low_end, high_end, tilt)


KINDS = [
    "room",
    "plates that cross",
    "plates that go on beyond the room",
    "plates that end on plates",
    "walls of two pieces",
    "a row of touching boxes",
    "a box in a box",
    "eight cells with common walls",
    "eight cells of six walls each",
]
