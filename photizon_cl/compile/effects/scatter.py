"""Scatter: a part of what surfaces send on goes aside."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.compile.effects.face_surfaces import faced
from photizon_cl.scene.scatters import Scatter as Model
from photizon_cl.scene.scatters.base import HEAD

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

_NONE = -1


class Scatter(Effect):
    """A share of each ray is scattered about the direction in which its surface sends it on."""

    name: ClassVar[str] = "scattering"
    what: ClassVar[str] = "a part of what a surface sends on, or takes, is scattered by a BSDF"
    costs: ClassVar[str] = (
        "a polynomial for the share, one random block or more for the direction, a queue write "
        "where both parts are followed"
    )

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where a surface scatters about its specular rays."""
        for element in scene.element:
            for surface in element.surfaces:
                if surface.lobe is not None:
                    return f'the surface of "{element.name}" has a scatter'
        return None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "no surface has a scatter"

    def possible(self, scene: Scene) -> bool:
        """Not without elements."""
        return bool(scene.element)

    def serves(self, kind: type[Described]) -> bool:
        """Where it is a model."""
        return issubclass(kind, Model)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the lobes' kernels, and how many rays go on beside two."""
        models = draft.scatters
        numbers = {f"scatter.{cls.kernel}": n for n, cls in enumerate(models)}
        places = HEAD.constants(0)
        for cls in models:
            places |= cls.row.constants(0)
        lobes = [s for e in draft.scene.element for s in e.surfaces if s.lobe is not None]
        of_second = any(s.splits for s in lobes)
        call = "scatter(launch, scene, p, h, c, ledger, element, found, takes, &outcome);"
        return EffectParts(
            extras=2 if of_second else int(any(s.branches for s in lobes)),
            templates=(
                ("survive", "lib/scatter"),
                *(("survive", f"scatters/{cls.kernel}") for cls in models),
                ("survive", "effects/scatter"),
            ),
            libraries=tuple(
                dict.fromkeys(("lib/powers", *(name for cls in models for name in cls.libraries)))
            ),
            hooks=(("surface", call),),
            launch=(
                ("scatter", "ulong", "where in codes the lobes of elements or their faces stand"),
                ("scatter_heads", "ulong", "where in codes it stands what the lobes have"),
                ("scatter_steps", "ulong", "the power of two from which TIS is searched"),
            ),
            parameters=(*numbers.items(), *places.items()),
        )

    def assemble(self, draft: Draft) -> None:
        """Put the models' numbers behind the geometry, and which face has which into the codes."""
        assert draft.geometry is not None
        number = {cls: n for n, cls in enumerate(draft.scatters)}
        parts, end, most = [draft.geometry], len(draft.geometry), 1

        def put(values: np.ndarray | list[float] | list[list[float]]) -> int:
            nonlocal end
            parts.append(np.ravel(np.asarray(values, np.float64)))
            end += len(parts[-1])
            return end - len(parts[-1])

        by_face = "material_of_face" in draft.launch  # of three faces each, see face_surfaces.py
        surfaces = [
            surface
            for element in draft.scene.element
            for surface in (faced(element) if by_face else element.surfaces)
        ]
        heads: dict[Model, int] = {}
        first = draft.add_codes([0] * len(HEAD))  # of what lanes without a lobe read
        for model in dict.fromkeys(s.lobe for s in surfaces if s.lobe is not None):
            pieces = model.pieces
            terms = np.column_stack((2.0 / np.diff(pieces.edges), pieces.terms))
            most = max(most, len(terms))
            head = {
                "model": number[type(model)],
                "row": put(model.row.pack(model.packed())),
                "pieces": len(terms),
                "edges": put(pieces.edges[:-1]),
                "term_place": put(terms),
                "nodes": put(model.nodes),
                "node_count": len(model.nodes),
            }
            heads[model] = draft.add_codes(map(int, HEAD.pack(head)))
        found = [
            heads[s.lobe] << 1 | int(s.splits) if s.lobe is not None else _NONE for s in surfaces
        ]
        draft.launch["scatter"] = draft.add_codes(found or [_NONE])
        draft.launch["scatter_heads"] = min(heads.values(), default=first)
        draft.launch["scatter_steps"] = 1 << max((most - 1).bit_length() - 1, 0)
        draft.geometry = np.concatenate(parts)
