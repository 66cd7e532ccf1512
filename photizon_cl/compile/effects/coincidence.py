"""Faces of several elements in one place: which of them a ray meets first."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.geometry.coincidence import unordered
from photizon_cl.scene.elements.base import ROUNDOFF
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Coincidence(Effect):
    """Where the nearest face may lie in others, a second search settles which comes first."""

    name: ClassVar[str] = "coincidence"
    what: ClassVar[str] = "faces of several elements in one place: their order"
    costs: ClassVar[str] = "a second search for each ray that meets such a face"
    row: ClassVar[Row] = Row(
        "COINCIDENCE", ("room", "m", "how far rounding may move a face, at most, eight times over")
    )

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where neither rounding nor the file may decide: `photizon_cl.geometry.coincidence`."""
        return self.needed_within(scene, settings, ROUNDOFF)

    def needed_within(self, scene: Scene, settings: RunSettings, roundoff: float) -> str | None:
        """Where there are such places to the rounding of the coordinates."""
        pair = next(unordered(scene.element, roundoff), None)
        if pair is None:
            return None
        a, b = (scene.element[n].name for n in pair)
        return f'"{a}" and "{b}" have faces in one place'

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "no two elements have faces in one place, or it is clear which comes first"

    def possible(self, scene: Scene) -> bool:
        """Not without elements."""
        return bool(scene.element)

    def prepare(self, draft: Draft, *, forced: bool) -> None:
        """Mark the elements that it is about."""
        draft.coincident = frozenset(
            n for pair in unordered(draft.near.elements, draft.near.roundoff) for n in pair
        )

    def packed(self, draft: Draft, number: int) -> dict[str, float]:
        """Return the room for rounding, which follows the positions that were given."""
        return {"room": 8.0 * draft.near.rounding * float(np.abs(draft.near.boxes[number]).max())}

    def parts(self, draft: Draft) -> EffectParts:
        """Return what settles the order, which the elements' functions call."""
        return EffectParts(libraries=("lib/coincidence",), orders=True)
