"""Media: what rays are in, and lose weight to."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hostcode.program.fields import RayField
from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.compile.effects.face_surfaces import faced
from photizon_cl.compile.layout import ABSORBED_IN, LedgerRow
from photizon_cl.errors import show
from photizon_cl.scene.media.names import VACUUM

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings
    from photizon_cl.scene.surfaces import Surface

_MEDIUM = RayField(
    "medium",
    "long",
    "medium_of_source(launch, scene, ri)",
    "number of the medium that it is in: 0 the vacuum, then those of the scene",
    "lsplat(0L)",
    onward="medium_behind(launch, scene, p, c, met, h->code, outcome.went_plus)",
)
_NAMED = 3
"""Elements of which it is told how often a ray met one in the wrong medium."""
_NO_BORDER = (-1, -1)


class Media(Effect):
    """Rays know the medium that they are in; it absorbs, and surfaces say whether it is right."""

    name: ClassVar[str] = "media"
    what: ClassVar[str] = "rays carry the medium that they are in, which absorbs on their way"
    costs: ClassVar[str] = (
        "a number more a ray, an exponential a segment that is absorbed, a ledger row a medium"
    )
    counted_as: ClassVar[str] = "media_mismatches"

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where the scene has media, or a surface names one."""
        if scene.medium:
            return f"the scene has the medium {show(scene.medium[0].name)}"
        named = next(
            (e for e in scene.element if any(s.media is not None for s in e.surfaces)), None
        )
        return f'the surface of "{named.name}" names a medium' if named else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "the scene has no [[medium]]"

    def rows(self, scene: Scene) -> tuple[LedgerRow, ...]:
        """Return what each medium absorbs."""
        return tuple(
            LedgerRow(
                f"{ABSORBED_IN}.{medium.name}",
                1,
                f"absorbed in {medium.name}",
                macro=f"{ABSORBED_IN}_{number}",
            )
            for number, medium in enumerate(scene.medium, 1)
        )

    def cells(self, scene: Scene) -> tuple[int, ...]:
        """Return one for each element, which counts the rays that meet it in another medium."""
        return (len(scene.element),) if scene.names_media and scene.element else ()

    def advice(self, scene: Scene, counts: Sequence[int]) -> list[str]:
        """Say how often a ray was in another medium than the surface that it met, and where."""
        total = sum(counts)
        if not total:
            return []
        worst = sorted(range(len(counts)), key=lambda n: -counts[n])[:_NAMED]
        told = ", ".join(f'{counts[n]} at "{scene.element[n].name}"' for n in worst if counts[n])
        more = sum(1 for n in counts if n) > _NAMED
        text = (
            f"{total} times a ray met a surface that names another medium than the ray was in "
            f"({told}{' …' if more else ''}): what it lost on its way there is that of the wrong "
            "one; give a source in glass or water its medium, bodies that share a border one name "
            "for what lies between them, and see that no two overlap and none is open at its side"
        )
        return [text]

    def parts(self, draft: Draft) -> EffectParts:
        """Return what absorbs, what follows the medium and what counts the wrong ones."""
        counted = bool(self.cells(draft.scene))
        count = "count_mismatches(launch, scene, ledger, p, c, met, h->code);"
        return EffectParts(
            ray=(_MEDIUM,),
            templates=(("survive", "effects/media"),),
            libraries=("lib/powers",),
            hooks=(
                ("travel", "absorb(launch, scene, ledger, p, h);"),
                *((("surface", count),) if counted else ()),
            ),
            launch=(
                ("media", "ulong", "first cell of the counts of rays in a wrong medium"),
                ("absorption", "ulong", "where in the geometry table the media's stands, in 1/m"),
                ("source_media", "ulong", "where in codes the numbers of the sources' media stand"),
                ("side_media", "ulong", "where in codes those of the elements' two sides stand"),
            ),
            ends=True,
            parameters=(("media", len(draft.scene.medium)), ("media_counted", int(counted))),
        )

    def assemble(self, draft: Draft) -> None:
        """Put absorptions behind the geometry, and the numbers of media into the codes."""
        scene = draft.scene
        number = {VACUUM: 0, **{m.name: n for n, m in enumerate(scene.medium, 1)}}
        nothing = [0.0] * (draft.grid.n * (draft.grid.degree + 1))
        absorption = [*nothing]
        for medium in scene.medium:
            absorption += chain.from_iterable(draft.grid.rows(medium.absorbing))
        absorption += nothing
        assert draft.geometry is not None
        draft.launch["media"] = 0  # unless it has cells
        draft.launch["absorption"] = len(draft.geometry)
        draft.geometry = np.concatenate((draft.geometry, absorption))
        draft.launch["source_media"] = draft.add_codes(
            number[scene.source[beam.source].medium] for beam in draft.beams
        )
        # a place for what meets none, too
        by_face = "material_of_face" in draft.launch  # of three faces each, see face_surfaces.py
        sides = [
            n
            for element in scene.element
            for surface in (faced(element) if by_face else element.surfaces)
            for n in _sides(surface, scene.optics[surface], number)
        ]
        draft.launch["side_media"] = draft.add_codes(sides or _NO_BORDER)


def _sides(surface: Surface, optics: Surface, number: Mapping[str, int]) -> tuple[int, ...]:
    """Return what lies behind a surface and before it, as the kernel reads it.

    The number of a medium twice, and one more where the surface names it. An index of 1 is the
    vacuum, and another one a medium without a name.
    """
    if surface.media is not None:
        return tuple(number[name] << 1 | 1 for name in surface.media)
    if optics.indices is None:
        return _NO_BORDER
    unnamed = len(number)
    return tuple((0 if index == 1.0 else unnamed) << 1 for index in optics.indices)
