"""Hard cases on walls of revolution: cylinders, cones and conics of many proportions."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.scene.elements.cone import Cone
from photizon_cl.scene.elements.conic import Conic
from photizon_cl.scene.elements.cylinder import Cylinder
from photizon_cl.scene.elements.sheets import equator
from photizon_cl.stability.build import SCALES, TILT, aimed, black, turned
from photizon_cl.stability.case import Case, Left

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.elements import Element

__all__ = [
    "round_axis",
    "round_departed",
    "round_far",
    "round_inside",
    "round_outside",
    "round_rims",
    "round_tangent",
    "round_wall",
]

_AT: Final = (0.3, -0.2, 0.1)
_CONES: Final = (  # entrance, exit, length
    (0.7, 1.3, 1.1), (0.7, 0.0, 1.1), (0.0, 0.7, 1.1), (0.7, 0.7 * (1 + 1e-9), 1.1),
    (0.0, 1.3, 1e-4), (0.5, 1.3, 1e-3), (1e-3, 0.0, 1.1), (1e-6, 1.3, 1.1), (0.7, 0.7, 1.1),
)  # fmt: skip
_CONICS: Final = (  # curvature, constant, aperture (0 for the equator), hole
    (1.3, 0.0, 0.9, 0.0), (1.3, 0.0, 0.0, 0.0), (1.3, 0.0, 1.3, 1.2), (1.3, -1.0, 1.1, 0.0),
    (1.3, -1.0, 1e-4, 0.0), (1.3, -1.0, 300.0, 0.0), (1.3, -0.6, 0.0, 0.0), (1.3, -0.6, 1.7, 0.5),
    (1.3, -1.0 + 1e-9, 1e3, 0.0), (1.3, -2.5, 2.3, 0.3), (1.3, -50.0, 40.0, 0.0),
    (1e-3, -1.4, 1.0, 0.0), (1.3, 0.8, 0.0, 0.0), (1.3, 1e3, 0.0, 0.0), (1e6, -1.0, 1.0, 0.0),
    # hyperboloids far out on their asymptotes
    (0.1, -1.5, 1.0, 0.0), (1e-6, -5.0, 1.0, 0.0), (0.01, -100.0, 1.0, 0.3), (1e-6, -1e4, 1.0, 0.0),
)  # fmt: skip
_SKEW: Final = 2.399963  # radians: no special angle


def _sizes() -> Iterator[tuple[Any, dict[str, float]]]:
    for length in (1.9, 700.0, 1e-4):
        yield Cylinder, {"radius": 0.7, "length": length}
    for entrance, exit_, length in _CONES:
        yield Cone, {"entrance_radius": entrance, "exit_radius": exit_, "length": length}
    for radius, k, rim, hole in _CONICS:
        made = {"curvature_radius": radius, "conic_constant": k, "inner_radius": hole}
        yield Conic, {**made, "aperture_radius": rim or equator(radius, k)}


def _shapes(r: random.Random) -> Iterator[tuple[str, tuple[Element, ...], Any]]:
    """Return every shape at some size, upright or tilted: a label, the scene, the element."""
    for n, (kind, sizes) in enumerate(_sizes()):
        for scale in SCALES if n in (0, 3, 15) else (1.0, r.choice(SCALES)):
            if kind is Conic:  # the equator is rounded anew
                sizes["aperture_radius"] *= 1.0 if scale == 1.0 else 1.0 - 2.0**-52
            tilt = r.choice([(0.0, 0.0), TILT])
            wall = black(kind, scale, tilt=tilt, at=_AT, name="one", axis="+z", **sizes)
            yield f"{kind.kind} {n}, scale {scale:g}{', tilted' if tilt[0] else ''}", (wall,), wall


def _meridian(wall: Any, share: float) -> tuple[float, float, float, float]:
    """Return radius and height of a place between the rims, and the direction to the upper one."""
    if isinstance(wall, Conic):
        low = wall.inner_radius
        r = low + share * (wall.aperture_radius - low)
        z = wall.sag(r)
        along = (max(wall.curvature_radius - wall.kappa * z, 0.0), r)
    else:
        low, high = (
            (wall.radius, wall.radius)
            if isinstance(wall, Cylinder)
            else (wall.entrance_radius, wall.exit_radius)
        )
        r, z = low + share * (high - low), share * wall.length
        along = (high - low, wall.length)
    k = math.hypot(*along)
    return r, z, along[0] / k, along[1] / k


def _place(
    wall: Any, share: float, phi: float, off: float = 0.0, shift: float = 0.0
) -> list[float]:
    """Return a point `off` outwards of the wall, `shift` along its meridian, in metres."""
    r, z, a, b = _meridian(wall, share)
    r, z = r + off * b + shift * a, z - off * a + shift * b
    return [r * math.cos(phi), r * math.sin(phi), z]


def _leaning(wall: Any, share: float, phi: float, turn: float, lean: float) -> list[float]:
    """Return a direction at the wall: `turn` from its circle, sine `lean` outwards."""
    _, _, a, b = _meridian(wall, share)
    flat = math.sqrt((1.0 - lean) * (1.0 + lean))
    around, up = flat * math.cos(turn), flat * math.sin(turn)
    out, along = lean * b + up * a, up * b - lean * a
    return [
        out * math.cos(phi) - around * math.sin(phi),
        out * math.sin(phi) + around * math.cos(phi),
        along,
    ]


def _size(wall: Any, share: float) -> float:
    """Return a length that a ray near a place of the wall is about as long as, in metres."""
    low, high = wall.heights
    return float(max(_meridian(wall, share)[0], 1e-3 * (high - low), 1e-6 * wall.widest))


def _angle(r: random.Random) -> float:
    return r.choice([0.0, _SKEW, r.uniform(0.0, 2.0 * math.pi)])


def round_inside() -> Iterator[Case]:
    """Rays from inside onto the wall and out of the ends: skew, across, in a meridian."""
    r = random.Random(51)
    for label, scene, wall in _shapes(r):
        for k in range(4):
            start, end, phi = r.random(), r.random(), _angle(r)
            depth = _meridian(wall, start)[0] * r.choice([0.5, 0.9, 1.5])
            a = _place(wall, start, phi, -depth)
            yield aimed(
                f"inside, {label}",
                scene,
                a,
                _place(wall, end, phi + r.choice([3.0, math.pi, 0.5, 0.0])),
            )
            if k < 2:
                low, high = wall.heights
                out = [0.3 * wall.widest * r.uniform(-1, 1) for _ in range(2)]
                yield aimed(f"to an end, {label}", scene, a, (*out, r.choice([low, high])))
        middle = _place(wall, 0.6, 1.0, -0.3 * _meridian(wall, 0.6)[0])
        yield turned(f"across, {label}", scene, middle, (1.0, 0.5, 0.0))


def round_outside() -> Iterator[Case]:
    """Rays from outside and through the ends onto both sides of the wall."""
    r = random.Random(52)
    for label, scene, wall in _shapes(r):
        low, high = wall.heights
        for _ in range(4):
            end, phi = r.random(), _angle(r)
            size = _size(wall, end)
            a = _place(wall, end, phi + r.uniform(-1, 1), size * r.choice([0.1, 1.0, 5.0]))
            yield aimed(f"from outside, {label}", scene, a, _place(wall, end, phi))
            over = r.choice([low - wall.widest, high + wall.widest])
            a = [wall.widest * r.uniform(-1, 1), wall.widest * r.uniform(-1, 1), over]
            yield aimed(f"from an end, {label}", scene, a, _place(wall, end, phi))


def round_tangent() -> Iterator[Case]:
    """Rays that graze the wall, along its circles, its meridians and between."""
    r = random.Random(53)
    for label, scene, wall in _shapes(r):
        for miss in (0.0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-8, -1e-8, 1e-3, -1e-3):
            share, phi = r.uniform(0.05, 0.95), _angle(r)
            size = _size(wall, share)
            along = _leaning(wall, share, phi, r.choice([0.0, 0.5 * math.pi, r.uniform(0, 6)]), 0.0)
            away = size * r.choice([0.3, 3.0, 40.0])
            place = _place(wall, share, phi, miss * size)
            start = [p - away * d for p, d in zip(place, along, strict=True)]
            yield turned(f"grazes by {miss:+g}, {label}", scene, start, along)


def round_rims() -> Iterator[Case]:
    """Rays at both rims, from inside and from outside."""
    r = random.Random(54)
    for label, scene, wall in _shapes(r):
        for share in (0.0, 1.0):
            for beside in (0.0, 1e-16, -1e-16, 1e-15, -1e-15, 1e-12, -1e-12, 1e-8, -1e-8):
                phi, size = _angle(r), _size(wall, share)
                end = _place(wall, share, phi, 0.0, (2.0 * share - 1.0) * beside * wall.widest)
                turn, lean = r.uniform(0, 6), r.choice([1, -1]) * r.choice([0.9, 0.3, 1e-3])
                along = _leaning(wall, share, phi, turn, lean)
                start = [p - size * d for p, d in zip(end, along, strict=True)]
                yield aimed(f"rim {share:g} {beside:+g}, {label}", scene, start, end)


def round_wall() -> Iterator[Case]:
    """Rays launched on the wall, and a little off it."""
    r = random.Random(55)
    for label, scene, wall in _shapes(r):
        for off in (0.0, 0.0, 1e-12, -1e-12, 1e-6, -1e-6):
            for lean in (0.9, 1e-3, 1e-9):
                share, phi = r.uniform(0.05, 0.95), _angle(r)
                start = _place(wall, share, phi, off * _size(wall, share))
                along = _leaning(wall, share, phi, r.uniform(0, 6), r.choice([1, -1]) * lean)
                yield turned(f"starts {off:+g} off the wall, {label}", scene, start, along)


def round_departed() -> Iterator[Case]:
    """Rays that left the wall, on either side of it."""
    r = random.Random(56)
    for label, scene, wall in _shapes(r):
        for lean in (1.0, 0.5, 0.1, 1e-3, 1e-6, 1e-9, 1e-12):
            for outside in (False, False, True):
                share, phi = r.uniform(0.05, 0.95), _angle(r)
                turn = r.choice([0.0, 0.5 * math.pi, -0.5 * math.pi, r.uniform(0, 6)])
                along = _leaning(wall, share, phi, turn, lean if outside else -lean)
                left = Left(0, 0, plus=outside == (wall.plus_side == "outside"))
                side = "outside" if outside else "inside"
                yield turned(
                    f"left the {side}, {lean:g}, {label}",
                    scene,
                    _place(wall, share, phi),
                    along,
                    left=left,
                )


def round_far() -> Iterator[Case]:
    """Rays from far away, and short ones at a huge wall."""
    r = random.Random(57)
    for label, scene, wall in _shapes(r):
        for ratio in (1e2, 1e4, 1e6, 1e8):
            share, phi = r.random(), _angle(r)
            size = _size(wall, share)
            place = _place(wall, share, phi)
            for away in (ratio, 1.0 / ratio):
                side = _leaning(wall, share, phi, r.uniform(0, 6), r.choice([1, -1]) * 0.5)
                start = [p - away * size * d for p, d in zip(place, side, strict=True)]
                yield aimed(f"from {away:g} sizes, {label}", scene, start, place)


def round_axis() -> Iterator[Case]:
    """Rays along the axis and near it, through a vertex or an apex, and at them from aside."""
    r = random.Random(58)
    for label, scene, wall in _shapes(r):
        low, high = wall.heights
        tall = max(high - low, wall.widest)
        for beside in (0.0, 1e-15, 1e-9, 1e-3):
            at = (beside * wall.widest * math.cos(_SKEW), beside * wall.widest * math.sin(_SKEW))
            for height, down in (
                (low - tall, 1.0),
                (high + tall, -1.0),
                (0.5 * (low + high), -1.0),
            ):
                yield turned(
                    f"{beside:g} off the axis, {label}", scene, (*at, height), (0, 0, down)
                )
            for lean in (1e-9, 1e-3, 1.0):
                for end in (low, high):
                    phi = _angle(r)
                    along = (lean * math.cos(phi), lean * math.sin(phi), r.choice([1.0, -1.0]))
                    k = tall * r.choice([1.0, 30.0])
                    start = [p - k * d for p, d in zip((*at, end), along, strict=True)]
                    yield turned(f"to the axis at an end, {lean:g}, {label}", scene, start, along)
