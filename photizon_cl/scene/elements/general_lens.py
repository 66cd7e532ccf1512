"""The lens: two conic faces and an edge."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import declare, number, positive_length, signed_radius
from photizon_cl.scene.described import Nested
from photizon_cl.scene.elements.base import ROUNDOFF, Element
from photizon_cl.scene.elements.lens_face import LensFace, thinnest
from photizon_cl.scene.elements.placed import Placed
from photizon_cl.scene.elements.sheets import equator
from photizon_cl.scene.faces import Straight
from photizon_cl.scene.parameters import LARGEST, about
from photizon_cl.scene.rows import Row
from photizon_cl.scene.surfaces import Surface
from photizon_cl.scene.surfaces.absorber import Absorber

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.frames import Vec3

_KNIFE: Final = Fraction(ROUNDOFF) * 8
"""An edge thinner than this part of the lens's sizes is none: who gave them has rounded them."""
_CONIC: Final = "a number from -1e6 to 1e6"


@dataclass(frozen=True, kw_only=True)
class Lens(Element):
    """A lens between two faces, spheres, conics or planes, with a cylindrical edge.

    `position` is the centre of the rim circle midway between the two rims, and `axis` points to
    the front vertex. With r the distance from the axis, R a face's radius of curvature and k its
    conic constant, the face falls from its vertex towards the rim by::

        r²/R / (1 + sqrt(1 − (1 + k) r²/R²)),   r ≤ aperture_radius

    R is positive where the face is convex, negative where it is concave, and infinite (``inf``, in
    JSON the string "inf") where it is flat. The edge is a cylinder of the radius of the rims
    between them; a lens as thick as its two sags together has none. Faces are closed and share the
    rims. Normals point out of the glass. What the edge and the faces take is booked to the lens.

    Parameters
    ----------
    front_radius : float
        R in metres of the face on the side of the axis.
    back_radius : float
        R in metres of the other face.
    thickness : float
        Thickness on the axis in metres.
    aperture_radius : float
        Radius of both rims and of the edge in metres; for k > −1 at most ``|R|/sqrt(1 + k)``.
    front_conic : float, optional
        k of the front face; 0 is a sphere.
    back_conic : float, optional
        k of the back face.
    edge : Surface, optional
        What a ray that hits the edge does.
    front : Surface, optional
        What a ray that hits the front face does, where that is another surface than `surface`.
    back : Surface, optional
        The same of the back face.
    """

    kind: ClassVar[str] = "lens"
    kernel: ClassVar[str] = "lens"
    does: ClassVar[str] = "two conic faces and the edge of a lens hit"
    costs: ClassVar[str] = "up to two roots a face and one at the edge a segment"
    templates: ClassVar[tuple[str, ...]] = ("lib/local", "elements/lens")
    libraries: ClassVar[tuple[str, ...]] = ("lib/quadric",)
    traits: ClassVar[frozenset[str]] = frozenset({"own-sides", "own-surfaces"})
    row: ClassVar[Row] = Row(
        "LENS",
        ("rim", "m", "radius of the rims and of the edge"),
        ("half", "m", "half the height of the edge"),
        ("near", "m", "rounding bound of a coordinate, to which one grows with its size"),
        ("most", "m", "the same all over the lens"),
        *(
            column
            for face in ("front", "back")
            for column in (
                (f"{face}_curvature", "1/m", "1/R at the vertex, 0 of a plane"),
                (f"{face}_kappa", "", "1 + conic constant"),
                (f"{face}_sag", "m", "height of the vertex over the rim"),
                (f"{face}_vertex", "m", "height of the vertex over the middle"),
                (f"{face}_polishes", "", "whether roots are polished, 0 or 1"),
            )
        ),
    )
    has_map: ClassVar[bool] = False
    default_side: ClassVar[str] = "outside"
    faces_at_a_point: ClassVar[int] = 3
    sample: ClassVar[Mapping[str, Any]] = MappingProxyType(
        {"front_radius": 0.1, "back_radius": 0.1, "thickness": 0.03, "aperture_radius": 0.05}
    )

    front_radius: float = field(metadata=signed_radius("radius of curvature of the front face"))
    back_radius: float = field(metadata=signed_radius("radius of curvature of the back face"))
    thickness: float = field(metadata=positive_length("thickness on the axis"))
    aperture_radius: float = field(metadata=positive_length("radius of the rims and of the edge"))
    front_conic: float = field(
        default=0.0, metadata=number(_CONIC, -1e6, 1e6, "conic constant of the front face")
    )
    back_conic: float = field(
        default=0.0, metadata=number(_CONIC, -1e6, 1e6, "conic constant of the back face")
    )
    edge: Surface = field(
        default=Absorber(), metadata=declare(Nested(Surface, meaning="what the edge does"))
    )
    front: Surface | None = field(
        default=None, metadata=declare(Nested(Surface, meaning="what the front face does"))
    )
    back: Surface | None = field(
        default=None, metadata=declare(Nested(Surface, meaning="what the back face does"))
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that the faces reach the rim and stand apart."""
        problems = super().cross_check(known)
        aperture, faces = known.get("aperture_radius"), []
        for name in ("front", "back"):
            radius, k = known.get(f"{name}_radius"), known.get(f"{name}_conic") or 0.0
            if radius is not None and math.isinf(radius) and k:
                expected = "0, or no such key, where the face is flat"
                problems.append(Problem(f"{name}_conic", show(k), expected))
            if radius is None or aperture is None:
                continue
            made = _face_problems(name, radius, k, aperture)
            problems += made
            if not made:
                faces.append(LensFace(radius, k, aperture))
        thickness = known.get("thickness")
        if len(faces) == 2 and thickness is not None:
            problems += _apart(faces[0], faces[1], thickness)
        return problems

    @cached_property
    def sides(self) -> tuple[LensFace, LensFace]:
        """Its front and its back."""
        return (
            LensFace(self.front_radius, self.front_conic, self.aperture_radius),
            LensFace(self.back_radius, self.back_conic, self.aperture_radius),
        )

    @cached_property
    def edge_thickness(self) -> float:
        """Height of the edge in metres, 0 where the faces meet at one rim."""
        front, back = self.sides
        return max(float(_edge(front, back, self.thickness)), 0.0)

    @property
    def vertices(self) -> tuple[float, float]:
        """Heights of the front and of the back vertex over `position` in metres."""
        half = Fraction(self.edge_thickness) / 2
        front, back = self.sides
        return float(half + front.sag), float(-half - back.sag)

    @property
    def reach(self) -> float:
        """Radius in metres of a ball around `position` that holds it."""
        rim = math.hypot(self.aperture_radius, 0.5 * self.edge_thickness)
        high, low = self.vertices
        front, back = self.sides
        return max(rim, front.reach(high), back.reach(-low))

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """The face on the side of the axis, the other one, and the edge where there is one."""
        front, back = self.sides
        a, high = self.aperture_radius, self.edge_thickness
        found = (front.face("front", 0.5 * high, 1.0), back.face("back", -0.5 * high, -1.0))
        if not high:
            return found
        wall = Straight(name="edge", radii=(a, a), length=high)
        return (*found, Placed(name="edge", shape=wall, height=-0.5 * high))

    def surface_of(self, face: int) -> Surface:
        """Return the surface of a face by its number."""
        return (self.front or self.surface, self.back or self.surface, self.edge)[face]

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        a, half = self.aperture_radius, 0.5 * self.edge_thickness
        front, back = self.vertices
        return (-a, -a, min(back, -half)), (a, a, max(front, half))

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return rims, rounding bounds and what makes each face."""
        low, high = self.local_box
        near = 4.0 * roundoff * max(map(abs, centre))
        longest = 2.0 * self.aperture_radius + max(abs(low[2]), abs(high[2]))
        found = {
            "rim": self.aperture_radius,
            "half": 0.5 * self.edge_thickness,
            "near": near,
            "most": near + 4.0 * roundoff * longest,
        }
        for name, side, vertex in zip(("front", "back"), self.sides, self.vertices, strict=True):
            found |= {
                f"{name}_curvature": side.curvature,
                f"{name}_kappa": side.kappa,
                f"{name}_sag": float(side.sag),
                f"{name}_vertex": vertex if name == "front" else -vertex,
                f"{name}_polishes": float(side.polishes),
            }
        return found

    @property
    def area(self) -> float:
        """Area of both faces and of the edge in m²."""
        front, back = self.sides
        return front.area + back.area + 2.0 * math.pi * self.aperture_radius * self.edge_thickness

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return sags, vertices, the edge, the area and, of one glass, the focal length."""
        front, back = self.sides
        out = {
            "front sag": (float(front.sag), "m"),
            "back sag": (float(back.sag), "m"),
            "front vertex at": (self.vertices[0], "m"),
            "back vertex at": (self.vertices[1], "m"),
            "edge thickness": (self.edge_thickness, "m"),
            "area": (self.area, "m²"),
        }
        length = self.focal_length
        if length is not None:
            out["focal length"] = (length, "m")
        return out

    @property
    def focal_length(self) -> float | None:
        """Paraxial focal length in metres in what surrounds it, None where it has none.

        The lensmaker's formula with N the glass's index relative to that outside and d the
        thickness: 1/f = (N − 1) (1/R₁ + 1/R₂ − (N − 1) d/(N R₁R₂)), R as here, positive for both
        convex faces.
        """
        both = [self.surface_of(n).indices for n in (0, 1)]
        if both[0] is None or both[0] != both[1]:
            return None
        inside, outside = both[0]
        c1, c2 = (side.curvature for side in self.sides)
        n = inside / outside
        power = (n - 1.0) * (c1 + c2 - (n - 1.0) * self.thickness * c1 * c2 / n)
        return 1.0 / power if power else None


def _face_problems(name: str, radius: float, k: float, aperture: float) -> list[Problem]:
    """Check that a face reaches the rim."""
    if math.isinf(radius):
        return []
    if k > -1.0 and aperture > (widest := equator(abs(radius), k)):
        term = f"|{name}_radius|" if not k else f"|{name}_radius|/sqrt(1 + {name}_conic)"
        hint = "a face is no wider than its ball or ellipsoid; equal makes a half"
        return [
            Problem("aperture_radius", show(aperture), f"at most {term}, {show(widest)}", hint=hint)
        ]
    high = abs(LensFace(radius, k, aperture).sag)
    if high > Fraction(LARGEST):
        expected = f"an aperture of faces at most {LARGEST:g} m high"
        hint = f"the sag of the {name} face would be {about(high)} m; take a smaller aperture"
        return [Problem("aperture_radius", show(aperture), expected, hint=hint)]
    return []


def _edge(front: LensFace, back: LensFace, thickness: float) -> Fraction:
    """Return the height of the edge, 0 where that is rounding."""
    left = Fraction(thickness) - front.sag - back.sag
    size = Fraction(thickness) + abs(front.sag) + abs(back.sag) + Fraction(front.aperture)
    return Fraction(0) if abs(left) <= _KNIFE * size else left


def _apart(front: LensFace, back: LensFace, thickness: float) -> list[Problem]:
    """Check that the faces do not cross at the rim or before it."""
    both: Any = front.sag + back.sag
    least = _KNIFE * (abs(front.sag) + abs(back.sag) + Fraction(front.aperture))
    if Fraction(thickness) <= least:
        expected = f"more than {show(float(least))}, what the rounding of its sizes amounts to"
        hint = "its faces would be one"
        return [Problem("thickness", show(thickness), expected, hint=hint)]
    if _edge(front, back, thickness) < 0:
        expected = f"at least the sags of both faces at the rim together, {show(float(both))}"
        hint = "the faces would cross; make it thicker, or aperture_radius smaller"
        return [Problem("thickness", show(thickness), expected, hint=hint)]
    at = thinnest(front, back)
    if at is not None:
        needed = front.sag_at(at) + back.sag_at(at)
        if needed >= Fraction(thickness):
            expected = f"more than {show(float(needed))}"
            hint = f"the faces would cross or touch at {at:.6g} m from the axis; make it thicker"
            return [Problem("thickness", show(thickness), expected, hint=hint)]
    return []
