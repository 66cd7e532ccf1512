"""Hard cases on the CPC, the tube and the lenses."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.cpc import Cpc
from photizon_cl.scene.elements.lens import centre_depth, sag
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.stability.build import SCALES, TILT, aimed, black, turned
from photizon_cl.stability.case import Case, Left

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.elements import Element

__all__ = [
    "cpc_inside",
    "cpc_outside",
    "cpc_rims",
    "cpc_wall",
    "lens_inside",
    "lens_rim",
    "lens_shapes",
    "lens_tangent",
    "tube_corners",
    "tube_holes",
]

_ANGLES: Final = (0.1, 1.0, 20.0, 45.0, 75.0, 89.0)
_AT: Final = (0.3, -0.2, 0.1)


def _cpcs(r: random.Random) -> Iterator[tuple[str, tuple[Element, ...], Any]]:
    for angle in _ANGLES:
        for scale in (1e-9, 1.0, 1e9) if angle == 20.0 else (r.choice(SCALES),):
            for tilt in ((0.0, 0.0), TILT):
                cpc: Any = black(
                    Cpc, scale, tilt=tilt, at=_AT, exit_radius=0.7, acceptance_deg=angle
                )
                yield f"{angle:g} deg, a' = {0.7 * scale:g}", (cpc,), cpc


def cpc_inside() -> Iterator[Case]:
    """Meridional, skew and axial rays from inside a CPC and through its apertures."""
    r = random.Random(21)
    for label, scene, cpc in _cpcs(r):
        wide, narrow, length = cpc.entrance_radius, cpc.exit_radius, cpc.length
        for _ in range(2):
            z = length * r.random()
            start = (0.4 * cpc.radius_at(z), 0.0, z)
            end = length * r.random()
            side = r.choice([1, -1]) * cpc.radius_at(end)
            yield aimed(f"meridional, {label}", scene, start, (side, 0.0, end))
            phi = r.uniform(0, 2 * math.pi)
            at = cpc.radius_at(end)
            yield aimed(
                f"skew, {label}", scene, start, (at * math.cos(phi), at * math.sin(phi), end)
            )
        yield turned(f"across, {label}", scene, (0.0, 0.0, 0.3 * length), (1, 0.5, 0))
        yield turned(f"down the axis, {label}", scene, (0.0, 0.0, 2 * length), (0, 0, -1))
        yield turned(
            f"beside the axis, {label}", scene, (0.5 * narrow, 0.1 * narrow, 2 * length), (0, 0, -1)
        )
        yield turned(
            f"parallel at the wall, {label}", scene, (0.99 * wide, 0.0, 1.1 * length), (0, 0, -1)
        )


def cpc_outside() -> Iterator[Case]:
    """Rays from outside: onto the wall, along it, past it."""
    r = random.Random(22)
    for label, scene, cpc in _cpcs(r):
        wide, length = cpc.entrance_radius, cpc.length
        for _ in range(2):
            phi, z = r.uniform(0, 2 * math.pi), length * r.random()
            at = cpc.radius_at(z)
            start = (3 * wide * math.cos(phi), 3 * wide * math.sin(phi), length * r.uniform(-1, 2))
            yield aimed(
                f"onto the wall, {label}",
                scene,
                start,
                (at * math.cos(phi + 0.3), at * math.sin(phi + 0.3), z),
            )
        z = 0.4 * length
        at = cpc.radius_at(z)
        slope = (cpc.radius_at(0.4001 * length) - cpc.radius_at(0.3999 * length)) / (2e-4 * length)
        for miss in (1e-3, -1e-3, 1e-9, -1e-9, 0.0):
            yield turned(
                f"across at R(1 {miss:+g}), {label}",
                scene,
                (at * (1 + miss), -2 * at, z),
                (0, 1, 0),
            )
            yield turned(
                f"along the profile at R(1 {miss:+g}), {label}",
                scene,
                (at * (1 + miss) - slope * 3 * length, 0.0, z - 3 * length),
                (slope, 0, 1),
            )


def cpc_rims() -> Iterator[Case]:
    """Rays at both rims, from inside and outside."""
    r = random.Random(23)
    for label, scene, cpc in _cpcs(r):
        for rim, z in ((cpc.exit_radius, 0.0), (cpc.entrance_radius, cpc.length)):
            for beside in (0.0, 1e-15, -1e-15, 1e-9, -1e-9):
                phi = r.uniform(0, 2 * math.pi)
                end = (
                    rim * (1 + beside) * math.cos(phi),
                    rim * (1 + beside) * math.sin(phi),
                    z + beside * cpc.length * r.choice([1, -1]),
                )
                inside = (0.1 * cpc.exit_radius, 0.0, 0.5 * cpc.length)
                outside = (0.3 * rim, 0.1 * rim, z + (1 if z else -1) * cpc.entrance_radius)
                for start in (r.choice((inside, outside)),):
                    yield aimed(f"rim at {z:.3g} m, {beside:+g}, {label}", scene, start, end)


def cpc_wall() -> Iterator[Case]:
    """Rays that left the wall, on either side, and rays launched on it."""
    r = random.Random(24)
    for label, scene, cpc in _cpcs(r):
        for grazing in (1.0, 1e-3, 1e-7):
            z = cpc.length * r.uniform(0.1, 0.9)
            phi = r.uniform(0, 2 * math.pi)
            at = cpc.radius_at(z)
            step = 1e-4 * cpc.length
            slope = (cpc.radius_at(z + step) - cpc.radius_at(z - step)) / (2 * step)
            k = math.hypot(1, slope)
            normal = (math.cos(phi) / k, math.sin(phi) / k, -slope / k)
            turn = r.uniform(0, 2 * math.pi)
            across = [
                -math.sin(phi) * math.cos(turn) + slope / k * math.cos(phi) * math.sin(turn),
                math.cos(phi) * math.cos(turn) + slope / k * math.sin(phi) * math.sin(turn),
                math.sin(turn) / k,
            ]
            start = (at * math.cos(phi), at * math.sin(phi), z)
            for sign in (-1, 1):
                along = [
                    math.sqrt(1 - grazing**2) * a + sign * grazing * n
                    for a, n in zip(across, normal, strict=True)
                ]
                plus = sign > 0
                yield turned(
                    f"left it, grazing {grazing:g}, {label}",
                    scene,
                    start,
                    along,
                    left=Left(0, 0, plus),
                )
                yield turned(f"launched on it, grazing {grazing:g}, {label}", scene, start, along)


def _tubes(baffles: int) -> Iterator[tuple[str, tuple[Element, ...], Any]]:
    for scale in SCALES:
        for tilt in ((0.0, 0.0), TILT):
            tube: Any = black(
                BaffledTube,
                scale,
                tilt=tilt,
                at=_AT,
                half_width=0.7,
                length=3.1,
                baffles=baffles,
                clear_half_width=0.3,
            )
            yield f"half width {0.7 * scale:g}{', tilted' if tilt[0] else ''}", (tube,), tube


def tube_holes() -> Iterator[Case]:
    """Rays at the edges and corners of a baffle's hole."""
    r = random.Random(25)
    for label, scene, tube in _tubes(3):
        c = tube.clear_half_width
        z = tube.baffle_positions[1]
        for places in (0, 1, -1, 3, -3, 100, -100, 10**5, -(10**5)):
            near = c * (1 + places * 2.0**-52)
            start = (
                0.3 * c * r.uniform(-1, 1),
                0.3 * c * r.uniform(-1, 1),
                z + 0.1 * tube.length * r.choice([1, -1]),
            )
            yield aimed(f"hole's edge, {places:+d} ulps, {label}", scene, start, (near, 0.2 * c, z))
            yield aimed(f"hole's corner, {places:+d} ulps, {label}", scene, start, (near, -near, z))


