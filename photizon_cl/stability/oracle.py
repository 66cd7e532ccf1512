"""What a case's answer must be, how ill-conditioned it is, and which answers rounding allows.

The inputs of a case are its doubles: origin, direction, position, orientation, sizes. A
*backward-stable* solution is the exact one of inputs each moved by no more than a unit roundoff of
its own size. To first order it is off by at most

    u · K,   K = Σ |∂ output / ∂ input| · (size of the input) + |output|,

which is what errors are counted in. A decision is firm where no inputs within `FIRM` times that
bound change it; where they do, every answer that they give is allowed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.cone import Cone
from photizon_cl.scene.elements.conic import Conic
from photizon_cl.scene.elements.cpc import Cpc
from photizon_cl.scene.elements.cylinder import Cylinder
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.stability.bodies import Face, exact_frame, faces_of, sizes_of
from photizon_cl.stability.digits import UNIT, Vector, add, dot, load_digits, norm, scaled, vector

if TYPE_CHECKING:
    from photizon_cl.scene.elements import Element
    from photizon_cl.stability.case import Case

__all__ = ["FIRM", "Candidate", "Verdict", "judge"]

FIRM: Final = 8.0
_STEP: Final = 1e-25
_CLOSED: Final = (Sphere, Biconvex, PlanoConvex, Cpc, Cylinder, Cone, Conic)


@dataclass
class Candidate:
    """A place where the ray may hit something.

    Parameters
    ----------
    element, face : int
        What.
    distance : number
        Metres; with `k_distance`, `k_point`, `k_normal` the K of each output.
    point, normal : list
        In world coordinates.
    certain : bool
        Whether no rounding takes it away.
    smooth : bool
        Whether the conditions mean something (not at a tangent within rounding).
    """

    element: int
    face: int
    distance: Any
    point: Vector
    normal: Vector
    k_distance: Any = 0
    k_point: Any = 0
    k_normal: Any = 0
    certain: bool = True
    smooth: bool = True


@dataclass
class Verdict:
    """The answers that are right: candidates, and whether a miss is."""

    candidates: list[Candidate] = field(default_factory=list)
    may_miss: bool = False

    @property
    def firm(self) -> bool:
        """Whether there is just one right answer."""
        return len(self.candidates) + self.may_miss == 1


class _Posed:
    """An element and a ray: the inputs as one vector, and what follows from them."""

    def __init__(self, case: Case, number: int) -> None:
        element: Element = case.elements[number]
        mpf = load_digits().mpf
        self.number, self.faces, self.rows = number, faces_of(element), exact_frame(element)
        tilted = element.tilt_deg != (0.0, 0.0)
        sizes = sizes_of(element)
        zeros = [mpf(0)] * 3
        self.x: Vector = [
            *vector(case.origin),
            *vector(case.direction),
            *vector(element.position),
            *zeros,
            *sizes,
        ]
        exact = element.flat or element.kind == "baffled-tube"
        if exact and not tilted:  # no operation there mixes components
            of_ray = [*map(abs, case.origin), *map(abs, case.direction)]
            of_centre = [abs(c) for c in element.position]
        else:
            of_ray = [max(map(abs, case.origin))] * 3 + [1.0] * 3
            of_centre = [max(map(abs, element.position))] * 3
        self.scales = [*of_ray, *of_centre, *[float(tilted)] * 3, *[abs(float(x)) for x in sizes]]

    def moved(self, i: int) -> tuple[Vector, Any]:
        """Return the inputs with one moved, and by how much."""
        mpf = load_digits().mpf
        step = mpf(self.scales[i]) * mpf(_STEP)
        x = list(self.x)
        x[i] = x[i] + step
        return x, step

    def ray(self, x: Vector) -> tuple[Vector, Vector]:
        """Return origin and unit direction in the world."""
        d = x[3:6]
        return x[0:3], scaled(1 / norm(d), d)

    def to_local(self, x: Vector, v: Vector) -> Vector:
        """Return a world vector in the element's frame, turned by the small angles in x."""
        u = [dot(row, v) for row in self.rows]
        a, b, c = x[9:12]
        return [u[0] - c * u[1] + b * u[2], u[1] + c * u[0] - a * u[2], u[2] - b * u[0] + a * u[1]]

    def place(self, x: Vector, t: Any) -> tuple[Vector, Vector]:
        """Return a point of the ray in the world and in the frame."""
        o, d = self.ray(x)
        p = add(o, t, d)
        return p, self.to_local(x, add(p, -1, x[6:9]))

    def value(self, face: Face, x: Vector, t: Any) -> Any:
        """Return the face's function at a distance along the ray."""
        return face.value(self.place(x, t)[1], x[12:])

    def outputs(self, face: Face, x: Vector, t: Any) -> tuple[Vector, Vector, Vector]:
        """Return point, normal and margins."""
        p, local = self.place(x, t)
        n = face.normal(local, x[12:])
        a, b, c = x[9:12]
        n = [n[0] + c * n[1] - b * n[2], n[1] - c * n[0] + a * n[2], n[2] + b * n[0] - a * n[1]]
        world = [sum(self.rows[i][k] * n[i] for i in range(3)) for k in range(3)]
        return p, world, face.margins(local, x[12:])

    def sensitivity(self, face: Face, t: Any) -> Any:
        """Return K of the face's function at a fixed distance."""
        here = self.value(face, self.x, t)
        total = load_digits().mpf(0)
        for i, scale in enumerate(self.scales):
            if scale:
                x, step = self.moved(i)
                total += abs(self.value(face, x, t) - here) / step * scale
        return total


