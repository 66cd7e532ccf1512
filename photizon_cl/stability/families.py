"""Hard cases on spheres and flat elements."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.stability.build import (
    SCALES,
    TILT,
    aimed,
    black,
    in_world,
    nudge,
    turned,
    unit,
)
from photizon_cl.stability.case import Case, Left, Triple

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = [
    "flat_edge",
    "flat_grazing",
    "flat_hole",
    "flat_tilt",
    "sphere_chord",
    "sphere_near_far",
    "sphere_port",
    "sphere_surface",
    "sphere_tangent",
]

_MISSES: Final = (0.0, 1e-15, -1e-15, 4e-15, -4e-15, 1e-12, -1e-12, 1e-8, -1e-8, 1e-3, -1e-3)


_FLATS: Final[tuple[tuple[Any, Any], ...]] = (
    (Rectangle, {"half_width": 1.0, "half_height": 2.0}),
    (Disk, {"radius": 1.5}),
)


def _basis(r: random.Random) -> tuple[Triple, Triple]:
    """Return two orthogonal unit vectors in no special direction."""
    a = unit([r.gauss(0, 1) for _ in range(3)])
    b = [r.gauss(0, 1) for _ in range(3)]
    along = math.fsum(x * y for x, y in zip(a, b, strict=True))
    return a, unit([y - along * x for x, y in zip(a, b, strict=True)])


def sphere_tangent() -> Iterator[Case]:
    """Rays whose closest approach is R(1 ± miss), from several distances."""
    r = random.Random(1)
    for scale in SCALES:
        ball = (black(Sphere, scale, radius=0.7, at=(0.3, -0.2, 0.1)),)
        radius = 0.7 * scale
        for miss in _MISSES:
            for away in (1.0, 40.0):
                across, along = _basis(r)
                start = [
                    radius * ((1 + miss) * a - away * b) for a, b in zip(across, along, strict=True)
                ]
                yield turned(f"closest approach R(1 {miss:+g}), R = {radius:g}", ball, start, along)
            start = [radius * (1 + miss), 0.0, -3 * radius]
            yield turned(f"axis ray at R(1 {miss:+g}), R = {radius:g}", ball, start, (0, 0, 1))


def sphere_near_far() -> Iterator[Case]:
    """Tiny and far, huge and near."""
    r = random.Random(2)
    for scale in SCALES:
        for ratio in (1e2, 1e5, 1e8, 1e11):
            tiny = (black(Sphere, scale, radius=1 / ratio),)
            for _ in range(3):
                out, _ = _basis(r)
                end = [0.7 * scale / ratio * x for x in _basis(r)[0]]
                yield aimed(
                    f"radius 1/{ratio:g} of the distance", tiny, [scale * x for x in out], end
                )
            huge = (black(Sphere, scale, radius=ratio, at=(0, 0, -ratio)),)
            top = ratio * scale
            for height in (1.0, -1.0):
                for _ in range(2):
                    along = unit([r.uniform(-1, 1), r.uniform(-1, 1), -r.random() * height])
                    start = (0.1 * scale, 0.2 * scale, top + height * scale)
                    yield turned(f"radius {ratio:g} times the height", huge, start, along)


def sphere_surface() -> Iterator[Case]:
    """Rays launched from a point of the surface, and a little off it."""
    r = random.Random(3)
    for scale in SCALES:
        ball = (black(Sphere, scale, radius=0.7, at=(0.3, -0.2, 0.1)),)
        for off in (0.0, 0.0, 1e-12, -1e-12, 1e-6, -1e-6):
            for grazing in (1.0, 1e-3, 1e-9):
                normal, across = _basis(r)
                for sign in (1, -1):
                    along = [
                        math.sqrt(1 - grazing**2) * a + sign * grazing * n
                        for a, n in zip(across, normal, strict=True)
                    ]
                    start = [0.7 * scale * (1 + off) * n for n in normal]
                    yield turned(
                        f"on the surface {off:+g}, grazing {grazing:g}", ball, start, along
                    )


def sphere_chord() -> Iterator[Case]:
    """Rays that left the sphere: the root at zero is taken out."""
    r = random.Random(4)
    for scale in SCALES:
        ball = (black(Sphere, scale, radius=0.7, at=(0.3, -0.2, 0.1)),)
        for grazing in (1.0, 0.1, 1e-3, 1e-6, 1e-9, 1e-12):
            for plus in (False, False, True):
                normal, across = _basis(r)
                sign = 1 if plus else -1
                along = [
                    math.sqrt(1 - grazing**2) * a + sign * grazing * n
                    for a, n in zip(across, normal, strict=True)
                ]
                start = [0.7 * scale * n for n in normal]
                label = f"left the {'outside' if plus else 'inside'}, grazing {grazing:g}"
                yield turned(label, ball, start, along, left=Left(0, 0, plus), must_hit=not plus)


def sphere_port() -> Iterator[Case]:
    """Rays at the rim of a port, from inside and through it."""
    r = random.Random(5)
    for scale in SCALES:
        for tilt in ((0.0, 0.0), TILT):
            for f in (0.5, 0.1, 1e-6):
                ball = (
                    black(
                        Sphere, scale, tilt=tilt, radius=0.7, port_fraction=f, at=(0.3, -0.2, 0.1)
                    ),
                )
                rim, high = 2 * math.sqrt(f * (1 - f)), 1 - 2 * f
                for beside in (0.0, 1e-15, -1e-15, 1e-9, -1e-9):
                    phi = r.uniform(0, 2 * math.pi)
                    end = [
                        0.7 * scale * x
                        for x in (
                            rim * (1 + beside) * math.cos(phi),
                            rim * (1 + beside) * math.sin(phi),
                            high - beside * rim,
                        )
                    ]
                    start = [0.2 * scale * r.uniform(-1, 1) for _ in range(3)]
                    yield aimed(f"rim of a port of {f:g}, {beside:+g}", ball, start, end)


def flat_grazing() -> Iterator[Case]:
    """Rays nearly in the plane."""
    r = random.Random(6)
    for scale in SCALES:
        for tilt in ((0.0, 0.0), TILT):
            for kind, sizes in _FLATS:
                one = (black(kind, scale, tilt=tilt, at=(0.3, -0.2, 0.1), **sizes),)
                for angle in (1e-3, 1e-7, 1e-10, 1e-13, 1e-15):
                    for side in (1, -1):
                        a = r.uniform(0, 2 * math.pi)
                        reach = 2.5 * scale
                        start = (-reach * math.cos(a), -reach * math.sin(a), side * angle * reach)
                        yield turned(
                            f"{angle:g} rad off the plane",
                            one,
                            start,
                            (math.cos(a), math.sin(a), -side * angle),
                        )


def flat_edge() -> Iterator[Case]:
    """Rays within an ulp of an edge, a corner, a rim."""
    r = random.Random(7)
    for scale in SCALES:
        for tilt in ((0.0, 0.0), TILT):
            at = (0.3, -0.2, 0.1)
            rect = (black(Rectangle, scale, tilt=tilt, at=at, half_width=1.0, half_height=0.3),)
            disk = (black(Disk, scale, tilt=tilt, at=at, radius=0.7),)
            for places in (0, 1, -1, 4, -4, 1000, -1000, 10**6, -(10**6)):
                near = 1 + places * 2.0**-52
                start = [
                    scale * r.uniform(-1, 1),
                    scale * r.uniform(-1, 1),
                    scale * r.choice([1, -2]),
                ]
                v = scale * r.uniform(-0.3, 0.3)
                yield aimed(f"edge, {places:+d} ulps", rect, start, (scale * near, v, 0))
                yield aimed(
                    f"corner, {places:+d} ulps", rect, start, (scale * near, -0.3 * scale * near, 0)
                )
                a = r.uniform(0, 2 * math.pi)
                rim = 0.7 * scale * near
                yield aimed(
                    f"rim, {places:+d} ulps", disk, start, (rim * math.cos(a), rim * math.sin(a), 0)
                )
            if tilt == (0.0, 0.0):
                for places in (0, 1, -1, 20, -20):
                    half = rect[0].position[0] + scale
                    start_x = nudge(half, places)
                    origin = (start_x, rect[0].position[1], rect[0].position[2] + scale)
                    yield Case(
                        f"parallel to the normal, edge {places:+d} ulps",
                        rect,
                        origin,
                        (0.0, 0.0, -1.0),
                    )


def flat_hole() -> Iterator[Case]:
    """Rays at both rims of an annulus, wide and narrow, and through its hole."""
    r = random.Random(9)
    for scale in SCALES:
        for tilt in ((0.0, 0.0), TILT):
            for inner in (1e-3, 0.3, 0.7 * (1.0 - 1e-9)):
                sizes: Any = {"radius": 0.7, "inner_radius": inner}
                one = (black(Disk, scale, tilt=tilt, at=(0.3, -0.2, 0.1), **sizes),)
                for places in (0, 1, -1, 4, -4, 1000, -1000, 10**6, -(10**6)):
                    a = r.uniform(0, 2 * math.pi)
                    start = [scale * r.uniform(-1, 1), scale * r.uniform(-1, 1), scale]
                    for rim in (0.7, inner):
                        near = rim * scale * (1 + places * 2.0**-52)
                        end = (near * math.cos(a), near * math.sin(a), 0)
                        yield aimed(f"rim of {rim:g}, {places:+d} ulps", one, start, end)
                for share in (-0.5, 0.0, 0.5, 1.5):
                    end = (scale * (inner + share * (0.7 - inner)), 0.1 * scale * inner, 0)
                    yield aimed(f"{share:g} of the ring", one, (0, 0, -2 * scale), end)


def flat_tilt() -> Iterator[Case]:
    """Tilts near 0 and near 90 degrees."""
    r = random.Random(8)
    for scale in SCALES:
        for tilt in (
            (1e-8, 0.0),
            (0.0, -1e-8),
            (89.999999, 0.0),
            (0.0, 89.999999),
            (-89.999999, 1e-8),
        ):
            for kind, sizes in _FLATS:
                one = (black(kind, scale, tilt=tilt, at=(0.3, -0.2, 0.1), **sizes),)
                for height in (1.0, 1e-6, 100.0):
                    end = [scale * r.uniform(-1.2, 1.2), scale * r.uniform(-2.2, 2.2), 0.0]
                    start = [scale * r.uniform(-2, 2), scale * r.uniform(-2, 2), scale * height]
                    yield aimed(f"tilt {tilt[0]:g}, {tilt[1]:g} deg", one, start, end)
                world = in_world(one[0], (0.1 * scale, 0.2 * scale, 0.0), point=True)
                above = (world[0], world[1], world[2] + 3 * scale)
                yield Case(
                    f"down the world's axis, tilt {tilt[0]:g}, {tilt[1]:g} deg",
                    one,
                    above,
                    (0.0, 0.0, -1.0),
                )
