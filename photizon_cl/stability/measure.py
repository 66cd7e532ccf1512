"""Runs cases through the kernels of the trace and counts their errors."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.program.precision import FP64, PRECISIONS
from hostcode.run.probe import LEFT_PLUS, NO_FACE, element_of, face_of, probe_faces
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.packing import code_of
from photizon_cl.scene.settings import RunSettings
from photizon_cl.stability.digits import DIGITS, add, load_digits, norm, vector
from photizon_cl.stability.oracle import FIRM, judge
from photizon_cl.stability.rounding import (
    ray_is_lost,
    rounded_case,
    rounded_elements,
    scene_of,
    start_is_lost,
    what_is_lost,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.scene.elements import Element
    from photizon_cl.stability.case import Case, Left
    from photizon_cl.stability.oracle import Candidate

__all__ = ["Measured", "compile_elements", "measure", "state_of"]


@dataclass(frozen=True)
class Measured:
    """A case's outcome.

    Parameters
    ----------
    label : str
        The case's.
    firm : bool
        Whether it had just one right answer.
    right : bool
        Whether the decision was among the right ones.
    errors : dict of str to float
        Errors in units of u·K by output; empty where there is nothing to compare.
    condition : float
        Largest K of its outputs relative to their size.
    note : str
        What went wrong, empty where nothing did.
    forward : float
        Relative error of the distance (of R for Fresnel) in unit roundoffs, whatever its condition.
    lost : str
        What of the case the precision cannot hold; then it was not asked.
    """

    label: str
    firm: bool
    right: bool
    errors: dict[str, float] = field(default_factory=dict)
    condition: float = 1.0
    note: str = ""
    forward: float = 0.0
    lost: str = ""

    @property
    def worst(self) -> float:
        """Largest error, 0 where there is none."""
        return max(self.errors.values(), default=0.0)


def compile_elements(elements: Sequence[Element], precision: str = FP64.name) -> CompiledScene:
    """Compile a scene of some elements, with a source that nobody uses."""
    return compile_scene(scene_of(elements), RunSettings(), precision=precision)


def state_of(compiled: CompiledScene, left: Left | None) -> int:
    """Return the packet's state of a ray that was reflected at a face, or that was launched."""
    if left is None:
        return NO_FACE
    code = code_of(compiled.tables, left.element)
    return (code | left.face << 16) << 2 | (LEFT_PLUS + 1) * left.plus


def measure(
    device: OpenDevice, cases: Iterable[Case], lanes: int = 1, precision: str = FP64.name
) -> list[Measured]:
    """Probe cases and compare them with the oracle; those of one scene go together.

    Parameters
    ----------
    device : OpenDevice
        Where.
    cases : iterable of Case
        What.
    lanes : int
        Lane width; changes no bit.
    precision : str
        In which mode. In single precision the cases are rounded to it first.
    """
    mode = PRECISIONS[precision]
    scenes: dict[tuple[Element, ...], list[Case]] = {}
    for case in cases:
        scenes.setdefault(case.elements, []).append(case)
    found = []
    for given, members in scenes.items():
        elements = given
        if mode.single:
            why = what_is_lost(given, mode.roundoff)
            if why:
                found += [Measured(c.label, firm=False, right=True, lost=why) for c in members]
                continue
            elements = rounded_elements(given)
        compiled = compile_elements(elements, precision)
        if mode.single:
            members = [rounded_case(c, elements, compiled.shift) for c in members]
        shift = np.array(compiled.shift)
        rays = np.array([[*np.subtract(c.origin, shift), *c.direction] for c in members])
        left = np.array([state_of(compiled, c.left) for c in members], np.int64)
        hits, states = probe_faces(device, compiled.tables, rays, lanes, left)
        hits[:, 1:4] += shift
        numbers, faces = element_of(states), face_of(states)
        for case, hit, n, face in zip(members, hits, numbers, faces, strict=True):
            one = _compare(case, hit, int(n), int(face), mode.roundoff)
            if mode.single and not (one.right and one.worst <= FIRM):
                why = ray_is_lost(case, mode.roundoff) or start_is_lost(case, mode.roundoff)
                if why:
                    one = Measured(case.label, firm=False, right=True, lost=why)
            found.append(one)
    return found


def _compare(
    case: Case, hit: NDArray[np.float64], element: int, face: int, unit: float
) -> Measured:
    mp = load_digits()
    with mp.workdps(DIGITS):
        verdict = judge(case, unit)
        if element < 0:
            right = verdict.may_miss and np.isinf(hit[0])
            note = "" if right else f"missed, not {_named(verdict.candidates)}"
            return Measured(case.label, verdict.firm, right, note=note)
        if np.isnan(hit).any():
            return Measured(case.label, verdict.firm, False, note="NaN")
        same = [c for c in verdict.candidates if (c.element, c.face) == (element, face)]
        # two faces may be one and the same surface: both caps of a whole ball
        others = [c for c in verdict.candidates if c.element == element and c not in same]
        same += [c for c in others if max(_errors(c, hit, unit)[0].values()) <= FIRM]
        if not same:
            note = f"hit {element}.{face} at {hit[0]:.17g}, not {_named(verdict.candidates)}"
            return Measured(case.label, verdict.firm, False, note=note)
        best = min(same, key=lambda c: abs(c.distance - mp.mpf(float(hit[0]))))
        if not best.smooth:
            return Measured(case.label, verdict.firm, True)
        errors, condition = _errors(best, hit, unit)
        off = abs(mp.mpf(float(hit[0])) - best.distance)
        forward = float(off / (unit * abs(best.distance))) if best.distance else 0.0
        return Measured(case.label, verdict.firm, True, errors, condition, forward=forward)


def _named(candidates: list[Candidate]) -> str:
    listed = [f"{c.element}.{c.face} at {float(c.distance):.17g}" for c in candidates]
    return " or ".join(listed) or "a miss"


def _errors(
    best: Candidate, hit: NDArray[np.float64], unit: float
) -> tuple[dict[str, float], float]:
    mpf = load_digits().mpf

    def ulps(error: Any, k: Any) -> float:
        return float(error / (unit * k)) if k else float(error > 0)

    errors = {
        "distance": ulps(abs(mpf(float(hit[0])) - best.distance), best.k_distance),
        "point": ulps(norm(add(vector(hit[1:4]), -1, best.point)), best.k_point),
        "normal": ulps(norm(add(vector(hit[4:7]), -1, best.normal)), best.k_normal),
    }
    relative = [best.k_normal]
    relative += [best.k_distance / abs(best.distance)] if best.distance else []
    return errors, float(max(relative))
