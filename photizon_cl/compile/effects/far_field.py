"""What escapes, by direction."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hostcode.program.spec import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.scene.edges import azimuth_edges, even_edges

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class FarField(Effect):
    """What escapes is binned by direction."""

    name: ClassVar[str] = "far-field"
    what: ClassVar[str] = "what escapes is binned by direction"
    costs: ClassVar[str] = "a terminal record and an exact-edge search an escape"
    removable: ClassVar[bool] = True

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where the scene asks for it."""
        return "the scene has a [far_field]" if scene.far_field is not None else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "the scene has no [far_field]"

    def possible(self, scene: Scene) -> bool:
        """Not without bins."""
        return scene.far_field is not None

    def cells(self, scene: Scene) -> tuple[int, ...]:
        """Return (n_mu, n_phi)."""
        assert scene.far_field is not None
        return scene.far_field.n_mu, scene.far_field.n_phi

    def parts(self, draft: Draft) -> EffectParts:
        """Return the binning of escapes."""
        return EffectParts(
            templates=(("tally", "effects/far_field"),),
            records=("escapes",),
            launch=(
                ("far_field", "ulong", "first cell of the far field"),
                ("n_mu", "ulong", "far-field bins in cos theta"),
                ("n_phi", "ulong", "far-field bins in phi"),
                ("mu_edges", "ulong", "where in edges those in cos theta stand"),
                ("phi_edges", "ulong", "where in edges those in phi stand"),
            ),
        )

    def assemble(self, draft: Draft) -> None:
        """Add the bins and their edges."""
        n_mu, n_phi = self.cells(draft.scene)
        launch = draft.launch
        launch["n_mu"], launch["n_phi"] = n_mu, n_phi
        launch["mu_edges"] = draft.add_edges(even_edges(-1.0, 1.0, n_mu))
        launch["phi_edges"] = draft.add_edges(azimuth_edges(n_phi))
