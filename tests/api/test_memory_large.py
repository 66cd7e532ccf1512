"""The largest scenes, each in a process with a limit of memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from plates import GB, line_of, scene

import photizon_cl as pz
from benchmarks.limits import endless

PEAK = """
import json, resource, sys
from photizon_cl.cli.main import main
status = main(sys.argv[1:])
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps([status, peak]), file=sys.__stderr__)
"""


def run_limited(arguments, kilobytes):
    """Run a command under ``ulimit -v``; return status, peak in bytes, and what it said."""
    command = f'ulimit -v {kilobytes}; exec "$0" -c "$PEAK" "$@"'
    done = subprocess.run(
        ["sh", "-c", command, sys.executable, *arguments],
        env={**os.environ, "PEAK": PEAK}, capture_output=True, text=True, timeout=900, check=False,
    )  # fmt: skip
    *said, last = done.stderr.splitlines()
    status, peak = json.loads(last)
    assert "Traceback" not in done.stderr
    assert "MemoryError" not in done.stderr
    return status, peak << 10, said


LARGE = {
    "map": scene(8192),
    "far field": scene(0, 8192),
    "twenty detectors": scene(2048, None, 20),
    "two maps": scene(8192, None, 2),
}


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ulimit -v as Linux has it")
@pytest.mark.parametrize("limit", ["4194304", "8388608", "unlimited"])
@pytest.mark.parametrize("name", LARGE)
def test_large_scenes_run_in_four_gigabytes_or_are_refused(name, limit, tmp_path):
    file, out = tmp_path / "scene.toml", tmp_path / "out"
    LARGE[name].save(file)
    arguments = ["run", str(file), "--batches", "3", "--rays-per-batch", "4096"]
    status, peak, said = run_limited([*arguments, "--out", str(out)], limit)
    if status:
        line = line_of("\n".join(said))
        if "in one piece" in line:
            pytest.skip(f"this device cannot hold it: {line}")
        assert "of memory" in line
        assert limit == "4194304" or (name, limit) == ("two maps", "8388608")
        assert not out.exists()
    else:
        assert peak < (4 if name != "two maps" else 6) * GB
        assert pz.open_result(out).batches == 3


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ulimit -v as Linux has it")
@pytest.mark.parametrize("limit", ["4194304", "8388608"])
def test_splitting_without_bound_ends_in_a_line(limit, tmp_path):
    file = tmp_path / "scene.toml"
    endless("glass in mirrors", 1024).save(file)
    status, peak, said = run_limited(["run", str(file), "--max-seconds", "30"], limit)
    assert status == 1
    assert "more rays split off than may wait" in said[-1]
    assert peak < 4 * GB
