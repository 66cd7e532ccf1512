"""Elements and sources that are turned off the axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from photizon_cl.compile.effects.base import Effect

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Tilt(Effect):
    """A frame that is no permutation of the axes."""

    name: ClassVar[str] = "tilt"
    what: ClassVar[str] = "elements or sources that are turned off the axes"
    costs: ClassVar[str] = "a full matrix instead of a permutation"

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where anything has a tilt."""
        named = [e.name for e in scene.element if e.tilt_deg != (0.0, 0.0)]
        named += [s.name for s in scene.source if getattr(s, "tilt_deg", (0.0, 0.0)) != (0.0, 0.0)]
        return f'"{named[0]}" is turned off the axes' if named else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "nothing is turned off the axes"

    def prepare(self, draft: Draft, *, forced: bool) -> None:
        """Take every element as turned, where it is forced on."""
        draft.all_tilted = forced
