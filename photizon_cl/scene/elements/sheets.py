"""Sheets of conics of revolution as faces: their profiles, sags and areas."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from photizon_cl.scene.faces import Ball, Revolved

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Sheet", "equator", "sheet_area", "sheet_sag"]


@dataclass(frozen=True, kw_only=True)
class Sheet(Revolved):
    """The meridian as `Conic` states it; lengths in metres.

    With κ = 1 + k, from r² = w(2R − κw) and dw/dr = r/(R − κw). Of an ellipsoid the profile runs by
    the angle of its slope, in which an equator has as many places as a vertex; of the others, whose
    slope comes to an end, by asinh(r sqrt(1 − κ)/R). Neither subtracts nearly equal numbers.
    """

    radius: float
    kappa: float
    rims: tuple[float, float]
    heights: tuple[float, float]

    def profile(  # noqa: D102
        self, s: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        big, kappa = self.radius, self.kappa
        rims = np.array(self.rims)
        if kappa > 0.0:
            first, last = np.arctan2(rims, self._levels(np.array(self.heights)))
            at = first * (1.0 - s) + last * s
            sine, cosine = np.sin(at), np.cos(at)
            r = big * sine / np.hypot(cosine, math.sqrt(kappa) * sine)
            root = big * cosine / np.hypot(cosine, math.sqrt(kappa) * sine)
        else:
            width = big / math.sqrt(1.0 - kappa)
            first, last = np.arcsinh(rims / width)
            r = width * np.sinh(first * (1.0 - s) + last * s)
            root = np.hypot(big, math.sqrt(-kappa) * r)
        w = r * (r / (big + root))
        for place, rim, height in zip((0.0, 1.0), self.rims, self.heights, strict=True):
            r, w = np.where(s == place, rim, r), np.where(s == place, height, w)
        return np.clip(r, *self.rims), np.clip(w, *self.heights)

    @property
    def ball(self) -> Ball | None:  # noqa: D102
        if self.kappa != 1.0:
            return None
        first, last = (
            math.atan2(r, self.radius - h) for r, h in zip(self.rims, self.heights, strict=True)
        )
        return Ball(
            name=self.name, sense=self.sense, radius=self.radius, height=self.radius,
            polar=(first, last), pole=-1.0,
        )  # fmt: skip

    @property
    def osculating(self) -> Ball | None:  # noqa: D102
        if self.kappa == 1.0 or self.rims[0] > 0.0:
            return self.ball
        return Ball(
            name=self.name, sense=self.sense, radius=self.radius, height=self.radius, pole=-1.0
        )

    def _levels(self, w: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return R − κw, what the slope's denominator is at a height."""
        return np.asarray(np.maximum(self.radius - self.kappa * w, 0.0))

    def place_at(self, height: float) -> float:
        """Return the place of the profile at a height; the nearer end beyond either."""
        w = min(max(height, self.heights[0]), self.heights[1])
        r, ends = self.radius_at(w), np.array(self.rims)
        if self.kappa > 0.0:
            first, last = np.arctan2(ends, self._levels(np.array(self.heights)))
            at = float(np.arctan2(r, self._levels(np.array(w))))
        else:
            width = self.radius / math.sqrt(1.0 - self.kappa)
            first, last = np.arcsinh(ends / width)
            at = math.asinh(r / width)
        return min(max((at - float(first)) / float(last - first), 0.0), 1.0)

    def radius_at(self, height: float) -> float:
        """Return the radius in metres at a height, that of the nearer rim beyond either."""
        w = min(max(height, self.heights[0]), self.heights[1])
        r = math.sqrt(w) * math.sqrt(2.0 * self.radius - self.kappa * w)
        return min(max(r, self.rims[0]), self.rims[1])

    def apart(self, radius: float, height: float) -> float:
        """Return the distance in metres of a circle about the axis from the sheet.

        |F|/|∇F| of F = r² − w(2R − κw), with F as a product.
        """
        w = min(max(height, self.heights[0]), self.heights[1])
        on = self.radius_at(w)
        gradient = math.hypot(radius, self.radius - self.kappa * w)
        return abs(radius - on) * (0.5 * ((radius + on) / gradient))

    def sine_at(self, radius: float, height: float, room: float) -> float:
        """Return the sine of the angle between the sheet and the plane of a circle that lies on it.

        Of one about the vertex that of the least circle at which the sheet leaves its plane.
        """
        w = min(max(height, self.heights[0]), self.heights[1])
        r = max(radius, min(math.sqrt(2.0 * room) * math.sqrt(self.radius), self.rims[1]))
        return r / math.hypot(r, self.radius - self.kappa * w)


def sheet_sag(radius: float, k: float, r: float) -> Fraction:
    """Return the height of a conic over its vertex in metres, beyond the range of a double too."""
    big, square = Fraction(radius), Fraction(r) ** 2
    # the equator's radius is rounded
    rest = max(big**2 - (1 + Fraction(k)) * square, Fraction(0))
    return square / (big + Fraction(math.sqrt(rest)))


def equator(radius: float, k: float) -> float:
    """Return the largest radius of an ellipsoid in metres, R/sqrt(1 + k), for k > −1."""
    return radius / math.sqrt(1 + Fraction(k))


def sheet_area(radius: float, k: float, heights: tuple[float, float]) -> float:
    """Return the area in m² of one side of a sheet between two heights over its vertex.

    2πr·ds = 2π sqrt(R² − k r²) dw with r² = w(2R − κw), by Gauss-Legendre quadrature
    in pieces that halve towards both rims, near which the root may turn sharply.
    """
    low, high = heights
    halves = 0.5 ** np.arange(1.0, 31.0)
    ends = np.concatenate([[0.0], halves[:0:-1], [0.5], 1.0 - halves[1:], [1.0]])
    nodes, weights = np.polynomial.legendre.leggauss(16)
    width = 0.5 * np.diff(ends)[:, None]
    s = ends[:-1, None] + width * (1.0 + nodes)
    w = low + s * (high - low)
    r = np.sqrt(w) * np.sqrt(2.0 * radius - (1.0 + k) * w)
    if k <= 0.0:
        root = np.hypot(radius, math.sqrt(-k) * r)
    else:
        part = math.sqrt(k) * r / radius
        root = radius * np.sqrt(np.maximum((1.0 - part) * (1.0 + part), 0.0))
    return 2.0 * math.pi * (high - low) * float((width * weights * root).sum())
