"""The parallel beam."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.faces import Circular, Plane
from photizon_cl.scene.parameters import positive_length
from photizon_cl.scene.rows import Row
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
    does: ClassVar[str] = "parallel rays from a disk"
    costs: ClassVar[str] = "one sine and cosine a ray"
    draws_position: ClassVar[bool] = True
    row: ClassVar[Row] = Row("COLLIMATED_DISK", ("radius", "m", "radius"))

    radius: float = field(metadata=positive_length("radius"))

    @property
    def face(self) -> Plane:
        """The disk that its rays start on."""
        return Plane(name="face", outline=Circular(self.radius))

    def packed(self) -> dict[str, float]:
        """Return the radius."""
        return {"radius": self.radius}

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
