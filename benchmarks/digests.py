"""The presets' first batches as digests: what every device must give, bit for bit.

    python -m benchmarks.digests             compare this machine's device with the stored digests
    python -m benchmarks.digests --all       the same on every device that there is
    python -m benchmarks.digests --write     store this device's digests
    python -m benchmarks.digests --precision fp32     only those of a mode; may be given again

Each preset has a digest in each precision; single precision is compared on devices that promise
its bits. Stored beside each digest is one of the preset's compiled tables, so that a changed preset
is told from a device that computes something else. Digests change with the kernels' arithmetic and
with nothing else; who changes either writes them anew and says so.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from benchmarks import facts
from benchmarks.report import table
from benchmarks.runner import Runner, compiled_preset
from hostcode.device.device import choose, open_device, preferred_lanes, qualify, survey
from hostcode.errors import DeviceError
from hostcode.program.plan import default_plan
from hostcode.program.precision import PRECISIONS
from photizon_cl.scene.presets import preset_names

if TYPE_CHECKING:
    from collections.abc import Sequence

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


def entry(
    device: OpenDevice, preset: str, plan: ExecutionPlan | None = None, precision: str = "fp64"
) -> dict[str, Any]:
    """Trace a preset's first batches as its file says and return what is stored of it."""
    compiled = compiled_preset(preset, precision=precision)
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


def stored(precision: str = "fp64") -> dict[str, dict[str, Any]]:
    """Return the stored entries of a mode by preset; none where there is no file."""
    if not STORED.is_file():
        return {}
    content = json.loads(STORED.read_text(encoding="utf-8"))
    presets: dict[str, dict[str, Any]] = (
        content["presets"] if precision == "fp64" else content.get(precision, {})
    )
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


def everywhere(modes: Sequence[str]) -> int:
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
    wrong, rows = 0, []
    for mode, preset in product(modes, preset_names()):
        known = stored(mode).get(preset)
        verdicts = []
        for name, device in here:
            if not device.record.promises(PRECISIONS[mode].real):
                verdicts.append(f"{name}: skipped, promises no bits in single precision")
                continue
            made = entry(device, preset, precision=mode)
            same, why = compare(made, known)
            wrong += same is not True
            verdicts.append(f"{name}: {'as stored' if same else made['digest'] + ', ' + why}")
        rows.append([mode, preset, (known or {}).get("digest", "none"), "; ".join(verdicts)])
    head = ["precision", "preset", "stored digest", "on each device"]
    print(*table(head, rows, left=4), sep="\n")
    print(f"{len(here)} devices, {len(rows)} digests, {wrong} that differ")
    return int(wrong > 0 or not here)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.digests")
    parser.add_argument("--write", action="store_true", help="store what this device gives")
    parser.add_argument("--all", action="store_true", help="compare every device that there is")
    parser.add_argument("--precision", action="append", choices=tuple(PRECISIONS), metavar="P")
    parser.add_argument("--device")
    asked = parser.parse_args(arguments)
    if asked.all:
        return everywhere(asked.precision or tuple(PRECISIONS))
    try:
        device = open_device(choose(asked.device))
    except DeviceError as error:
        print(f"benchmarks.digests: {error}", file=sys.stderr)
        return 2
    found = {
        mode: {name: entry(device, name, precision=mode) for name in preset_names()}
        for mode in asked.precision or PRECISIONS
    }
    rows, all_same = [], True
    for mode, entries in found.items():
        known = stored(mode)
        for name, made in entries.items():
            same, why = compare(made, known.get(name))
            if not same and not device.record.promises(PRECISIONS[mode].real):
                same, why = True, "this device promises no bits in single precision"
            all_same = all_same and bool(same)
            rows.append([mode, name, made["digest"], why])
    print(*table(["precision", "preset", "digest", ""], rows, left=4), sep="\n")
    if asked.write:
        conditions = facts.facts(device.record)
        kept = ("device", "platform_version", "driver", "commit", "date")
        made_with = {key: conditions[key] for key in kept}
        STORED.parent.mkdir(exist_ok=True)
        kept_ones = {mode: found.get(mode) or stored(mode) for mode in PRECISIONS}
        presets = kept_ones.pop("fp64")
        text = json.dumps({"made_with": made_with, "presets": presets, **kept_ones}, indent=1)
        STORED.write_text(text + "\n", encoding="utf-8")
        print(f"wrote {STORED.name}")
        return 0
    return 0 if all_same else 1


if __name__ == "__main__":
    sys.exit(main())
