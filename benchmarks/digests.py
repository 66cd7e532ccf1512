"""The presets' first batches as digests: what every device must give, bit for bit.

    python -m benchmarks.digests             compare this machine's device with the stored digests
    python -m benchmarks.digests --all       the same on every device that there is
    python -m benchmarks.digests --write     store this device's digests

Stored beside each digest is one of the preset's compiled tables, so that a changed preset is told
from a device that computes something else. Digests change with the kernels' arithmetic and with
nothing else; who changes either writes them anew and says so.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from benchmarks import facts
from benchmarks.report import table
from benchmarks.runner import Runner, compiled_preset
from hostcode.device.device import choose, open_device, preferred_lanes, qualify, survey
from hostcode.errors import DeviceError
from hostcode.program.plan import default_plan
from photizon_cl.scene.presets import preset_names

if TYPE_CHECKING:
    from hostcode.device.device import OpenDevice
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.compile.compiled import CompiledScene

STORED: Final = Path(__file__).absolute().parent / "data" / "digests.json"
BATCHES: Final = 2

WANTED: Final = {
    "debian": "PoCL, by apt install pocl-opencl-icd",
    "pypi": "PoCL, by pip install 'pyopencl[pocl]'",
    "intel": "Intel's CPU runtime, by pip install 'photizon-cl[intel]'",
    "gpu": "a GPU with its vendor's driver",
}
"""Runtimes that digests are compared on where they are, and how to get them."""


def tables_digest(compiled: CompiledScene) -> str:
    """Return a digest of all that a device reads of a scene, seed and batch size included."""
    tables = compiled.tables
    state = hashlib.sha256()
    for array in (
        tables.geometry,
        tables.materials,
        tables.sources,
        tables.codes,
        tables.detector_numbers,
        tables.edges,
    ):
        state.update(array.astype(array.dtype.newbyteorder("<")).tobytes())
    state.update(json.dumps(tables.launch, sort_keys=True, default=str).encode())
    return f"sha256:{state.hexdigest()[:32]}"


def entry(device: OpenDevice, preset: str, plan: ExecutionPlan | None = None) -> dict[str, Any]:
    """Trace a preset's first batches as its file says and return what is stored of it."""
    compiled = compiled_preset(preset)
    if plan is None:
        plan = default_plan(device.record, preferred_lanes(device.record))
    timing = Runner(device, compiled, plan, BATCHES).time()
    return {
        "batches": BATCHES,
        "rays_per_batch": compiled.settings.rays_per_batch,
        "seed": compiled.settings.seed,
        "interactions": timing.interactions,
        "tables": tables_digest(compiled),
        "digest": timing.digest,
    }


def stored() -> dict[str, dict[str, Any]]:
    """Return the stored entries by preset; none where there is no file."""
    if not STORED.is_file():
        return {}
    presets: dict[str, dict[str, Any]] = json.loads(STORED.read_text(encoding="utf-8"))["presets"]
    return presets


def compare(found: dict[str, Any], known: dict[str, Any] | None) -> tuple[bool | None, str]:
    """Return whether an entry is the stored one (None where nothing can be said), and why."""
    if known is None:
        return None, "no digest is stored"
    if found["digest"] == known["digest"] and found["interactions"] == known["interactions"]:
        return True, "the stored digest"
    if found["tables"] != known["tables"]:
        return None, "the preset's tables changed since its digest was stored"
    return False, f"stored is {known['digest']}"


def everywhere() -> int:
    """Compare every device of this machine; return the exit status, 1 where any bit differs."""
    here: list[tuple[str, OpenDevice]] = []
    for record in survey().records:
        name = record.origin or record.type
        reasons = qualify(record, self_test=True)
        print(f"{name}: {record.label}" + (f", skipped: {'; '.join(reasons)}" if reasons else ""))
        if not reasons:
            here.append((name, open_device(record)))
    found = {record.origin for record in survey().records} | {r.type for r in survey().records}
    for name, what in WANTED.items():
        if name not in found:
            print(f"{name}: skipped, not here: {what}")
    for problem in survey().problems:
        print(f"not readable: {problem}")
    known, wrong, rows = stored(), 0, []
    for preset in preset_names():
        verdicts = []
        for name, device in here:
            made = entry(device, preset)
            same, why = compare(made, known.get(preset))
            wrong += same is not True
            verdicts.append(f"{name}: {'as stored' if same else made['digest'] + ', ' + why}")
        rows.append([preset, known.get(preset, {}).get("digest", "none"), "; ".join(verdicts)])
    print(*table(["preset", "stored digest", "on each device"], rows, left=3), sep="\n")
    print(f"{len(here)} devices, {len(rows)} presets, {wrong} that differ")
    return int(wrong > 0 or not here)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.digests")
    parser.add_argument("--write", action="store_true", help="store what this device gives")
    parser.add_argument("--all", action="store_true", help="compare every device that there is")
    parser.add_argument("--device")
    asked = parser.parse_args(arguments)
    if asked.all:
        return everywhere()
    try:
        device = open_device(choose(asked.device))
    except DeviceError as error:
        print(f"benchmarks.digests: {error}", file=sys.stderr)
        return 2
    found = {name: entry(device, name) for name in preset_names()}
    known = stored()
    verdicts = {name: compare(made, known.get(name)) for name, made in found.items()}
    rows = [[name, found[name]["digest"], why] for name, (_, why) in verdicts.items()]
    print(*table(["preset", "digest", ""], rows, left=3), sep="\n")
    if asked.write:
        conditions = facts.facts(device.record)
        kept = ("device", "platform_version", "driver", "commit", "date")
        made_with = {key: conditions[key] for key in kept}
        STORED.parent.mkdir(exist_ok=True)
        text = json.dumps({"made_with": made_with, "presets": found}, indent=1)
        STORED.write_text(text + "\n", encoding="utf-8")
        print(f"wrote {STORED.name}")
        return 0
    return 0 if all(same for same, _ in verdicts.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
