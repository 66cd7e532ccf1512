"""The documentation, built once for all tests of it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
sys.path.insert(0, str(ROOT / "docs" / "_ext"))
sys.path.insert(0, str(Path(__file__).parent))

from narrow import four_lanes as four_lanes  # noqa: E402

# The user's width must not enter what commands print.
os.environ["COLUMNS"] = "80"


class Build(NamedTuple):
    """A copy of the sources, the pages made of them, and what Sphinx said."""

    source: Path
    pages: Path
    status: int
    said: str


@pytest.fixture(scope="session", autouse=True)
def _building(tmp_path_factory, quickly):
    """Start to build a copy of the documentation, beside the tests that do without it.

    A page traces a few rays by programs of its own.
    """
    source = tmp_path_factory.mktemp("docs") / "docs"
    ignored = shutil.ignore_patterns("_build", "parts", "__pycache__")
    shutil.copytree(ROOT / "docs", source, ignore=ignored)
    pages, log = source.parent / "html", source.parent / "log"
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    with quickly(), log.open("wb") as said:
        running = subprocess.Popen(
            [
                sys.executable,
                ROOT / "tests" / "narrow.py",  # the tests' own programs
                "sphinx",
                "-W",
                "--keep-going",
                "-n",
                "-b",
                "html",
                source,
                pages,
            ],
            cwd=source.parent,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            stdout=subprocess.DEVNULL,
            stderr=said,
        )
    yield source, pages, log, running
    running.kill()
    running.wait()


@pytest.fixture(scope="session")
def build(_building):
    """Wait for the documentation to be built."""
    source, pages, log, running = _building
    status = running.wait(timeout=300)
    return Build(source, pages, status, log.read_text("utf-8"))


@pytest.fixture
def checkout(tmp_path):
    """Return a copy of the packages, for a test that changes them."""
    folder = tmp_path / "checkout"
    for name in ("photizon_cl", "hostcode", "kernels", "presets", "docs/_ext"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    # what `narrow` does in this process: few lanes build faster
    usual = folder / "hostcode" / "run" / "usual.py"
    text, lanes = usual.read_text("utf-8"), "preferred_lanes(record, tables.spec.effects)"
    assert text.count(lanes) == 1
    usual.write_text(text.replace(lanes, f"min({lanes}, 4)"), encoding="utf-8")
    return folder
