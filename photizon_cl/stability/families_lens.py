"""Hard cases on lenses of every shape: both faces, the edge, and the rims that they share."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.scene.elements.general_lens import Lens
from photizon_cl.scene.elements.sheets import equator
from photizon_cl.stability.build import SCALES, TILT, aimed, black, turned
from photizon_cl.stability.case import Case, Left

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.elements import Element

__all__ = [
    "glass_chord",
    "glass_faces",
    "glass_far",
    "glass_inside",
    "glass_on_it",
    "glass_rims",
    "glass_tangent",
    "glass_vertex",
]

_AT: Final = (0.3, -0.2, 0.1)
_INF: Final = math.inf
# front and back radius, conic constants, thickness; the rim has the radius 1
_SHAPES: Final = (
    (1.5, 2.5, 0.0, 0.0, 0.9),  # biconvex
    (-1.5, -2.5, 0.0, 0.0, 0.2),  # biconcave
    (1.5, -2.5, 0.0, 0.0, 0.3),  # menisci, thicker and thinner in the middle
    (2.5, -1.5, 0.0, 0.0, 0.05),
    (_INF, -1.2, 0.0, 0.0, 0.1),  # plano-concave
    (1.2, _INF, 0.0, 0.0, 0.7),  # plano-convex
    (_INF, _INF, 0.0, 0.0, 0.3),  # a plate
    (1.0, 1.0, 0.0, 0.0, 2.5),  # hemispheres
    (1.0, -1.0, 0.0, 0.0, 0.2),
    (0.5, _INF, -2.25, 0.0, 1.3),  # hyperboloid, ellipsoid, paraboloid
    (1.5, -0.8, -0.5, -1.0, 0.3),
    (0.9, -3.0, 0.6, -5.0, 0.8),
    (-0.01, 0.5, -30.0, -1.0, 2.0),  # far out on their asymptotes, and deep
    (1e6, -1e6, 0.0, 0.0, 1e-3),  # shallow: sags of a millionth
    (5e8, 1e6, 0.0, 0.0, 0.1),
    (-1e6, 3.0, 0.0, 0.0, 0.3),
    (1.5, 2.5, 0.0, 0.0, 0.0),  # edges like knives
    (1.5, -2.5, 0.0, 0.0, 0.0),
    (1e3, -1.001e3, 0.0, 0.0, 0.0),
    (1.3, 0.7, 0.0, -1.0, 40.0),  # a rod
)


def _lenses(r: random.Random) -> Iterator[tuple[str, tuple[Element, ...], Any]]:
    """Return every shape at some size, upright or tilted: a label, the scene, the lens."""
    for n, (front, back, k1, k2, thickness) in enumerate(_SHAPES):
        for scale in SCALES if n in (0, 3) else (1.0, r.choice(SCALES)):
            both = ((front, k1), (back, k2))
            widest = [equator(abs(x), k) for x, k in both if k > -1.0 and math.isfinite(x)]
            sizes: dict[str, Any] = {
                "front_radius": front, "back_radius": back, "front_conic": k1, "back_conic": k2,
                # an equator is rounded anew
                "aperture_radius": min([1.0, *widest]) * (1.0 if scale == 1.0 else 1.0 - 2.0**-50),
            }  # fmt: skip
            least = _sags(front, back, k1, k2, sizes["aperture_radius"])
            tilt = r.choice([(0.0, 0.0), TILT])
            # at the origin nothing but the lens itself is a measure of rounding
            at = r.choice([_AT, (0.0, 0.0, 0.0)])
            lens = black(Lens, scale, tilt=tilt, at=at, thickness=thickness or least, **sizes)
            label = f"shape {n}, scale {scale:g}{', tilted' if tilt[0] else ''}"
            yield label, (lens,), lens


def _sags(front: float, back: float, k1: float, k2: float, a: float) -> float:
    """Return the thickness of a lens whose faces meet at the rim."""
    total = 0.0
    for radius, k in ((front, k1), (back, k2)):
        if math.isfinite(radius):
            root = math.sqrt(max(radius * radius - (1.0 + k) * a * a, 0.0))
            total += math.copysign(a * a / (abs(radius) + root), radius)
    return total


class _Place:
    """A place on a face of a lens: the point, the normal and two directions along the face."""

    def __init__(self, lens: Any, face: int, share: float, phi: float) -> None:
        a, high = lens.aperture_radius, lens.edge_thickness
        cosine, sine = math.cos(phi), math.sin(phi)
        self.around = (-sine, cosine, 0.0)
        if face == 2:
            self.point = (a * cosine, a * sine, (share - 0.5) * high)
            self.normal, self.along = (cosine, sine, 0.0), (0.0, 0.0, 1.0)
            return
        side, up = lens.sides[face], 1.0 if face == 0 else -1.0
        r = share * a
        height = up * (lens.vertices[face] * up - float(side.sag_at(r)))
        self.point = (r * cosine, r * sine, height)
        slope = 0.0
        if not side.flat:
            root = math.sqrt(max(side.radius**2 - side.kappa * r * r, 0.0))
            slope = (
                math.copysign(r / root, side.radius) if root else math.copysign(1e16, side.radius)
            )
        k = math.hypot(1.0, slope)
        self.normal = (slope / k * cosine, slope / k * sine, up / k)
        self.along = (cosine / k, sine / k, -up * slope / k)

    def off(self, distance: float) -> tuple[float, ...]:
        """Return the point moved along the normal."""
        return tuple(p + distance * n for p, n in zip(self.point, self.normal, strict=True))

    def leaning(self, turn: float, lean: float) -> list[float]:
        """Return a direction: `turn` from the circle, sine `lean` outwards."""
        flat = math.sqrt((1.0 - lean) * (1.0 + lean))
        return [
            flat * (math.cos(turn) * a + math.sin(turn) * b) + lean * n
            for a, b, n in zip(self.around, self.along, self.normal, strict=True)
        ]


def _faces(lens: Any) -> range:
    return range(len(lens.faces))


def _turn(r: random.Random) -> float:
    return r.uniform(0.0, 2.0 * math.pi)


def _middle(lens: Any, r: random.Random) -> tuple[float, float, float]:
    """Return a point in the glass, near the axis."""
    low, high = lens.vertices[1], lens.vertices[0]
    z = low + (high - low) * r.uniform(0.2, 0.8)
    x = 0.02 * min(lens.aperture_radius, lens.thickness) * r.uniform(-1, 1)
    return (x, 0.3 * x, z)


def glass_faces() -> Iterator[Case]:
    """Rays onto faces and edge from outside, from any side."""
    r = random.Random(51)
    for label, scene, lens in _lenses(r):
        for face in _faces(lens):
            for _ in range(2):
                place = _Place(lens, face, r.uniform(0.02, 0.98), _turn(r))
                size = lens.aperture_radius
                start = place.off(size * r.choice([0.3, 3.0, 100.0]))
                start = tuple(x + size * 0.3 * r.gauss(0, 1) for x in start)
                yield aimed(f"onto face {face}, {label}", scene, start, place.point)
            inside = _Place(lens, face, r.uniform(0.02, 0.98), _turn(r))
            yield aimed(
                f"from the glass onto face {face}, {label}", scene, _middle(lens, r), inside.point,
                must_hit=True,
            )  # fmt: skip


def glass_rims() -> Iterator[Case]:
    """Rays at the rims that faces and edge share, from outside and from the glass."""
    r = random.Random(52)
    for label, scene, lens in _lenses(r):
        for up in (1.0, -1.0):
            for beside in (0.0, 1e-15, -1e-15, 1e-10, -1e-10):
                phi, a = _turn(r), lens.aperture_radius * (1.0 + beside)
                z = up * 0.5 * lens.edge_thickness * (1.0 + r.choice([0.0, beside, -beside]))
                end = (a * math.cos(phi), a * math.sin(phi), z)
                start = [2.0 * lens.reach * r.gauss(0, 1) for _ in range(3)]
                yield aimed(f"at a rim {beside:+g}, {label}", scene, start, end)
                yield aimed(
                    f"from the glass at a rim {beside:+g}, {label}", scene, _middle(lens, r), end,
                    must_hit=True,
                )  # fmt: skip
            yield turned(
                f"in a rim's plane, {label}", scene,
                (lens.aperture_radius, -3.0 * lens.aperture_radius, z), (0, 1, 0),
            )  # fmt: skip


def glass_tangent() -> Iterator[Case]:
    """Rays that graze a face or the edge: just off it, on it, just in the glass."""
    r = random.Random(53)
    for label, scene, lens in _lenses(r):
        for face in _faces(lens):
            for miss in (0.0, 1e-15, -1e-15, 1e-12, 1e-7, -1e-7, 1e-3):
                place = _Place(lens, face, r.uniform(0.05, 0.9), _turn(r))
                along = place.leaning(r.choice([0.0, _turn(r)]), 0.0)
                point = place.off(miss * lens.aperture_radius)
                back = lens.aperture_radius * r.choice([0.3, 3.0])
                start = [p - back * d for p, d in zip(point, along, strict=True)]
                yield turned(f"grazes face {face} at {miss:+g}, {label}", scene, start, along)


def glass_vertex() -> Iterator[Case]:
    """Rays along the axis, beside it, and through the vertices at all angles."""
    r = random.Random(54)
    for label, scene, lens in _lenses(r):
        for face, up in ((0, 1.0), (1, -1.0)):
            vertex, size = lens.vertices[face], lens.aperture_radius
            for beside in (0.0, 1e-160, 1e-20, 1e-9, 0.3):
                at = (beside * size, 0.0, vertex + up * size)
                yield turned(
                    f"along the axis, {beside:g} beside it, {label}", scene, at, (0, 0, -up)
                )
            for lean in (0.7, 1e-2, 1e-6, 1e-12):
                flat = math.sqrt((1.0 - lean) * (1.0 + lean))
                along = (flat, 0.0, -up * lean)
                start = [-size * d for d in along]
                start[2] += vertex
                yield turned(f"through a vertex, sine {lean:g}, {label}", scene, start, along)


def glass_inside() -> Iterator[Case]:
    """Rays in the glass that left a face: anywhere, beside the rims, grazing what they left."""
    r = random.Random(55)
    for label, scene, lens in _lenses(r):
        for face in _faces(lens):
            left = Left(0, face)
            for lean in (0.9, 0.3, 1e-2, 1e-5, 1e-9):
                place = _Place(lens, face, r.uniform(0.02, 0.98), _turn(r))
                yield turned(
                    f"left face {face}, sine {lean:g}, {label}", scene, place.point,
                    place.leaning(_turn(r), -lean), left=left, must_hit=True,
                )  # fmt: skip
            near_rim = _Place(lens, face, 1.0 - 10.0 ** r.uniform(-15, -3), _turn(r))
            yield turned(
                f"left face {face} beside the rim, {label}", scene, near_rim.point,
                near_rim.leaning(_turn(r), -r.choice([0.9, 1e-3])), left=left, must_hit=True,
            )  # fmt: skip


def glass_chord() -> Iterator[Case]:
    """Rays that left a face to the outside: across the hollow of a concave one, or away."""
    r = random.Random(56)
    for label, scene, lens in _lenses(r):
        for face in _faces(lens):
            hollow = face < 2 and lens.sides[face].radius < 0.0
            for lean in (0.9, 0.3, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9) if hollow else (0.3, 1e-5):
                place = _Place(lens, face, r.uniform(0.02, 0.98), _turn(r))
                # inwards where it may meet the face again
                turn = -0.5 * math.pi + r.uniform(-0.9, 0.9) if hollow else _turn(r)
                yield turned(
                    f"left face {face} outwards, sine {lean:g}, {label}", scene, place.point,
                    place.leaning(turn, lean), left=Left(0, face, plus=True),
                )  # fmt: skip


def glass_on_it() -> Iterator[Case]:
    """Rays launched on a face, or hardly off it, on either side."""
    r = random.Random(57)
    for label, scene, lens in _lenses(r):
        for face in _faces(lens):
            for off in (0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-8):
                place = _Place(lens, face, r.uniform(0.05, 0.95), _turn(r))
                start = place.off(off * lens.aperture_radius)
                lean = r.choice([1.0, -1.0]) * r.choice([1.0, 0.3, 1e-3])
                yield turned(
                    f"from face {face} {off:+g}, sine {lean:g}, {label}", scene, start,
                    place.leaning(_turn(r), lean),
                )  # fmt: skip


def glass_far() -> Iterator[Case]:
    """Rays from very far away and from very near."""
    r = random.Random(58)
    for label, scene, lens in _lenses(r):
        for face in _faces(lens):
            for away in (1e-6, 1e-3, 1e4, 1e8):
                place = _Place(lens, face, r.uniform(0.05, 0.95), _turn(r))
                lean = r.uniform(0.2, 0.9)
                along = place.leaning(_turn(r), -lean)
                far = away * lens.aperture_radius
                start = [p - far * d for p, d in zip(place.point, along, strict=True)]
                yield aimed(f"onto face {face} from {away:g}, {label}", scene, start, place.point)
