"""What all elements share."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final

from photizon_cl.errors import Problem, show, with_article
from photizon_cl.scene.declarations import declare, point, signed_axis, tilt, unique_name
from photizon_cl.scene.described import Described, Known, Nested, parameters_of
from photizon_cl.scene.detectors import Detector
from photizon_cl.scene.device_kinds import DeviceKind
from photizon_cl.scene.frames import Frame, Vec3, frame, to_local
from photizon_cl.scene.surfaces import Surface

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.bins import MapBins
    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.rows import Row

FLAT_SIDES: Final = ("front", "back")
CURVED_SIDES: Final = ("inside", "outside")
OTHER_SIDE: Final = {
    "inside": "outside", "outside": "inside", "front": "back", "back": "front",
}  # fmt: skip
ROUNDOFF: Final = 2.0**-53
"""Unit roundoff of doubles."""
_ROUNDING = 2.0**-48  # of a point's coordinates, in the few operations that bring it to a face


_FACES = ("faces", "outline", "surfaces")  # what is cached of an element's faces


def _counting() -> list[str]:
    """Return the kinds of surface that carry a detector."""
    return sorted(cls.kind for cls in Surface.__subclasses__() if cls.carries_detector)


def own_surfaces(cls: type[Described]) -> list[str]:
    """Return the parameters of a class that are surfaces of faces."""
    return [
        name
        for name, parameter in parameters_of(cls).items()
        if name != "surface" and isinstance(parameter, Nested) and parameter.base is Surface
    ]


@dataclass(frozen=True, kw_only=True)
class Element(DeviceKind):
    """A piece of geometry with one surface and, where that carries one, perhaps a detector.

    Parameters
    ----------
    name : str
        Unique among the scene's elements.
    position : tuple of float
        Where the element sits, in metres; each kind says which of its points that is.
    axis : str
        Direction of the local w axis, one of ``+x -x +y -y +z -z``.
    tilt_deg : tuple of float, optional
        ``(a, b)`` in degrees, see `photizon_cl.scene.frames`.
    surface : Surface
        What a ray that hits it does.
    detector : Detector, optional
        What is counted of what arrives; only on a surface that carries one (`carries_detector`):
        one where light ends, or that it passes.
    """

    label: ClassVar[str] = "element"
    kind: ClassVar[str] = ""
    row: ClassVar[Row]
    """Columns of its row in the geometry table, between its position and its frame."""
    templates: ClassVar[tuple[str, ...]]
    """Kernel templates that are rendered for each class of it, in order, its own among them."""
    traits: ClassVar[frozenset[str]] = frozenset()
    """What else the shared templates ask for; ``inward`` where normals point to the inside,
    ``own-surfaces`` where faces may have surfaces of their own (`surface_of`)."""
    faced: ClassVar[bool] = True
    """Whether its kernel works in its own frame and says which of its faces is hit."""
    alone: ClassVar[bool] = False
    """Whether its kernel makes use of being the only element of its class in the scene."""
    flat: ClassVar[bool] = False
    """Whether it is a part of a plane: then a detector's side is set by the normal alone."""
    faces_at_a_point: ClassVar[int] = 1
    """How many of its faces may meet at one point."""
    has_map: ClassVar[bool]
    """Whether a detector may have a map."""
    default_side: ClassVar[str] = "front"
    """Side that a detector counts when it names none."""

    name: str = field(metadata=unique_name("unique among the elements"))
    position: Sequence[float] = field(metadata=point("where the element sits"))
    axis: str = field(metadata=signed_axis("direction of the local w axis"))
    tilt_deg: Sequence[float] = field(default=(0.0, 0.0), metadata=tilt())
    surface: Surface = field(
        metadata=declare(Nested(Surface, meaning="what a ray that hits it does"))
    )
    detector: Detector | None = field(
        default=None, metadata=declare(Nested(Detector, meaning="what is counted"))
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check the surface and the detector against each other and against the geometry."""
        surface, detector = known.get("surface"), known.get("detector")
        problems: list[Problem] = []
        optics = surface.cls if surface is not None else Surface
        assert issubclass(optics, Surface)  # what the parameter `surface` takes
        if optics.refracts:
            wall = cls.wall_reason(known)
            if wall:
                problems.append(
                    Problem(
                        "surface.kind",
                        show(optics.kind),
                        "a surface that does not refract",
                        hint=wall,
                    )
                )
        if detector is None:
            return problems
        if optics.kind and not optics.carries_detector:
            given = {k: v for k, v in detector.values.items() if v is not None and v is not False}
            problems.append(
                Problem(
                    "detector",
                    show(given),
                    f"no detector on {with_article(optics.kind)} surface",
                    hint="a detector counts what ends on a surface, or passes it, and this one "
                    "sends a part of what arrives back or aside; take one that carries a detector: "
                    f"{' or '.join(_counting())}",
                )
            )
        scatters = surface is not None and surface.get("scatter") is not None
        if optics.carries_detector and scatters:
            hint = (
                "a detector counts what ends on a surface, and this one sends a part of it on; put "
                "a surface that light passes before it"
            )
            problems.append(Problem("detector", "a detector", "none beside a scatter", hint=hint))
        for name in own_surfaces(cls):
            own = known.get(name)
            if own is not None and own.kind and not own.cls.carries_detector:
                hint = (
                    f"a detector counts what arrives at all faces of {with_article(cls.kind)}, and "
                    "this one sends it on; take one that carries a detector: "
                    f"{' or '.join(_counting())}"
                )
                expected = f"no {own.kind} surface beside a detector"
                problems.append(Problem(f"{name}.kind", show(own.kind), expected, hint=hint))
            elif own is not None and own.get("scatter") is not None:
                hint = "a detector counts what ends, and this face sends a part of it on"
                expected = "none beside a detector"
                problems.append(Problem(f"{name}.scatter", "a scatter", expected, hint=hint))
        side, sides = detector.get("side"), FLAT_SIDES if cls.flat else CURVED_SIDES
        if side is not None and side not in sides:
            body = "flat: its front is the side that its normal points to" if cls.flat else "curved"
            problems.append(
                Problem(
                    "detector.side",
                    show(side),
                    f"one of {show(sides[0])} {show(sides[1])}",
                    hint=f"{with_article(cls.kind)} is {body}",
                )
            )
        if not cls.has_map and detector.get("map") is not None:
            problems.append(
                Problem(
                    "detector.map",
                    show(detector.get("map")),
                    f"no map on {with_article(cls.kind)}",
                    hint="its bins would have no exact areas; leave the map out, or put a flat "
                    "element where it is wanted",
                )
            )
        return problems

    @classmethod
    def wall_reason(cls, known: Known) -> str:
        """Say why this is a wall and its surface cannot refract; empty where it can."""
        return ""

    def __getstate__(self) -> dict[str, Any]:
        """Leave out the faces, which follow from the rest: there may be thousands."""
        return {name: value for name, value in self.__dict__.items() if name not in _FACES}

    @cached_property
    def frame(self) -> Frame:
        """Rows (u, v, w) of the local frame in world coordinates."""
        return frame(self.axis, self.tilt_deg)

    @property
    def detector_side(self) -> str | None:
        """Side that the detector counts, one of `SIDES`; None without a detector."""
        if self.detector is None:
            return None
        return self.detector.side or self.default_side

    @property
    def detector_plus(self) -> bool:
        """Whether the side that the detector counts is the one that the normals point to."""
        return self.detector_side in ("front", self.plus_side)

    @property
    def plus_side(self) -> str:
        """Named side that the normals of a curved element point to."""
        return "inside" if "inward" in self.traits else "outside"

    @property
    def opening(self) -> bool:
        """Whether a part of it is cut out, so that the device tests for the opening."""
        return False

    @property
    def class_axis(self) -> int | None:
        """World axis (0, 1, 2) that its kernel is specialised to; None for the general one."""
        return None

    @property
    @abstractmethod
    def reach(self) -> float:
        """Radius in metres of a ball around `position` that holds the element."""

    @property
    @abstractmethod
    def faces(self) -> tuple[Face, ...]:
        """Its faces in local coordinates, in the order of the kernels' face numbers."""

    def surface_of(self, face: int) -> Surface:
        """Return the surface of a face by the number that the kernels give it."""
        return self.surface

    @cached_property
    def surfaces(self) -> tuple[Surface, ...]:
        """Its surfaces, each once: several where faces have surfaces of their own."""
        if "own-surfaces" not in self.traits:
            return (self.surface,)
        return tuple(dict.fromkeys(self.surface_of(n) for n in range(len(self.faces))))

    @property
    def sole_face(self) -> Face | None:
        """Its face, where it has only one."""
        return self.faces[0] if len(self.faces) == 1 else None

    @property
    def face_names(self) -> tuple[str, ...]:
        """Names of its faces, each once."""
        return tuple(dict.fromkeys(face.name for face in self.faces))

    def face_name(self, number: int) -> str:
        """Return the name of a face by the number that the kernels give it."""
        return self.faces[number].name

    def face_number(self, number: int) -> int:
        """Return the number of the first face that has the name of a face."""
        name = self.faces[number].name
        return next(k for k, face in enumerate(self.faces) if face.name == name)

    @property
    def self_view_factor(self) -> float | None:
        """Part of what any place of its inside sends out diffusely that meets the inside again.

        None where that differs from place to place.
        """
        return None

    @property
    @abstractmethod
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""

    @abstractmethod
    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (1.0, 1.0, 1.0, 1.0),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return the values of its row's columns by name.

        Parameters
        ----------
        centre : tuple of float
            Size of each coordinate of `position`, in the world's or the device's coordinates,
            whichever is larger, in metres: what rounding bounds follow.
        axis : int or None
            World axis that its kernel is specialised to; None for the general one.
        at_edges : sequence of float
            By how much rounding bounds at the edges +u, −u, +v and −v are to be multiplied, see
            `photizon_cl.geometry.wedges`.
        roundoff : float, optional
            Unit roundoff of the coordinates that the kernels compute in.
        """

    def map_bins(self, nx: int, ny: int) -> MapBins:
        """Return the bins of a map with nx columns and ny rows; only those with `has_map` do."""
        raise NotImplementedError(f"no map on {with_article(self.kind)}")

    @property
    @abstractmethod
    def area(self) -> float:
        """Area of one side of the surface in m²."""

    @abstractmethod
    def derived(self) -> dict[str, tuple[float, str]]:
        """Return derived quantities: name → (value, unit)."""

    def touches(self, local: Vec3, slack: float, reach: float = 0.0) -> bool:
        """Say whether a point lies on the surface.

        Parameters
        ----------
        local : tuple of float
            The point in local coordinates, in metres.
        slack : float
            Distance in metres that counts as rounding.
        reach : float, optional
            Metres by which the outlines of plane faces are widened in their planes.
        """
        beyond = slack + reach
        return all(
            low - beyond <= x <= high + beyond
            for x, low, high in zip(local, *self.local_box, strict=True)
        ) and any(face.touches(local, slack, reach) for face in self.faces)

    def local(self, point: Sequence[float]) -> Vec3:
        """Return a world point in local coordinates."""
        x, y, z = (a - b for a, b in zip(point, self.position, strict=True))
        return to_local(self.frame, (x, y, z))

    def rounding(self, point: Sequence[float]) -> float:
        """Return the distance in metres that rounding may make of none for a world point."""
        local = map(abs, self.local(point))
        return _ROUNDING * max(*map(abs, point), *map(abs, self.position), *local)

    def holds(self, point: Sequence[float]) -> bool:
        """Say whether a world point lies on the surface within rounding."""
        return self.touches(self.local(point), self.rounding(point))