def _candidate(posed: _Posed, index: int, t: Any) -> tuple[Candidate, list[tuple[Any, Any]]]:
    """Return a root with its conditions, and each margin with its K."""
    mp = load_digits()
    face = posed.faces[index]
    point, normal, margins = posed.outputs(face, posed.x, t)
    tiny = mp.mpf(_STEP) * (abs(t) + max(map(abs, posed.scales[:3])) + posed.scales[12])
    slope = (posed.value(face, posed.x, t + tiny) - posed.value(face, posed.x, t - tiny)) / (
        2 * tiny
    )
    k_t, k_p, k_n = abs(t), norm(point), mp.mpf(1)
    k_m = [abs(m) for m in margins]
    for i, scale in enumerate(posed.scales):
        if not scale:
            continue
        x, step = posed.moved(i)
        # where a ray touches the face, it is the place on the ray that moves, not the distance
        shift = -posed.value(face, x, t) / slope if slope else mp.mpf(0)
        p, n, m = posed.outputs(face, x, t + shift)
        k_t += abs(shift) / step * scale
        k_p += norm(add(p, -1, point)) / step * scale
        k_n += norm(add(n, -1, normal)) / step * scale
        k_m = [k + abs(a - b) / step * scale for k, a, b in zip(k_m, m, margins, strict=True)]
    found = Candidate(posed.number, index, t, point, normal, k_t, k_p, k_n)
    return found, list(zip(margins, k_m, strict=True))


def _roots(case: Case, posed: _Posed, index: int, unit: float) -> list[tuple[Any, bool, bool]]:
    """Return distances at which a face's surface may be hit: (t, certain, smooth)."""
    face, x = posed.faces[index], posed.x
    o, d = posed.ray(x)
    local_o = posed.to_local(x, add(o, -1, x[6:9]))
    local_d = posed.to_local(x, d)
    roots = face.roots(local_o, local_d, x[12:])
    bound = FIRM * unit
    for places in face.blurs(local_o, local_d, x[12:]):
        if all(abs(posed.value(face, x, t)) <= bound * posed.sensitivity(face, t) for t in places):
            return [(t, False, False) for t in (*roots.at, *places)]
    departed = case.left is not None and (case.left.element, case.left.face) == (
        posed.number,
        index,
    )
    found = [(t, True, True) for t in roots.at]
    if roots.turning is not None:
        depth = -posed.value(face, x, roots.turning)
        if abs(depth) <= bound * posed.sensitivity(face, roots.turning):
            found = [(t, False, False) for t in roots.at or [roots.turning]]
    if departed:
        if len(found) > 1:
            found.remove(min(found, key=lambda root: abs(root[0])))
        elif roots.turning is None:
            found = []
        return found
    on_face = abs(posed.value(face, x, 0)) <= bound * posed.sensitivity(face, 0)
    if on_face and found:
        nearest = min(found, key=lambda root: abs(root[0]))
        found = [
            (t, certain and (t, certain, smooth) != nearest, smooth) for t, certain, smooth in found
        ]
    return found


def judge(case: Case, unit: float = UNIT) -> Verdict:
    """Return the answers that are right for a case.

    Parameters
    ----------
    case : Case
        The case.
    unit : float
        u, the unit roundoff of the arithmetic that is asked.
    """
    mp = load_digits()
    bound = FIRM * unit
    everything: list[Candidate] = []
    for number, element in enumerate(case.elements):
        own = case.left is not None and case.left.element == number
        outside = case.left is not None and case.left.plus == (element.plus_side == "outside")
        if own and isinstance(element, _CLOSED) and outside:
            continue  # it leaves a convex body outwards
        posed = _Posed(case, number)
        for index in range(len(posed.faces)):
            for t, certain, smooth in _roots(case, posed, index, unit):
                candidate, margins = _candidate(posed, index, t)
                ahead = bound * candidate.k_distance
                if any(m < -bound * k for m, k in margins) or (t < -ahead and smooth):
                    continue
                candidate.certain = certain and t > ahead and all(m > bound * k for m, k in margins)
                candidate.smooth = smooth
                everything.append(candidate)
    sure = [c.distance + bound * c.k_distance for c in everything if c.certain]
    limit = min(sure, default=mp.inf)
    able = [c for c in everything if c.distance - bound * c.k_distance <= limit]
    return Verdict(able, may_miss=not sure and not case.must_hit)
