"""Walls of revolution in exact geometry: x² + y² = P(z) with a quadratic P, in 60 digits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from photizon_cl.scene.elements.cone import Cone
from photizon_cl.scene.elements.conic import Conic
from photizon_cl.scene.elements.cylinder import Cylinder
from photizon_cl.stability.digits import Vector, dot, load_digits

if TYPE_CHECKING:
    from photizon_cl.scene.elements import Element

__all__ = ["Quadric", "lengths_of"]


def lengths_of(element: Element) -> tuple[Any, ...]:
    """Return the numbers that make a wall's shape, as `Quadric` takes them."""
    match element:
        case Cylinder():
            return (element.radius, element.length)
        case Cone():
            return (element.entrance_radius, element.exit_radius, element.length)
        case Conic():
            rims = (element.aperture_radius, element.inner_radius)
            return (element.curvature_radius, *rims, element.conic_constant)
    raise TypeError(element.kind)


class Quadric:
    """The wall of a cylinder, a cone or a conic."""

    def __init__(self, element: Element) -> None:
        self.element = element

    def _profile(self, s: Vector) -> tuple[Any, Any, Any]:
        """Return A, B, C of P(z) = A + B z + C z²."""
        match self.element:
            case Cylinder():
                return s[0] ** 2, 0, 0
            case Cone():
                k = (s[1] - s[0]) / s[2]
                return s[0] ** 2, 2 * s[0] * k, k * k
        return 0, 2 * s[0], -(1 + s[3])

    def _own_nappe(self, z: Any, s: Vector) -> bool:
        match self.element:
            case Cylinder():
                return True
            case Cone():
                return bool(s[0] + (s[1] - s[0]) / s[2] * z >= 0)
        return bool(s[0] - (1 + s[3]) * z >= 0)  # at an equator too the lower half

    def _gradient(self, p: Vector, s: Vector) -> tuple[Any, Any]:
        """Return x² + y² − P and half the length of its gradient."""
        mp = load_digits()
        a, b, c = self._profile(s)
        f = p[0] ** 2 + p[1] ** 2 - (a + b * p[2] + c * p[2] ** 2)
        return f, mp.sqrt(p[0] ** 2 + p[1] ** 2 + (b / 2 + c * p[2]) ** 2)

    def value(self, p: Vector, s: Vector) -> Any:
        """Return the signed distance (to first order) of a point, positive outside."""
        if isinstance(self.element, Conic):
            f, g = self._gradient(p, s)
            return f / (2 * (g or s[0]))
        mp = load_digits()
        k = (s[1] - s[0]) / s[2] if isinstance(self.element, Cone) else 0
        r = mp.sqrt(p[0] ** 2 + p[1] ** 2)
        return (r - abs(s[0] + k * p[2])) / mp.sqrt(1 + k * k)

    def normal(self, p: Vector, s: Vector) -> Vector:
        """Return the unit normal: away from the axis, of a conic into the concave side."""
        _, b, c = self._profile(s)
        sign = -1 if self.element.plus_side == "inside" else 1
        _, g = self._gradient(p, s)
        if not g:  # an apex
            return [load_digits().mpf(x) for x in (1, 0, 0)]
        return [sign * x / g for x in (p[0], p[1], -(b / 2 + c * p[2]))]

    def margins(self, p: Vector, s: Vector) -> Vector:
        """Return lengths that are all at least zero between the rims."""
        mp = load_digits()
        if not isinstance(self.element, Conic):
            return [p[2], s[-1] - p[2]]
        r = mp.sqrt(p[0] ** 2 + p[1] ** 2)
        found = [s[1] - r, s[0] - (1 + s[3]) * p[2]]
        return [*found, r - s[2]] if self.element.inner_radius else found

    def blurs(self, o: Vector, d: Vector, s: Vector) -> list[tuple[Any, ...]]:
        """Return where a line comes to a cone's apex, and where it passes the rims."""
        if isinstance(self.element, Conic):
            return []
        groups: list[tuple[Any, ...]] = []
        if d[2]:
            groups.append((-o[2] / d[2], (s[-1] - o[2]) / d[2]))
        if isinstance(self.element, Cone) and 0 in s[:2]:
            apex = [o[0], o[1], o[2] - (0 if s[0] == 0 else s[2])]
            groups.append((-dot(apex, d) / dot(d, d),))
        return groups

    def line(self, o: Vector, d: Vector, s: Vector) -> tuple[list[Any], Any]:
        """Return where a line meets it, ascending, and where it is deepest, or None."""
        mp = load_digits()
        a0, b0, c0 = self._profile(s)
        a = d[0] ** 2 + d[1] ** 2 - c0 * d[2] ** 2
        b = o[0] * d[0] + o[1] * d[1] - (b0 / 2 + c0 * o[2]) * d[2]
        c = o[0] ** 2 + o[1] ** 2 - (a0 + b0 * o[2] + c0 * o[2] ** 2)
        if a == 0:
            at, turning = ([-c / (2 * b)] if b else []), None
        else:
            turning = -b / a if a > 0 else None
            square = b * b - a * c
            if square < 0:
                at = []
            else:
                root = mp.sqrt(square)
                at = sorted([(-b - root) / a, (-b + root) / a])
        if not (isinstance(self.element, Conic) and self.element.kappa > 0):
            at = [t for t in at if self._own_nappe(o[2] + t * d[2], s)]
            if turning is not None and not self._own_nappe(o[2] + turning * d[2], s):
                turning = None
        return at, turning
