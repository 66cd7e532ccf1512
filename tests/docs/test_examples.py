"""Every example in the documentation does what the page says."""

from __future__ import annotations

import re
import shutil

import pytest
from pages import ROOT, Runner, apply_hunks, matches
from photizon_docs.tables import GROUPS

# Programs of the largest scenes, and of folders of tests that show the same; `make pages` runs all.
SLOW = (
    "coatings.md", "error-bars.md", "importance-sampling.md", "many-machines.md", "media.md",
    "polarisation.md", "results.md", "reverse-traces.md", "scatter.md", "stray-light.md",
    "sweeps.md", "tutorial.md",
)  # fmt: skip
WRITTEN = sorted(p.name for p in (ROOT / "docs").glob("*.md") if p.name != "add-a-kind.md")
KINDS = [(group, kind) for group, kinds in GROUPS.items() for kind in kinds]


@pytest.mark.usefixtures("few_figures")
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in WRITTEN]
)
def test_page(name, tmp_path):
    Runner(tmp_path).run(ROOT / "docs" / name)


@pytest.mark.parametrize(
    "kinds",
    # what every kind must hold is tests/structure; these would be fifteen programs more
    ["", pytest.param("(retroreflector or phong or bounces)", marks=pytest.mark.slow)],
)
def test_a_surface_and_an_effect_are_added(kinds, checkout):
    runner = Runner(checkout, apart=True)
    runner.run(ROOT / "docs" / "add-a-kind.md")
    # what the page does not show: conservation to the last bit, and the page that comes by itself
    exact, page = runner.process(
        "-c",
        "import photizon_cl as pz\n"
        "result = pz.trace('retro.toml', batches=2, rays_per_batch=1024)\n"
        "ledger = result.ledger\n"
        "print(ledger.closure, ledger.absorbed['sheet'].value, ledger.absorbed['target'].value)\n"
        "print(result.detectors['target'].power.value, ledger.escaped.value, '\\n----')\n"
        "import sys; sys.path.insert(0, 'docs/_ext')\n"
        "from photizon_docs.parts import page\n"
        "from photizon_docs.tables import GROUPS\n"
        "print(page('surface', 'retroreflector', GROUPS['surface']['retroreflector'])[0])",
    ).split("----\n", 1)
    assert exact.split() == ["0.0", "0.25", "0.75", "0.75", "0.0"]
    assert "# retroreflector" in page
    assert "| `reflectance` | part of the power that is reflected |" in page
    assert "d' = -d, weight times reflectance" in page
    assert "pz.Retroreflector(reflectance=0.8)" in page
    if not kinds:
        return
    # and what every kind must hold, these with the others
    shutil.copy(ROOT / "pyproject.toml", checkout)
    for name in ("tests", "docs"):
        shutil.copytree(ROOT / name, checkout / name, dirs_exist_ok=True)
    contract = [
        f"tests/structure/test_contract{part}.py"
        for part in ("", "_effects", "_chance", "_scatter")
    ]
    said = runner.process(
        "-m",
        "pytest",
        "-q",
        *contract,
        "-k",
        # what needs the scene of everything is left out, and that each kind has its part in it
        f"{kinds} and not everything and not lanes and not its_part",
        timeout_s=600,
    )
    passed = re.search(r"^(\d+) passed, \d+ deselected", said, re.M)
    assert passed, said
    assert int(passed[1]) >= 10, said


@pytest.mark.usefixtures("itself_built_quickly")  # as the pages were
@pytest.mark.parametrize(("group", "kind"), KINDS, ids=[kind for _, kind in KINDS])
def test_page_of_a_kind(group, kind, build, tmp_path):
    import photizon_cl as pz

    runner = Runner(tmp_path)
    # the file, the code, and what the code prints
    assert runner.run(build.source / "parts" / f"{group}s" / f"{kind}.md") == 3
    # file and code are the same scene
    assert pz.load(tmp_path / f"{kind}.toml") == runner.names["scene"]
    # and nothing of the flux is lost
    assert abs(runner.names["result"].ledger.closure) < 1e-15


def test_shown_output_is_compared():
    assert matches("seed 1, …\nW 2", "seed 1, 3 s\non x\nW 2\n")
    assert not matches("seed 1, …\nW 2", "seed 1, 3 s\nW 3\n")
    assert not matches("W 2", "W 2\nW 3")


def test_hunks_apply_once():
    assert apply_hunks("a\nb\n", " a\n+c\n@@\n-b\n+d\n") == "a\nc\nd\n"
    with pytest.raises(AssertionError, match="stand 2 times"):
        apply_hunks("a\na\n", "-a\n")