def tube_corners() -> Iterator[Case]:
    """Rays into the long edges, onto the ends, along the walls, from the walls."""
    r = random.Random(26)
    for label, scene, tube in _tubes(0):
        h, length = tube.half_width, tube.length
        for places in (0, 1, -1, 4, -4):
            near = h * (1 + places * 2.0**-52)
            start = (0.3 * h * r.uniform(-1, 1), 0.3 * h, length * r.random())
            z = length * r.uniform(0.1, 0.9)
            yield aimed(
                f"long edge, {places:+d} ulps, {label}",
                scene,
                start,
                (near, near, z),
                must_hit=True,
            )
            yield aimed(
                f"end, {places:+d} ulps, {label}",
                scene,
                start,
                (h, 0.1 * h, length * (1 + places * 2.0**-52)),
            )
        yield turned(f"along the axis, {label}", scene, (0.1 * h, 0.0, -length), (0, 0, 1))
        for lean in (1e-3, 1e-9, 1e-14):
            yield turned(
                f"{lean:g} off the axis, {label}", scene, (0.1 * h, 0.0, -length), (lean, 0, 1)
            )
        for face in range(4):
            place = [0.2 * h, -0.3 * h, 0.4 * length]
            place[face // 2] = h * (-1 if face % 2 else 1)
            along = [0.3, 0.4, r.uniform(-1, 1)]
            along[face // 2] = 0.9 * (1 if face % 2 else -1)
            yield turned(f"left wall {face}, {label}", scene, place, along, left=Left(0, face))


def _lenses() -> Iterator[tuple[str, tuple[Element, ...], float, float, float]]:
    """Return lenses with their aperture and the radii of their caps (0 for the flat face)."""
    shapes = ((1.5, 2.5), (1.0, 1.0), (1.0, 1e6), (1e6, 1e6), (5e8, 5e8))
    for n, (front, back) in enumerate(shapes):
        for k, scale in enumerate(SCALES if n < 2 else (1e-9, 1e9)):
            for tilt in (((0.0, 0.0), TILT)[(n + k) % 2],):
                name = f"R = {front:g}, {back:g} a, a = {scale:g}{', tilted' if tilt[0] else ''}"
                lens = black(
                    Biconvex,
                    scale,
                    tilt=tilt,
                    at=_AT,
                    aperture_radius=1.0,
                    front_radius=front,
                    back_radius=back,
                )
                yield name, (lens,), scale, front * scale, back * scale
                flat = black(
                    PlanoConvex,
                    scale,
                    tilt=tilt,
                    at=_AT,
                    aperture_radius=1.0,
                    curvature_radius=front,
                )
                yield f"flat, {name}", (flat,), scale, front * scale, 0.0


def _height(radius: float, a: float, x: float) -> float:
    """Return the height of a cap of aperture a at a distance x from its axis."""
    if not radius:
        return 0.0
    depth = centre_depth(radius, a)
    return (a - x) * (a + x) / (depth + math.sqrt(max((radius - x) * (radius + x), 0.0)))


def lens_shapes() -> Iterator[Case]:
    """Rays onto both faces, from flat (a sag of 1e-9) to a hemisphere, radii up to 1 : 10^6."""
    r = random.Random(27)
    for label, scene, a, front, back in _lenses():
        for _ in range(2):
            for radius, side in ((front, 1), (back, -1)):
                x, phi = a * r.uniform(0, 0.999), r.uniform(0, 2 * math.pi)
                end = (x * math.cos(phi), x * math.sin(phi), side * _height(radius, a, x))
                start = (
                    a * r.uniform(-1, 1),
                    a * r.uniform(-1, 1),
                    side * a * r.choice([1.5, 30.0]),
                )
                yield aimed(f"from outside, {label}", scene, start, end)


def lens_rim() -> Iterator[Case]:
    """Rays at the rim, from above, below and the side."""
    r = random.Random(28)
    for label, scene, a, *_ in _lenses():
        for beside in (0.0, 1e-15, -1e-15, 1e-10, -1e-10):
            phi = r.uniform(0, 2 * math.pi)
            end = (a * (1 + beside) * math.cos(phi), a * (1 + beside) * math.sin(phi), 0.0)
            start = (a * r.uniform(-2, 2), a * r.uniform(-2, 2), 2 * a * r.choice([1, -1]))
            yield aimed(f"rim {beside:+g}, {label}", scene, start, end)
            yield turned(
                f"in the rim's plane {beside:+g}, {label}",
                scene,
                (a * (1 + beside), -3 * a, 0.0),
                (0, 1, 0),
            )


def lens_tangent() -> Iterator[Case]:
    """Rays that graze the vertex or a zone of a cap, outside and in."""
    r = random.Random(29)
    for label, scene, a, front, _ in _lenses():
        for x in (0.0, 0.6 * a):
            top, depth = _height(front, a, x), centre_depth(front, a)
            height = sag(front, a)
            for miss in (0.0, 1e-15, -1e-15, 1e-7, -1e-7):
                phi = r.uniform(0, 2 * math.pi)
                # across the slope there: along the circle, at right angles to the meridian
                point = (x * math.cos(phi), x * math.sin(phi), top + miss * height)
                along = (-math.sin(phi), math.cos(phi), 0.0)
                if x and r.random() < 0.5 and top:
                    k = (depth + top) / front
                    along = (k * math.cos(phi), k * math.sin(phi), -x / front)
                start = [p - 3 * a * d for p, d in zip(point, along, strict=True)]
                yield turned(f"grazes a cap, {miss:+g} of its height, {label}", scene, start, along)


def lens_inside() -> Iterator[Case]:
    """Rays inside the glass: from a face just passed, from within, towards the rim."""
    r = random.Random(30)
    for label, scene, a, front, back in _lenses():
        for side, radius, face in ((1, front, 0), (-1, back, 1)):
            if isinstance(scene[0], PlanoConvex):
                face = 1 - face
            x, phi = a * r.uniform(0, 0.95), r.uniform(0, 2 * math.pi)
            start = (x * math.cos(phi), x * math.sin(phi), side * _height(radius, a, x))
            other = back if side > 0 else front
            y, psi = a * r.uniform(0, 0.95), r.uniform(0, 2 * math.pi)
            end = (y * math.cos(psi), y * math.sin(psi), -side * _height(other, a, y))
            yield aimed(
                f"through the glass, {label}", scene, start, end, left=Left(0, face), must_hit=True
            )
            rim = (a * math.cos(psi), a * math.sin(psi), 0.0)
            yield aimed(
                f"to the rim, {label}", scene, start, rim, left=Left(0, face), must_hit=True
            )
            yield aimed(f"launched on a face, {label}", scene, start, end)
            out = (0.3 * math.cos(phi), 0.3 * math.sin(phi), side)
            yield turned(f"outwards, {label}", scene, start, out, left=Left(0, face, plus=True))
        middle = (0.1 * a, 0.2 * a, 0.4 * (_height(front, a, 0.3 * a) - _height(back, a, 0.3 * a)))
        yield turned(
            f"from within, {label}", scene, middle, [r.gauss(0, 1) for _ in range(3)], must_hit=True
        )
