"""Hard cases of reflection and refraction, through one interaction of the trace."""

from __future__ import annotations

import dataclasses
import math
import random
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program.precision import FP64, PRECISIONS
from hostcode.run.probe import follow_rays
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.surfaces.fresnel import Fresnel
from photizon_cl.stability.digits import (
    DIGITS,
    Vector,
    add,
    load_digits,
    norm,
    scaled,
    vector,
)
from photizon_cl.stability.measure import Measured, compile_elements
from photizon_cl.stability.oracle import FIRM
from photizon_cl.stability.rounding import single

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from hostcode.device.device import OpenDevice

__all__ = ["FresnelCase", "fresnel_cases", "measure_fresnel"]

_STEP: Final = 1e-25
_PAIRS: Final = (
    (1.0, 1.5),
    (1.5, 1.0),
    (1.0, 1.0 + 1e-12),
    (1.0 + 1e-12, 1.0),
    (1.5, 1.5 * (1 + 1e-9)),
    (4.0, 1.0),
    (1.0, 4.0),
    (1.7, 1.3),
    (1.0, 1.0),
)
"""Indices on the side of incidence and behind."""


@dataclass(frozen=True)
class FresnelCase:
    """A ray at the middle of a plate across z.

    Parameters
    ----------
    label : str
        What is hard about it.
    outside, inside : float
        Indices on the side of the normal and behind it.
    direction : tuple of float
        Unit up to rounding; d_z < 0 comes from outside.
    """

    label: str
    outside: float
    inside: float
    direction: tuple[float, float, float]


def fresnel_cases() -> Iterator[FresnelCase]:
    """Return rays at normal and grazing incidence, Brewster's angle, the critical angle."""
    r = random.Random(51)
    for first, second in _PAIRS:
        cosines = [
            ("normal", 1.0),
            ("nearly normal", 1 - 1e-12),
            ("45 deg", math.sqrt(0.5)),
            ("Brewster", first / math.hypot(first, second)),
        ]
        cosines += [(f"grazing {c:g}", c) for c in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15)]
        if first > second:
            with load_digits().workdps(DIGITS):
                for off in (0.0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-6, -1e-6):
                    angle = load_digits().asin(load_digits().mpf(second) / first) * (1 + off)
                    cosines.append((f"critical angle {off:+g}", float(load_digits().cos(angle))))
        for name, cosine in cosines:
            for from_outside in (True, False):
                phi = r.uniform(0, 2 * math.pi)
                sine = math.sqrt((1 - cosine) * (1 + cosine))
                z = -cosine if from_outside else cosine
                outside, inside = (first, second) if from_outside else (second, first)
                label = f"{name}, {first:.13g} to {second:.13g}"
                yield FresnelCase(
                    label, outside, inside, (sine * math.cos(phi), sine * math.sin(phi), z)
                )


def _exact(x: Vector) -> tuple[Any, Any, Any, Vector, Vector]:
    """Return cos² of refraction, R, T and the reflected and refracted directions.

    x holds the indices before and behind, and the direction.
    """
    mp = load_digits()
    n1, n2 = x[0], x[1]
    d = scaled(1 / norm(x[2:5]), x[2:5])
    cosine = abs(d[2])
    m = n1 / n2
    square = 1 - m * m * (1 - cosine * cosine)
    reflected = [d[0], d[1], -d[2]]
    if square <= 0:
        return square, mp.mpf(1), mp.mpf(0), reflected, reflected
    ct = mp.sqrt(square)
    rs = (n1 * cosine - n2 * ct) / (n1 * cosine + n2 * ct)
    rp = (n1 * ct - n2 * cosine) / (n1 * ct + n2 * cosine)
    reflectance = (rs * rs + rp * rp) / 2
    refracted = [m * d[0], m * d[1], ct if d[2] > 0 else -ct]
    return square, reflectance, 1 - reflectance, reflected, refracted


