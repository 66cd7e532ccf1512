from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

import photizon_cl

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_one_version(project):
    assert project["project"]["version"] == photizon_cl.__version__


def test_assets_go_into_the_packages_that_read_them(project):
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["packages"] == ["photizon_cl", "hostcode"]
    assert wheel["force-include"] == {
        "kernels": "hostcode/kernels",
        "presets": "photizon_cl/presets",
    }


def test_both_packages_are_typed():
    for package in ("photizon_cl", "hostcode"):
        assert (ROOT / package / "py.typed").is_file()


def test_hostcode_never_imports_the_other_package():
    for path in (ROOT / "hostcode").glob("**/*.py"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"^\s*(from|import) photizon_cl", text, re.MULTILINE), path.name


@pytest.mark.parametrize(("shell", "script"), [("sh", ".ci/setup"), ("bash", ".ci/run")])
def test_scripts_parse(shell, script):
    subprocess.run([shell, "-n", str(ROOT / script)], check=True)


def test_continuous_integration_is_make_test():
    assert (ROOT / ".ci/run").read_text(encoding="utf-8").rstrip().endswith("exec make test")
