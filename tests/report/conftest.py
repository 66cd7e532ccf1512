"""Fixtures of the tests of reports: saved results, and a browser to look at their pages."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from narrow import four_lanes as four_lanes


@pytest.fixture(scope="session")
def results(quickly):
    """Return results that between them have all that a report can show."""
    from report_scenes import capped, hostile, plate, scene

    import photizon_cl as pz

    with quickly():
        return {
            "room": pz.trace("box-room", batches=10, rays_per_batch=2048),
            "sphere": pz.trace("integrating-sphere", batches=10, rays_per_batch=2048),
            "hostile": pz.trace(pz.load(hostile()), batches=9, rays_per_batch=2048),
            "capped": pz.trace(pz.load(capped()), batches=9, rays_per_batch=2048),
            "single": pz.trace(
                pz.load(scene("single", element=[plate("t", detector={"map": [8, 8]})])),
                batches=1,
                rays_per_batch=1024,
            ),
            "empty": pz.trace(pz.load(scene("empty")), batches=2, rays_per_batch=64),
        }


@pytest.fixture(scope="session")
def pages(results, tmp_path_factory):
    """Return the path of each result's report."""
    from photizon_cl.run.report import write_report

    written = {}
    for name, result in results.items():
        folder = tmp_path_factory.mktemp(name)
        result.save(folder, figures=False)
        written[name] = write_report(folder).page
    return written


@pytest.fixture(scope="module")
def browser():
    """Return the system's Chromium, without a window; skips where there is none, fails in CI."""
    from pagecheck import executable

    path = executable()
    if path is None:
        missing = "no Chromium on this machine: `apt install chromium fonts-dejavu-core`"
        if os.environ.get("CI") == "true":
            pytest.fail(f"{missing}; .ci/setup was to install it")
        pytest.skip(missing)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        launched = driver.chromium.launch(executable_path=path)
        yield launched
        launched.close()
