"""What all effects share.

An effect is a named piece of physics or bookkeeping that costs time on the device. A scene compiles
exactly the effects that it needs; forcing one on changes no other number: one with cells or rows of
its own adds those.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

from hostcode.program.parts import EffectParts
from photizon_cl.scene.rows import NO_ROW

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.compile.draft import Draft
    from photizon_cl.compile.layout import LedgerRow
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.rows import Row
    from photizon_cl.scene.settings import RunSettings

__all__ = ["Effect"]


class Effect(ABC):
    """One thing that a scene may need and another does without.

    `compile_scene` asks every effect in the order of the table, and knows none by name.
    """

    name: ClassVar[str]
    """A word."""
    what: ClassVar[str]
    """What it does, in one line."""
    costs: ClassVar[str]
    """What the device does more because of it, in one line."""
    in_text: ClassVar[bool] = False
    """Whether kernels ask for it by name (``"name" in effects``)."""
    removable: ClassVar[bool] = False
    """Whether a scene that needs it has the same numbers without it, but for those of its own."""

    row: ClassVar[Row] = NO_ROW
    """Columns that it adds to every element's row in the geometry table."""

    unit: ClassVar[str] = "W"
    """Unit of what its labelled cells show."""

    counted_as: ClassVar[str] = ""
    """What the summary calls the number of all that its cells counted; empty where nothing."""

    @abstractmethod
    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Return why a scene, run so, needs it, as a clause behind "because"; None where not."""

    def needed_within(self, scene: Scene, settings: RunSettings, roundoff: float) -> str | None:
        """Return the same for coordinates of some unit roundoff, where that makes a difference."""
        return self.needed(scene, settings)

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Return why a scene, run so, does without it, as a clause behind "because".

        Asked where `needed` gives None.
        """
        return "nothing in the scene calls for it"

    def possible(self, scene: Scene) -> bool:
        """Say whether it can be forced on in a scene that does not need it."""
        return True

    def serves(self, kind: type[Described]) -> bool:
        """Say whether a kind's kernel may ask for it, whatever the values of its objects are."""
        return False

    def rows(self, scene: Scene) -> tuple[LedgerRow, ...]:
        """Return the rows that it adds to the ledger."""
        return ()

    def cells(self, scene: Scene) -> tuple[int, ...]:
        """Return the shape of the cells that it brings to the tally; empty where it brings none.

        Their first one is the member ``<name>`` (with ``_`` for ``-``) of the launch structure.
        """
        return ()

    def labels(self, scene: Scene) -> tuple[str, ...]:
        """Return what each of its cells is, row-major, each different.

        The cells are then shown under its name wherever results are: summary, files, printed
        result, report. Empty where it brings none, or they are shown in a way of their own.
        """
        return ()

    def divides(self, scene: Scene) -> int:
        """Return into how many parts it divides every row of the ledger; 0 where it does not.

        The device then books the parts alone, and the host adds them up (`TallyLayout.part`).
        """
        return 0

    def scale(self, scene: Scene) -> float:
        """Return what a counted 1 stands for, in `unit` per watt: 1 where weights are counted.

        What a kernel counts at once must lie in 0 … 4 (`count_weights`). An effect that counts
        anything else than weights divides it by a bound of the scene, and gives that here.
        """
        return 1.0

    def advice(self, scene: Scene, counts: Sequence[int]) -> list[str]:
        """Return what a run's counts, one of each of its cells, give reason to say."""
        return []

    def heaviest(self, scene: Scene, settings: RunSettings) -> float:
        """Return what a ray weighs at most because of it; the heaviest launched one weighs 1.

        4 at most, which a tally holds (`count_weights` in kernels/lib/ledger.mako).
        """
        return 1.0

    def prepare(self, draft: Draft, *, forced: bool) -> None:  # noqa: B027 - most have nothing to do
        """Change how the scene is laid out, before the tables are made."""

    def packed(self, draft: Draft, number: int) -> dict[str, float]:
        """Return the values of those columns by name, for an element by its number."""
        return {}

    def parts(self, draft: Draft) -> EffectParts:
        """Return what it brings to the program."""
        return EffectParts()

    def assemble(self, draft: Draft) -> None:  # noqa: B027 - most have nothing to do
        """Add to the tables, once the elements' rows and codes are there."""
