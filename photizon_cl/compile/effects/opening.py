"""Elements with a part cut out."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from photizon_cl.compile.effects.base import Effect

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Opening(Effect):
    """A port or a hole."""

    name: ClassVar[str] = "port"
    what: ClassVar[str] = "elements with an opening: a port, a hole"
    costs: ClassVar[str] = "a test of each place where such an element may be hit"

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where an element is open."""
        named = next((e for e in scene.element if e.opening), None)
        return f'"{named.name}" has an opening' if named else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "no element has an opening"

    def possible(self, scene: Scene) -> bool:
        """Not without an opening: it is a part of such an element's own text."""
        return False
