"""What all sources share."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.described import Described
from photizon_cl.scene.frames import Frame, Vec3, frame
from photizon_cl.scene.parameters import (
    point,
    positive_number,
    positive_power,
    signed_axis,
    tilt,
    unique_name,
)


@dataclass(frozen=True, kw_only=True)
class Source(Described):
    """Where rays start. Sources do not block light.

    Parameters
    ----------
    name : str
        Unique among the scene's sources.
    flux : float
        Radiant flux launched, Φ, in watts, whatever medium surrounds the source.
    position : tuple of float
        Centre of the source, in metres.
    share : float, optional
        Weight of this source in dividing the rays, given by all sources or by none and normalised
        to their sum; None divides in proportion to flux. It moves effort, never the answer.
    """

    label: ClassVar[str] = "source"
    kind: ClassVar[str] = ""
    kernel: ClassVar[str] = ""
    directed: ClassVar[bool] = False
    """Whether it has an axis and a tilt."""

    name: str = field(metadata=unique_name("unique among the sources"))
    flux: float = field(metadata=positive_power("radiant flux launched"))
    position: Vec3 = field(metadata=point("centre of the source"))
    share: float | None = field(default=None, metadata=positive_number("part of the rays"))

    @property
    def frame(self) -> Frame:
        """Rows (u, v, w) of the local frame in world coordinates."""
        return frame("+z")

    def packed(self) -> tuple[float, ...]:
        """Return the device parameters of the shape, in the order that the kernel names them."""
        return ()

    @abstractmethod
    def derived(self) -> dict[str, tuple[float, str]]:
        """Return derived quantities: name → (value, unit)."""


@dataclass(frozen=True, kw_only=True)
class DirectedSource(Source):
    """A source with a direction.

    Parameters
    ----------
    axis : str
        Direction of emission, one of ``+x -x +y -y +z -z``; the local w axis.
    tilt_deg : tuple of float, optional
        ``(a, b)`` in degrees, see `photizon_cl.scene.frames`. The whole source turns with it.
    """

    directed: ClassVar[bool] = True

    axis: str = field(metadata=signed_axis("direction of emission"))
    tilt_deg: tuple[float, float] = field(default=(0.0, 0.0), metadata=tilt())

    @property
    def frame(self) -> Frame:
        """Rows (u, v, w) of the local frame in world coordinates."""
        return frame(self.axis, self.tilt_deg)


def circle_area(radius: float) -> float:
    """Return πr² in m²."""
    return math.pi * radius * radius
