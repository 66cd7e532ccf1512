"""A tree of boxes over many elements."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.compile.packing import codes_in_order
from photizon_cl.compile.tree_nodes import TREE_NODE, add_tree
from photizon_cl.geometry.tree import BREAK_EVEN, TREE_STACK, TREE_WIDTH

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class Acceleration(Effect):
    """The nearest hit is sought through a tree, one ray at a time."""

    name: ClassVar[str] = "acceleration"
    what: ClassVar[str] = "a tree of boxes over many elements"
    costs: ClassVar[str] = (
        "box tests instead of element tests; the plain scan is faster for few elements"
    )
    in_text: ClassVar[bool] = True
    removable: ClassVar[bool] = True

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """From a number of elements on."""
        n = len(scene.element)
        return f"{n} elements are more than {BREAK_EVEN - 1}" if n >= BREAK_EVEN else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return f"there are fewer than {BREAK_EVEN} elements: {len(scene.element)}"

    def possible(self, scene: Scene) -> bool:
        """Not without elements."""
        return bool(scene.element)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the search; packets then have one lane."""
        return EffectParts(
            templates=(("search", "effects/acceleration"),),
            one_by_one=True,
            parameters=(
                ("tree_node", TREE_NODE),
                ("tree_width", TREE_WIDTH),
                ("tree_stack", TREE_STACK),
            ),
        )

    def assemble(self, draft: Draft) -> None:
        """Put the tree behind the elements' rows, and the codes in the elements' order."""
        place, draft.geometry = add_tree(draft)
        draft.codes = codes_in_order(draft.element_codes, draft.material_of, draft.classes, place)
        draft.launch["material_of"] = len(draft.classes) + 1
