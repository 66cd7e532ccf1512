"""A stack of thin films."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple

import numpy as np

from photizon_cl.errors import ArgumentError, Problem, show
from photizon_cl.scene.coatings.base import Coating, meeting
from photizon_cl.scene.curves import wavelength
from photizon_cl.scene.declarations import declare, number, refractive_index
from photizon_cl.scene.described import REQUIRED, Accepts, Described
from photizon_cl.scene.parameters import BAD, Parameter
from photizon_cl.scene.rows import Row
from photizon_cl.scene.whole import read_whole

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from photizon_cl.scene.coatings.base import Array, Meeting

    Waves = NDArray[np.complex128]

__all__ = ["Amplitudes", "Layer", "StackCoating"]

MOST_LAYERS: Final = 1000
_ACTS: Final = 1e-3
"""Part of a wavelength that a film is thick, below which it does next to nothing."""
THICKEST_NM: Final = 1e6
"""A millimetre: what is thicker than the light is coherent is a body of its own."""


@dataclass(frozen=True)
class Layer(Described):
    """One film of a stack.

    Parameters
    ----------
    index : float
        Refractive index n, from 0.001 to 1000.
    thickness_nm : float
        Thickness in nanometres, from 0 to 1e6.
    extinction : float, optional
        Extinction coefficient κ of the complex index n + iκ, from 0 to 1000: a wave falls by
        exp(−2πκ z/λ).
    """

    label: ClassVar[str] = "layer"
    one_value: ClassVar[bool] = True

    index: float = field(metadata=refractive_index("refractive index"))
    thickness_nm: float = field(
        metadata=number(
            "a thickness in nanometres, from 0 to 1e6", 0.0, THICKEST_NM, "thickness", "nm"
        )
    )
    extinction: float = field(
        default=0.0,
        metadata=number(
            "an extinction coefficient, a number from 0 to 1000", 0.0, 1e3, "extinction coefficient"
        ),
    )

    def __str__(self) -> str:
        lost = f" + {self.extinction:.9g}i" if self.extinction else ""
        return f"{self.thickness_nm:.9g} nm of {self.index:.9g}{lost}"


class Layers(Parameter):
    """Layers in order, read as a tuple."""

    needs_spectrum = True
    member = Layer
    """What stands in the list, for the paths of parameters."""

    @property
    def expected(self) -> str:
        return (
            f"a list of 1 to {MOST_LAYERS} layers, from outside to inside: "
            "{ index, extinction = 0, thickness_nm }"
        )

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:
        if isinstance(value, str | bytes) or not isinstance(value, Sequence):
            return self.refuse(value, path, problems, "write them in brackets")
        if not 1 <= len(value) <= MOST_LAYERS:
            hint = "without a layer it is no coating: leave the coating out" if not value else ""
            problems.append(Problem(path, f"{len(value)} layers", self.expected, hint=hint))
            return BAD
        found = [self._layer(item, f"{path}[{i}]", problems) for i, item in enumerate(value)]
        return BAD if any(item is BAD for item in found) else tuple(found)

    def _layer(self, value: object, path: str, problems: list[Problem]) -> Any:
        if isinstance(value, Layer):
            return value
        if isinstance(value, Mapping):
            return read_whole(Layer, value, path, problems, "a layer")
        problems.append(Problem(path, show(value), "a layer: { index, thickness_nm }"))
        return BAD


class Amplitudes(NamedTuple):
    """Complex amplitudes of the electric field, for e^(−iωt); |t|² is a transmittance.

    What is transmitted is multiplied by the root of the ratio of the two sides' admittances, so
    that no factor is left between |t|² and a part of the power; both are 0 beyond the critical
    angle. r_p is positive where the reflected field points as in Born and Wolf (1.5.2).
    """

    r_s: Waves
    r_p: Waves
    t_s: Waves
    t_p: Waves


@dataclass(frozen=True)
class StackCoating(Coating):
    """Thin films on one another, each with an index, an extinction and a thickness.

    Reflectance and transmittance are those of plane waves that interfere in the films, by the
    characteristic matrices of the layers: of unpolarised light the means of s and p, and where the
    run carries polarisation both amplitudes of the ray's own. They depend
    on wavelength, so that the scene needs ``[spectrum]``. What the layers absorb is absorbed by the
    element; a stack without extinction absorbs exactly nothing. Beyond the critical angle T is 0,
    and all that the layers leave is reflected.

    Parameters
    ----------
    layers : sequence of Layer
        1 to 1000 of them from outside, where the normal points, to inside.

    Notes
    -----
    Formulas: M. Born and E. Wolf, Principles of Optics, 7th edition, § 1.6.2; H. A. Macleod,
    Thin-Film Optical Filters, 4th edition, § 2.7. Indices of layers do not depend on wavelength.
    """

    kind: ClassVar[str] = "stack"
    kernel: ClassVar[str] = "stack"
    does: ClassVar[str] = "interference in thin films"
    polarises: ClassVar[bool] = True
    costs: ClassVar[str] = (
        "for each layer a complex root, a sine, a cosine and four complex products an interaction, "
        "and an exponential where a wave decays"
    )
    libraries: ClassVar[tuple[str, ...]] = ("lib/powers",)
    row: ClassVar[Row] = Row(
        "STACK_COATING",
        ("nm", "nm", "wavelength"),
        ("outside", "", "index on the normal's side"),
        ("inside", "", "index on the other side"),
    )
    reads: ClassVar[Row] = Row(
        "LAYER",
        ("index", "", "n"),
        ("extinction", "", "kappa"),
        ("thickness", "nm", "d"),
        ("inverse", "", "real part of 1/(n + i kappa)^2"),
        ("inverse_imaginary", "", "its imaginary part"),
    )
    sample: ClassVar[Mapping[str, object]] = MappingProxyType(
        {"layers": ({"index": 1.38, "thickness_nm": 99.6},)}
    )

    layers: Accepts[Sequence[Layer], tuple[Layer, ...]] = field(
        default=REQUIRED, metadata=declare(Layers("from outside to inside"))
    )

    @property
    def lossless(self) -> bool:
        """Whether no layer has an extinction."""
        return not any(layer.extinction for layer in self.layers)

    def packed(self, indices: tuple[float, float], nm: float | None) -> dict[str, float]:
        """Return wavelength and indices."""
        inside, outside = indices
        return {"nm": _given(nm), "outside": outside, "inside": inside}

    @property
    def nodes(self) -> list[list[float]]:
        """Of each layer n, κ, d in nm, and 1/(n + iκ)²."""
        rows = []
        for layer in self.layers:
            inverse = 1.0 / complex(layer.index, layer.extinction) ** 2
            rows.append(
                [layer.index, layer.extinction, layer.thickness_nm, inverse.real, inverse.imag]
            )
        return rows

    def amplitudes(
        self,
        angle_deg: ArrayLike,
        index: float,
        index_outside: float = 1.0,
        *,
        nm: float,
        inside: bool = False,
    ) -> Amplitudes:
        """Return the complex amplitudes of reflected and transmitted light, see `powers`.

        Raises
        ------
        ArgumentError
            Where an angle is none.
        """
        return self._amplitudes(meeting(angle_deg, index, index_outside, inside=inside), nm)

    def parts(self, met: Meeting, nm: float | None) -> tuple[Array, Array]:
        """Return reflectance and transmittance."""
        r_s, r_p, t_s, t_p = (abs(wave) ** 2 for wave in self._amplitudes(met, _given(nm)))
        r, t = 0.5 * (r_s + r_p), 0.5 * (t_s + t_p)
        if self.lossless:  # of the two the smaller one is known the better
            small = r < t
            r, t = np.where(small, r, 1.0 - t), np.where(small, 1.0 - r, t)
        return r, t

    def _amplitudes(self, met: Meeting, nm: float) -> Amplitudes:
        along = met.before * met.sine
        cosine: Waves = np.sqrt(np.asarray(met.square, np.complex128))  # i times its size beyond
        reflected: list[Waves] = []
        transmitted: list[Waves] = []
        for p in (False, True):
            near = met.cosine / met.before if p else met.before * met.cosine
            far: Waves = cosine / met.behind if p else met.behind * cosine
            h = far
            e: Waves = np.ones_like(far, dtype=np.complex128)
            passed = np.ones_like(along)
            layers = self.layers if met.inside else self.layers[::-1]
            for layer in layers:
                n = complex(layer.index, layer.extinction)
                q = np.sqrt(n * n - along * along)
                phase = 2.0 * np.pi * layer.thickness_nm / nm * q
                decay = np.exp(-phase.imag)
                c, s = np.cos(phase.real), np.sin(phase.real)
                up, down = 0.5 * (1.0 + decay * decay), -0.5 * np.expm1(-2.0 * phase.imag)
                cos, sin = c * up - 1j * s * down, s * up + 1j * c * down
                admittance = q / (n * n) if p else q
                with np.errstate(divide="ignore", invalid="ignore"):
                    over = np.where(
                        q == 0.0,
                        2.0 * np.pi * layer.thickness_nm / nm * (n * n if p else 1.0),
                        sin / admittance,
                    )
                e, h = cos * e - 1j * over * h, cos * h - 1j * admittance * sin * e
                size = abs(e) + abs(h)
                e, h, passed = e / size, h / size, passed * decay / size
            total = near * e + h
            reflected.append((near * e - h) / total)
            share = np.sqrt(np.where(met.square > 0.0, near * far.real, 0.0))
            transmitted.append(2.0 * share * passed / total)
        return Amplitudes(reflected[0], reflected[1], transmitted[0], transmitted[1])

    def waves(self, nm: float) -> float:
        """Return how many wavelengths of its own light it is thick."""
        return sum(y.index * y.thickness_nm for y in self.layers) / nm

    def idle(self, nm: float) -> tuple[str, float] | None:
        """Return the first layer that is given a thickness, and one far below a wavelength."""
        for n, y in enumerate(self.layers):
            if 0.0 < math.hypot(y.index, y.extinction) * y.thickness_nm < _ACTS * nm:
                return f"layers[{n}]", y.thickness_nm
        return None

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the thickness of all layers together."""
        return {"thickness of the stack": (sum(y.thickness_nm for y in self.layers), "nm")}


def _given(nm: float | None) -> float:
    if nm is None:
        raise ArgumentError(
            "nm: found no wavelength, expected one in nanometres, as a stack depends on it"
        )
    return wavelength(nm, "nm")
