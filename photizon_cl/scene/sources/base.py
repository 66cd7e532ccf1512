"""What all sources share."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.scene.declarations import (
    declare,
    point,
    positive_number,
    positive_power,
    signed_axis,
    tilt,
    unique_name,
)
from photizon_cl.scene.described import ABSENT, Accepts, Nested
from photizon_cl.scene.device_kinds import DeviceKind
from photizon_cl.scene.frames import Frame, frame
from photizon_cl.scene.media.names import VACUUM, medium_name
from photizon_cl.scene.polarisation import Polarisation
from photizon_cl.scene.rows import NO_ROW, Row
from photizon_cl.scene.spectrum import relative_powers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.faces import Ball, Plane


@dataclass(frozen=True, kw_only=True)
class Source(DeviceKind):
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
    medium : str, optional
        Name of the medium in which its rays start.
    spectrum : sequence of float, optional
        Relative power of each line or band of the scene's ``[spectrum]``; by default the same
        of each.
    polarisation : Polarisation, optional
        How its light is polarised; None: not at all. Refused where the run has no polarisation.
    """

    label: ClassVar[str] = "source"
    kind: ClassVar[str] = ""
    directed: ClassVar[bool] = False
    """Whether it has an axis and a tilt."""
    draws_position: ClassVar[bool] = False
    """Whether its rays start at many points, for which each draws a second pair of uniforms."""
    is_beam: ClassVar[bool] = False
    """Whether its light has a cross-section of its own, with the same irradiance all over it."""
    row: ClassVar[Row] = NO_ROW
    """Columns of its row in the source table, behind those that all sources have."""

    name: str = field(metadata=unique_name("unique among the sources"))
    flux: float = field(metadata=positive_power("radiant flux launched"))
    position: Sequence[float] = field(metadata=point("centre of the source"))
    share: float | None = field(default=None, metadata=positive_number("part of the rays"))
    medium: str = field(default=VACUUM, metadata=medium_name("in which its rays start"))
    spectrum: Accepts[Sequence[float] | None, tuple[float, ...] | None] = field(
        default=ABSENT, metadata=relative_powers("relative power of each line or band")
    )
    polarisation: Polarisation | None = field(
        default=None,
        metadata=declare(Nested(Polarisation, "the", meaning="how its light is polarised")),
    )

    @property
    def frame(self) -> Frame:
        """Rows (u, v, w) of the local frame in world coordinates."""
        return frame("+z")

    @property
    def face(self) -> Plane | Ball | None:
        """What it shines from, around its position and in its frame; None for a point."""
        return None

    @property
    def beam_area(self) -> float | None:
        """Cross-section of its beam in m²; None where it sends out none."""
        return None

    @property
    def reach(self) -> float:
        """Radius in metres of a ball around `position` that holds it."""
        return 0.0 if self.face is None else self.face.reach

    def outline(self) -> list[NDArray[np.float64]]:
        """Return the lines that show its size, shape (k, 3), in metres; one point for a point."""
        at = np.array(self.position)
        if self.face is None:
            return [at[np.newaxis]]
        return [at + line for line in self.face.sketch(np.array(self.frame))]

    @property
    def option(self) -> str:
        """What its kernel is rendered with beside its kind; empty where it has just one form."""
        return ""

    def packed(self) -> dict[str, float]:
        """Return the values of its row's columns by name."""
        return {}

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
    tilt_deg: Sequence[float] = field(default=(0.0, 0.0), metadata=tilt())

    @property
    def frame(self) -> Frame:
        """Rows (u, v, w) of the local frame in world coordinates."""
        return frame(self.axis, self.tilt_deg)


def circle_area(radius: float) -> float:
    """Return πr² in m²."""
    return math.pi * radius * radius
