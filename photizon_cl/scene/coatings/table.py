"""A coating that was measured over angle."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.errors import Problem, show
from photizon_cl.scene.angles import angles
from photizon_cl.scene.coatings.base import Coating, whole
from photizon_cl.scene.declarations import fractions
from photizon_cl.scene.number_lists import lengths_agree
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from photizon_cl.scene.coatings.base import Array, Meeting
    from photizon_cl.scene.described import Known


@dataclass(frozen=True)
class TableCoating(Coating):
    """Reflectance and transmittance over angle, linear between the nodes.

    The angle is that in the medium outside, on the side that the normal points to: light from
    inside is looked up at the angle at which it leaves. 1 − R − T is absorbed by the element.
    Beyond the critical angle R + T is reflected: of light from inside as at 90°.

    Parameters
    ----------
    angle_deg : sequence of float
        Nodes in degrees, ascending, the first 0 and the last 90: a ray may come at any angle.
    reflectance : sequence of float
        R in [0, 1] at each.
    transmittance : sequence of float
        T at each; R + T is at most 1.
    """

    kind: ClassVar[str] = "table"
    kernel: ClassVar[str] = "table"
    does: ClassVar[str] = "reflectance and transmittance by a table over angle"
    costs: ClassVar[str] = "an arctangent and a search of the table an interaction"
    libraries: ClassVar[tuple[str, ...]] = ("lib/angles",)
    reads: ClassVar[Row] = Row(
        "ANGLE_NODE",
        ("angle", "deg", "where it stands"),
        ("density", "1/deg", "1 over the way to the next node, 0 of the last"),
        ("reflectance", "", "R there"),
        ("transmittance", "", "T there"),
    )
    sample: ClassVar[Mapping[str, object]] = MappingProxyType(
        {
            "angle_deg": (0.0, 45.0, 70.0, 90.0),
            "reflectance": (0.01, 0.015, 0.1, 1.0),
            "transmittance": (0.98, 0.97, 0.87, 0.0),
        }
    )

    angle_deg: Sequence[float] = field(metadata=angles("nodes: from 0 to 90", least=2))
    reflectance: Sequence[float] = field(
        metadata=fractions("angle", "part of the power that is reflected")
    )
    transmittance: Sequence[float] = field(metadata=fractions("angle", "part that passes"))

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that all angles are covered, and that no more leaves than arrives."""
        nodes = known.get("angle_deg")
        if nodes is None:
            return []
        problems = lengths_agree(known, "angle_deg", "angle", "reflectance", "transmittance")
        hint = "rays come at any angle, and what a coating does is not extrapolated"
        if nodes[0] != 0.0:
            problems.append(Problem("angle_deg[0]", show(nodes[0]), "0", hint=hint))
        if nodes[-1] != 90.0:
            last = f"angle_deg[{len(nodes) - 1}]"
            problems.append(Problem(last, show(nodes[-1]), "90", hint=hint))
        both = known.get("reflectance"), known.get("transmittance")
        if problems or None in both:
            return problems
        for n, (r, t) in enumerate(zip(*both, strict=True)):
            if r + t > 1.0 + 2.0**-52:
                hint = f"reflectance + transmittance are {r + t:.9g} there, and at most 1"
                expected = f"a number from 0 to {1.0 - r:.9g}, as {show(r)} is reflected"
                problems.append(Problem(f"transmittance[{n}]", show(t), expected, hint=hint))
        return problems

    @property
    def lossless(self) -> bool:
        """Whether R + T is 1 at every node, and so between them."""
        return all(map(whole, self.reflectance, self.transmittance))

    @property
    def nodes(self) -> list[list[float]]:
        """Of each node the angle, 1 over the way to the next, R and T."""
        steps = [b - a for a, b in zip(self.angle_deg, self.angle_deg[1:], strict=False)]
        rows = zip(
            self.angle_deg,
            [*(1.0 / step for step in steps), 0.0],
            self.reflectance,
            self.transmittance,
            strict=True,
        )
        return [list(row) for row in rows]

    def parts(self, met: Meeting, nm: float | None) -> tuple[Array, Array]:
        """Return reflectance and transmittance."""
        total = met.square <= 0.0
        angle = np.arctan2(met.sine, met.cosine)
        if met.inside:
            sine = met.before / met.behind * met.sine
            angle = np.where(total, np.pi / 2, np.arctan2(sine, np.sqrt(np.maximum(met.square, 0))))
        nodes = np.asarray(self.angle_deg)
        r, t = (
            np.interp(np.degrees(angle), nodes, np.asarray(values))
            for values in (self.reflectance, self.transmittance)
        )
        return np.where(total, np.minimum(r + t, 1.0), r), np.where(total, 0.0, t)
