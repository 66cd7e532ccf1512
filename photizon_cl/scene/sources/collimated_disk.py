"""The parallel beam."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.parameters import positive_length
from photizon_cl.scene.sources.base import DirectedSource, circle_area


@dataclass(frozen=True, kw_only=True)
class CollimatedDisk(DirectedSource):
    """A beam of parallel rays along +w that starts on a disk, uniform by area.

    A tilt turns the disk with its beam, so the irradiance across the beam stays Φ/πr².

    Parameters
    ----------
    radius : float
        r in metres.
    """

    kind: ClassVar[str] = "collimated-disk"
    kernel: ClassVar[str] = "collimated_disk"

    radius: float = field(metadata=positive_length("radius"))

    def packed(self) -> tuple[float, ...]:
        """Return ``(radius,)``."""
        return (self.radius,)

    @property
    def area(self) -> float:
        """Cross-section of the beam πr² in m²."""
        return circle_area(self.radius)

    @property
    def irradiance(self) -> float:
        """Irradiance across the beam, Φ/πr², in W/m²."""
        return self.flux / self.area

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the beam's area and irradiance."""
        return {"beam area": (self.area, "m²"), "irradiance": (self.irradiance, "W/m²")}
