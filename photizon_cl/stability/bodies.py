"""The elements in exact geometry: what the kernels should find, in 60 digits.

Written from the contract, face by face: a face is the zero set of a function with margins that are
not negative inside its outline. All are in the element's own frame and in metres.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.cone import Cone
from photizon_cl.scene.elements.conic import Conic
from photizon_cl.scene.elements.cpc import Cpc
from photizon_cl.scene.elements.cylinder import Cylinder
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.general_lens import Lens
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import frame
from photizon_cl.stability.digits import Vector, add, dot, load_digits, norm, scaled
from photizon_cl.stability.lens_bodies import EdgeShape, SheetShape, lens_sizes
from photizon_cl.stability.quadrics import Quadric, lengths_of

if TYPE_CHECKING:
    from photizon_cl.scene.elements import Element

__all__ = ["Face", "Roots", "exact_frame", "faces_of", "sizes_of"]


class Roots:
    """Where a line meets a face's whole surface, outline or not.

    Parameters
    ----------
    at : list
        Distances, ascending.
    turning : number, optional
        Distance of the line's deepest point, where two roots would merge.
    """

    def __init__(self, at: list[Any], turning: Any = None) -> None:
        self.at, self.turning = at, turning


class Face(ABC):
    """One face of an element; `s` are the element's sizes as `sizes_of` lists them."""

    @abstractmethod
    def value(self, p: Vector, s: Vector) -> Any:
        """Return the signed distance (to first order) of a point, positive outside."""

    @abstractmethod
    def normal(self, p: Vector, s: Vector) -> Vector:
        """Return the outward unit normal at a point of it."""

    @abstractmethod
    def margins(self, p: Vector, s: Vector) -> Vector:
        """Return lengths that are all at least zero inside the outline."""

    @abstractmethod
    def roots(self, o: Vector, d: Vector, s: Vector) -> Roots:
        """Return where a line meets it."""

    def blurs(self, o: Vector, d: Vector, s: Vector) -> list[tuple[Any, ...]]:
        """Return places of a line; where all of a group lie on the face to rounding, all is right.

        That is so at an apex, which may hit or miss, and of a line that runs within the face.
        """
        return []


class Plane(Face):
    """Part of a plane across a local axis, with its outline."""

    def __init__(self, axis: int, sign: int, offset: Any, outline: Any) -> None:
        self.axis, self.sign, self.offset, self.outline = axis, sign, offset, outline

    def value(self, p: Vector, s: Vector) -> Any:
        """Return the distance along the normal."""
        return self.sign * (p[self.axis] - self.offset(s))

    def normal(self, p: Vector, s: Vector) -> Vector:
        """Return the normal."""
        mpf = load_digits().mpf
        out = [mpf(0), mpf(0), mpf(0)]
        out[self.axis] = mpf(self.sign)
        return out

    def margins(self, p: Vector, s: Vector) -> Vector:
        """Return what the outline gives."""
        found: Vector = self.outline(p, s)
        return found

    def roots(self, o: Vector, d: Vector, s: Vector) -> Roots:
        """Return the one root, none for a line in or along the plane."""
        if d[self.axis] == 0:
            return Roots([])
        return Roots([(self.offset(s) - o[self.axis]) / d[self.axis]])


class Ball(Face):
    """A sphere around a point on the local axis; `centre(s)` is that point's z."""

    def __init__(self, radius: Any, centre: Any, outline: Any) -> None:
        self.radius, self.centre, self.outline = radius, centre, outline

    def _from_centre(self, p: Vector, s: Vector) -> Vector:
        return [p[0], p[1], p[2] - self.centre(s)]

    def value(self, p: Vector, s: Vector) -> Any:
        """Return (|f|² − R²)/2R."""
        f, r = self._from_centre(p, s), self.radius(s)
        return (dot(f, f) - r * r) / (2 * r)

    def normal(self, p: Vector, s: Vector) -> Vector:
        """Return f/|f|."""
        f = self._from_centre(p, s)
        return scaled(1 / norm(f), f)

    def margins(self, p: Vector, s: Vector) -> Vector:
        """Return what the outline gives."""
        found: Vector = self.outline(p, s)
        return found

    def roots(self, o: Vector, d: Vector, s: Vector) -> Roots:
        """Return the chord's ends."""
        mp = load_digits()
        f, r = self._from_centre(o, s), self.radius(s)
        a, b, c = dot(d, d), dot(f, d), dot(f, f) - r * r
        square = b * b - a * c
        turning = -b / a
        if square < 0:
            return Roots([], turning)
        root = mp.sqrt(square) / a
        return Roots([turning - root, turning + root], turning)


