"""How a source's light is polarised."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Final

from photizon_cl.errors import Problem, join
from photizon_cl.scene.declarations import fraction, number
from photizon_cl.scene.described import Described
from photizon_cl.scene.frames import sincos_deg

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.described import Known

__all__ = ["Polarisation", "unasked"]

_MOST_DEG: Final = 36000.0


@dataclass(frozen=True, kw_only=True)
class Polarisation(Described):
    """The table ``polarisation`` of a source: its light is polarised linearly.

    Parameters
    ----------
    degree : float
        Part of the power that is polarised, in [0, 1]; the rest is unpolarised.
    angle_deg : float
        Direction of the electric field in degrees: across each ray, from the projection of the
        source's u towards v. A ray along u has no such projection, and takes any direction.
    """

    label: ClassVar[str] = "polarisation"

    degree: float = field(
        default=1.0, metadata=fraction("part of the power that is polarised linearly")
    )
    angle_deg: float = field(
        default=0.0,
        metadata=number(
            "an angle from -36000 to 36000 degrees", -_MOST_DEG, _MOST_DEG,
            "direction of the field, from the source's u towards v", "deg",
        ),
    )  # fmt: skip

    @property
    def stokes(self) -> tuple[float, float]:
        """Stokes parameters q and u over the power, in the frame of the source's u."""
        sine, cosine = sincos_deg(2.0 * self.angle_deg)
        return self.degree * cosine, self.degree * sine


def unasked(run: Known | None, sources: Sequence[Known | None]) -> list[Problem]:
    """Return the problems of polarised sources in a scene that is run without polarisation.

    Parameters
    ----------
    run : Known or None
        Good values of the settings; None without a table.
    sources : sequence of Known or None
        The scene's sources; None where an entry could not be read at all.
    """
    key = Polarisation.label
    if run is not None and (key not in run.values or run.get(key)):
        return []
    hint = f"its rays would carry none: set run.{key} = true, or leave it out"
    return [
        Problem(join(f"source[{i}]", key), "a table", f"none while run.{key} is false", hint=hint)
        for i, known in enumerate(sources)
        if known is not None and known.get(key) is not None
    ]
