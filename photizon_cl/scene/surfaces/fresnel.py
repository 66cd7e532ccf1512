"""The smooth interface of two transparent media."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import ArgumentError, Problem, show
from photizon_cl.scene.declarations import refractive_index
from photizon_cl.scene.described import REQUIRED, parameters_of
from photizon_cl.scene.media.names import VACUUM, medium_name
from photizon_cl.scene.rows import Row
from photizon_cl.scene.scatters.base import scatter_problems
from photizon_cl.scene.surfaces.base import Surface, coated, scattering

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.coatings import Coating
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.scatters import Scatter

_BY_INDEX = ("index", "index_outside")
_BY_NAME = ("medium", "medium_outside")


@dataclass(frozen=True)
class Fresnel(Surface):
    """A smooth dielectric interface that splits every ray into both children.

    R is the mean of the two polarised Fresnel reflectances and T = 1 − R; where the run carries
    polarisation, that of the light that comes. The reflected child carries R of the weight, the
    transmitted one T, bent by Snell's law. Beyond the critical angle
    the reflected child keeps everything. Nothing is absorbed and no draw is made. The side that a
    ray comes from says which index it is in. Instead of two indices it takes the names of two
    media: rays then carry the medium that they are in, and lose weight on their way through it.
    With a `scatter` TIS(θ) of each child's weight is scattered about that child's direction. With a
    `coating` that says what R and T are, and 1 − R − T is absorbed.

    Parameters
    ----------
    index : float, optional
        Refractive index behind a flat element's normal, and inside a solid.
    index_outside : float, optional
        Refractive index on the side that the normal points to, 1 by default.
    medium : str, optional
        Instead: name of the medium behind a flat element's normal, and inside a solid.
    medium_outside : str, optional
        Name of the medium on the side that the normal points to, "vacuum" by default.
    scatter : Scatter, optional
        What of each child is scattered: dust, polishing marks.
    coating : Coating, optional
        What is reflected and passes instead.

    Notes
    -----
    Formulas: M. Born and E. Wolf, Principles of Optics, 7th edition, § 1.5.2 and 1.5.4. Both
    indices are real and from 0.001 to 1000.
    """

    kind: ClassVar[str] = "fresnel"
    kernel: ClassVar[str] = "fresnel"
    does: ClassVar[str] = "refraction and partial reflection"
    costs: ClassVar[str] = "two square roots and a division an interaction"
    row: ClassVar[Row] = Row(
        "FRESNEL",
        ("ratio_plus", "", "m = n₁/n₂ for a ray from the + side"),
        ("one_less_square_plus", "", "1 − m², without cancellation"),
        ("ratio_minus", "", "m for a ray from the − side"),
        ("one_less_square_minus", "", "1 − m², without cancellation"),
    )
    reflects: ClassVar[bool] = True
    transmits: ClassVar[bool] = True
    refracts: ClassVar[bool] = True
    splits: ClassVar[bool] = True
    colour: ClassVar[str] = "#56b4e9"
    label_text: ClassVar[str] = "glass"

    sample: ClassVar[Mapping[str, object]] = MappingProxyType({"index": 1.5168})
    usual: ClassVar[Mapping[str, object]] = MappingProxyType(
        {"index": REQUIRED, "index_outside": 1.0, "medium_outside": VACUUM}
    )
    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {**dict.fromkeys(_BY_INDEX, _BY_NAME), **dict.fromkeys(_BY_NAME, _BY_INDEX)}
    )

    index: float | None = field(
        default=None,
        metadata=refractive_index("index behind the normal, or inside the solid; or medium"),
    )
    index_outside: float | None = field(
        default=None, metadata=refractive_index("index on the normal's side")
    )
    medium: str | None = field(
        default=None,
        metadata=medium_name("instead of index: what is behind the normal, or inside the solid"),
    )
    medium_outside: str | None = field(
        default=None,
        metadata=medium_name("instead of index_outside: what is on the normal's side"),
    )

    scatter: Scatter | None = field(
        default=None, metadata=scattering("what of each child is scattered")
    )
    coating: Coating | None = field(
        default=None, metadata=coated("what is reflected and passes instead")
    )

    def __post_init__(self) -> None:
        """Check every value; outside is the vacuum where nothing is said."""
        super().__post_init__()
        if self.medium is not None and self.medium_outside is None:
            object.__setattr__(self, "medium_outside", VACUUM)
        if self.medium is None and self.index_outside is None:
            object.__setattr__(self, "index_outside", 1.0)

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """See that the inside is given, and by an index or a medium, as is the outside."""
        problems = scatter_problems(known, 1.0, "1", "more of a child would scatter than there is")
        return cls._sides_checked(known) + problems

    @classmethod
    def _sides_checked(cls, known: Known) -> list[Problem]:
        by_index, by_name = (
            [item for item in items if item not in known.values or known.get(item) is not None]
            for items in (_BY_INDEX, _BY_NAME)
        )  # one that was refused was given
        if by_index and by_name:
            hint = f"give indices or the names of media, and not {by_index[0]} beside {by_name[0]}"
            return [
                Problem(item, show(known.get(item)), f"nothing beside {by_index[0]}", hint=hint)
                for item in by_name
                if known.get(item) is not None
            ]
        if "index" in by_index or "medium" in by_name:
            return []
        if by_name:
            parameter, wanted = parameters_of(cls)["medium"], "medium"
        else:
            parameter, wanted = parameters_of(cls)["index"], "index"
        hint = f"the surface {cls.kind} requires the key {wanted}"
        hint += "" if by_name else ", or medium"
        return [Problem(wanted, "nothing", parameter.expected, hint=hint)]

    @property
    def media(self) -> tuple[str, str] | None:
        """Names of the media behind its normal and on the other side; None by indices."""
        if self.medium is None or self.medium_outside is None:
            return None
        return self.medium, self.medium_outside

    def among(self, index_of: Mapping[str, float]) -> Fresnel:
        """Return it with the indices of its media, by their names."""
        if self.media is None:
            return self
        inside, outside = (index_of[name] for name in self.media)
        return self.unchecked(index=inside, index_outside=outside, medium=None, medium_outside=None)

    def at(self, nm: float | None) -> Fresnel:
        """Return it with numbers in place of tables over wavelength, which a coating may have."""
        coating = self.coating.at(nm) if self.coating is not None else None
        return self if coating is self.coating else self.unchecked(coating=coating)

    @property
    def absorbs(self) -> bool:  # type: ignore[override]  # bare glass takes nothing
        """Whether the element takes what does not go on: what a coating absorbs."""
        return self.coating is not None

    @property
    def polarises(self) -> bool:  # type: ignore[override]  # unless its coating is alike for both
        """Whether it does another thing to light along s than to light along p."""
        return self.coating is None or self.coating.polarises

    def packed(self) -> dict[str, float]:
        """Return m = n₁/n₂ and 1 − m² from the + side, and from the − side.

        1 − m² = (n₂ − n₁)(n₂ + n₁)/n₂², with the difference of the indices taken before anything
        is rounded.
        """
        inside, outside = self._pair
        return {
            "ratio_plus": outside / inside,
            "one_less_square_plus": (inside - outside) * (inside + outside) / (inside * inside),
            "ratio_minus": inside / outside,
            "one_less_square_minus": (outside - inside) * (outside + inside) / (outside * outside),
        }

    @property
    def indices(self) -> tuple[float, float] | None:
        """Refractive indices behind its normal and on the other side; None by names of media."""
        if self.index is None or self.index_outside is None:
            return None
        return self.index, self.index_outside

    @property
    def _pair(self) -> tuple[float, float]:
        if self.indices is None:
            raise ArgumentError(
                f"found media {show(self.medium)} and {show(self.medium_outside)} by "
                "name, expected indices: they follow from the scene's media: scene.optics[surface]"
            )
        return self.indices

    @property
    def normal_reflectance(self) -> float:
        """Reflectance at normal incidence without a coating, ((n − n')/(n + n'))²."""
        inside, outside = self._pair
        ratio = (inside - outside) / (inside + outside)
        return ratio * ratio

    @property
    def critical_angle_deg(self) -> float | None:
        """Critical angle in degrees in the denser medium; None where the indices are equal."""
        low, high = sorted(self._pair)
        if low == high:
            return None
        return math.degrees(math.asin(low / high))

    def advice(self) -> list[str]:
        """Say where it is no border."""
        inside, outside = self._pair
        if inside != outside or self.scatter is not None or self.coating is not None:
            return []
        return ["has the same index on both sides: it reflects nothing and bends nothing"]

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return reflectance at normal incidence, critical angle, given indices; what scatters."""
        if self.indices is None:
            return self.scattered
        out: dict[str, tuple[float, str]] = {}
        if self.coating is None:
            out["reflectance at normal incidence"] = (self.normal_reflectance, "")
        if self.critical_angle_deg is not None:
            out["critical angle in the denser medium"] = (self.critical_angle_deg, "deg")
        return out | self.scattered
