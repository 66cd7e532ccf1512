"""The reflector that is partly specular and partly diffuse."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import Problem, show
from photizon_cl.scene.curves import (
    INTERPOLATED,
    Curve,
    at_wavelength,
    fraction_or_curve,
    number_of,
)
from photizon_cl.scene.rows import Row
from photizon_cl.scene.surfaces.base import Surface

if TYPE_CHECKING:
    from photizon_cl.scene.described import Known


@dataclass(frozen=True)
class Mixed(Surface):
    """A reflector of which a part is specular and a part ideally diffuse, on both sides.

    A ray splits: the specular child leaves as from a mirror with the weight times `specular`, the
    diffuse one with density cos θ/π per steradian about the normal of the side that was hit, with
    the weight times `diffuse`. Either may be 0 and then has no child. What is left,
    1 − specular − diffuse, is absorbed by the element.

    Parameters
    ----------
    specular : float or Curve
        Part of the power that is reflected as by a mirror, in [0, 1]; a table over wavelength in a
        scene that has a spectrum.
    diffuse : float or Curve
        Part of the power that is reflected diffusely, in [0, 1 − specular], likewise.
    """

    kind: ClassVar[str] = "mixed"
    kernel: ClassVar[str] = "mixed"
    does: ClassVar[str] = "specular and diffuse reflection, both followed"
    costs: ClassVar[str] = "one random block, sine and cosine an interaction, and the split"
    row: ClassVar[Row] = Row(
        "MIXED",
        ("specular", "", "part of the weight of the specular child"),
        ("diffuse", "", "part of the weight of the diffuse child"),
    )
    reflects: ClassVar[bool] = True
    draws: ClassVar[bool] = True
    scatters: ClassVar[bool] = True
    colour: ClassVar[str] = "#882255"
    label_text: ClassVar[str] = "mixed reflector"

    specular: float | Curve = field(
        metadata=fraction_or_curve("part of the power that is reflected specularly")
    )
    diffuse: float | Curve = field(
        metadata=fraction_or_curve(
            "part of the power that is reflected diffusely", "the rest of both is absorbed"
        )
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that no more is reflected than arrives."""
        specular, diffuse = known.get("specular"), known.get("diffuse")
        if specular is None or diffuse is None:
            return []
        # the sum of two tables that are linear between nodes is largest at one
        curves = [c for c in (specular, diffuse) if isinstance(c, Curve)]
        wavelengths: list[float | None] = [*sorted({nm for c in curves for nm in c.wavelength_nm})]
        most = 1.0 + INTERPOLATED if curves else 1.0
        for nm in wavelengths or [None]:
            s, d = at_wavelength(specular, nm), at_wavelength(diffuse, nm)
            if s + d > most:
                where = "" if nm is None else f" at {nm:.9g} nm"
                hint = "more would be reflected than arrives"
                expected = f"at most 1 - {show(s)}{where}"
                return [Problem("diffuse", f"{show(d)}{where}", expected, hint=hint)]
        return []

    @property
    def splits(self) -> bool:  # type: ignore[override]  # of this one, not of the class
        """Whether both children exist."""
        return _any(self.specular) and _any(self.diffuse)

    @property
    def absorptance(self) -> float | None:
        """Part of each arrival that the element absorbs, 1 − specular − diffuse.

        None where one of them is a table.
        """
        if isinstance(self.specular, Curve) or isinstance(self.diffuse, Curve):
            return None
        return max(1.0 - self.specular - self.diffuse, 0.0)

    def packed(self) -> dict[str, float]:
        """Return both parts."""
        return {"specular": number_of(self.specular), "diffuse": number_of(self.diffuse)}

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the absorptance, where it is a number."""
        return {} if self.absorptance is None else {"absorptance": (self.absorptance, "")}


def _any(part: float | Curve) -> bool:
    return any(part.value) if isinstance(part, Curve) else part > 0.0
