"""What `gpu.py` does once the path and the driver are in place: checks first, then timings."""

from __future__ import annotations

import time
import traceback
from typing import TYPE_CHECKING

from benchmarks import builds, cells, facts, gpu_checks, gpu_timings
from benchmarks.gpu_session import Session
from benchmarks.report import Report
from hostcode.device.device import choose, open_device, qualify, survey
from hostcode.errors import DeviceError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


def run(selector: str, out: Path | None, *, quick: bool, seconds: float) -> int:
    """Run everything on one device, print it, write it; return the exit status."""
    started = time.perf_counter()
    report = Report()
    found = survey()
    report.say("photizon_cl: checks and timings of one device", "", "devices of this machine")
    for record in found.records:
        reasons = qualify(record)
        report.say(
            f"  {record.index}  {record.type}  {record.label}, {record.compute_units} compute units"
            f"{'; refused: ' + ', '.join(reasons) if reasons else ''}"
        )
    report.say(*(f"  problem: {problem}" for problem in found.problems))
    if not found.records:
        report.say("  none")
    try:
        record = choose(selector)
        device = open_device(record)
    except DeviceError as error:
        report.say("", str(error), "", f"NO RESULT: no usable device for {selector!r}")
        there = any(record.type == selector for record in found.records)
        return 1 if there else 2  # a GPU that is there and is refused is a failed check
    known = facts.facts(record)
    report.say("", "under test", *facts.lines(known))
    session = Session(device, report, quick, started + seconds)
    session.data = {"facts": known, "quick": quick, "devices": [r.label for r in found.records]}
    presets = cells.SCENES[: 1 if quick else None]
    reference = gpu_checks.reference_device(record, session)
    _part(session, "self-test", lambda: gpu_checks.self_test(session))
    _part(session, "presets", lambda: gpu_checks.presets(session, reference))
    session.share(2)  # at most half of the time: compilers may be slow
    _part(session, "matrix", lambda: gpu_checks.matrix(session))
    session.share(1)
    _part(session, "builds", lambda: _builds(session, presets))
    _part(session, "kernels", lambda: gpu_timings.kernels(session))
    _part(session, "throughput", lambda: gpu_timings.throughput(session))
    session.data["seconds"] = round(time.perf_counter() - started, 1)
    _summary(session)
    folder = facts.ROOT / "out" if out is None else out
    try:
        paths = report.write(folder, f"gpu-{facts.slug(record.name)}", session.data)
    except OSError as error:
        print(f"could not write the results: {error}")
    else:
        print(f"wrote {' and '.join(path.name for path in paths)}")
    return 1 if session.failures else 0


def _part(session: Session, name: str, work: Callable[[], None]) -> None:
    """Do a part; one that breaks is a failure and does not take the others with it."""
    try:
        work()
    except Exception as error:
        session.report.say(*traceback.format_exc().splitlines())
        session.fail(f"{name} broke off: {type(error).__name__}: {str(error).splitlines()[:1]}")


def _builds(session: Session, presets: tuple[str, ...]) -> None:
    record = session.device.record
    session.data["builds"] = builds.measure(record, session.report, repeats=1, presets=presets)


def _summary(session: Session) -> None:
    data, report = session.data, session.report
    record = session.device.record
    report.heading("In short")
    report.say(*(f"note: {note}" for note in session.notes))
    report.say(f"{record.type} {record.label}, {record.compute_units} compute units")
    for name, found in data.get("builds", {}).items():
        cold, warm = (found[state]["first_result"]["median"] for state in ("cold", "warm"))
        report.say(f"{name}: first result after {cold:.2f} s cold, {warm:.2f} s warm")
    for name, found in data.get("throughput", {}).items():
        rate, best, scalar = (
            found["default"]["median"],
            found["best"]["rate"],
            found["whole_path"],
        )
        ratio = f", {rate / scalar:.2f} × the whole path" if scalar else ""
        report.say(
            f"{name}: default {rate:.0f} M/s{ratio}; best plan {best:.0f} M/s ({best / rate:.2f} ×)"
        )
    presets = data.get("presets", {}).values()
    stored, cpu = (sum(p[key] is True for p in presets) for key in ("as_stored", "as_cpu"))
    asked = [sum(p[key] is not None for p in presets) for key in ("as_stored", "as_cpu")]
    matrix = [len(of_scene) for of_scene in data.get("matrix", {}).get("digests", {}).values()]
    passed = "self_test" in data and not data["self_test"]["failures"]
    report.say(
        f"self-test {'passed' if passed else 'FAILED'}; "
        f"presets: {stored} of {asked[0]} digests as stored, {cpu} of {asked[1]} as on a CPU here; "
        f"matrix: {sum(matrix)} runs",
        f"{data['seconds']:.0f} s",
    )
    data["failures"], data["notes"] = session.failures, session.notes
    if session.failures:
        report.say(*(f"FAILED: {text}" for text in session.failures))
        report.say(f"{len(session.failures)} CHECKS FAILED")
    else:
        report.say("ALL CHECKS PASSED")