class Paraboloid(Face):
    """The wall of a CPC; sizes are exit radius and acceptance angle in degrees."""

    def _terms(self, s: Vector) -> Any:
        mp = load_digits()
        angle = s[1] * mp.pi / 180
        si, co, a = mp.sin(angle), mp.cos(angle), s[0]
        b = 2 * a * (1 + si) ** 2
        d = 2 * a * co * (2 + si)
        e = a * a * (1 + si) * (3 + si)
        wide = a / si
        return si, co, b, d, e, wide, (wide + a) * co / si

    def _radius(self, z: Any, terms: Any) -> Any:
        """Return R(z) and R'(z)."""
        si, co, b, d, e = terms[:5]
        # C²R² + (2CSz + B) R + S²z² − Dz − E = 0
        p, q = 2 * co * si * z + b, e + d * z - si * si * z * z
        root = load_digits().sqrt(p * p + 4 * co * co * q)
        r = 2 * q / (p + root)
        w = co * r + si * z
        return r, (d - 2 * si * w) / (b + 2 * co * w)

    def value(self, p: Vector, s: Vector) -> Any:
        """Return r − R(z), along the normal to first order."""
        mp = load_digits()
        r, slope = self._radius(p[2], self._terms(s))
        return (mp.sqrt(p[0] ** 2 + p[1] ** 2) - r) / mp.sqrt(1 + slope * slope)

    def normal(self, p: Vector, s: Vector) -> Vector:
        """Return the normal from the profile's slope."""
        mp = load_digits()
        _, slope = self._radius(p[2], self._terms(s))
        r, k = mp.sqrt(p[0] ** 2 + p[1] ** 2), mp.sqrt(1 + slope * slope)
        return [p[0] / (r * k), p[1] / (r * k), -slope / k]

    def margins(self, p: Vector, s: Vector) -> Vector:
        """Return the heights above the exit and below the entrance."""
        return [p[2], self._terms(s)[6] - p[2]]

    def roots(self, o: Vector, d: Vector, s: Vector) -> Roots:
        """Return the ends of the chord: R(z) − r is concave along a line."""
        mp = load_digits()
        terms = self._terms(s)
        span = self._span(o, d, terms)
        if span is None:
            return Roots([])
        low, high = span
        flat = mp.sqrt(d[0] ** 2 + d[1] ** 2)

        def at(t: Any) -> tuple[Any, Any]:
            p = add(o, t, d)
            r, slope = self._radius(p[2], terms)
            away = mp.sqrt(p[0] ** 2 + p[1] ** 2)
            speed = (p[0] * d[0] + p[1] * d[1]) / away if away else flat
            return r - away, slope * d[2] - speed

        left, right = low, high
        if at(left)[1] <= 0:
            top = left
        elif at(right)[1] >= 0:
            top = right
        else:
            # half of the digits do: about its top R(z) − r changes with the square
            for _ in range(120):
                top = (left + right) / 2
                left, right = (top, right) if at(top)[1] > 0 else (left, top)
        if at(top)[0] < 0:
            return Roots([], top)
        return Roots(
            [
                end
                for end in (self._newton(at, low, top), self._newton(at, high, top))
                if end is not None
            ],
            top,
        )

    def _span(self, o: Vector, d: Vector, terms: Any) -> tuple[Any, Any] | None:
        """Return the part of a line that can meet the wall, a little more than its outline."""
        mp = load_digits()
        wide, length = terms[5], terms[6]
        room = min(length, wide * terms[0]) / 1000
        # at the entrance it runs along the axis: rounding moves a root far along it
        beyond = length / 1000
        low, high = -mp.inf, mp.inf
        if d[2] == 0:
            if not -room <= o[2] <= length + beyond:
                return None
        else:
            ends = sorted([(-room - o[2]) / d[2], (length + beyond - o[2]) / d[2]])
            low, high = ends
        a, b = d[0] ** 2 + d[1] ** 2, o[0] * d[0] + o[1] * d[1]
        c = o[0] ** 2 + o[1] ** 2 - (wide * mp.mpf("1.01")) ** 2
        if a == 0:
            return None if c > 0 else (low, high)
        square = b * b - a * c
        if square < 0:
            return None
        root = mp.sqrt(square)
        low, high = max(low, (-b - root) / a), min(high, (-b + root) / a)
        return (low, high) if low < high else None

    def _newton(self, at: Any, start: Any, top: Any) -> Any:
        """Run from an end where the function is negative towards the top."""
        value, slope = at(start)
        if value > 0:
            return None  # the line leaves the widened span inside: through an aperture
        t = start
        for _ in range(400):
            value, slope = at(t)
            if slope == 0 or value == 0:
                break
            step = value / slope
            t -= step
            if abs(step) <= abs(t - top) * load_digits().mpf(10) ** -52:
                break
        return t


class Solved(Face):
    """A face that says itself where a line meets it, and where it is deepest."""

    @abstractmethod
    def line(self, o: Vector, d: Vector, s: Vector) -> tuple[list[Any], Any]:
        """Return distances, ascending, and that of the deepest place, or None."""

    def roots(self, o: Vector, d: Vector, s: Vector) -> Roots:
        """Return where a line meets it."""
        return Roots(*self.line(o, d, s))


class Wall(Quadric, Solved):
    """The wall of a cylinder, a cone or a conic."""


