"""Closed regions between curved and flat elements, and rays at the lines where those meet."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from oracles.corners import ROUNDING, Exact, U, follow
from photizon_cl.elements import (
    BaffledTube,
    Biconvex,
    Cpc,
    Disk,
    PlanoConvex,
    Rectangle,
    Sphere,
)
from photizon_cl.frames import frame

if TYPE_CHECKING:
    from collections.abc import Callable

    from photizon_cl.elements import Element
    from photizon_cl.surfaces import Surface

    Curve = Callable[[np.ndarray], np.ndarray]
    Height = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Region:
    """A closed region in a frame and a unit of its own, filled by the builders below.

    Parameters
    ----------
    surface : Surface
        Of every element.
    tilt : tuple of float
        Turn of the frame.
    scale : float
        Its unit in metres.
    at : ndarray
        Its origin in world coordinates, in metres.
    elements : list of Element
        What stands in and around it.
    heights : list of callable
        Distance inwards from each surface around it, of world points (..., 3): right in sign, and in
        size near the surface.
    edges : list of callable
        Points (n, 3) on the lines where surfaces meet, in the frame, of n numbers in [0, 1).
    middle : tuple of float
        A point in it from which every edge is seen, in the frame.
    """

    surface: Surface
    tilt: tuple[float, float]
    scale: float
    at: np.ndarray
    elements: list[Element] = field(default_factory=list)
    heights: list[Height] = field(default_factory=list)
    edges: list[Curve] = field(default_factory=list)
    middle: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])

    @property
    def rows(self) -> np.ndarray:
        """Axes of the frame."""
        return np.array(frame("+z", self.tilt))

    @property
    def far(self) -> float:
        """Largest coordinate of anything that bounds the region, in metres."""
        return float(np.abs(self.at).max() + 3.0 * self.scale)

    def world(self, points: Any) -> np.ndarray:
        """Return world points of points in the frame."""
        return np.asarray(points, Exact) * self.scale @ self.rows.astype(Exact) + self.at

    def plane(self, normal: Any, through: Any, radius: float | None = None) -> None:
        """Add a plate with its normal into the region: a disk, or a rectangle beyond everything."""
        toward = np.asarray(normal, float) @ self.rows
        # R_v(b) R_u(a) turns +z to (sin b cos a, -sin a, cos b cos a)
        flat = math.hypot(toward[0], toward[2])
        tilt = math.degrees(math.atan2(-toward[1], flat)), math.degrees(math.atan2(toward[0], toward[2]))
        x, y, z = self.world(through).astype(float).tolist()
        where: dict[str, Any] = {"axis": "+z", "tilt_deg": tilt, "position": (x, y, z)}
        where |= {"name": f"plate {len(self.elements)}", "surface": self.surface}
        sides = {"half_width": 4.0 * self.scale, "half_height": 5.0 * self.scale}
        plate = (
            Rectangle(**where, **sides)
            if radius is None
            else Disk(**where, radius=radius * self.scale)
        )
        self.elements.append(plate)
        w, place = np.array(plate.frame[2], Exact), np.array(plate.position, Exact)
        self.heights.append(lambda points: (points - place) @ w)

    def body(self, kind: Any, centre: Any = (0.0, 0.0, 0.0), **sizes: Any) -> Callable[[Any], Any]:
        """Add a body around the axis; return points in its frame and unit of world points."""
        lengths = {k: v if k in _NUMBERS else v * self.scale for k, v in sizes.items()}
        x, y, z = self.world(centre).astype(float).tolist()
        body = kind(
            name=f"body {len(self.elements)}", axis="+z", tilt_deg=self.tilt, position=(x, y, z),
            surface=self.surface, **lengths,
        )  # fmt: skip
        self.elements.append(body)
        rows, place = np.array(body.frame, Exact), np.array(body.position, Exact)
        return lambda points: (points - place) @ rows.T

    def ball(self, centre: Any, radius: float, sign: float = 1.0) -> None:
        """Add a ball around the region, or with sign −1 one outside it."""
        local = self.body(Sphere, centre, radius=radius)
        r = Exact(radius * self.scale)
        self.heights.append(lambda points: sign * (r - norm(local(points))))

    def tube(self, baffles: int, clear: float, half: float, length: float) -> None:
        """Add the walls of a tube from z = 0 on."""
        local = self.body(
            BaffledTube, half_width=half, length=length, baffles=baffles, clear_half_width=clear
        )
        h = Exact(half * self.scale)
        for a in (0, 1):
            self.heights.append(lambda points, a=a: h - np.abs(local(points)[..., a]))

    def cpc(self, exit_radius: float, acceptance: float) -> Cpc:
        """Add a concentrator's wall; return it in the region's unit."""
        local = self.body(Cpc, exit_radius=exit_radius, acceptance_deg=acceptance)
        angle, a = np.radians(Exact(acceptance)), Exact(exit_radius * self.scale)
        s, c = np.sin(angle), np.cos(angle)
        b, d, e = 2 * a * (1 + s) ** 2, 2 * a * c * (2 + s), a * a * (1 + s) * (3 + s)

        def height(points: Any) -> Any:
            r, z = norm(local(points)[..., :2]), local(points)[..., 2]
            w = c * r + s * z
            slope = np.hypot(2 * c * w + b, 2 * s * w - d)
            return -(w * w + b * r - d * z - e) / slope

        self.heights.append(height)
        place = (0.0, 0.0, 0.0)
        return Cpc(
            name="unit", axis="+z", position=place, surface=self.surface,
            exit_radius=exit_radius, acceptance_deg=acceptance,
        )  # fmt: skip

    def lens(self, front: float, back: float | None, rim: float, *, inside: bool) -> None:
        """Add a lens with its rim around the origin, around the region or outside it."""
        sizes = {"aperture_radius": rim}
        if back is None:
            local = self.body(PlanoConvex, curvature_radius=front, **sizes)
        else:
            local = self.body(Biconvex, front_radius=front, back_radius=back, **sizes)
        a = Exact(rim * self.scale)

        def height(points: Any) -> Any:
            x = local(points)
            faces = []
            for sign, radius in ((1, front), (-1, back)):
                if radius is None:
                    faces.append(x[..., 2])
                    continue
                big = Exact(radius * self.scale)
                depth = np.sqrt((big - a) * (big + a))
                rise = x[..., 2] * (x[..., 2] + 2 * sign * depth) - a * a
                square = x[..., 0] ** 2 + x[..., 1] ** 2 + rise
                faces.append(-square / (2 * big))
            return np.minimum(*faces)

        self.heights.append(height if inside else lambda points: -height(points))


_NUMBERS = ("acceptance_deg", "baffles")


def norm(x: Any) -> Any:
    """Return lengths of vectors."""
    return np.sqrt((x * x).sum(axis=-1))


def circle(z: float, radius: float) -> Curve:
    """Return a circle about the axis."""
    return arc((0.0, 0.0, z), (radius, 0.0, 0.0), (0.0, radius, 0.0))


def arc(centre: Any, u: Any, v: Any, start: float = 0.0, end: float = 2 * np.pi) -> Curve:
    """Return the arc centre + u cos φ + v sin φ."""
    o, p, q = (np.array(x, Exact) for x in (centre, u, v))

    def points(t: np.ndarray) -> np.ndarray:
        phi = (start + (end - start) * t.astype(Exact))[:, None]
        return np.asarray(o + np.cos(phi) * p + np.sin(phi) * q)

    return points


def segment(a: Any, b: Any) -> Curve:
    """Return a straight line from a to b."""
    low, high = np.array(a, Exact), np.array(b, Exact)
    return lambda t: low + t[:, None].astype(Exact) * (high - low)


# -- the regions ---------------------------------------------------------------------------------


def tube_and_plates(r: Region) -> None:
    """Between two baffles of a tube and a plate along it."""
    r.tube(3, 0.0, 0.5, 2.0)
    r.plane((1, 0, 0), (0.1, 0, 0))
    low, high = (0.1, -0.5, 0.5), (0.5, 0.5, 1.0)
    local = r.elements[0]
    rows, place = np.array(local.frame, Exact), np.array(local.position, Exact)
    for sign, z in ((1, 0.5), (-1, 1.0)):
        at = Exact(z * r.scale)
        r.heights.append(
            lambda points, sign=sign, at=at: sign * ((points - place) @ rows[2] - at)
        )
    box_edges(r, low, high)


def tube_cut(r: Region) -> None:
    """In a tube between an oblique plate through its walls and one at its end."""
    r.tube(0, 0.0, 0.5, 3.0)
    n = np.array([0.3, -0.5, 1.0]) / math.sqrt(1.34)
    r.plane(n, (0, 0, 1.0))
    r.plane((0, 0, -1), (0, 0, 3.0))
    corners = [(x, y, 1.0 - 0.3 * x + 0.5 * y) for x, y in
               ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]  # fmt: skip
    for k in range(4):
        (x, y, z), other = corners[k], corners[k - 1]
        r.edges.extend((segment(other, (x, y, z)), segment((x, y, z), (x, y, 3.0))))
        r.edges.append(segment((other[0], other[1], 3.0), (x, y, 3.0)))
    r.middle[:] = 0.0, 0.0, 2.0


def box_edges(r: Region, low: Any, high: Any) -> None:
    """Add the twelve edges of a box, and its middle."""
    ends = np.array([low, high], float)
    for a in range(3):
        for bits in range(4):
            p = ends[[bits & 1, bits >> 1, 0], [(a + 1) % 3, (a + 2) % 3, a]]
            q = p.copy()
            q[2] = ends[1, a]
            order = [(0 - a + 2) % 3, (1 - a + 2) % 3, (2 - a + 2) % 3]
            r.edges.append(segment(p[order], q[order]))
    r.middle[:] = ends.mean(axis=0)


def ball_in_tube(r: Region) -> None:
    """In a tube and in a ball that bulges through its walls."""
    r.tube(0, 0.0, 0.5, 2.0)
    r.ball((0.0, 0.0, 1.0), 0.6)
    s = math.sqrt(0.36 - 0.25)
    for sign in (-0.5, 0.5):
        r.edges.extend((arc((sign, 0, 1), (0, s, 0), (0, 0, s)), arc((0, sign, 1), (s, 0, 0), (0, 0, s))))
    r.middle[:] = 0.0, 0.0, 1.0


def two_balls(r: Region) -> None:
    """In two balls at once."""
    r.ball((0.0, 0.0, 0.4), 1.0)
    r.ball((0.0, 0.0, -0.3), 0.9)
    z = (0.81 - 1.0 + 0.16 - 0.09) / 1.4
    r.edges.append(circle(z, math.sqrt(1.0 - (z - 0.4) ** 2)))


def closed_cpc(r: Region) -> None:
    """In a concentrator with both apertures closed by disks."""
    cpc = r.cpc(0.3, 25.0)
    r.plane((0, 0, 1), (0, 0, 0), 0.3)
    r.plane((0, 0, -1), (0, 0, cpc.length), cpc.entrance_radius)
    r.edges.extend((circle(0.0, 0.3), circle(cpc.length, cpc.entrance_radius)))
    r.middle[:] = 0.0, 0.0, 0.5 * cpc.length


def halved_cpc(r: Region) -> None:
    """In a concentrator, beside a plate through its axis, between two plates across it."""
    cpc = r.cpc(0.3, 25.0)
    low, high = 0.2 * cpc.length, 0.9 * cpc.length
    r.plane((1, 0, 0), (0, 0, 0))
    r.plane((0, 0, 1), (0, 0, low))
    r.plane((0, 0, -1), (0, 0, high))
    heights = np.linspace(low, high, 200)
    profile = np.array([cpc.radius_at(float(z)) for z in heights])

    def meridian(sign: float) -> Curve:
        def points(t: np.ndarray) -> np.ndarray:
            k = (t * 200).astype(int)
            return np.stack([0 * heights[k], sign * profile[k], heights[k]], axis=-1).astype(Exact)

        return points

    r.edges.extend((meridian(1.0), meridian(-1.0)))
    for z in (low, high):
        radius = cpc.radius_at(z)
        r.edges.extend((
            arc((0, 0, z), (radius, 0, 0), (0, radius, 0), -np.pi / 2, np.pi / 2),
            segment((0, -radius, z), (0, radius, z)),
        ))
    r.middle[:] = 0.15, 0.0, 0.5 * (low + high)


def halved_lens(r: Region) -> None:
    """In a lens, beside a plate through its axis."""
    r.lens(1.3, 0.9, 0.7, inside=True)
    r.plane((1, 0, 0), (0, 0, 0))
    for sign, radius in ((1, 1.3), (-1, 0.9)):
        depth = math.sqrt(radius * radius - 0.49)
        half = math.asin(0.7 / radius)
        r.edges.append(arc((0, 0, -sign * depth), (0, 0, sign * radius), (0, radius, 0), -half, half))
    r.edges.append(arc((0, 0, 0), (0.7, 0, 0), (0, 0.7, 0), -np.pi / 2, np.pi / 2))
    r.middle[:] = 0.2, 0.0, 0.0


def lens_on_a_plate(r: Region) -> None:
    """In a plano-convex lens that stands on a plate, cut by another one."""
    r.lens(0.8, None, 0.7, inside=True)
    r.plane((0, 0, 1), (0, 0, 0))
    r.plane((0, 1, 0), (0, 0.1, 0))
    r.edges.extend((circle_part(0.1, 0.7), segment((-math.sqrt(0.48), 0.1, 0), (math.sqrt(0.48), 0.1, 0))))
    depth = math.sqrt(0.64 - 0.49)
    across = math.sqrt(0.64 - 0.01)
    half = math.asin(math.sqrt(0.48) / across)
    r.edges.append(arc((0, 0.1, -depth), (0, 0, across), (across, 0, 0), -half, half))
    r.middle[:] = 0.0, 0.3, 0.15


def circle_part(y: float, radius: float) -> Curve:
    """Return the part of a circle about the axis in z = 0 that lies beyond a y."""
    low = math.asin(y / radius)
    return arc((0, 0, 0), (radius, 0, 0), (0, radius, 0), low, np.pi - low)


def beside_a_lens(r: Region) -> None:
    """Between a lens that stands on a plate and a ball around it."""
    r.lens(0.8, None, 0.5, inside=False)
    r.plane((0, 0, 1), (0, 0, 0))
    r.ball((0.0, 0.0, 0.0), 1.1)
    r.edges.extend((circle(0.0, 0.5), circle(0.0, 1.1)))
    r.middle[:] = 0.0, 0.0, 0.9


def ball_in_lens(r: Region) -> None:
    """In a lens and in a ball that stands off its axis."""
    r.lens(1.3, 0.9, 0.7, inside=True)
    r.ball((0.1, 0.0, 0.05), 0.25)
    for sign, radius in ((1, 1.3), (-1, 0.9)):
        depth = math.sqrt(radius * radius - 0.49)
        a, b = np.array([0.0, 0.0, -sign * depth]), np.array([0.1, 0.0, 0.05])
        w = b - a
        apart = float(np.linalg.norm(w))
        along = (radius * radius - 0.0625 + apart * apart) / (2 * apart)
        ring = math.sqrt(max(radius * radius - along * along, 0.0))
        w /= apart
        v = np.array([0.0, 1.0, 0.0])
        u = np.cross(v, w)
        r.edges.append(arc(a + along * w, ring * u, ring * v))
    r.middle[:] = 0.1, 0.0, 0.05


REGIONS = {
    f.__name__.replace("_", " "): f
    for f in (
        tube_and_plates, tube_cut, ball_in_tube, two_balls, closed_cpc, halved_cpc, halved_lens,
        lens_on_a_plate, beside_a_lens, ball_in_lens,
    )
}  # fmt: skip


def made(kind: str, surface: Surface, tilt: tuple[float, float], scale: float, at: Any) -> Region:
    """Return a region of some kind at some place."""
    region = Region(surface, tilt, scale, np.array(at, float))
    REGIONS[kind](region)
    return region


def _on_edges(r: np.random.Generator, region: Region, n: int) -> np.ndarray:
    which = r.integers(0, len(region.edges), n)
    share = np.where(r.random(n) < 0.7, r.random(n), 10.0 ** -r.uniform(6, 17, n))
    share = np.where(r.random(n) < 0.2, 0.0, share)
    points = np.empty((n, 3), Exact)
    for k, edge in enumerate(region.edges):
        points[which == k] = edge(share[which == k])
    return points


def rays_in(r: np.random.Generator, region: Region, n: int) -> tuple[Any, Any]:
    """Return rays from inside at the edges and up to 8 units in the last place beside them.

    They start anywhere between the middle and a place beside another edge, as near to it as 1e-12.
    """
    ends = region.world(_on_edges(r, region, n))
    ends = (ends + r.integers(-8, 9, (n, 3)) * np.spacing(np.abs(ends).astype(float))).astype(float)
    least = 4096.0 * U * region.far / region.scale
    share = np.maximum(r.choice([1.0, 0.1, 1e-3, 1e-6, 1e-9, 1e-12], (n, 1)), least).astype(Exact)
    beside, middle = _on_edges(r, region, n), np.array(region.middle, Exact)
    starts = region.world(beside + share * (middle - beside)).astype(float)
    apart = np.linalg.norm(ends - starts, axis=1)
    within = np.array([height(starts.astype(Exact)) for height in region.heights]).min(axis=0)
    keep = (apart > 1e-3 * region.scale) & (within > 512.0 * U * region.far)
    return starts[keep], ((ends - starts) / apart[:, None])[keep]


def leaks_of(region: Region, starts: Any, along: Any, steps: int = 30) -> tuple[int, int]:
    """Return how many rays escaped, and how many met something outside the region."""
    points, escaped, _ = follow(region.elements, starts, along, steps)
    low = np.array([height(points) for height in region.heights]).min(axis=0)
    return int(escaped.sum()), int((low < -ROUNDING * U * region.far).any(axis=1).sum())
