"""What plane bodies in contact do to a ray, interface by interface, without geometry.

A stack of plane interfaces between layers: a ray in a layer meets the next interface on its way and
splits into what is reflected and what goes on. Angles follow from Snell's law alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


def reflectance(before: float, behind: float, sine: float) -> float:
    """Return the unpolarised Fresnel reflectance for n sin θ = `sine` (Born & Wolf § 1.5.2)."""
    if before == behind:
        return 0.0
    if sine >= behind:
        return 1.0
    c, d = math.sqrt(1.0 - (sine / before) ** 2), math.sqrt(1.0 - (sine / behind) ** 2)
    s = (before * c - behind * d) / (before * c + behind * d)
    p = (behind * c - before * d) / (behind * c + before * d)
    return 0.5 * (s * s + p * p)


@dataclass(frozen=True)
class Film:
    """What becomes of a ray of weight 1.

    transmitted, reflected : float
        What leaves behind and before the stack.
    left : float
        What is alive after the last interaction that is allowed.
    """

    transmitted: float
    reflected: float
    left: float


def stack(indices: Sequence[float], angle_deg: float, cap: int) -> Film:
    """Follow a ray that comes from the first layer at an angle, for `cap` interactions.

    `indices` are those of the layers in order.
    """
    sine = indices[0] * math.sin(math.radians(angle_deg))
    walls = [reflectance(a, b, sine) for a, b in pairwise(indices)]
    layers = [{+1: 0.0, -1: 0.0} for _ in indices]
    layers[0][+1] = 1.0
    transmitted = reflected = 0.0
    for _ in range(cap):
        after = [{+1: 0.0, -1: 0.0} for _ in indices]
        reflected += layers[0][-1]
        transmitted += layers[-1][+1]
        for n, r in enumerate(walls):
            forth, back = layers[n][+1], layers[n + 1][-1]
            after[n + 1][+1] += (1.0 - r) * forth
            after[n][-1] += r * forth
            after[n][-1] += (1.0 - r) * back
            after[n + 1][+1] += r * back
        layers = after
    return Film(transmitted, reflected, sum(sum(layer.values()) for layer in layers))
