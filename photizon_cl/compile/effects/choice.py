"""Choice: one of two children goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Choice(Effect):
    """Of the two children of a surface that splits one is followed, with the weight of both."""

    name: ClassVar[str] = "choice"
    what: ClassVar[str] = "one child of a surface that splits is followed, chosen by chance"
    costs: ClassVar[str] = "a random block for each choice; no queue, and more noise a ray"

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where a surface splits and the settings say that rays do not."""
        named = scene.splitter
        if named is None or settings.splitting:
            return None
        return f'splitting is false, and a ray that meets "{named.name}" could go on as two'

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say whether nothing splits, or both children are followed."""
        if scene.splitter is None:
            return "no surface splits"
        return "splitting is true: both children are followed"

    def possible(self, scene: Scene) -> bool:
        """Say whether nothing splits: where something does, the settings alone say which."""
        return scene.splitter is None

    def parts(self, draft: Draft) -> EffectParts:
        """Return the draw."""
        return EffectParts(
            templates=(("survive", "effects/choice"),),
            hooks=(("surface", "choose(launch, p, c, ledger, element, takes, &outcome);"),),
            pairs=True,
        )
