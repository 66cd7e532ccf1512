"""Closed regions in and around lenses with faces and an edge of their own."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from oracles.corners import Exact
from oracles.curved import Region, arc, circle, norm, segment
from photizon_cl.scene.elements.cone import Cone
from photizon_cl.scene.elements.cylinder import Cylinder
from photizon_cl.scene.elements.general_lens import Lens
from photizon_cl.scene.elements.sheets import equator

if TYPE_CHECKING:
    from collections.abc import Callable

    from oracles.curved import Curve
    from photizon_cl.scene.surfaces import Surface

__all__ = ["LENS_REGIONS", "SHAPES", "lens_made"]

INF = math.inf
# front and back radius, conic constants, thickness of the edge; the rim has the radius 0.7
SHAPES: dict[str, tuple[float, ...]] = {
    "knife": (1.3, 0.9, 0.0, 0.0, 0.0),
    "knife-edged meniscus": (0.8, -1.4, 0.0, 0.0, 0.0),
    "biconvex": (1.3, 0.9, 0.0, 0.0, 0.2),
    "biconcave": (-1.3, -0.9, 0.0, 0.0, 0.9),
    "meniscus": (0.9, -1.2, 0.0, 0.0, 0.3),
    "hollow meniscus": (-1.1, 0.8, 0.0, 0.0, 0.3),
    "plano-convex": (0.9, INF, 0.0, 0.0, 0.1),
    "plate": (INF, INF, 0.0, 0.0, 0.2),
    "ball ends": (0.7, 0.7, 0.0, 0.0, 0.3),
    "hollow ball end": (-0.7, 1.1, 0.0, 0.0, 1.0),
    "aspheric": (0.5, -2.0, -1.4, -3.0, 0.2),
    "half an ellipsoid": (0.5, INF, 1.0 / 1.96 - 1.0, 0.0, 0.2),
    "oblate end": (0.7 * math.sqrt(3.0), INF, 2.0, 0.0, 0.2),
    "shallow": (1e4, -2e4, 0.0, 0.0, 0.2),
}  # fmt: skip
RIM = 0.7
_SMOOTH = {"ball ends", "half an ellipsoid", "oblate end"}
"""Those of which the front goes on from the edge without a corner."""


class Glass:
    """A lens in a region, its rims at `low` and `high` over its place, in the region's unit."""

    def __init__(self, r: Region, shape: str, z: float = 0.0) -> None:
        front, back, k1, k2, edge = SHAPES[shape]
        a = RIM * r.scale
        sizes: dict[str, Any] = {}
        total = edge * r.scale
        for name, radius, k in (("front", front, k1), ("back", back, k2)):
            big = radius * r.scale
            if k > -1.0 and math.isfinite(radius):
                a = min(a, equator(abs(big), k))
            sizes |= {f"{name}_radius": big, f"{name}_conic": k}
        for name in ("front", "back"):
            big, k = sizes[f"{name}_radius"], sizes[f"{name}_conic"]
            if math.isfinite(big):
                root = math.sqrt(max(big * big - (1.0 + k) * a * a, 0.0))
                total += math.copysign(a * a / (abs(big) + root), big)
        x, y, w = r.world((0.0, 0.0, z)).astype(float).tolist()
        body = Lens(
            name=f"body {len(r.elements)}", axis="+z", tilt_deg=r.tilt, position=(x, y, w),
            surface=r.surface, edge=r.surface, aperture_radius=a, thickness=total, **sizes,
        )  # fmt: skip
        r.elements.append(body)
        self.body, self.z = body, z
        self.scale, self.rim = r.scale, a / r.scale
        self.half = 0.5 * body.edge_thickness / r.scale
        rows, place = np.array(body.frame, Exact), np.array(body.position, Exact)

        def height(points: Any) -> Any:
            """Return the distance into the glass."""
            p = (points - place) @ rows.T
            away = norm(p[..., :2])
            found = Exact(a) - away
            for side, sign, vertex in zip(body.sides, (1, -1), body.vertices, strict=True):
                found = np.minimum(
                    found, -_over(side, sign * p[..., 2] - Exact(sign * vertex), away)
                )
            return found

        self.height = height

    def sag(self, face: int, r: Any) -> Any:
        """Return how far a face is beyond its vertex's plane at distances from the axis."""
        side = self.body.sides[face]
        return (
            -np.array([float(side.sag_at(float(x) * self.scale)) for x in np.ravel(r)]) / self.scale
        )

    def vertex(self, face: int) -> float:
        """Return the height of a vertex in the region."""
        return self.z + self.body.vertices[face] / self.scale

    def meridian(self, face: int, y: float = 0.0, x: float = 0.0) -> Curve:
        """Return a face's line in the plane at x (over y), both halves."""
        most = math.sqrt(self.rim**2 - x * x)
        across = np.linspace(-most, most, 401)
        up = 1.0 if face == 0 else -1.0
        heights = self.vertex(face) + up * self.sag(face, np.minimum(np.hypot(across, x), self.rim))

        def points(t: np.ndarray) -> np.ndarray:
            k = (t * 401).astype(int)
            return np.stack([0 * across[k] + x, across[k], heights[k]], axis=-1).astype(Exact)

        return points


