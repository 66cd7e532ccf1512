"""Splitting: rays that go on as two."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hostcode.program.fields import RayField
from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.scene.surfaces import Surface

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Splitting(Effect):
    """Both children of a surface are followed, each with a place in the ray's tree."""

    name: ClassVar[str] = "splitting"
    what: ClassVar[str] = "both children of a surface that splits are followed"
    costs: ClassVar[str] = "a queue write for each split"

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where a surface splits."""
        named = scene.splitter
        if named is None or not settings.splitting:
            return None
        return f'a ray that meets "{named.name}" goes on as two'

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not, or that one child is chosen."""
        if scene.splitter is None:
            return "no surface sends a ray on as two"
        return "splitting is false: of two children one is chosen"

    def serves(self, kind: type[Described]) -> bool:
        """Where an object of it may split."""
        return issubclass(kind, Surface) and kind.splits is not False

    def parts(self, draft: Draft) -> EffectParts:
        """Return the path position that every draw is keyed by."""
        path = RayField("path", "ulong", "root", "place in the launched ray's tree", "(luint)(1UL)")
        return EffectParts(ray=(path,), splits=True)
