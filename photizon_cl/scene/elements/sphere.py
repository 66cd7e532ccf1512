"""The sphere, whole or with a circular port."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import Problem, show
from photizon_cl.scene.areas import zone_areas
from photizon_cl.scene.bins import MapBins
from photizon_cl.scene.declarations import number, positive_length
from photizon_cl.scene.elements.base import ROUNDOFF, Element
from photizon_cl.scene.faces import Ball
from photizon_cl.scene.filters.along import polar_cosine
from photizon_cl.scene.filters.azimuth import Azimuth
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.frames import Vec3

SMALLEST_PORT = 1e-16  # below about half of this, 1 − 2f rounds to 1
PORT_RANGE = "0, or a number from 1e-16 up to but not including 1"


def _fraction(rim: float, radius: float) -> float:
    """Return the part of a sphere's area inside a circle on it; NaN where it does not fit."""
    part = rim / radius
    if not part < 1.0:
        return math.nan
    # (1 − sqrt(1 − part²))/2 without its cancellation
    return 0.5 * part * part / (1.0 + math.sqrt((1.0 - part) * (1.0 + part)))


@dataclass(frozen=True, kw_only=True)
class Sphere(Element):
    """A sphere of radius R, without the port: points of |p| = R with cos θ ≤ cos θ_port.

    `position` is the centre; the port is the cap around +w that holds the fraction f of the whole
    area, so that cos θ_port = 1 − 2f (Archimedes: the area of a cap is proportional to its
    height). The rim belongs to the wall. Normals point away from the centre, also for a ray that
    comes from inside.

    Parameters
    ----------
    radius : float
        R in metres.
    port_fraction : float, optional
        f, 0 for a whole sphere. A sphere with a port is a wall and refuses surfaces that refract.
    port_radius : float, optional
        Instead of f, the radius of the port's rim r < R in metres: f = (1 − sqrt(1 − r²/R²))/2,
        less than half of the sphere. `port` is f, whichever is given.
    """

    kind: ClassVar[str] = "sphere"
    kernel: ClassVar[str] = "sphere"
    does: ClassVar[str] = "sphere hit"
    costs: ClassVar[str] = "one square root and up to two roots an element a segment"
    templates: ClassVar[tuple[str, ...]] = ("elements/sphere",)
    row: ClassVar[Row] = Row(
        "SPHERE",
        ("radius", "m", "radius R"),
        ("inverse_square", "1/m²", "1/R²"),
        ("inverse", "1/m", "1/R"),
        ("rim", "m", "height of the port's rim over the centre, with its rounding bound"),
        ("on_surface", "m²", "rounding bound of |f|² − R²"),
    )
    faced: ClassVar[bool] = False
    alone: ClassVar[bool] = True
    has_map: ClassVar[bool] = True
    default_side: ClassVar[str] = "inside"
    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {"port_fraction": ("port_radius",), "port_radius": ("port_fraction",)}
    )

    radius: float = field(metadata=positive_length("radius"))
    port_fraction: float = field(
        default=0.0,
        metadata=number(
            PORT_RANGE, 0.0, 1.0, "part of the sphere's area that is open", open_high=True
        ),
    )
    port_radius: float | None = field(
        default=None,
        metadata=positive_length("radius of the port's rim, instead of port_fraction"),
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Refuse ports that cos θ_port cannot tell from none, and refracting walls."""
        problems = super().cross_check(known)
        f = known.get("port_fraction")
        if f and f < SMALLEST_PORT:
            hint = "cos θ_port = 1 − 2f would round to 1, a sphere without a port"
            problems.append(Problem("port_fraction", show(f), PORT_RANGE, hint=hint))
        rim, radius = known.get("port_radius"), known.get("radius")
        if rim is None:
            return problems
        if f:
            expected = "nothing beside port_fraction"
            hint = f"port_fraction = {show(f)} says how large the port is; give one of the two"
            problems.append(Problem("port_radius", show(rim), expected, hint=hint))
        elif radius is not None and not _fraction(rim, radius) >= SMALLEST_PORT:
            hint = "cos θ_port would round to 1, a sphere without a port"
            if rim >= radius:
                hint = "a port of half the sphere or more takes port_fraction, 0.5 or more"
            expected = f"a length below the radius of {show(radius)} m, and not below 2e-8 of it"
            problems.append(Problem("port_radius", show(rim), expected, hint=hint))
        return problems

    @classmethod
    def wall_reason(cls, known: Known) -> str:
        """Say why the surface of a sphere with a port cannot refract."""
        ported = (known.get("port_fraction") or 0.0) >= SMALLEST_PORT
        if not ported and known.get("port_radius") is None:
            return ""
        return (
            "a sphere with a port is a wall, not a solid with glass inside; "
            "close the port or take another surface"
        )

    @property
    def port(self) -> float:
        """Part of the sphere's area that is open, f, whether it was given or its rim was."""
        if self.port_radius is None:
            return self.port_fraction
        return _fraction(self.port_radius, self.radius)

    @property
    def opening(self) -> bool:
        """Whether it has a port."""
        return self.port > 0.0

    @property
    def reach(self) -> float:
        """Its radius in metres."""
        return self.radius

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """Its wall."""
        polar = (math.acos(self.cos_port), math.pi)
        return (Ball(name="wall", radius=self.radius, polar=polar),)

    @property
    def self_view_factor(self) -> float:
        """Part of what any place of the wall sends inwards diffusely that meets it again, 1 − f."""
        return 1.0 - self.port

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        r = self.radius
        return (-r, -r, -r), (r, r, r)

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return the radius and what follows from it."""
        radius, far = self.radius, max(map(abs, centre))
        rim = radius * self.cos_port + 4.0 * roundoff * (radius + far)
        on_surface = 8.0 * roundoff * radius * (radius + far)
        return {
            "radius": radius,
            "inverse_square": 1.0 / (radius * radius),
            "inverse": 1.0 / radius,
            "rim": rim,
            "on_surface": on_surface,
        }

    def map_bins(self, nx: int, ny: int) -> MapBins:
        """Return the bins of a map, in φ and in cos θ about the axis."""
        return MapBins(
            x=Azimuth(nx),
            y=polar_cosine(self.radius, ny),
            area_of=partial(zone_areas, self.radius, self.port, nx, ny),
        )

    @property
    def cos_port(self) -> float:
        """Cosine of the port's polar angle, 1 − 2f; 1 for a whole sphere."""
        return 1.0 - 2.0 * self.port

    @property
    def area(self) -> float:
        """Area of the wall in m², 4πR²(1 − f)."""
        return 4.0 * math.pi * self.radius * self.radius * (1.0 - self.port)

    @property
    def port_area(self) -> float:
        """Area of the cap that the port removes in m², 4πR²f."""
        return 4.0 * math.pi * self.radius * self.radius * self.port

    @property
    def rim_radius(self) -> float:
        """Radius of the port's rim in metres, 2R·sqrt(f(1 − f)); 0 for a whole sphere."""
        if self.port_radius is not None:
            return self.port_radius
        return 2.0 * self.radius * math.sqrt(self.port * (1.0 - self.port))

    @property
    def multiplier(self) -> float | None:
        """Sphere multiplier 1/(1 − ρ(1 − f)) of a diffuse wall, else None; infinite at ρ = 1.

        D. G. Goebel, Generalized Integrating-Sphere Theory, Applied Optics 6, 125 (1967).
        """
        rho = self.surface.diffuse_reflectance
        if rho is None:
            return None
        rest = 1.0 - rho * self.self_view_factor
        return 1.0 / rest if rest > 0.0 else math.inf

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the areas, the port and, for a diffuse wall, the sphere multiplier."""
        out = {"wall area": (self.area, "m²")}
        if self.port > 0.0:
            out["cos θ_port"] = (self.cos_port, "")
            out["port angle"] = (math.degrees(math.acos(self.cos_port)), "deg")
            out["port radius"] = (self.rim_radius, "m")
            out["port area"] = (self.port_area, "m²")
        if self.multiplier is not None:
            out["sphere multiplier"] = (self.multiplier, "")
        return out
