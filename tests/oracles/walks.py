"""Rays followed through many interactions, and the bodies and places that tests of them share."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.run.probe import follow_rays
from oracles.engine import open_device
from photizon_cl.scene.surfaces.lambertian import Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror
from photizon_cl.stability.measure import compile_elements

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hostcode.run.probe import Followed
    from photizon_cl.scene.elements import Element

U = 2.0**-53
TILT = (33.3, -71.7)
SILVER, WHITE = Mirror(1.0), Lambertian(1.0)
PLACES = [((0.0, 0.0, 0.0), (0.0, 0.0)), ((0.3, -0.2, 0.1), TILT)]
LENSES: list[dict[str, Any]] = [
    {"front_radius": 1.5, "back_radius": 2.5},
    {"front_radius": 1.0, "back_radius": 1e6},
    {"front_radius": 40.0, "back_radius": 30.0},
]


def follow(
    elements: Sequence[Element],
    starts: Any,
    along: Any,
    steps: int,
    precision: str = "fp64",
    **how: Any,
) -> Followed:
    compiled = compile_elements(elements, precision)
    rays = np.hstack([np.subtract(starts, compiled.shift), along])
    found = follow_rays(open_device(), compiled.tables, rays, steps, **how)
    return replace(found, point=found.point + np.array(compiled.shift))


def unit(v: Any) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)
