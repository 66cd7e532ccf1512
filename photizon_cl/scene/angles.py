"""Numbers over the angle of incidence: what a mirror reflects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

from photizon_cl.scene.curves import Curve, NumberOrCurve
from photizon_cl.scene.declarations import declare, fractions
from photizon_cl.scene.described import REQUIRED, Accepts, Described
from photizon_cl.scene.number_lists import Ascending, lengths_agree
from photizon_cl.scene.whole import read_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.errors import Problem
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.parameters import Parameter

__all__ = ["AngleCurve", "angles", "fraction_over"]

_MOST_NODES: Final = 10_000
_CLOSEST: Final = 1e-9
"""How far apart angles are at least, in degrees: directions are told apart to 1e-14."""


def angles(meaning: str, *, least: int) -> dict[str, Parameter]:
    """Declare the angles at which a table has values."""
    return declare(
        Ascending(
            "angles in degrees", 0.0, 90.0, least=least, most=_MOST_NODES, closest=_CLOSEST,
            meaning=meaning, unit="deg",
        )
    )  # fmt: skip


@dataclass(frozen=True)
class AngleCurve(Described):
    """A part of the power over the angle of incidence, linear between nodes, constant outside.

    Parameters
    ----------
    angle_deg : sequence of float
        Nodes in degrees, ascending, from 0 to 90.
    value : sequence of float
        A number in [0, 1] at each.
    """

    label: ClassVar[str] = "curve"
    one_value: ClassVar[bool] = True

    angle_deg: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED, metadata=angles("where it has values", least=1)
    )
    value: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED, metadata=fractions("angle", "what it is there")
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that there is a value for each angle."""
        return lengths_agree(known, "angle_deg", "angle", "value")

    @property
    def extended(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Angles from 0 to 90 degrees, and the value at each."""
        angle, value = self.angle_deg, self.value
        if angle[0] > 0.0:
            angle, value = (0.0, *angle), (value[0], *value)
        if angle[-1] < 90.0:
            angle, value = (*angle, 90.0), (*value, value[-1])
        return angle, value

    def __str__(self) -> str:
        low, high = min(self.value), max(self.value)
        return f"{low:.9g} … {high:.9g} over {self.angle_deg[0]:.9g} … {self.angle_deg[-1]:.9g} deg"


class FractionOver(NumberOrCurve):
    """A number in [0, 1], or a table of such over wavelength or over angle."""

    def __init__(self, meaning: str, hint: str = "") -> None:
        form = "{ wavelength_nm = [..], value = [..] }, or { angle_deg = [..], value = [..] }"
        super().__init__(Curve, form, "a number in [0, 1]", 0.0, 1.0, meaning=meaning, hint=hint)

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:
        if isinstance(value, AngleCurve):
            return value
        if isinstance(value, Mapping) and "angle_deg" in value:
            return read_whole(AngleCurve, value, path, problems, "a table over angle")
        return super().read(value, path, problems)


def fraction_over(meaning: str, hint: str = "") -> dict[str, Parameter]:
    """Declare a number in [0, 1], or a table of such over wavelength or over angle."""
    return declare(FractionOver(meaning, hint))
