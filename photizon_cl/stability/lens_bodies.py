"""Faces of lenses in exact geometry, in 60 digits: conics seen from their vertices, the edge."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from photizon_cl.stability.digits import Vector, load_digits

if TYPE_CHECKING:
    from photizon_cl.scene.elements.general_lens import Lens
    from photizon_cl.scene.elements.lens_face import LensFace

__all__ = ["EdgeShape", "SheetShape", "lens_sizes"]


def lens_sizes(lens: Lens) -> tuple[Any, ...]:
    """Return rim, half the edge, and of each face the vertex's height, curvature and 1 + k.

    Vertices and edge, not radii and thickness alone: at an equator those would be ill-conditioned
    inputs, and what the kernels do is better than they allow.
    """
    mp = load_digits()
    sags = [_sag(side) for side in lens.sides]
    half = (mp.mpf(lens.thickness) - sags[0] - sags[1]) / 2 if lens.edge_thickness else mp.mpf(0)
    found = [mp.mpf(lens.aperture_radius), half]
    for sag, side in zip(sags, lens.sides, strict=True):
        curvature = mp.mpf(0) if side.flat else 1 / mp.mpf(side.radius)
        found += [half + sag, curvature, 1 + mp.mpf(side.constant)]
    return tuple(found)


def _sag(side: LensFace) -> Any:
    mp = load_digits()
    if side.flat:
        return mp.mpf(0)
    radius, a = mp.mpf(side.radius), mp.mpf(side.aperture)
    # the equator's radius is rounded
    rest = max(radius**2 - (1 + mp.mpf(side.constant)) * a**2, mp.mpf(0))
    return a**2 / (abs(radius) + mp.sqrt(rest)) * (1 if radius > 0 else -1)


class SheetShape:
    """A conic face: c (r² + κw²) + 2w = 0, w outwards from the vertex; `side` 1 front, −1 back."""

    def __init__(self, side: int) -> None:
        self.side, self.at = side, 2 if side > 0 else 5

    def _own(self, p: Vector, s: Vector) -> tuple[Any, Any, Any, Any]:
        """Return w, c, κ and 1 + cκw."""
        vertex, c, kappa = s[self.at : self.at + 3]
        w = self.side * p[2] - vertex
        return w, c, kappa, 1 + c * kappa * w

    def value(self, p: Vector, s: Vector) -> Any:
        """Return the signed distance (to first order) of a point, positive outside."""
        w, c, kappa, g = self._own(p, s)
        rr = p[0] ** 2 + p[1] ** 2
        steep = load_digits().sqrt(c * c * rr + g * g)
        return (c * (rr + kappa * w * w) + 2 * w) / (2 * (steep or 1))  # a middle has no slope

    def normal(self, p: Vector, s: Vector) -> Vector:
        """Return the outward unit normal."""
        _, c, _, g = self._own(p, s)
        n = load_digits().sqrt(c * c * (p[0] ** 2 + p[1] ** 2) + g * g)
        return [c * p[0] / n, c * p[1] / n, self.side * g / n]

    def margins(self, p: Vector, s: Vector) -> Vector:
        """Return lengths that are all at least zero within the rim, on the vertex's half."""
        mp = load_digits()
        _, c, _, g = self._own(p, s)
        found = [s[0] - mp.sqrt(p[0] ** 2 + p[1] ** 2)]
        return [*found, g / abs(c)] if c else found

    def line(self, o: Vector, d: Vector, s: Vector) -> tuple[list[Any], Any]:
        """Return where a line meets it, ascending, and where it is deepest, or None."""
        mp = load_digits()
        w, c, kappa, _ = self._own(o, s)
        dw = self.side * d[2]
        a = c * (d[0] ** 2 + d[1] ** 2 + kappa * dw * dw)
        b = c * (o[0] * d[0] + o[1] * d[1] + kappa * w * dw) + dw
        f = c * (o[0] ** 2 + o[1] ** 2 + kappa * w * w) + 2 * w
        if a == 0:
            at, turning = ([-f / (2 * b)] if b else []), None
        else:
            turning = -b / a if a * c > 0 else None
            square = b * b - a * f
            root = mp.sqrt(square) if square >= 0 else None
            at = [] if root is None else sorted([(-b - root) / a, (-b + root) / a])

        def own(t: Any) -> bool:
            return bool(1 + c * kappa * (w + t * dw) >= 0)

        if kappa <= 0:
            at = [t for t in at if own(t)]
            if turning is not None and not own(turning):
                turning = None
        return at, turning


class EdgeShape:
    """The edge: x² + y² = rim², half of it above the middle."""

    def value(self, p: Vector, s: Vector) -> Any:
        """Return the distance from it, positive outside."""
        return load_digits().sqrt(p[0] ** 2 + p[1] ** 2) - s[0]

    def normal(self, p: Vector, s: Vector) -> Vector:
        """Return the direction away from the axis."""
        mp = load_digits()
        r = mp.sqrt(p[0] ** 2 + p[1] ** 2)
        return [p[0] / r, p[1] / r, mp.mpf(0)]

    def margins(self, p: Vector, s: Vector) -> Vector:
        """Return the height left below the rims."""
        return [s[1] - abs(p[2])]

    def blurs(self, o: Vector, d: Vector, s: Vector) -> list[tuple[Any, ...]]:
        """Return where a line passes the rims."""
        return [((s[1] - o[2]) / d[2], (-s[1] - o[2]) / d[2])] if d[2] else []

    def line(self, o: Vector, d: Vector, s: Vector) -> tuple[list[Any], Any]:
        """Return where a line meets it, ascending, and where it is deepest, or None."""
        a = d[0] ** 2 + d[1] ** 2
        if a == 0:
            return [], None
        b, f = o[0] * d[0] + o[1] * d[1], o[0] ** 2 + o[1] ** 2 - s[0] ** 2
        square = b * b - a * f
        if square < 0:
            return [], -b / a
        root = load_digits().sqrt(square)
        return [(-b - root) / a, (-b + root) / a], -b / a
