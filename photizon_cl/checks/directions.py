"""How finely single precision tells directions from each other.

A random number in single precision is one of 2^24, so a source that sends all its rays from one
point sends them in so many polar angles; what it sees under a part f of all directions has f 2^24
of them. Where rays start from many points, or are scattered at many, that evens out. What does not
is that a direction is rounded: it may be counted beside an edge of the far field's bins, and what
is scattered into a narrow lobe makes a wider one.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from photizon_cl.scene.elements.base import ROUNDOFF

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.model import Scene

__all__ = ["coarse_directions"]

_TOLD: Final = 1e-4
"""Relative error from which on it is told, as of areas."""
_ROUNDED: Final = 4.0
"""Roundings of a direction, in radians."""


def coarse_directions(scene: Scene, roundoff: float) -> Iterator[str]:
    """Give a sentence for each detector that a point source sees under too few directions.

    And one for bins of the far field, and for each element whose scatter is narrow beside a
    direction's rounding.

    Parameters
    ----------
    scene : Scene
        What is looked at.
    roundoff : float
        Unit roundoff of the kernels' numbers; of doubles there is nothing to tell.
    """
    if roundoff == ROUNDOFF:
        return
    far = scene.far_field
    if far is not None and far.by_theta:
        narrowest = min(b - a for a, b in pairwise(far.edges_deg))
        wrong = _ROUNDED * roundoff / math.radians(narrowest)
        if wrong > _TOLD:
            yield (
                f"far_field has bins of {narrowest:.3g} degrees, and in single precision "
                f"directions are rounded to {math.degrees(_ROUNDED * roundoff):.1e}: what is in "
                f"such a bin may be wrong by {min(wrong, 1.0):.1e}; run it in fp64"
            )
    for element in scene.element:
        widths = [s.lobe.width for s in element.surfaces if s.lobe is not None]
        rounded = _ROUNDED * roundoff
        if widths and (rounded / min(widths)) ** 2 > _TOLD:
            yield (
                f'the scatter of "{element.name}" is {min(widths):.1e} wide, and in single '
                f"precision directions are rounded to {rounded:.1e}: it comes out wider; run it "
                "in fp64"
            )
    points = [source for source in scene.source if not source.draws_position]
    for element in scene.element:
        if element.detector is None:
            continue
        for source in points:
            away = math.dist(element.position, source.position)
            if away <= element.reach:
                continue
            # part of the sphere that a ball around it takes, (1 - cos)/2 without cancellation
            sine = element.reach / away
            part = 0.5 * sine * sine / (1.0 + math.sqrt(1.0 - sine * sine))
            wrong = roundoff / part
            if wrong > _TOLD:
                yield (
                    f'"{source.name}" sees the detector "{element.name}" under a part {part:.1e} '
                    "of all directions, and in single precision its rays have 2^24 polar angles: "
                    f"what comes straight from it may be wrong by {min(wrong, 1.0):.1e}; run it "
                    "in fp64"
                )
                break
