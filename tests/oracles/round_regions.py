"""Closed regions between walls of revolution, disks with and without holes, balls and plates."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from oracles.curved import arc, circle, segment
from photizon_cl.scene.elements.cone import Cone
from photizon_cl.scene.elements.conic import Conic, equator
from photizon_cl.scene.elements.cylinder import Cylinder

if TYPE_CHECKING:
    from collections.abc import Callable

    from oracles.curved import Region

__all__ = ["ROUND"]


def closed_cylinder(r: Region) -> None:
    """In a tube closed by disks."""
    r.wall(Cylinder, radius=0.4, length=1.1)
    r.plane((0, 0, 1), (0, 0, 0), 0.4)
    r.plane((0, 0, -1), (0, 0, 1.1), 0.4)
    r.edges.extend((circle(0.0, 0.4), circle(1.1, 0.4)))
    r.middle[:] = 0.0, 0.0, 0.5


def cylinder_and_plates(r: Region) -> None:
    """In a tube between an oblique plate and a plate along its axis."""
    r.wall(Cylinder, radius=0.4, length=3.0)
    n = (0.3, -0.5, 1.0)
    k = math.sqrt(1.34)
    r.plane([x / k for x in n], (0, 0, 1.0))
    r.plane((0, 0, -1), (0, 0, 2.5))
    r.plane((1, 0, 0), (0, 0, 0))
    # the plate's height is 1 - 0.3 x + 0.5 y
    r.edges.append(arc((0, 0, 1), (0.4, 0, -0.12), (0, 0.4, 0.2), -math.pi / 2, math.pi / 2))
    r.edges.append(arc((0, 0, 2.5), (0.4, 0, 0), (0, 0.4, 0), -math.pi / 2, math.pi / 2))
    for y in (-0.4, 0.4):
        r.edges.append(segment((0, y, 1.0 + 0.5 * y), (0, y, 2.5)))
    r.edges.append(segment((0, -0.4, 0.8), (0, 0.4, 1.2)))
    r.edges.append(segment((0, -0.4, 2.5), (0, 0.4, 2.5)))
    r.middle[:] = 0.2, 0.0, 1.8


def ball_in_cylinder(r: Region) -> None:
    """In a tube and in a ball that bulges through it."""
    r.wall(Cylinder, radius=0.4, length=2.0)
    r.ball((0.0, 0.0, 1.0), 0.6)
    s = math.sqrt(0.36 - 0.16)
    r.edges.extend((circle(1.0 - s, 0.4), circle(1.0 + s, 0.4)))
    r.middle[:] = 0.0, 0.0, 1.0


def closed_frustum(r: Region) -> None:
    """In a frustum closed by disks."""
    r.wall(Cone, entrance_radius=0.5, exit_radius=0.2, length=0.7)
    r.plane((0, 0, 1), (0, 0, 0), 0.5)
    r.plane((0, 0, -1), (0, 0, 0.7), 0.2)
    r.edges.extend((circle(0.0, 0.5), circle(0.7, 0.2)))
    r.middle[:] = 0.0, 0.0, 0.3


def closed_cone(r: Region) -> None:
    """In a full cone on a disk, its apex among the edges."""
    r.wall(Cone, entrance_radius=0.5, exit_radius=0.0, length=0.7)
    r.plane((0, 0, 1), (0, 0, 0), 0.5)
    r.edges.extend((circle(0.0, 0.5), circle(0.7, 0.0)))
    r.middle[:] = 0.0, 0.0, 0.3


def flat_cone(r: Region) -> None:
    """In a full cone that makes a small angle with the disk that closes it."""
    r.wall(Cone, entrance_radius=0.0, exit_radius=0.5, length=0.02)
    r.plane((0, 0, -1), (0, 0, 0.02), 0.5)
    r.edges.append(circle(0.02, 0.5))
    r.middle[:] = 0.0, 0.0, 0.015


def two_cones(r: Region) -> None:
    """Between two flat cones that share a rim."""
    r.wall(Cone, entrance_radius=0.0, exit_radius=0.5, length=0.05)
    r.wall(Cone, (0.0, 0.0, 0.05), entrance_radius=0.5, exit_radius=0.0, length=0.02)
    r.edges.append(circle(0.05, 0.5))
    r.middle[:] = 0.0, 0.0, 0.05


def capsule(r: Region) -> None:
    """In a tube between a cone and an ellipsoid that share its rims."""
    r.wall(Cylinder, radius=0.4, length=0.6)
    r.wall(Cone, (0.0, 0.0, 0.6), entrance_radius=0.4, exit_radius=0.1, length=0.5)
    r.plane((0, 0, -1), (0, 0, 1.1), 0.1)
    r.plane((0, 0, 1), (0, 0, 0), 0.4, inner=0.15)
    r.plane((0, 0, 1), (0, 0, 0), 0.15)
    r.edges.extend((circle(0.0, 0.4), circle(0.0, 0.15), circle(0.6, 0.4), circle(1.1, 0.1)))
    r.middle[:] = 0.0, 0.0, 0.5


def tubes_end_to_end(r: Region) -> None:
    """In two tubes that go on as one, closed by disks."""
    r.wall(Cylinder, radius=0.4, length=0.5)
    r.wall(Cylinder, (0.0, 0.0, 0.5), radius=0.4, length=0.6)
    r.plane((0, 0, 1), (0, 0, 0), 0.4)
    r.plane((0, 0, -1), (0, 0, 1.1), 0.4)
    r.edges.extend((circle(0.0, 0.4), circle(0.5, 0.4), circle(1.1, 0.4)))
    r.middle[:] = 0.0, 0.0, 0.5


def _dish(radius: float, k: float, rim: float) -> Callable[[Region], None]:
    def dish(r: Region) -> None:
        """In a sheet closed by a disk."""
        _, high = r.wall(Conic, curvature_radius=radius, conic_constant=k, aperture_radius=rim)
        r.plane((0, 0, -1), (0, 0, high), rim)
        r.edges.append(circle(high, rim))
        r.middle[:] = 0.0, 0.0, 0.6 * high

    return dish


def holed_dish(r: Region) -> None:
    """In a sheet with a hole, both of its rims closed by disks."""
    low, high = r.wall(Conic, curvature_radius=0.5, aperture_radius=0.4, inner_radius=0.1)
    r.plane((0, 0, -1), (0, 0, high), 0.4)
    r.plane((0, 0, 1), (0, 0, low), 0.1)
    r.edges.extend((circle(high, 0.4), circle(low, 0.1)))
    r.middle[:] = 0.0, 0.0, 0.6 * high


def halved_dish(r: Region) -> None:
    """In a paraboloid, beside a plate through its axis, under a plate across it."""
    r.wall(Conic, curvature_radius=0.5, conic_constant=-1.0, aperture_radius=0.6)
    high = 0.25
    rim = 0.5
    r.plane((0, 0, -1), (0, 0, high))
    r.plane((1, 0, 0), (0, 0, 0))
    r.edges.append(arc((0, 0, high), (rim, 0, 0), (0, rim, 0), -math.pi / 2, math.pi / 2))
    r.edges.append(segment((0, -rim, high), (0, rim, high)))
    r.middle[:] = 0.2, 0.0, 0.6 * high


ROUND: dict[str, Any] = {
    f.__name__.replace("_", " "): f
    for f in (
        closed_cylinder, cylinder_and_plates, ball_in_cylinder, closed_frustum, closed_cone,
        flat_cone, two_cones, capsule, tubes_end_to_end, holed_dish, halved_dish,
    )
} | {
    "paraboloid and disk": _dish(0.5, -1.0, 0.8),
    "half an ellipsoid": _dish(0.5, -0.6, equator(0.5, -0.6)),
    "ellipsoid and disk": _dish(0.5, -0.6, 0.6),
    "hemisphere and disk": _dish(0.5, 0.0, 0.5),
    "hyperboloid and disk": _dish(0.5, -2.5, 0.9),
    "shallow sheet and disk": _dish(0.5, -1.0, 0.02),
    "deep paraboloid and disk": _dish(0.01, -1.0, 0.5),
    "oblate sheet and disk": _dish(0.5, 3.0, 0.24),
}  # fmt: skip
