"""The reflector that is partly specular and partly diffuse."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import Problem, show
from photizon_cl.scene.parameters import fraction
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
    specular : float
        Part of the power that is reflected as by a mirror, in [0, 1].
    diffuse : float
        Part of the power that is reflected diffusely, in [0, 1 − specular].
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

    specular: float = field(metadata=fraction("part of the power that is reflected specularly"))
    diffuse: float = field(
        metadata=fraction(
            "part of the power that is reflected diffusely", "the rest of both is absorbed"
        )
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that no more is reflected than arrives."""
        specular, diffuse = known.get("specular"), known.get("diffuse")
        if specular is None or diffuse is None or specular + diffuse <= 1.0:
            return []
        hint = "more would be reflected than arrives"
        return [Problem("diffuse", show(diffuse), f"at most 1 - {show(specular)}", hint=hint)]

    @property
    def splits(self) -> bool:  # type: ignore[override]  # of this one, not of the class
        """Whether both children exist."""
        return self.specular > 0.0 and self.diffuse > 0.0

    @property
    def absorptance(self) -> float:
        """Part of each arrival that the element absorbs, 1 − specular − diffuse."""
        return max(1.0 - self.specular - self.diffuse, 0.0)

    def packed(self) -> dict[str, float]:
        """Return both parts."""
        return {"specular": self.specular, "diffuse": self.diffuse}

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the absorptance."""
        return {"absorptance": (self.absorptance, "")}
