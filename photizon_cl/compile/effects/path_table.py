"""The path table: which sequences of faces and events bring light to a detector."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hostcode.program.fields import EndingField, RayField
from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

_ONWARD = "extend_trail(launch, scene, met, p->trail, h->code, outcome.event)"
_SECOND = "extend_trail(launch, scene, met, p->trail, h->code, outcome.second_event)"


class PathTable(Effect):
    """A ray carries a key of what it met; each arrival is counted by that key too."""

    name: ClassVar[str] = "path-table"
    what: ClassVar[str] = "arrivals are counted by the sequence of faces and events before them"
    costs: ClassVar[str] = "a key an interaction, and a place in a hash table an arrival"

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where a detector has a path table."""
        for element in scene.element:
            if element.detector is not None and element.detector.paths is not None:
                return f'the detector on "{element.name}" has a path table'
        return None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "no detector has a path table"

    def possible(self, scene: Scene) -> bool:
        """Not without a detector: forced on, keys are carried and recorded, and no table made."""
        return any(e.detector is not None for e in scene.element)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the key, what is recorded of it, and the table."""
        trail = RayField(
            "trail",
            "ulong",
            "(luint)(0UL)",
            "key of the faces and events that it met",
            onward=_ONWARD,
            second=_SECOND,
        )
        launch = [("path_tables", "ulong", "where in codes it stands which detectors have one")]
        if self._shared(draft.scene):
            launch.append(("face_names", "ulong", "where in codes the elements' face names stand"))
        return EffectParts(
            ray=(trail,),
            ending=(
                EndingField("trail_lo", "word", "TO_WORD(p->trail)", "key of its path, low half"),
                EndingField("trail_hi", "word", "TO_WORD(p->trail >> 32)", "the same, high half"),
                EndingField("ray_lo", "word", "p->ray_lo", "number of the launched ray, low half"),
                EndingField("ray_hi", "word", "p->ray_hi", "the same, high half"),
            ),
            templates=(("survive", "effects/path_table"), ("tally", "effects/path_counts")),
            hooks=(("arrival", "count_path(keyed, codes, launch, which, end);"),),
            launch=tuple(launch),
            libraries=("lib/trail_key",),
            events=True,
            keyed=True,
            parameters=(("shared_names", int(self._shared(draft.scene))),),
        )

    def assemble(self, draft: Draft) -> None:
        """Say which detectors have a table, and, where faces share names, the name of each."""
        elements = draft.scene.element
        draft.launch["path_tables"] = draft.add_codes(
            int(d.paths > 0) for d in draft.layout.detectors
        )
        if self._shared(draft.scene):
            places = draft.add_codes(0 for _ in elements)
            draft.launch["face_names"] = places
            known: dict[tuple[int, ...], int] = {}
            for n, element in enumerate(elements):
                names = tuple(element.face_number(k) for k in range(len(element.faces)))
                if names not in known:
                    known[names] = draft.add_codes(names)
                draft.codes[places + n] = known[names]

    @staticmethod
    def _shared(scene: Scene) -> bool:
        return any(len(e.face_names) < len(e.faces) for e in scene.element)
