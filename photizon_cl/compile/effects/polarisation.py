"""Polarisation: rays carry the Stokes parameters of their light."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hostcode.program.fields import RayField
from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.scene.polarisation import Polarisation as Polarised
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

_SOURCE = Row(
    "POLARISED",
    ("q", "", "Q/I of its rays, in the frame of its u across them"),
    ("u", "", "U/I, towards its v"),
    *((f"{row}{axis}", "", "its frame") for row in "uw" for axis in "xyz"),
)
"""What the kernel reads of a source."""
_NONE = (0.0, 0.0)


class Polarisation(Effect):
    """Rays carry how their light is polarised, and borders send it on by its parts."""

    name: ClassVar[str] = "polarisation"
    what: ClassVar[str] = "rays carry the polarisation of their light, and borders act by it"
    costs: ClassVar[str] = (
        "three numbers more a ray; at mirrors and glass frames that are turned, some ten divisions "
        "and roots"
    )

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where the settings ask for it."""
        return f"run.{Polarised.label} is true" if settings.polarisation else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say that nobody asked for it."""
        return f"run.{Polarised.label} is false: all light is unpolarised at every face"

    def possible(self, scene: Scene) -> bool:
        """Only where no surface acts by it: elsewhere the numbers depend on it."""
        return not scene.polarises

    def serves(self, kind: type[Described]) -> bool:
        """Where it is what a source says of its light."""
        return issubclass(kind, Polarised)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the three numbers of a ray, and what surfaces call."""
        polarised = any(s.polarisation is not None for s in draft.scene.source)
        call = "launched_light(launch, scene, ri, dx, dy, dz, {})"
        starts = {"q": call.format(0), "u": call.format(1)} if polarised else {}
        ray = tuple(
            RayField(
                f"stokes_{letter}",
                "real",
                starts.get(letter, "splat(0.0)"),
                f"{letter.upper()}/I of its light, see effects/polarisation.mako",
                "splat(0.0)",
                onward=f"outcome.stokes_{letter}",
                second=f"outcome.second_stokes_{letter}",
                beside="splat(0.0)",
            )
            for letter in "quv"
        )
        return EffectParts(
            ray=ray,
            templates=(("surfaces", "effects/polarisation"),),
            launch=(
                ("polarisation", "ulong", "where in the geometry table the sources' light stands"),
            ),
            amplitudes=True,
            parameters=(
                ("polarised_sources", int(polarised)),
                ("polarised_numbers", len(_SOURCE)),
                *_SOURCE.constants(0).items(),
            ),
        )

    def assemble(self, draft: Draft) -> None:
        """Put what the sources' light is behind the geometry."""
        assert draft.geometry is not None
        rows = []
        for beam in draft.beams:  # as the rows of the source table are
            source = draft.scene.source[beam.source]
            q, u = _NONE if source.polarisation is None else source.polarisation.stokes
            (ux, uy, uz), _, (wx, wy, wz) = source.frame
            values = {
                "q": q, "u": u, "ux": ux, "uy": uy, "uz": uz, "wx": wx, "wy": wy, "wz": wz,
            }  # fmt: skip
            rows.append(_SOURCE.pack(values))
        draft.launch["polarisation"] = len(draft.geometry)
        draft.geometry = np.concatenate((draft.geometry, np.ravel(rows)))
