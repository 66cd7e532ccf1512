"""Checks of one device: self-test, the presets' digests, one digest whatever the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import pyopencl as cl

from benchmarks import cells, digests
from benchmarks.report import table
from benchmarks.runner import Runner, compiled_preset
from hostcode.device import selftest
from hostcode.device.device import open_device, qualify, survey
from hostcode.errors import DeviceError, HostError, KernelBuildError
from photizon_cl.scene.presets import preset_names

if TYPE_CHECKING:
    from collections.abc import Iterator

    from benchmarks.gpu_session import Session
    from hostcode.device.device import DeviceRecord, OpenDevice
    from hostcode.program.plan import ExecutionPlan

_MATRIX_RAYS: Final = 20000
"""Rays of a batch in the matrix: no power of two, so that nothing divides evenly."""
_MATRIX_BATCHES: Final = 3


def self_test(session: Session) -> None:
    report = selftest.run(session.device)
    session.data["self_test"] = {
        "failures": list(report.failures),
        "seconds": round(report.seconds, 2),
    }
    session.report.heading("Self-test")
    if report.passed:
        session.report.say(f"passed in {report.seconds:.2f} s, compiling included")
    else:
        session.fail(f"self-test: {'; '.join(report.failures)}")


def reference_device(record: DeviceRecord, session: Session) -> OpenDevice | None:
    """Return a CPU device of this machine to compare with, None where there is none."""
    for other in survey().records:
        if other.type == "cpu" and other != record and not qualify(other):
            try:
                return open_device(other)
            except DeviceError as error:
                session.notes.append(f"the CPU device {other.label} cannot be used: {error.reason}")
    return None


def presets(session: Session, reference: OpenDevice | None) -> None:
    """Compare the presets' digests with the stored ones and with a CPU's."""
    known = digests.stored()
    made: dict[str, Any] = {}
    rows = []
    for name in preset_names():
        entry = digests.entry(session.device, name)
        same, why = digests.compare(entry, known.get(name))
        row = [name, entry["digest"][:23] + "…", why[:40]]
        if same is False:
            session.fail(f"{name}: digest {entry['digest']}, {why}")
        if reference is not None:
            other = digests.entry(reference, name)
            equal = other["digest"] == entry["digest"]
            row.append("the CPU's digest" if equal else "NOT the CPU's")
            if not equal:
                session.fail(f"{name}: {entry['digest']}, and {other['digest']} on the CPU")
        else:
            equal = None
            row.append("no CPU device here")
        made[name] = {**entry, "as_stored": same, "as_cpu": equal}
        rows.append(row)
    session.data["presets"] = made
    session.report.heading(f"Presets, {digests.BATCHES} batches each")
    session.report.say(*table(["preset", "digest", "", ""], rows, left=4))


def matrix_plans(plan: ExecutionPlan, *, quick: bool) -> Iterator[tuple[str, ExecutionPlan]]:
    """Give a plan and plans that differ from it in one thing each, with what it is."""
    yield "default", plan
    for label, other in _variants(plan, quick=quick):
        if other != plan:
            yield label, other


def _variants(plan: ExecutionPlan, *, quick: bool) -> Iterator[tuple[str, ExecutionPlan]]:
    sizes = (1 << 10, 1 << 14, 1 << 20)
    for wave in sizes[:1] if quick else sizes:
        yield f"waves of {wave} rays", plan.with_(wave_rays=wave)
    for items in (7,) if quick else (64, 1000, 1 << 14, 1 << 17):
        yield f"{items} work-items", plan.with_(items=items)
    for local in (32,) if quick else (1, 32, 128, 256):
        yield f"work-groups of {local}", plan.with_(local_size=local)
    for steps in (1,) if quick else (1, 4):
        yield f"K = {steps}", plan.with_(max_bounces=steps, items=min(plan.wave_rays, 4096))
    yield "the other queue layout", plan.with_(interleaved=not plan.interleaved)
    yield "3 tally parts", plan.with_(tally_parts=3, tally_copies=0)
    yield "5 tally copies", plan.with_(tally_copies=5)
    yield "small stacks that grow", plan.with_(stack_rays=1)
    classical = plan.with_(composition="classical")
    yield "classical", classical
    if not quick:
        yield "classical, small waves", classical.with_(wave_rays=1 << 12, local_size=32)
        yield "classical, the other layout", classical.with_(interleaved=not plan.interleaved)
    whole = plan.with_(composition="whole-path", lanes=1, refill=1, wave_rays=1 << 14, stack_rays=8)
    yield "whole path", whole
    if not quick:
        yield "whole path, groups of 256", whole.with_(local_size=256)
    for lanes in (1,) if quick else (1, 2, 4):
        if lanes != plan.lanes:
            yield f"{lanes} lanes", plan.with_(lanes=lanes, refill=max(lanes // 4, 1))


def matrix(session: Session) -> None:
    """Run every plan on the three scenes: all must give one digest a scene."""
    session.report.heading("One scene, one digest, whatever the plan")
    plans = list(matrix_plans(session.plan, quick=session.quick))
    scenes = {name: compiled_preset(name, _MATRIX_RAYS) for name in cells.SCENES}
    found: dict[str, dict[str, str]] = {name: {} for name in scenes}
    done: list[str] = []
    refused: list[str] = []
    for label, plan in plans:
        if session.late():
            break
        done.append(label)
        for name, compiled in scenes.items():
            try:
                runner = Runner(session.device, compiled, plan, _MATRIX_BATCHES)
                found[name][label] = runner.digest()
            except KernelBuildError as error:
                if plan.lanes == 1:
                    session.fail(f"{name}, {label}: {error}")
                elif label not in refused:  # a compiler without vectors may be: lanes are 1 there
                    refused.append(label)
                    session.notes.append(f"{label}: this compiler refuses it ({error.message})")
            except (HostError, cl.Error, MemoryError, AssertionError) as error:
                session.fail(f"{name}, {label}: {type(error).__name__}: {error}")
    for name, of_scene in found.items():
        first = of_scene.get("default", "")
        other = [label for label, digest in of_scene.items() if digest != first]
        if other:
            session.fail(f"{name}: another digest than the default's with {', '.join(other)}")
        session.report.say(
            f"{name}: {len(of_scene) - len(other)} of {len(of_scene)} plans give {first[:23]}…"
        )
    session.report.say(f"plans: {', '.join(done)}")
    session.report.say(*(f"not built: {label}" for label in refused))
    skipped = [label for label, _ in plans[len(done) :]]
    if skipped:
        session.notes.append(f"no time was left for the plans {', '.join(skipped)}")
    session.data["matrix"] = {"digests": found, "refused": refused, "skipped": skipped}
