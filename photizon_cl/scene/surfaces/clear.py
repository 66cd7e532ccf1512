"""The surface that is not there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from photizon_cl.scene.surfaces.base import Surface


@dataclass(frozen=True)
class Clear(Surface):
    """A surface at which nothing happens: every ray passes, unchanged and uncounted.

    The ray keeps its direction, its weight and its generation: passing is no interaction, so that
    it brings no ray nearer to the generation cap and no roulette is played. What it is for is to
    carry a detector where light passes, a counting plane: power, map and ladder of what crosses it
    from the side that the detector counts. Every crossing is an arrival, however often a ray
    crosses. It takes no parameter.
    """

    kind: ClassVar[str] = "clear"
    kernel: ClassVar[str] = "clear"
    does: ClassVar[str] = "lets everything pass, for a detector to count"
    costs: ClassVar[str] = "one segment more for each ray that passes, one tally event a passage"
    absorbs: ClassVar[bool] = False
    transmits: ClassVar[bool] = True
    counts: ClassVar[bool] = False
    carries_detector: ClassVar[bool] = True
    colour: ClassVar[str] = "#009e73"
    label_text: ClassVar[str] = "counting surface"