def _over(side: Any, w: Any, away: Any) -> Any:
    """Return the height over a face, to first order."""
    if side.flat:
        return w
    c, kappa = 1 / Exact(side.radius), 1 + Exact(side.constant)
    g = 1 + c * kappa * w
    value = (c * (away * away + kappa * w * w) + 2 * w) / (2 * np.hypot(c * away, g))
    # beyond the middle of a ball it says nothing
    return np.where(g >= 0, value, w)


def halved(r: Region, shape: str) -> None:
    """In a lens, beside a plate through its axis."""
    g = Glass(r, shape)
    r.heights.append(g.height)
    r.plane((1, 0, 0), (0, 0, 0))
    for face, z in ((0, g.half), (1, -g.half)):
        r.edges.append(g.meridian(face))
        r.edges.append(arc((0, 0, z), (g.rim, 0, 0), (0, g.rim, 0), -np.pi / 2, np.pi / 2))
    if g.half:
        for y in (-g.rim, g.rim):
            r.edges.append(segment((0, y, -g.half), (0, y, g.half)))
    r.middle[:] = 0.2, 0.0, 0.5 * (g.vertex(0) + g.vertex(1))


def on_a_plate(r: Region, shape: str) -> None:
    """In a lens whose lower rim lies on a plate, cut by another one."""
    g = Glass(r, shape)
    r.heights.append(g.height)
    r.plane((0, 0, 1), (0, 0, -g.half))
    r.plane((0, 1, 0), (0, 0.1, 0))
    low, x = math.asin(0.1 / g.rim), math.sqrt(g.rim**2 - 0.01)
    for z in (g.half, -g.half):
        r.edges.append(arc((0, 0, z), (g.rim, 0, 0), (0, g.rim, 0), low, np.pi - low))
    r.edges.append(segment((-x, 0.1, -g.half), (x, 0.1, -g.half)))
    top = g.meridian(0, x=0.1)
    turn = np.array([[0, 1, 0], [1, 0, 0], [0, 0, 1]], Exact)
    r.edges.append(lambda t: top(t) @ turn)
    r.middle[:] = 0.0, 0.3, -g.half + 0.5 * (g.vertex(0) + g.half)


def in_a_barrel(r: Region, shape: str, begin: float = -0.5) -> None:
    """Between the front of a lens, the tube that it fills and a disk."""
    g = Glass(r, shape)
    r.heights.append(lambda points: -g.height(points))
    top = max(g.vertex(0), g.half) + 0.4
    low = -g.half + begin if begin < 0 else g.half
    r.wall(Cylinder, (0, 0, low), radius=g.rim, length=top - low)
    r.plane((0, 0, -1), (0, 0, top), g.rim)
    r.edges.extend((circle(g.half, g.rim), circle(top, g.rim)))
    r.middle[:] = 0.0, 0.0, top - 0.2


def at_a_barrels_end(r: Region, shape: str) -> None:
    """The same where the tube ends on the rim."""
    in_a_barrel(r, shape, 0.0)


def glass_in_a_barrel(r: Region, shape: str) -> None:
    """In a lens that fills a tube."""
    g = Glass(r, shape)
    r.heights.append(g.height)
    low = -g.half - 0.5
    r.wall(Cylinder, (0, 0, low), radius=g.rim, length=1.0 + 2.0 * g.half)
    r.edges.extend((circle(g.half, g.rim), circle(-g.half, g.rim)))
    r.middle[:] = 0.0, 0.0, 0.5 * (g.vertex(0) + g.vertex(1))


def in_a_cone(r: Region, shape: str) -> None:
    """Between the front of a lens, a cone on which its upper rim lies, and a disk."""
    g = Glass(r, shape)
    r.heights.append(lambda points: -g.height(points))
    top = max(g.vertex(0), g.half) + 0.4
    low = g.half - 0.2
    k = 0.5
    wide, narrow = g.rim + 0.2 * k, g.rim - k * (top - g.half)
    r.wall(Cone, (0, 0, low), entrance_radius=wide, exit_radius=narrow, length=top - low)
    r.plane((0, 0, -1), (0, 0, top), narrow)
    r.edges.extend((circle(g.half, g.rim), circle(top, narrow)))
    r.middle[:] = 0.0, 0.0, top - 0.2


def in_a_ball(r: Region, shape: str) -> None:
    """Between the front of a lens and a ball on which its upper rim lies."""
    g = Glass(r, shape)
    r.heights.append(lambda points: -g.height(points))
    up = max(g.vertex(0), g.half) - g.half + 0.1
    r.ball((0, 0, g.half + up), math.hypot(up, g.rim))
    r.edges.append(circle(g.half, g.rim))
    r.middle[:] = 0.0, 0.0, g.half + up + 0.1


