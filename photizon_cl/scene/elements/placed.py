"""Surfaces of revolution somewhere on their element's axis, either way up."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from photizon_cl.scene.faces import Revolved

if TYPE_CHECKING:
    from photizon_cl.scene.faces import Ball
    from photizon_cl.scene.outlines import Values

__all__ = ["Placed"]


@dataclass(frozen=True, kw_only=True)
class Placed(Revolved):
    """A surface of revolution moved along the axis, and perhaps turned over.

    Parameters
    ----------
    shape : Revolved
        The surface about the origin.
    height : float
        Where on the axis its origin stands, in metres.
    up : float
        1 where its own axis points along the element's, else −1.
    """

    shape: Revolved
    height: float
    up: float = 1.0

    def profile(self, s: Values) -> tuple[Values, Values]:  # noqa: D102
        radius, height = self.shape.profile(s)
        return radius, self.height + self.up * height

    def _own(self, height: float) -> float:
        """Return a height over the shape's own origin."""
        return self.up * (height - self.height)

    @property
    def ball(self) -> Ball | None:  # noqa: D102
        return self._moved(self.shape.ball)

    @property
    def osculating(self) -> Ball | None:  # noqa: D102
        return self._moved(self.shape.osculating)

    def _moved(self, own: Ball | None) -> Ball | None:
        if own is None:
            return None
        height, pole = self.height + self.up * own.height, self.up * own.pole
        return replace(own, name=self.name, sense=self.sense, height=height, pole=pole)

    def place_at(self, height: float) -> float:  # noqa: D102
        return self.shape.place_at(self._own(height))

    def apart(self, radius: float, height: float) -> float:  # noqa: D102
        return self.shape.apart(radius, self._own(height))

    def sine_at(self, radius: float, height: float, room: float) -> float:  # noqa: D102
        return self.shape.sine_at(radius, self._own(height), room)
