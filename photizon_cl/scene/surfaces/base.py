"""What all surfaces share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from photizon_cl.scene.described import Described
from photizon_cl.scene.rows import NO_ROW, Row


@dataclass(frozen=True)
class Surface(Described):
    """The one optical property of an element: what a ray that hits it does."""

    label: ClassVar[str] = "surface"
    kind: ClassVar[str] = ""
    kernel: ClassVar[str] = ""
    does: ClassVar[str] = ""
    """What it does, in one line."""
    costs: ClassVar[str] = ""
    """What the device does more because of it, in one line."""
    row: ClassVar[Row] = NO_ROW
    """Columns of its row in the material table."""
    absorbs: ClassVar[bool] = True
    """Whether the element takes what does not go on; else everything goes on."""
    counts: ClassVar[bool] = True
    """Whether meeting it is an interaction; else a ray passes as if nothing were there."""
    splits: ClassVar[bool] = False
    """Whether a ray may go on as two."""

    def packed(self) -> dict[str, float]:
        """Return the values of its row's columns by name."""
        return {}

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return derived quantities: name → (value, unit)."""
        return {}
