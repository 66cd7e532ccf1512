"""Russian roulette."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hostcode.program.fields import LAUNCHED
from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Roulette(Effect):
    """Rays below the floor go on with more weight or end, by chance.

    With twice it, each other one; with four times it, one in four, where a surface sends on four.
    """

    name: ClassVar[str] = "roulette"
    what: ClassVar[str] = "rays of low weight survive by chance, with more weight"
    costs: ClassVar[str] = (
        "one comparison an interaction, a random block for each play, two ledger rows"
    )

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where there is a floor."""
        floor = scene.roulette_floor(settings)
        if floor <= 0.0:
            return None
        asked = settings.roulette_floor == floor
        return f"roulette_floor is {floor:g}" + ("" if asked else ", as rays split")

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say that there is no floor."""
        asked = settings.roulette_floor == 0.0
        return "roulette_floor is 0" + ("" if asked else ", as no ray splits")

    def heaviest(self, scene: Scene, settings: RunSettings) -> float:
        """Return what the floor is raised to: twice, or four times.

        Of rays that are sent towards something the floor may lie as high as their launched weight.
        """
        four = any(s.splits and s.lobe is not None for e in scene.element for s in e.surfaces)
        raised = 4.0 if four and scene.splits(settings) else 2.0
        floor = scene.roulette_floor(settings) if scene.importance is None else 1.0
        return max(1.0, raised * floor)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the play, and the launched weight that the floor is a fraction of."""
        return EffectParts(
            # rays that all weigh 1 need not remember it
            ray=(LAUNCHED,) if draft.weights_differ else (),
            templates=(("survive", "effects/roulette"),),
            hooks=(("survive", "roulette(launch, p, ledger, met);"),),
            launch=(("roulette_floor", "double", "fraction of the launched weight"),),
        )

    def assemble(self, draft: Draft) -> None:
        """Add the floor."""
        draft.launch["roulette_floor"] = draft.scene.roulette_floor(draft.settings)
