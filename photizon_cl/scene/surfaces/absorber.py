"""The ideal absorber."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from photizon_cl.scene.surfaces.base import Surface


@dataclass(frozen=True)
class Absorber(Surface):
    """A black surface: the whole weight of every arrival ends here, from either side.

    It can carry a detector. It makes no draw and takes no parameter.
    """

    kind: ClassVar[str] = "absorber"
    kernel: ClassVar[str] = "absorber"
    does: ClassVar[str] = "ends what arrives"
    costs: ClassVar[str] = "one tally event a path"
    absorbs: ClassVar[bool] = True
    carries_detector: ClassVar[bool] = True
    label_text: ClassVar[str] = "absorber"
