"""Timings of one device: where the default's time goes, and which plan is the fastest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import pyopencl as cl

from benchmarks import cells
from benchmarks.report import Spread, table
from benchmarks.runner import Runner, compiled_preset, kernel_seconds
from hostcode.device.device import open_device
from hostcode.errors import HostError

if TYPE_CHECKING:
    from benchmarks.gpu_session import Session
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.compile.compiled import CompiledScene


def kernels(session: Session) -> None:
    """Say where the default's time goes, by kernel and outside kernels."""
    device = open_device(session.device.record, profiling=True)
    session.report.heading("Where the default plan's time goes")
    session.data["kernels"] = {}
    for name in cells.SCENES:
        runner = Runner(device, compiled_preset(name), session.plan)
        runner.warm_up(0.1 if session.quick else 0.5)
        with kernel_seconds() as spent:
            timing = runner.time()
        share = {k: s / timing.seconds for k, s in spent.by_kernel.items()}
        share["outside kernels"] = 1.0 - spent.total / timing.seconds
        session.data["kernels"][name] = {
            **{k: round(s, 4) for k, s in share.items()},
            "rate": float(f"{timing.rate:.5g}"),
            "launches": spent.launches,
            "enqueue": round(timing.enqueue_seconds / timing.seconds, 5),
        }
        parts = ", ".join(f"{k} {100 * s:.1f} %" for k, s in share.items())
        session.report.say(
            f"{name}: {timing.rate:.0f} M/s; {parts}; "
            f"{spent.launches / timing.seconds:.0f} launches/s"
        )


@dataclass
class Best:
    """The fastest plan of a scene so far."""

    what: str
    plan: ExecutionPlan
    rate: float


def _time(session: Session, compiled: CompiledScene, plan: ExecutionPlan) -> Spread | None:
    seconds, runs = (0.05, 2) if session.quick else (0.3, 3)
    try:
        runner = Runner(session.device, compiled, plan)
        runner.warm_up(seconds)
        return Spread.of(runner.time().rate for _ in range(runs))
    except (HostError, cl.Error, MemoryError) as error:
        session.notes.append(f"{plan}: {type(error).__name__}: {str(error).splitlines()[0]}")
        return None


def throughput(session: Session) -> None:
    """Time compositions by wave size, then vary the best plan, one choice after the other."""
    report = session.report
    session.data["throughput"] = {}
    waves = (1 << 14, 1 << 18) if session.quick else (1 << 14, 1 << 16, 1 << 18, 1 << 20, 1 << 22)
    scenes = cells.SCENES[:1] if session.quick else cells.SCENES
    for number, name in enumerate(scenes):
        session.share(len(scenes) - number)
        compiled = compiled_preset(name)
        splitting = "splitting" in compiled.effects
        report.heading(f"{name}: millions of interactions per second, by rays a wave")
        rows, points = [], []
        best: Best | None = None
        for composition in (cells.WHOLE_PATH, cells.PACKETS, cells.PACKETS_4, cells.CLASSICAL):
            lanes = session.plan.lanes if composition != cells.WHOLE_PATH else 1
            record = session.device.record
            base = cells.composition_plan(record, composition, lanes, splitting=splitting)
            row = [composition]
            for wave in waves:
                plan = base.with_(wave_rays=wave)
                rate = None if session.late() else _time(session, compiled, plan)
                row.append("–" if rate is None else f"{rate.median:.0f}")
                if rate is None:
                    continue
                points.append({"composition": composition, "wave_rays": wave, **rate.data()})
                if best is None or rate.median > best.rate:
                    best = Best(composition, plan, rate.median)
            rows.append(row)
        report.say(*table(["composition", *(f"2^{w.bit_length() - 1}" for w in waves)], rows))
        default = _time(session, compiled, session.plan)
        if best is None or default is None:
            session.fail(f"{name}: nothing could be timed")
            continue
        if default.median > best.rate:
            best = Best("default", session.plan, default.median)
        best, varied = _vary(session, compiled, best)
        default, fastest = _beside(session, compiled, best.plan)
        best.rate = fastest.median
        report.say(
            f"default {default.text(0)} M/s; best {best.rate:.0f} M/s: {best.what}, "
            f"{_differences(best.plan, session.plan)}"
        )
        scalar = max(
            (p["median"] for p in points if p["composition"] == cells.WHOLE_PATH), default=0.0
        )
        session.data["throughput"][name] = {
            "points": points,
            "varied": varied,
            "default": default.data(),
            "whole_path": scalar,
            "best": {
                "rate": best.rate,
                "what": best.what,
                "plan": {k: getattr(best.plan, k) for k in best.plan.__dataclass_fields__},
            },
        }


def _beside(
    session: Session, compiled: CompiledScene, plan: ExecutionPlan
) -> tuple[Spread, Spread]:
    """Time the default and another plan in turns."""
    runners = [Runner(session.device, compiled, p) for p in (session.plan, plan)]
    for runner in runners:
        runner.warm_up(0.05 if session.quick else 0.2)
    rates = [[runner.time().rate for runner in runners] for _ in range(5)]
    return Spread.of(r[0] for r in rates), Spread.of(r[1] for r in rates)


def _vary(
    session: Session, compiled: CompiledScene, best: Best
) -> tuple[Best, list[dict[str, Any]]]:
    """Go once through the plan's choices, keeping what is faster."""
    cpu = session.device.record.type == "cpu"
    choices: dict[str, tuple[Any, ...]] = {
        "items": (8, 16, 64) if cpu else (1 << 14, 1 << 16, 1 << 17, 1 << 18, 1 << 19),
        "local_size": (1, 4) if cpu else (32, 64, 128, 256),
        "max_bounces": (64, 1 << 20) if cpu else (4, 16, 64, 256, 1 << 20),
        "tally_parts": (1, 4) if cpu else (1, 4, 16),
        "interleaved": (True, False),
    }
    if session.quick:
        choices = {"local_size": choices["local_size"][:2]}
    tried = []
    for name, values in choices.items():
        for value in values:
            if session.late() or value == getattr(best.plan, name):
                continue
            plan = best.plan.with_(**{name: value})
            rate = _time(session, compiled, plan)
            if rate is None:
                continue
            tried.append({"changed": name, "to": value, **rate.data()})
            if rate.median > 1.02 * best.rate:  # within the noise the old choice stays
                best = Best(best.what, plan, rate.median)
    if tried:
        text = ", ".join(f"{t['changed']} {t['to']}: {t['median']:.0f}" for t in tried)
        session.report.say(f"varied, M/s: {text}")
    return best, tried


def _differences(plan: ExecutionPlan, default: ExecutionPlan) -> str:
    changed = [
        f"{name} {getattr(plan, name)}"
        for name in plan.__dataclass_fields__
        if getattr(plan, name) != getattr(default, name)
    ]
    return ", ".join(changed) if changed else "the default plan"
