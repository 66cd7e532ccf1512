"""The closed regions whose edges are tested: tubes, concentrators, lenses, balls among plates."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from oracles.corners import Exact
from oracles.curved import Region, arc, circle, segment
from oracles.round_regions import ROUND

if TYPE_CHECKING:
    from oracles.curved import Curve
    from photizon_cl.scene.surfaces import Surface

__all__ = ["REGIONS", "made"]


def tube_and_plates(r: Region) -> None:
    """Between two baffles of a tube and a plate along it."""
    r.tube(3, 0.0, 0.5, 2.0)
    r.plane((1, 0, 0), (0.1, 0, 0))
    low, high = (0.1, -0.5, 0.5), (0.5, 0.5, 1.0)
    local = r.elements[0]
    rows, place = np.array(local.frame, Exact), np.array(local.position, Exact)
    for sign, z in ((1, 0.5), (-1, 1.0)):
        at = Exact(z * r.scale)
        r.heights.append(lambda points, sign=sign, at=at: sign * ((points - place) @ rows[2] - at))
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
        r.edges.extend(
            (arc((sign, 0, 1), (0, s, 0), (0, 0, s)), arc((0, sign, 1), (s, 0, 0), (0, 0, s)))
        )
    r.middle[:] = 0.0, 0.0, 1.0


def two_balls(r: Region) -> None:
    """In two balls at once."""
    r.ball((0.0, 0.0, 0.4), 1.0)
    r.ball((0.0, 0.0, -0.3), 0.9)
    z = (0.81 - 1.0 + 0.16 - 0.09) / 1.4
    r.edges.append(circle(z, math.sqrt(1.0 - (z - 0.4) ** 2)))


def closed_port(r: Region) -> None:
    """In a ball with a small port that a disk closes."""
    share = 1e-3
    r.ball((0.0, 0.0, 0.0), 1.0, port=share)
    height, rim = 1.0 - 2.0 * share, 2.0 * math.sqrt(share * (1.0 - share))
    r.plane((0, 0, -1), (0, 0, height), rim)
    r.edges.append(circle(height, rim))


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
        r.edges.extend(
            (
                arc((0, 0, z), (radius, 0, 0), (0, radius, 0), -np.pi / 2, np.pi / 2),
                segment((0, -radius, z), (0, radius, z)),
            )
        )
    r.middle[:] = 0.15, 0.0, 0.5 * (low + high)


def halved_lens(r: Region) -> None:
    """In a lens, beside a plate through its axis."""
    r.lens(1.3, 0.9, 0.7, inside=True)
    r.plane((1, 0, 0), (0, 0, 0))
    for sign, radius in ((1, 1.3), (-1, 0.9)):
        depth = math.sqrt(radius * radius - 0.49)
        half = math.asin(0.7 / radius)
        r.edges.append(
            arc((0, 0, -sign * depth), (0, 0, sign * radius), (0, radius, 0), -half, half)
        )
    r.edges.append(arc((0, 0, 0), (0.7, 0, 0), (0, 0.7, 0), -np.pi / 2, np.pi / 2))
    r.middle[:] = 0.2, 0.0, 0.0


def lens_on_a_plate(r: Region) -> None:
    """In a plano-convex lens that stands on a plate, cut by another one."""
    r.lens(0.8, None, 0.7, inside=True)
    r.plane((0, 0, 1), (0, 0, 0))
    r.plane((0, 1, 0), (0, 0.1, 0))
    r.edges.extend(
        (circle_part(0.1, 0.7), segment((-math.sqrt(0.48), 0.1, 0), (math.sqrt(0.48), 0.1, 0)))
    )
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


REGIONS: dict[str, Any] = {
    f.__name__.replace("_", " "): f
    for f in (
        tube_and_plates, tube_cut, ball_in_tube, two_balls, closed_port, closed_cpc, halved_cpc,
        halved_lens,
        lens_on_a_plate, beside_a_lens, ball_in_lens,
    )
} | ROUND  # fmt: skip


def made(kind: str, surface: Surface, tilt: tuple[float, float], scale: float, at: Any) -> Region:
    """Return a region of some kind at some place."""
    region = Region(surface, tilt, scale, np.array(at, float))
    REGIONS[kind](region)
    return region
