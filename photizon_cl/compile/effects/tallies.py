"""What detectors divide arrivals by: maps and ladders."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from photizon_cl.compile.effects.base import Effect

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class _Tally(Effect):
    """A tally that some detector has; its filters' text comes with it."""

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where a detector has one."""
        for element in scene.element:
            if element.detector is not None:
                names = [name for name, _ in element.detector.tallies(element)]
                if self.name in names:
                    return f'the detector on "{element.name}" has one'
        return None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "no detector has one"

    def possible(self, scene: Scene) -> bool:
        """Not without such a detector."""
        return False


class Map(_Tally):
    """Irradiance maps."""

    name: ClassVar[str] = "map"
    what: ClassVar[str] = "irradiance maps"
    costs: ClassVar[str] = "a terminal record and a bin an arrival"


class Ladder(_Tally):
    """Power by generation."""

    name: ClassVar[str] = "ladder"
    what: ClassVar[str] = "power by generation"
    costs: ClassVar[str] = "one row more an arrival"
