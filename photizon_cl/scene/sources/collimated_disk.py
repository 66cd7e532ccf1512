"""The parallel beam."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.declarations import number, positive_length
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.frames import sincos_deg
from photizon_cl.scene.outlines import Circular
from photizon_cl.scene.rows import Row
from photizon_cl.scene.sources.base import DirectedSource, circle_area


@dataclass(frozen=True, kw_only=True)
class CollimatedDisk(DirectedSource):
    """A beam along +w that starts on a disk, uniform by area; parallel unless it diverges.

    A tilt turns the disk with its beam, so the irradiance across the beam stays Φ/πr².

    Parameters
    ----------
    radius : float
        r in metres.
    divergence_deg : float, optional
        δ in degrees, from 0 up to but not including 90. Above 0 every point of the disk sends
        uniform radiance into a cone of this half-angle about the axis, so that power goes as cos θ
        within it: the sun has 0.2665.
    """

    kind: ClassVar[str] = "collimated-disk"
    kernel: ClassVar[str] = "collimated_disk"
    does: ClassVar[str] = "parallel rays from a disk"
    costs: ClassVar[str] = "one sine and cosine a ray"
    draws_position: ClassVar[bool] = True
    is_beam: ClassVar[bool] = True
    row: ClassVar[Row] = Row(
        "COLLIMATED_DISK",
        ("radius", "m", "radius"),
        ("sine", "", "of the divergence"),
    )

    radius: float = field(metadata=positive_length("radius"))
    divergence_deg: float = field(
        default=0.0,
        metadata=number(
            "an angle from 0 up to but not including 90 degrees", 0.0, 90.0,
            "half-angle of the cone that each point fills", "deg", open_high=True,
        ),
    )  # fmt: skip

    @property
    def option(self) -> str:
        """``diverging`` where it is not parallel."""
        return "diverging" if self.divergence_deg else ""

    @property
    def face(self) -> Plane:
        """The disk that its rays start on."""
        return Plane(name="face", outline=Circular(self.radius))

    def packed(self) -> dict[str, float]:
        """Return the radius and the sine of the divergence."""
        return {"radius": self.radius, "sine": sincos_deg(self.divergence_deg)[0]}

    @property
    def area(self) -> float:
        """Cross-section of the beam πr² in m²."""
        return circle_area(self.radius)

    @property
    def beam_area(self) -> float:
        """Cross-section of the beam where it starts, with a divergence too, in m²."""
        return self.area

    @property
    def irradiance(self) -> float:
        """Irradiance across the beam, Φ/πr², in W/m²."""
        return self.flux / self.area

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the beam's area and irradiance."""
        return {"beam area": (self.area, "m²"), "irradiance": (self.irradiance, "W/m²")}
