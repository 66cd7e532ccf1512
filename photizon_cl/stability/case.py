"""A hard case: some elements and a ray."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from photizon_cl.scene.elements import Element

Triple = tuple[float, float, float]

__all__ = ["Case", "Left", "Triple"]


@dataclass(frozen=True)
class Left:
    """The face that a ray left.

    Parameters
    ----------
    element, face : int
        Which.
    plus : bool
        Whether the ray is now on the side that the normal points to.
    """

    element: int
    face: int = 0
    plus: bool = False


@dataclass(frozen=True)
class Case:
    """One ray in one scene; the doubles are exact.

    Parameters
    ----------
    label : str
        What is hard about it.
    elements : tuple of Element
        The scene. Cases with the same tuple are probed together.
    origin, direction : tuple of float
        Metres; a unit vector up to rounding.
    left : Left, optional
        What the ray left; None for a launched ray.
    must_hit : bool
        Whether a miss is wrong however near an edge the ray passes: closed bodies, shared edges.
    """

    label: str
    elements: tuple[Element, ...]
    origin: Triple
    direction: Triple
    left: Left | None = None
    must_hit: bool = False
