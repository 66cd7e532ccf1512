"""Coatings: what a face reflects and lets pass is another thing than Fresnel's formulas say."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.compile.effects.face_surfaces import faced
from photizon_cl.scene.coatings import Coating
from photizon_cl.scene.coatings.base import HEAD

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

_NONE = -1
_PREFIX = "coating."


class Coatings(Effect):
    """Faces reflect and let pass what their coatings say."""

    name: ClassVar[str] = "coated-faces"
    what: ClassVar[str] = (
        "what a face reflects and lets pass, by angle and wavelength, is a coating's"
    )
    costs: ClassVar[str] = (
        "a look-up an interaction, and what the kinds of coatings take: a search of a table over "
        "angle, complex arithmetic for each layer of a stack"
    )

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where a surface has one, or a table over angle."""
        for element in scene.element:
            for surface in element.surfaces:
                if surface.coat is not None:
                    how = "coating" if hasattr(surface, "coating") else "reflectance over angle"
                    return f'the surface of "{element.name}" has a {how}'
        return None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "no surface has a coating, or a reflectance over angle"

    def possible(self, scene: Scene) -> bool:
        """Not without elements."""
        return bool(scene.element)

    def serves(self, kind: type[Described]) -> bool:
        """Where it is a coating."""
        return issubclass(kind, Coating)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the kernels of the coatings, and where it stands which face has which."""
        kinds = draft.coatings
        numbers = {f"{_PREFIX}{cls.kernel}": n for n, cls in enumerate(kinds)}
        places = HEAD.constants(0)
        for cls in kinds:
            places |= cls.reads.constants(0)
            if len(cls.reads):
                places[f"SIZE_OF_{cls.reads.name}"] = len(cls.reads)
        return EffectParts(
            coats=True,
            templates=(
                ("surfaces", "lib/coating"),
                *(("surfaces", f"coatings/{cls.kernel}") for cls in kinds),
                ("surfaces", "effects/coatings"),
            ),
            libraries=tuple(dict.fromkeys(name for cls in kinds for name in cls.libraries)),
            launch=(
                ("coatings", "ulong", "where in codes the coatings of elements or faces stand"),
                ("coating_head", "ulong", "where in codes it stands what one of them has"),
            ),
            parameters=(*numbers.items(), *places.items()),
        )

    def assemble(self, draft: Draft) -> None:
        """Put nodes and layers behind the geometry, and which face has which into the codes.

        Of each face the place of its coating's head, and in the lowest bit whether its element
        takes what does not go on.
        """
        assert draft.geometry is not None
        number = {cls: n for n, cls in enumerate(draft.coatings)}
        parts, end = [draft.geometry], len(draft.geometry)
        by_face = "material_of_face" in draft.launch  # of three faces each, see face_surfaces.py
        surfaces = [
            surface
            for element in draft.scene.element
            for surface in (faced(element) if by_face else element.surfaces)
        ]
        first = draft.add_codes([0] * len(HEAD))  # of what lanes without one read
        heads: dict[Coating, int] = {}
        for coat in dict.fromkeys(c for s in surfaces if (c := s.coat) is not None):
            nodes = np.ravel(np.asarray(coat.nodes, np.float64))
            head = {"kind": number[type(coat)], "nodes": end, "count": len(coat.nodes)}
            heads[coat] = draft.add_codes(map(int, HEAD.pack(head)))
            parts.append(nodes)
            end += len(nodes)
        found = []
        for surface in surfaces:
            own = surface.coat
            takes = surface.absorbs if own is None else not own.lossless
            found.append((_NONE if own is None else heads[own]) << 1 | int(takes))
        draft.launch["coatings"] = draft.add_codes(found or [_NONE << 1])
        draft.launch["coating_head"] = min(heads.values(), default=first)
        draft.geometry = np.concatenate(parts)