def _compare(case: FresnelCase, outcome: dict[str, Any], unit: float) -> Measured:
    mp = load_digits()
    pair = (case.outside, case.inside) if case.direction[2] < 0 else (case.inside, case.outside)
    x = [*vector(pair), *vector(case.direction)]
    square, r, t, reflected, refracted = _exact(x)
    k_square, k_r, k_d, k_f = abs(square), abs(r), mp.mpf(1), mp.mpf(1)
    for i, value in enumerate(x):
        if value == 0:
            continue
        step = abs(value) * mp.mpf(_STEP)
        moved = list(x)
        moved[i] = value + step
        square_, r_, _, reflected_, refracted_ = _exact(moved)
        # one moved input changes it by this for a relative step of 1
        size = abs(value) / step
        k_square += abs(square_ - square) * size
        k_r += abs(r_ - r) * size
        k_d += norm(add(reflected_, -1, reflected)) * size
        k_f += norm(add(refracted_, -1, refracted)) * size
    firm = bool(abs(square) > FIRM * unit * k_square)
    total = outcome["transmitted"] is None
    if total != bool(square <= 0) and not (r == 1 or r == 0):
        note = "" if not firm else f"total reflection {total}, cos² = {float(square):g}"
        return Measured(case.label, firm, not firm, note=note)
    if not firm:
        return Measured(case.label, firm, True)

    def ulps(error: Any, k: Any) -> float:
        return float(error / (unit * k)) if k else float(error > 0)

    mpf = mp.mpf
    errors = {"R": ulps(abs(mpf(float(outcome["R"])) - r), k_r)}
    # the transmitted weight is what the reflected one leaves of 1: its unit is the weight's
    errors["T"] = ulps(abs(mpf(float(outcome["T"])) - t), k_r + 1)
    if outcome["reflected"] is not None:
        errors["reflected"] = ulps(norm(add(vector(outcome["reflected"]), -1, reflected)), k_d)
    if not total:
        errors["refracted"] = ulps(norm(add(vector(outcome["transmitted"]), -1, refracted)), k_f)
    nan = any(math.isnan(e) for e in errors.values())
    relative = float(max(k_r / r if r > mpf(10) ** -50 else mpf(1), k_f))
    off = abs(mpf(float(outcome["R"])) - r)
    forward = float(off / (unit * r)) if r > mpf(10) ** -50 else 0.0
    return Measured(case.label, firm, not nan, errors, relative, "NaN" if nan else "", forward)


def measure_fresnel(
    device: OpenDevice,
    cases: Sequence[FresnelCase] | None = None,
    precision: str = FP64.name,
) -> list[Measured]:
    """Send rays through plates and compare weights and directions with the oracle.

    Parameters
    ----------
    device : OpenDevice
        Where.
    cases : sequence of FresnelCase, optional
        Default `fresnel_cases`.
    precision : str
        In which mode. In single precision directions are rounded to it first; indices are not, as
        the host takes their differences in double precision.
    """
    mode = PRECISIONS[precision]
    plates: dict[tuple[float, float], list[FresnelCase]] = {}
    for given in cases if cases is not None else fresnel_cases():
        case = given
        if mode.single:
            x, y, z = map(single, given.direction)
            case = dataclasses.replace(given, direction=(x, y, z))
        plates.setdefault((case.outside, case.inside), []).append(case)
    found = []
    for (outside, inside), members in plates.items():
        plate = Rectangle(
            name="plate",
            position=(0.0, 0.0, 0.0),
            axis="+z",
            half_width=2.0,
            half_height=2.0,
            surface=Fresnel(index=inside, index_outside=outside),
        )
        compiled = compile_elements((plate,), precision)
        directions = np.array([case.direction for case in members])
        followed = follow_rays(device, compiled.tables, np.hstack([-directions, directions]), 1)
        for n, case in enumerate(members):
            weight, other = followed.weight[n, 0], followed.other_weight[n, 0]
            along = followed.direction[n, 0]
            through = along[2] * case.direction[2] > 0
            outcome = {
                "R": other if through else weight,
                "T": weight if through else 0.0,
                "reflected": (followed.other_direction[n, 0] if other else None)
                if through
                else along,
                "transmitted": along if through else None,
            }
            height, bound = abs(case.direction[2]), FIRM * mode.roundoff * 3.0
            if mode.single and height < bound:
                why = f"a ray starts {height:.1e} m off a face, within {bound:.1e} m of rounding"
                found.append(Measured(case.label, firm=False, right=True, lost=why))
                continue
            with load_digits().workdps(DIGITS):
                found.append(_compare(case, outcome, mode.roundoff))
    return found
