"""Gaps between faces that are there, and that single precision does not tell from none."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.geometry.coincidence import shared_places
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.placing import recentre, recentred
from photizon_cl.scene.elements.base import ROUNDOFF

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.geometry.coincidence import Shared
    from photizon_cl.scene.model import Scene

__all__ = ["lost_gaps"]

_NAMED: Final = 20
"""So many pairs are named; of the others only how many there are."""
_LOOKED: Final = 20_000
"""So many pairs of faces in one place are looked at, which takes a second."""


def lost_gaps(scene: Scene, roundoff: float) -> Iterator[str]:
    """Give a sentence for each pair of elements with faces apart that count as in one place.

    Parameters
    ----------
    scene : Scene
        What is looked at.
    roundoff : float
        Unit roundoff of the kernels' coordinates; of doubles there is nothing to tell.
    """
    if roundoff == ROUNDOFF:
        return
    placed = recentred(scene, recentre(scene), roundoff)
    near = Neighbours(placed.element, roundoff)
    found = {_faces(pair) for pair in islice(shared_places(near, _every), _LOOKED)}
    if not found:
        return
    found -= {
        _faces(pair) for pair in islice(shared_places(Neighbours(scene.element), _every), _LOOKED)
    }
    pairs = sorted({(first, second) for first, second, _, _ in found})
    for i, j in pairs[:_NAMED]:
        one, other = (scene.element[n].name for n in (i, j))
        within = near.rounding * float(np.abs(near.boxes[[i, j]]).max())
        yield (
            f'elements "{one}" and "{other}" have faces that stand apart by less than '
            f"{within:.1e} m, which single precision does not tell from none: they count as in one "
            "place; run it in fp64 if light is to pass between them"
        )
    if len(pairs) > _NAMED:
        yield f"{len(pairs) - _NAMED} more pairs of elements have faces as near each other"


def _every(i: Any, j: Any) -> Any:
    return (i >= 0) & (j >= 0)


def _faces(pair: Shared) -> tuple[int, int, int, int]:
    return pair.first, pair.second, pair.first_face, pair.second_face
