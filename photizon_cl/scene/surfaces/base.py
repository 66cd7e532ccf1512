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
    absorbs: ClassVar[bool] = False
    """Whether it may take weight."""
    reflects: ClassVar[bool] = False
    """Whether light may turn back to the side that it came from."""
    transmits: ClassVar[bool] = False
    """Whether light may go on to the other side."""
    refracts: ClassVar[bool] = False
    """Whether it is the border of two media."""
    splits: ClassVar[bool] = False
    """Whether a ray goes on as two."""
    draws: ClassVar[bool] = False
    """Whether it draws random numbers."""
    carries_detector: ClassVar[bool] = False
    """Whether what arrives may be counted."""
    colour: ClassVar[str] = "#000000"
    """In drawings; safe for colour-blind readers (Okabe and Ito, Color Universal Design, 2008)."""
    label_text: ClassVar[str] = ""
    """In the legends of drawings."""

    def packed(self) -> tuple[float, ...]:
        """Return the device parameters, in the order that the kernel names them."""
        return ()

    @property
    def diffuse_reflectance(self) -> float | None:
        """Part of the power that leaves it with equal radiance everywhere, where all else ends."""
        return None

    def advice(self) -> list[str]:
        """Return what is valid and yet probably not meant, as what follows its element's name."""
        return []

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return derived quantities: name → (value, unit)."""
        return {}
