"""What arrives at detectors."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.compile.layout import DetectorCells
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Detector(Effect):
    """Arrivals on the side that a detector counts."""

    name: ClassVar[str] = "detector"
    what: ClassVar[str] = "arrivals on the side that a detector faces are counted"
    costs: ClassVar[str] = "one tally event an arrival"

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where an element has a detector."""
        named = next((e for e in scene.element if e.detector is not None), None)
        return f'"{named.name}" has a detector' if named else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "no element has a detector"

    def possible(self, scene: Scene) -> bool:
        """Not without a detector."""
        return any(e.detector is not None for e in scene.element)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the counting of arrivals."""
        return EffectParts(
            templates=(("tally", "lib/detector"),),
            records=("arrivals",),
            launch=(
                ("detector_of", "ulong", "where in codes the elements' detector numbers stand"),
                (
                    "detectors",
                    "ulong",
                    "where in codes those of the detectors' integers stand",
                ),
            ),
        )

    def assemble(self, draft: Draft) -> None:
        """Add each detector's integers and numbers, see ``kernels/lib/detector.mako``."""
        detectors = draft.layout.detectors
        of_element = {d.element: n for n, d in enumerate(detectors)}
        draft.launch["detector_of"] = draft.add_codes(
            of_element.get(n, -1) for n in range(len(draft.scene.element))
        )
        places = len(draft.codes)
        draft.launch["detectors"] = draft.add_codes(0 for _ in detectors)
        for n, d in enumerate(detectors):
            draft.codes[places + n] = draft.add_codes(self._integers(draft, d))
            element = draft.scene.element[d.element]
            draft.detector_numbers += np.subtract(element.position, draft.shift).tolist()
            draft.detector_numbers += np.ravel(element.frame).tolist()

    def _integers(self, draft: Draft, d: DetectorCells) -> list[int]:
        element = draft.scene.element[d.element]
        widest = max((len(form.filters) for form in draft.forms), default=0)
        out = [int(element.detector_plus), d.power, len(d.tallies)]
        for tally in d.tallies:
            row = [draft.form_of(tally.filters), tally.first]
            for item in tally.filters:
                row += [item.bins, draft.add_edges(item.device_edges())]
            out += row + [0] * (2 + 2 * widest - len(row))
        return out
