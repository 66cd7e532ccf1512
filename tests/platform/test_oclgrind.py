"""Every kernel under Oclgrind, a simulator that sees each access to memory: nothing is reported.

It looks for accesses beyond a buffer, for data races, for values that were never set, and for wrong
calls of OpenCL. Functions are left as they are (``-O0`` without inlining), so that it sees every
variable, and since it does not know what optimisers make of them.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from oracles import watched

from photizon_cl.scene.presets import preset_names
from photizon_cl.scene.registry import COATINGS, ELEMENTS, FILTERS, SCATTERS, SOURCES, SURFACES

ROOT = Path(__file__).resolve().parents[2]
PYTHONPATH = os.pathsep.join((str(ROOT / "tests"), str(ROOT)))
OCLGRIND = shutil.which("oclgrind")
OPTIONS = (
    "--data-races",
    "--check-api",
    "--build-options",
    "-O0 -Dalways_inline=noinline",
    "--log",
)

needs_oclgrind = pytest.mark.skipif(
    OCLGRIND is None, reason="oclgrind is not installed (Debian: apt install oclgrind)"
)


def run(name, tmp_path):
    """Return what a case gave, and what was reported."""
    log = tmp_path / "reports"
    unset = ["--uninitialized"] if watched.ALL[name].unset else []
    script = [sys.executable, "-m", "oracles.watched", name]
    hidden = ("OCL_ICD_VENDORS", "OCL_ICD_FILENAMES", "POCL_CACHE_DIR")
    environment = {key: value for key, value in os.environ.items() if key not in hidden}
    done = subprocess.run(
        [str(OCLGRIND), *unset, *OPTIONS, str(log), *script],
        # kept kernels would be those of other options
        env={**environment, "XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": PYTHONPATH},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    # wrong calls are told on standard error, whatever the log
    said = log.read_text(errors="replace") + "\n\n" if log.is_file() else ""
    reports = [text.strip() for text in re.split(r"\n\s*\n", said + done.stderr) if text.strip()]
    assert done.returncode == 0 or reports
    return done.stdout.strip(), reports


def clean(name, tmp_path):
    """Assert that nothing is reported, and that what came out is what the device gives."""
    found, reports = run(name, tmp_path)
    assert not reports, f"{len(reports)} reports, the first:\n" + "\n\n".join(reports[:3])
    # the answer tells that all was run
    assert found == watched.digest(name)


def test_the_scene_has_every_kind():
    scene = watched.every_kind()
    kinds = lambda rows: {row["kind"] for row in rows}  # noqa: E731
    assert kinds(scene["element"]) == set(ELEMENTS)
    assert kinds(scene["source"]) == set(SOURCES)
    assert kinds(row["surface"] for row in scene["element"]) == set(SURFACES)
    lobes = [row["surface"].get("scatter") for row in scene["element"]]
    assert kinds(lobe for lobe in lobes if lobe) == set(SCATTERS)
    lit = watched.every_kind("lines")["element"]
    assert kinds(row["surface"]["coating"] for row in lit if "coating" in row["surface"]) == set(
        COATINGS
    )
    stems = set()
    for light in ("", "lines", "bands"):
        made = watched.compiled(watched.load(watched.every_kind(light)))
        stems |= {stem for form in made.tables.spec.forms for stem, _ in form.filters}
    assert stems == set(FILTERS)
    assert set(preset_names()) <= set(watched.MORE)


BRIEFLY = ("every kind, through a tree", "path tables")
"""What is looked at unless slow tests are asked for: the simulator takes its time."""


@needs_oclgrind
@pytest.mark.usefixtures("itself_built_quickly")  # of the device the answer is asked for alone
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in BRIEFLY else pytest.mark.slow)
        for name in watched.CASES
    ],
)
def test_nothing_is_reported(name, tmp_path):
    clean(name, tmp_path)


@needs_oclgrind
@pytest.mark.slow
@pytest.mark.parametrize("name", watched.MORE)
def test_nothing_is_reported_of_more(name, tmp_path):
    clean(name, tmp_path)


SAID = {
    "writes beyond the tally": "Invalid write",
    "adds without atomics": "data race",
    "uses what was never set": "ninitialized",
    "looks at a path's cell without atomics": "data race",
}


@needs_oclgrind
@pytest.mark.parametrize("name", watched.BROKEN)
def test_a_broken_kernel_is_reported(name, tmp_path):
    _, reports = run(name, tmp_path)
    assert any(SAID[name] in report for report in reports), reports[:2]