def beside_on_a_plate(r: Region, shape: str) -> None:
    """Between a lens whose lower rim lies on a plate and a ball around it."""
    g = Glass(r, shape)
    r.heights.append(lambda points: -g.height(points))
    r.plane((0, 0, 1), (0, 0, -g.half))
    big = 1.5 + max(g.vertex(0), g.half)
    r.ball((0.0, 0.0, -g.half), big)
    r.edges.extend((circle(-g.half, g.rim), circle(-g.half, big)))
    if g.half:
        r.edges.append(circle(g.half, g.rim))
    r.middle[:] = 0.0, 0.0, -g.half + big - 0.3


def rim_to_rim(r: Region, shape: str) -> None:
    """Between two lenses whose rims touch, in a tube that both fill."""
    g = Glass(r, shape)
    h = Glass(r, "biconcave")
    r.elements.pop()
    # a face that bulges touches the other lens's hollow one at no place
    away = max(g.vertex(0), g.half) + h.half
    h = Glass(r, "biconcave", away)
    r.heights.extend((lambda points: -g.height(points), lambda points: -h.height(points)))
    low = -g.half - 0.2
    r.wall(Cylinder, (0, 0, low), radius=g.rim, length=away + h.half + 0.1 - low)
    r.edges.extend((circle(g.half, g.rim), circle(away - h.half, h.rim)))
    r.middle[:] = 0.0, 0.0, 0.5 * (g.vertex(0) + h.vertex(1))


def face_to_face(r: Region, shape: str) -> None:
    """Between two hollow faces whose rims are one."""
    g = Glass(r, "biconcave")
    h = Glass(r, "biconcave", 2.0 * g.half)
    r.heights.extend((lambda points: -g.height(points), lambda points: -h.height(points)))
    r.edges.append(circle(g.half, g.rim))
    r.middle[:] = 0.0, 0.0, g.half


KINDS: dict[str, Callable[[Region, str], None]] = {
    f.__name__.replace("_", " "): f
    for f in (halved, on_a_plate, in_a_barrel, at_a_barrels_end, glass_in_a_barrel, in_a_cone,
              in_a_ball, beside_on_a_plate, rim_to_rim, face_to_face)
}  # fmt: skip


def _meant(kind: str, shape: str) -> bool:
    front, back = SHAPES[shape][:2]
    if kind == "on a plate":
        # else the plate cuts the face itself; nor where face and edge go on as one
        return back > 0 and shape not in _SMOOTH
    if kind == "beside on a plate":
        return back < 0 or math.isinf(back)
    if kind == "face to face":
        return shape == "biconcave"
    if kind == "rim to rim":
        return shape not in {*_SMOOTH, "hollow ball end"}
    if shape == "hollow ball end" and kind in {"at a barrels end", "glass in a barrel", "halved"}:
        return False  # at its rim the glass is a wedge of no angle
    if kind == "halved":
        return shape not in _SMOOTH  # a limit, see docs/guarantees.md
    if kind == "in a ball":
        return front < 0 or front > 1.0
    if kind == "in a cone":
        return shape not in {*_SMOOTH, "aspheric"}
    return True


LENS_REGIONS = [(kind, shape) for kind in KINDS for shape in SHAPES if _meant(kind, shape)]


def lens_made(
    kind: str, shape: str, surface: Surface, tilt: tuple[float, float], scale: float, at: Any,
    glass: Surface | None = None,
) -> Region:  # fmt: skip
    """Return a region of some kind around a lens of some shape at some place.

    `stack` is one for lenses of `glass`: it goes on in them.
    """
    region = Region(surface, tilt, scale, np.array(at, float))
    if kind == "stack":
        stack(region, shape, glass)
    else:
        KINDS[kind](region, shape)
    return region


def stack(r: Region, shape: str, glass: Surface | None) -> None:
    """In a tube that a lens fills, and another one whose hollow face begins at its rim."""
    inside = replace(r, surface=glass or r.surface)  # the lists are one
    g = Glass(inside, shape)
    h = Glass(inside, "biconcave")
    r.elements.pop()
    away = max(g.half, g.vertex(0)) + h.half
    h = Glass(inside, "biconcave", away)
    low, top = min(g.vertex(1), -g.half) - 0.3, away + h.half + 0.3
    r.wall(Cylinder, (0, 0, low), radius=g.rim, length=top - low)
    r.plane((0, 0, 1), (0, 0, low), g.rim)
    r.plane((0, 0, -1), (0, 0, top), g.rim)
    for z in (low, -g.half, g.half, away - h.half, away + h.half, top):
        r.edges.append(circle(z, g.rim))
    r.middle[:] = 0.0, 0.0, top - 0.2
