"""Importance sampling that cannot do what it is for."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from photizon_cl.geometry.targets import BALL, target_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.geometry.targets import Target
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene

__all__ = ["idle_importance"]


def idle_importance(scene: Scene) -> Iterator[str]:
    """Give a sentence where nothing scatters, and for targets that nothing can be sent towards."""
    asked = scene.importance
    if asked is None or not asked.fraction:
        return
    scattering = [
        element for element in scene.element if any(s.scatters or s.lobe for s in element.surfaces)
    ]
    if not scattering:
        yield (
            "importance: no surface of the scene scatters, so no ray is sent towards anything; "
            "mirrors and glass have no other direction to send one in"
        )
        return
    for name in asked.toward:
        element = scene.element[name]
        target = target_of(element)
        others = [other for other in scattering if other is not element]
        if target.shape == BALL and all(_holds(target, o) for o in others):
            yield (
                f'importance: the ball around "{name}" holds all that scatters, and from within it '
                "nothing is sent towards it; name an element that is met from outside, or leave it "
                "out"
            )


def _holds(target: Target, element: Element) -> bool:
    """Say whether a target's ball holds all of an element."""
    return math.dist(target.centre, element.position) + element.reach <= target.reach
