"""Elements whose faces have surfaces of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings
    from photizon_cl.scene.surfaces import Surface

FACES: Final = 3
"""Faces of an element that may differ in their surfaces; further ones have the last one's."""


class FaceSurfaces(Effect):
    """The surface that a ray meets is that of the face, not of the element."""

    name: ClassVar[str] = "face-surfaces"
    what: ClassVar[str] = "elements whose faces have surfaces of their own"
    costs: ClassVar[str] = "three columns an element, and a look-up an interaction"
    in_text: ClassVar[bool] = True
    row: ClassVar[Row] = Row(
        "FACES",
        ("first", "", "number of the surface kind of face 0"),
        ("second", "", "of face 1"),
        ("third", "", "of all others"),
    )

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where an element has several surfaces."""
        named = next((e for e in scene.element if len(e.surfaces) > 1), None)
        return f'"{named.name}" has faces with surfaces of their own' if named else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "every element has one surface for all its faces"

    def possible(self, scene: Scene) -> bool:
        """Not without elements."""
        return bool(scene.element)

    def serves(self, kind: type[Described]) -> bool:
        """Where faces may have surfaces of their own."""
        return "own-surfaces" in getattr(kind, "traits", ())

    def packed(self, draft: Draft, number: int) -> dict[str, float]:
        """Return the numbers of the faces' surface kinds."""
        kinds = [draft.surface_numbers[s.kernel] for s in faced(draft.scene.element[number])]
        return dict(zip(("first", "second", "third"), map(float, kinds), strict=True))

    def parts(self, draft: Draft) -> EffectParts:
        """Return where the materials of faces stand."""
        meaning = "where in codes the places of faces' materials stand (material_of_face)"
        return EffectParts(
            launch=(("material_of_face", "ulong", meaning),), libraries=("lib/face_surfaces",)
        )

    def assemble(self, draft: Draft) -> None:
        """Add the places in the material table, one for each face."""
        places = [draft.materials[s] for e in draft.scene.element for s in faced(e)]
        draft.launch["material_of_face"] = draft.add_codes(places)


def faced(element: Element) -> list[Surface]:
    """Return the surfaces of an element's first faces, the last one's for those that it has not."""
    last = len(element.faces) - 1 if len(element.surfaces) > 1 else 0
    return [element.surface_of(min(n, last)) for n in range(FACES)]