class LensSheet(SheetShape, Solved):
    """A face of a lens."""


class LensEdge(EdgeShape, Solved):
    """The edge of a lens."""


def _rectangle(p: Vector, s: Vector) -> Vector:
    return [s[0] - abs(p[0]), s[1] - abs(p[1])]


def _disk(p: Vector, s: Vector) -> Vector:
    return [s[0] - load_digits().sqrt(p[0] ** 2 + p[1] ** 2)]


def _annulus(p: Vector, s: Vector) -> Vector:
    r = load_digits().sqrt(p[0] ** 2 + p[1] ** 2)
    return [s[0] - r, r - s[1]]


def _zero(s: Vector) -> Any:
    return load_digits().mpf(0)


def sizes_of(element: Element) -> Vector:
    """Return the lengths and angles that make an element's shape, exactly.

    A cap is given by its aperture a and its centre's depth h = sqrt(R² − a²): at a hemisphere R
    and a would be ill-conditioned inputs, and what the kernels do is better than they allow.
    """
    mpf = load_digits().mpf
    return [mpf(x) for x in _sizes(element)]


def _depth(radius: float, aperture: float) -> Any:
    mp = load_digits()
    return mp.sqrt(mp.mpf(radius) ** 2 - mp.mpf(aperture) ** 2)


def _sizes(element: Element) -> tuple[Any, ...]:
    match element:
        case Rectangle():
            return (element.half_width, element.half_height)
        case Disk():
            return (element.radius, element.inner_radius)
        case Sphere():
            return (element.radius, element.port)
        case Cpc():
            return (element.exit_radius, element.acceptance_deg)
        case BaffledTube():
            return (element.half_width, element.length, element.clear_half_width or 0.0)
        case PlanoConvex():
            a = element.aperture_radius
            return (a, _depth(element.curvature_radius, a))
        case Biconvex():
            a = element.aperture_radius
            return (a, _depth(element.front_radius, a), _depth(element.back_radius, a))
        case Lens():
            return lens_sizes(element)
        case Cylinder() | Cone() | Conic():
            return lengths_of(element)
    raise TypeError(element.kind)


def _cap(n: int, side: int) -> Ball:
    """Return the cap whose centre lies s[n] behind the rim's plane."""
    return Ball(
        lambda s: load_digits().sqrt(s[0] ** 2 + s[n] ** 2),
        lambda s: -side * s[n],
        lambda p, s: [side * p[2]],
    )


def _tube(element: BaffledTube) -> list[Face]:
    def wall(other: int) -> Any:
        return lambda p, s: [s[0] - abs(p[other]), p[2], s[1] - p[2]]

    def plate(p: Vector, s: Vector) -> Vector:
        across = max(abs(p[0]), abs(p[1]))
        return [s[0] - across, across - s[2]]

    n = element.baffles
    faces: list[Face] = [
        Plane(axis, sign, lambda s, sign=sign: sign * s[0], wall(1 - axis))
        for axis in (0, 1)
        for sign in (1, -1)
    ]
    for i in range(n):
        faces.append(Plane(2, 1, lambda s, i=i: s[1] * (i + 1) / (n + 1), plate))
    return faces


def faces_of(element: Element) -> list[Face]:
    """Return an element's faces, numbered as in its kernel."""
    match element:
        case Rectangle():
            return [Plane(2, 1, _zero, _rectangle)]
        case Disk():
            return [Plane(2, 1, _zero, _annulus if element.opening else _disk)]
        case Sphere():
            port = element.opening
            return [
                Ball(
                    lambda s: s[0],
                    _zero,
                    lambda p, s: [s[0] * (1 - 2 * s[1]) - p[2]] if port else [],
                )
            ]
        case Cpc():
            return [Paraboloid()]
        case BaffledTube():
            return _tube(element)
        case PlanoConvex():
            return [Plane(2, -1, _zero, _disk), _cap(1, 1)]
        case Biconvex():
            return [_cap(1, 1), _cap(2, -1)]
        case Lens():
            edge: list[Face] = [LensEdge()] if element.edge_thickness else []
            return [LensSheet(1), LensSheet(-1), *edge]
        case Cylinder() | Cone() | Conic():
            return [Wall(element)]
    raise TypeError(element.kind)


def exact_frame(element: Element) -> list[Vector]:
    """Return the rows u, v, w in world coordinates."""
    mp = load_digits()
    rows = [[mp.mpf(x) for x in row] for row in frame(element.axis, (0.0, 0.0))]
    a, b = (mp.mpf(x) * mp.pi / 180 for x in element.tilt_deg)
    sa, ca, sb, cb = mp.sin(a), mp.cos(a), mp.sin(b), mp.cos(b)
    turned = ((cb, 0, -sb), (sa * sb, ca, sa * cb), (ca * sb, -sa, ca * cb))
    return [[sum(row[i] * rows[i][k] for i in range(3)) for k in range(3)] for row in turned]
