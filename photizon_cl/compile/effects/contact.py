"""Elements that touch or cross: which side of each a ray is on."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hostcode.program.fields import HitField, RayField
from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.geometry.contact import in_contact, note_size
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.scene.elements.base import ROUNDOFF

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Contact(Effect):
    """A ray remembers the faces around its start, and the side of each that it is on."""

    name: ClassVar[str] = "contact"
    what: ClassVar[str] = "elements that touch or cross: which side of each a ray is on"
    costs: ClassVar[str] = "five to fifteen words more a ray"
    in_text: ClassVar[bool] = True

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where elements touch, or may: see `photizon_cl.geometry.contact`."""
        return self.needed_within(scene, settings, ROUNDOFF)

    def needed_within(self, scene: Scene, settings: RunSettings, roundoff: float) -> str | None:
        """Where they may to the rounding of their coordinates."""
        touching = in_contact(Neighbours(scene.element, roundoff), scene.source)
        return "elements touch, cross, or meet at an outer edge" if touching else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "no elements touch or cross, or only at edges as the walls of a room do"

    def parts(self, draft: Draft) -> EffectParts:
        """Return the notes, and the last way of any length."""
        words, bits = note_size(draft.near)
        words = max(words, draft.note_words)
        came = [
            RayField(f"came_{x}", "real", "splat(0.0)", "last segment that had a length, in m")
            for x in "xyz"
        ]
        notes = [
            RayField(f"note{n}", "long", "lsplat(NO_FACE)", "faces around where it started last")
            for n in range(words)
        ]
        noted = [
            HitField(f"noted.word{n}", "long", "faces around the start, which it will remember")
            for n in range(words)
        ]
        return EffectParts(
            ray=(*came, *notes),
            hit=tuple(noted),
            parameters=(("note_words", words), ("note_bits", bits)),
        )
