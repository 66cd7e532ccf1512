"""The compound parabolic concentrator."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import number, positive_length
from photizon_cl.scene.elements.base import ROUNDOFF, Element
from photizon_cl.scene.faces import Revolved
from photizon_cl.scene.frames import sincos_deg
from photizon_cl.scene.parameters import LARGEST, about
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.frames import Vec3


@dataclass(frozen=True, kw_only=True)
class _Wall(Revolved):
    """The tilted parabola, solved for the radius as `Cpc` states it; sizes in metres."""

    exit_radius: float
    acceptance_deg: float
    length: float

    def profile(self, s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        a, (sine, cosine) = self.exit_radius, sincos_deg(self.acceptance_deg)
        z = s * (self.length / a)
        q = (1.0 + sine) * (3.0 + sine) + z * (2.0 * cosine * (2.0 + sine) - sine * sine * z)
        p = 2.0 * cosine * sine * z + 2.0 * (1.0 + sine) ** 2
        return a * 2.0 * q / (p + np.sqrt(p * p + 4.0 * cosine * cosine * q)), s * self.length


@dataclass(frozen=True, kw_only=True)
class Cpc(Element):
    """The wall of a compound parabolic concentrator (CPC), open at both ends.

    `position` is the centre of the exit aperture (radius a') and `axis` points from the exit to the
    entrance. A parabola, tilted by the acceptance angle θa, with its focus on the opposite rim of
    the exit, turns about the axis. With r the distance from the axis and z along it::

        (r cos θa + z sin θa)² + 2a'(1 + sin θa)² r − 2a' cos θa (2 + sin θa) z
            − a'²(1 + sin θa)(3 + sin θa) = 0,   0 ≤ z ≤ L

    (R. Winston, J. C. Miñano, P. Benítez, Nonimaging Optics, 2005, ch. 4). The entrance radius is
    a = a'/sin θa and the length L = (a + a')/tan θa. Normals point away from the axis.

    Parameters
    ----------
    exit_radius : float
        a' in metres.
    acceptance_deg : float
        θa in degrees, from 0.01 to 89.99.
    """

    kind: ClassVar[str] = "cpc"
    kernel: ClassVar[str] = "cpc"
    does: ClassVar[str] = "compound parabolic concentrator hit"
    costs: ClassVar[str] = "Newton steps on the profile, a square root each, an element a segment"
    templates: ClassVar[tuple[str, ...]] = ("lib/local", "elements/cpc")
    row: ClassVar[Row] = Row(
        "CPC",
        ("length", "scaled", "L"),
        ("cosine", "", "C, of the acceptance angle"),
        ("sine", "", "S, of the acceptance angle"),
        ("b", "scaled", "coefficient B of the meridian"),
        ("d", "scaled", "coefficient D"),
        ("e", "scaled²", "coefficient E"),
        ("alpha", "scaled²", "B² + 4 C² E"),
        ("beta", "scaled", "4 C (S B + C D)"),
        ("outer", "scaled", "radius of a cylinder around it"),
        ("scale", "1/m", "power of two that lengths are multiplied by, so that a' is about 1"),
        ("near", "scaled", "rounding bound of a coordinate"),
    )
    has_map: ClassVar[bool] = False
    default_side: ClassVar[str] = "inside"

    exit_radius: float = field(metadata=positive_length("radius of the exit aperture"))
    acceptance_deg: float = field(
        metadata=number(
            "an angle from 0.01 to 89.99 degrees", 0.01, 89.99, "acceptance half-angle", "deg"
        )
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Refuse an entrance or a length beyond the range of lengths."""
        problems = super().cross_check(known)
        exit_, angle = known.get("exit_radius"), known.get("acceptance_deg")
        if exit_ is not None and angle is not None:
            sine, cosine = sincos_deg(angle)
            times = max(1.0, (1.0 + sine) * cosine / sine) / sine
            if Fraction(exit_) * Fraction(times) > Fraction(LARGEST):
                size = about(Fraction(exit_) * Fraction(times))
                wanted = f"an exit whose CPC is at most {LARGEST:g} m wide and long"
                hint = f"at this acceptance_deg it would be {size} m; take a smaller exit"
                problems.append(Problem("exit_radius", show(exit_), wanted, hint=hint))
        return problems

    @classmethod
    def wall_reason(cls, known: Known) -> str:
        """Say why a CPC's surface cannot refract."""
        return "a CPC is a wall, not a solid with an inside of glass; take a wall's surface"

    @property
    def entrance_radius(self) -> float:
        """Entrance radius a = a'/sin θa in metres."""
        return self.exit_radius / sincos_deg(self.acceptance_deg)[0]

    @property
    def length(self) -> float:
        """Length L = (a + a')/tan θa in metres."""
        sine, cosine = sincos_deg(self.acceptance_deg)
        return (self.entrance_radius + self.exit_radius) * cosine / sine

    @property
    def concentration(self) -> float:
        """Geometric concentration 1/sin² θa."""
        return 1.0 / sincos_deg(self.acceptance_deg)[0] ** 2

    @property
    def reach(self) -> float:
        """Distance in metres from the centre of the exit to the entrance's rim."""
        return math.hypot(self.entrance_radius, self.length)

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """Its wall."""
        return (
            _Wall(
                name="wall",
                exit_radius=self.exit_radius,
                acceptance_deg=self.acceptance_deg,
                length=self.length,
            ),
        )

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        a = self.entrance_radius
        return (-a, -a, 0.0), (a, a, self.length)

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return the profile's coefficients, lengths scaled."""
        scale = math.ldexp(1.0, -math.frexp(self.exit_radius)[1])
        s, c = sincos_deg(self.acceptance_deg)
        a1, length = self.exit_radius * scale, self.length * scale
        b = 2.0 * a1 * (1.0 + s) ** 2
        d = 2.0 * a1 * c * (2.0 + s)
        e = a1 * a1 * (1.0 + s) * (3.0 + s)
        alpha = b * b + 4.0 * c * c * e
        beta = 4.0 * c * (s * b + c * d)
        outer = self.entrance_radius * scale
        far = max(map(abs, centre)) * scale
        rounding = 4.0 * roundoff * (far + outer)
        return {
            "length": length, "cosine": c, "sine": s,
            "b": b, "d": d, "e": e, "alpha": alpha, "beta": beta,
            "outer": outer + rounding, "scale": scale, "near": rounding,
        }  # fmt: skip

    def radius_at(self, z: float) -> float:
        """Return the wall's radius in metres at a height above the exit, 0 ≤ z ≤ L."""
        k = self.packed((0.0, 0.0, 0.0), None)
        c, s, z = k["cosine"], k["sine"], z * k["scale"]
        q = k["e"] + z * (k["d"] - s * s * z)
        root = math.sqrt(k["alpha"] + k["beta"] * z)
        return 2.0 * q / (2.0 * c * s * z + k["b"] + root) / k["scale"]

    @property
    def area(self) -> float:
        """Area of the wall in m², by Gauss-Legendre quadrature of 2πR·ds."""
        nodes, weights = np.polynomial.legendre.leggauss(64)
        k = self.packed((0.0, 0.0, 0.0), None)
        length, c, s, b, d, scale = (
            k[name] for name in ("length", "cosine", "sine", "b", "d", "scale")
        )
        total = 0.0
        for node, weight in zip(nodes, weights, strict=True):
            z = 0.5 * length * (1.0 + float(node))
            r = self.radius_at(z / scale) * scale
            w = c * r + s * z
            slope = (d - 2.0 * s * w) / (2.0 * c * w + b)
            total += float(weight) * 0.5 * length * 2.0 * math.pi * r * math.hypot(1.0, slope)
        return total / (scale * scale)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the entrance, the length and the concentration."""
        return {
            "entrance radius": (self.entrance_radius, "m"),
            "length": (self.length, "m"),
            "geometric concentration": (self.concentration, ""),
            "wall area": (self.area, "m²"),
        }
