"""Whether a cost study finds faults that were planted: ``python -m benchmarks.planted``.

Each fault is one setting of a study more, whose kernels are broken at a named point or whose scene
is; beside it runs the engine as it is. The study must say "biased" of the fault (more than four
standard errors of its own) and of nothing else. Exit status 1 where it does not.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

from benchmarks.report import Report
from hostcode import templates
from hostcode.program import build
from photizon_cl.compile import compiled
from photizon_cl.scene.files import load
from photizon_cl.studies import trial
from photizon_cl.studies.costing import Study
from photizon_cl.studies.knobs import Option

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from photizon_cl.scene.model import Scene
    from photizon_cl.studies.trial import Trial


@dataclass(frozen=True)
class Fault:
    """A fault: the scene, what of its settings or kernels is wrong, and how large that is."""

    name: str
    scene: str
    quantity: str
    points: Mapping[str, str]
    run: Mapping[str, Any]
    healthy: Mapping[str, Any]
    """Settings of a row beside it that must not be found."""
    longer: float = 1.0
    """Times the seconds of the others."""
    away: float = 0.0
    """Metres that everything is moved by along x; the fault is then that nothing is recentred."""
    precision: str = "fp64"


REFLECTANCE = "weight_number(material, LAMBERTIAN_REFLECTANCE)"
FAULTS = (
    Fault(
        "weight that survives a matt wall 0.1 % too large",
        "integrating-sphere",
        "ledger.escaped",
        {"lambertian.weight": f"WT(1.001) * p->w * {REFLECTANCE}"},
        {},
        {},
    ),
    Fault(
        # against the scene without roulette, whose noise it does not share
        "weight that survives roulette 0.1 % too small",
        "integrating-sphere",
        "ledger.escaped",
        {"roulette.weight": "WT(0.999) * (p->w + p->w)"},
        {"roulette_floor": 0.9},
        {"roulette_floor": 0.9},
        3.0,
    ),
    Fault(
        "a Fresnel reflectance 0.001 too large",
        "plano-convex-condenser",
        "detectors.focus.power",
        {"fresnel.reflectance": "(R(0.5) * fma(rs, rs, rp * rp) + R(0.001))"},
        {},
        {},
    ),
    Fault(
        "a generation cap of 60 in a sphere that needs hundreds",
        "integrating-sphere",
        "ledger.escaped",
        {},
        {"generation_cap": 60},
        {"generation_cap": 2000},
    ),
    Fault(
        "single precision 10^6 m from the origin, not recentred",
        "box-room",
        "detectors.floor.power",
        {},
        {},
        {},
        away=1e6,
        precision="fp32",
    ),
)


class _Broken(Study):
    """A study in which one setting's kernels are broken."""

    fault: Fault

    def _opened(self, option: Option) -> Trial:
        if option.knob != "planted":
            return super()._opened(option)
        with ExitStack() as stack:
            put = stack.enter_context
            put(patch.object(templates, "MUTATIONS", dict(self.fault.points)))
            put(patch.object(build, "_CACHE", {}))
            if self.fault.away:
                put(patch.object(compiled, "recentre", lambda _: (0.0, 0.0, 0.0)))
                # which would refuse it
                put(patch.object(trial, "fitting_mode", lambda *_: None))
            return super()._opened(option)


def _with(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, **changes))


def _moved(scene: Scene, by: float) -> Scene:
    def away(thing: Any) -> Any:
        x, y, z = thing.position
        return dataclasses.replace(thing, position=(x + by, y, z))

    return dataclasses.replace(
        scene, source=tuple(map(away, scene.source)), element=tuple(map(away, scene.element))
    )


def study_of(fault: Fault, seconds: float) -> Any:
    """Return the study of a fault: the scene as it is, the fault, and a healthy row beside it."""

    def knob(scene: Scene, cap: int) -> Iterator[Option]:
        broken = _with(scene, fault.run)
        yield Option("planted", "planted", "", "", broken, precision=fault.precision)
        if fault.healthy:
            yield Option("healthy", "healthy", "", "", _with(scene, fault.healthy))

    scene = _with(_moved(load(fault.scene), fault.away), {"max_seconds": fault.longer * seconds})
    study = _Broken(scene, fault.quantity, None, lambda _: None, (knob,))
    study.fault = fault
    return study.run()


def main(argv: list[str] | None = None) -> int:
    """Run every study; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0, help="of each study; default 20")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    args = parser.parse_args(argv)
    report = Report()
    report.say(f"{'fault':52s} {'bias':>11s} {'± σ':>9s} {'σ away':>8s}  found", "")
    good, rows = True, []
    for fault in FAULTS:
        found = study_of(fault, args.seconds)
        for name in ("planted", "healthy"):
            row = next((row for row in found if row.name == name), None)
            if row is None:
                good &= not (name == "planted" or fault.healthy)
                continue
            right = row.is_biased == (name == "planted")
            good &= right
            away = abs(row.bias) / row.bias_sigma if row.bias_sigma else float("inf")
            report.say(
                f"{fault.name if name == 'planted' else '  the same without the fault':52s} "
                f"{row.bias:11.3e} {row.bias_sigma:9.1e} {min(away, 9e9):8.1f}  "
                f"{'yes' if row.is_biased else 'no'}{'' if right else '  WRONG'}"
            )
            rows.append({"fault": fault.name, **row.summary()})
    report.say("", "every fault was found, and nothing else" if good else "NOT as it should be")
    if args.out:
        report.write(args.out, "planted", {"seconds": args.seconds, "rows": rows})
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
