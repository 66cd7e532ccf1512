"""The spectrum: rays are of a line or band, by which glass, losses and the ledger are known."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hostcode.program.fields import EndingField, RayField
from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

_LINE = RayField(
    "line",
    "long",
    "line_of_ray(launch, scene, ri)",
    "number of the line of the spectrum that it is of",
    "lsplat(0L)",
)
_SPOT = "spot_of_ray(launch, scene, line_of_ray(launch, scene, ri), lo, hi)"
_IN_BAND = (
    RayField(
        "piece",
        "long",
        f"{_SPOT}.piece",
        "number of the piece of its band that it is in",
        "lsplat(0L)",
    ),
    RayField("along", "real", f"{_SPOT}.along", "place in that, from 0 to 1", "splat(0.0)"),
)
_ENDING = EndingField("line", "word", "TO_WORD(p->line)", "number of its line of the spectrum")


class Spectrum(Effect):
    """Rays know the line or band of the spectrum that they are of."""

    name: ClassVar[str] = "spectrum"
    what: ClassVar[str] = (
        "rays are of a wavelength, by which glass, losses and the ledger are known"
    )
    costs: ClassVar[str] = (
        "a number more a ray, a row of each surface for each line, or in bands a polynomial a "
        "number, and a ledger that is kept in memory by line"
    )

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where the scene has one."""
        return None if scene.spectrum is None else f"[spectrum] has {scene.spectrum.about}"

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "the scene has no [spectrum]"

    def divides(self, scene: Scene) -> int:
        """Return the number of lines; one, forced on without any."""
        return len(scene.wavelengths)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the line of a ray, and what has the ledger booked by it."""
        asked = any(d.wavelengths for d in draft.layout.detectors)
        bands: tuple[tuple[str, str, str], ...] = ()
        degree: tuple[tuple[str, int], ...] = ()
        if draft.grid.edges:
            bands = (
                ("pieces", "ulong", "pieces of all bands"),
                (
                    "band_edges",
                    "ulong",
                    "where in the geometry table the pieces' edges stand, in nm",
                ),
                ("band_pieces", "ulong", "where in codes it stands which is each band's first"),
                ("band_steps", "ulong", "halvings that find a piece among those of a band"),
            )
            degree = (("band_degree", draft.grid.degree),)
        return EffectParts(
            ray=(_LINE, *(_IN_BAND if bands else ())),
            ending=(_ENDING,) * asked,
            templates=(("survive", "effects/spectrum"),),
            hooks=(("travel", "part_by_line(launch, ledger, p->line);"),),
            launch=(
                ("lines", "ulong", "lines of the spectrum"),
                ("line_rows", "ulong", "first cell of the ledger's rows by line"),
                (
                    "beam_lines",
                    "ulong",
                    "where in codes the lines of the source table's rows stand",
                ),
                *bands,
            ),
            parameters=(("ledger_parts", 1), *degree),
        )

    def assemble(self, draft: Draft) -> None:
        """Say which line each row of the source table is of."""
        draft.launch["lines"] = draft.layout.parts
        draft.launch["line_rows"] = draft.layout.divided
        draft.launch["beam_lines"] = draft.add_codes(beam.line for beam in draft.beams)
        grid = draft.grid
        if grid.edges:
            assert draft.geometry is not None
            draft.launch["pieces"] = grid.n
            draft.launch["band_edges"] = len(draft.geometry)
            draft.geometry = np.concatenate((draft.geometry, grid.edges))
            draft.launch["band_pieces"] = draft.add_codes(grid.first)
            draft.launch["band_steps"] = (grid.most - 1).bit_length()
