"""The sphere, whole or with a circular port."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import Problem, show
from photizon_cl.scene.areas import zone_areas
from photizon_cl.scene.bins import MapBins
from photizon_cl.scene.elements.base import Element
from photizon_cl.scene.faces import Ball
from photizon_cl.scene.filters.along import polar_cosine
from photizon_cl.scene.filters.azimuth import Azimuth
from photizon_cl.scene.parameters import number, positive_length
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.frames import Vec3

SMALLEST_PORT = 1e-16  # below about half of this, 1 − 2f rounds to 1
_ROUNDOFF = 2.0**-53
PORT_RANGE = "0, or a number from 1e-16 up to but not including 1"


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

    radius: float = field(metadata=positive_length("radius"))
    port_fraction: float = field(
        default=0.0,
        metadata=number(
            PORT_RANGE, 0.0, 1.0, "part of the sphere's area that is open", open_high=True
        ),
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Refuse ports that cos θ_port cannot tell from none, and refracting walls."""
        problems = super().cross_check(known)
        f = known.get("port_fraction")
        if f and f < SMALLEST_PORT:
            hint = "cos θ_port = 1 − 2f would round to 1, a sphere without a port"
            problems.append(Problem("port_fraction", show(f), PORT_RANGE, hint=hint))
        return problems

    @classmethod
    def wall_reason(cls, known: Known) -> str:
        """Say why the surface of a sphere with a port cannot refract."""
        if (known.get("port_fraction") or 0.0) < SMALLEST_PORT:
            return ""
        return (
            "a sphere with a port is a wall, not a solid with glass inside; "
            "close the port or take another surface"
        )

    @property
    def opening(self) -> bool:
        """Whether it has a port."""
        return self.port_fraction > 0.0

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
        return 1.0 - self.port_fraction

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        r = self.radius
        return (-r, -r, -r), (r, r, r)

    def packed(
        self, centre: Vec3, axis: int | None, at_edges: Sequence[float] = ()
    ) -> dict[str, float]:
        """Return the radius and what follows from it."""
        radius, far = self.radius, max(map(abs, centre))
        rim = radius * self.cos_port + 4.0 * _ROUNDOFF * (radius + far)
        on_surface = 8.0 * _ROUNDOFF * radius * (radius + far)
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
            area_of=partial(zone_areas, self.radius, self.port_fraction, nx, ny),
        )

    @property
    def cos_port(self) -> float:
        """Cosine of the port's polar angle, 1 − 2f; 1 for a whole sphere."""
        return 1.0 - 2.0 * self.port_fraction

    @property
    def area(self) -> float:
        """Area of the wall in m², 4πR²(1 − f)."""
        return 4.0 * math.pi * self.radius * self.radius * (1.0 - self.port_fraction)

    @property
    def port_area(self) -> float:
        """Area of the cap that the port removes in m², 4πR²f."""
        return 4.0 * math.pi * self.radius * self.radius * self.port_fraction

    @property
    def port_radius(self) -> float:
        """Radius of the port's rim in metres, 2R·sqrt(f(1 − f))."""
        return 2.0 * self.radius * math.sqrt(self.port_fraction * (1.0 - self.port_fraction))

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
        if self.port_fraction > 0.0:
            out["cos θ_port"] = (self.cos_port, "")
            out["port angle"] = (math.degrees(math.acos(self.cos_port)), "deg")
            out["port radius"] = (self.port_radius, "m")
            out["port area"] = (self.port_area, "m²")
        if self.multiplier is not None:
            out["sphere multiplier"] = (self.multiplier, "")
        return out
