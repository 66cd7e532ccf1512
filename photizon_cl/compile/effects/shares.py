"""Sources whose rays weigh differently."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from photizon_cl.compile.effects.base import Effect
from photizon_cl.compile.rays import beams_of, ray_weights, share_rays

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Shares(Effect):
    """Rays are divided among sources otherwise than by flux."""

    name: ClassVar[str] = "shares"
    what: ClassVar[str] = "rays divided other than by flux, or among several sources"
    costs: ClassVar[str] = "a choice of source and a launched weight a ray"

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where the sources' rays do not all weigh the same."""
        _, weights = ray_weights(scene, share_rays(scene, settings.rays_per_batch))
        if all(w == 1.0 for w in weights):
            return None
        least, beam = min(zip(weights, beams_of(scene), strict=True), key=lambda pair: pair[0])
        return f'a ray of "{scene.source[beam.source].name}" weighs {least:.3g} of the heaviest'

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "all rays weigh the same"

    def prepare(self, draft: Draft, *, forced: bool) -> None:
        """Have rays remember their launched weight where it matters."""
        draft.weights_differ = True
