"""What all surfaces share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from photizon_cl.scene.described import Described


@dataclass(frozen=True)
class Surface(Described):
    """The one optical property of an element: what a ray that hits it does."""

    label: ClassVar[str] = "surface"
    kind: ClassVar[str] = ""
    kernel: ClassVar[str] = ""
    splits: ClassVar[bool] = False
    """Whether a ray goes on as two."""

    def packed(self) -> tuple[float, ...]:
        """Return the device parameters, in the order that the kernel names them."""
        return ()

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return derived quantities: name → (value, unit)."""
        return {}
