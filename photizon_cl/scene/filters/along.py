"""Arrivals by a coordinate of the detector's own frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.scene.edges import even_edges
from photizon_cl.scene.filters.base import Axis, Filter

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

__all__ = ["Along", "across", "along_axis", "polar_cosine"]


@dataclass(frozen=True, eq=False)
class Along(Filter):
    """Equal bins along u, v or w.

    Parameters
    ----------
    bins : int
        Their number.
    component : str
        ``"u"``, ``"v"`` or ``"w"``.
    low, high : float
        Where the first bin begins and the last one ends, in metres.
    shown : callable
        Gives the axis as people see it.
    """

    kind: ClassVar[str] = "along"
    kernel: ClassVar[str] = "along"
    what: ClassVar[str] = "a coordinate of the detector's own frame"

    component: str
    low: float
    high: float
    shown: Callable[[int], Axis]

    @property
    def axis(self) -> Axis:
        """The axis as people see it."""
        return self.shown(self.bins)

    @property
    def option(self) -> str:
        """The component."""
        return self.component

    def device_edges(self) -> list[float]:
        """Return the n + 1 edges of n bins in metres, ascending, each rounded once."""
        return even_edges(self.low, self.high, self.bins)


def _symmetric(half: float, n: int) -> NDArray[np.float64]:
    return np.asarray(half * ((2 * np.arange(n + 1) - n) / n))


def across(name: str, half: float, n: int) -> Along:
    """Return n equal bins from −half to half metres along a local axis, ``u`` or ``v``."""
    return Along(n, name, -half, half, partial(_across, name, half))


def _across(name: str, half: float, bins: int) -> Axis:
    return Axis(
        name=name, units="m", edges=_symmetric(half, bins), symbol=name,
        text=f"local {name}", said=f"{name} =",
    )  # fmt: skip


def along_axis(length: float, n: int) -> Along:
    """Return n equal bins from 0 to a length in metres along the local axis w."""
    return Along(n, "w", 0.0, length, partial(_along_axis, length))


def _along_axis(length: float, bins: int) -> Axis:
    return Axis(
        name="w", units="m", edges=length * (np.arange(bins + 1) / bins), symbol="w",
        text="local w, along the axis", said="w =", about="along the axis",
    )  # fmt: skip


def polar_cosine(radius: float, n: int) -> Along:
    """Return n equal bins of the cosine of the angle from the local axis, ascending from −1.

    The device has the height in metres on a ball of a radius.
    """
    return Along(n, "w", -radius, radius, _polar_cosine)


def _polar_cosine(bins: int) -> Axis:
    return Axis(
        name="cos_theta", units="1", edges=_symmetric(1.0, bins), symbol="cos θ",
        text="cosine of the angle from the axis", said="cosine", about="from the axis",
    )  # fmt: skip
