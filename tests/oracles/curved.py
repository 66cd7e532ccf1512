"""Closed regions between curved and flat elements, and rays at the lines where those meet."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from oracles.corners import ROUNDING, Exact, U, follow
from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.conic import Conic
from photizon_cl.scene.elements.cpc import Cpc
from photizon_cl.scene.elements.cylinder import Cylinder
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import frame

if TYPE_CHECKING:
    from collections.abc import Callable

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.surfaces import Surface

    Curve = Callable[[np.ndarray], np.ndarray]
    Height = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Region:
    """A closed region in a frame and a unit of its own, filled by the builders in `regions`.

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
        Distance inwards from each surface around it, of world points (..., 3): right in
        sign, and in size near the surface.
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

    def plane(
        self, normal: Any, through: Any, radius: float | None = None, inner: float = 0.0
    ) -> None:
        """Add a plate with its normal into the region: a disk, or a rectangle beyond everything."""
        toward = np.asarray(normal, float) @ self.rows
        # R_v(b) R_u(a) turns +z to (sin b cos a, -sin a, cos b cos a)
        flat = math.hypot(toward[0], toward[2])
        tilt = (
            math.degrees(math.atan2(-toward[1], flat)),
            math.degrees(math.atan2(toward[0], toward[2])),
        )
        x, y, z = self.world(through).astype(float).tolist()
        where: dict[str, Any] = {"axis": "+z", "tilt_deg": tilt, "position": (x, y, z)}
        where |= {"name": f"plate {len(self.elements)}", "surface": self.surface}
        sides = {"half_width": 4.0 * self.scale, "half_height": 5.0 * self.scale}
        plate = (
            Rectangle(**where, **sides)
            if radius is None
            else Disk(**where, radius=radius * self.scale, inner_radius=inner * self.scale)
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

    def ball(self, centre: Any, radius: float, sign: float = 1.0, port: float = 0.0) -> None:
        """Add a ball around the region, perhaps with a port, or with sign −1 one outside it."""
        local = self.body(Sphere, centre, radius=radius, port_fraction=port)
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

    def wall(
        self, kind: Any, centre: Any = (0.0, 0.0, 0.0), sign: float = 1.0, **sizes: Any
    ) -> Any:
        """Add a wall of revolution around the region; return its rims' heights over its place."""
        local = self.body(kind, centre, **sizes)
        made = self.elements[-1]

        def height(points: Any) -> Any:
            p = local(points)
            r, z = norm(p[..., :2]), p[..., 2]
            if isinstance(made, Conic):
                big, kappa = Exact(made.curvature_radius), 1 + Exact(made.conic_constant)
                g = big - kappa * z
                return sign * (z * (g + big) - r * r) / (2 * np.hypot(r, g))
            low = Exact(made.radius if isinstance(made, Cylinder) else made.entrance_radius)
            high = Exact(made.radius if isinstance(made, Cylinder) else made.exit_radius)
            k = (high - low) / Exact(made.length)
            return sign * (low + k * z - r) / np.hypot(Exact(1), k)

        self.heights.append(height)
        # as those of the element, which at an equator are not to rounding those of its model
        return [Exact(z) / Exact(self.scale) for z in made.heights]

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


_NUMBERS = ("acceptance_deg", "baffles", "port_fraction", "conic_constant")


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


def leaks_of(
    region: Region, starts: Any, along: Any, steps: int = 30, *, reflected: bool = False
) -> tuple[int, int]:
    """Return how many rays escaped, and how many met something outside the region.

    Where a ray splits its transmitted child is followed, or the reflected one.
    """
    points, escaped, _ = follow(region.elements, starts, along, steps, reflected=reflected)
    low = np.array([height(points) for height in region.heights]).min(axis=0)
    return int(escaped.sum()), int((low < -ROUNDING * U * region.far).any(axis=1).sum())
