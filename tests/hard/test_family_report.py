"""Every family of hard cases against 60 digits: decisions right, errors within the bound."""

from __future__ import annotations

import os
import random
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from oracles.engine import open_device

from hostcode.run.probe import probe_faces
from photizon_cl import stability
from photizon_cl.stability.measure import compile_elements, measure, state_of
from photizon_cl.stability.report import BOUND, FAMILIES, Row, stability_report, table, write_figure

if TYPE_CHECKING:
    from photizon_cl.scene.elements import Element
    from photizon_cl.stability.case import Case
    from photizon_cl.stability.measure import Measured


def part_of(family: str) -> Row:
    """Measure a part of a family's cases, drawn with a seed: 60 digits take their time.

    As many as are needed for 30 to have one right decision, which those at shared edges do not
    have, and for 30 to be compared in more than that, which most of the rays that graze cannot be.
    """
    cases = list(FAMILIES[family]())
    # scene by scene, since each takes a launch
    scenes = list(dict.fromkeys(case.elements for case in cases))
    random.Random(family).shuffle(scenes)
    found: list[Measured] = []
    for scene in scenes:
        found += measure(open_device(), [case for case in cases if case.elements == scene])
        firm = family == "shared edges" or sum(m.firm for m in found) >= 30
        if firm and len(found) >= 36 and sum(bool(m.errors) for m in found) >= 30:
            break
    return Row(family, tuple(found), 0.0)


@pytest.fixture(scope="module", params=["a part", pytest.param("all", marks=pytest.mark.slow)])
def rows(request: pytest.FixtureRequest) -> dict[str, Row]:
    if request.param == "all":  # as `photizon stability` measures them
        return {row.family: row for row in stability_report(open_device())}
    fresnel = stability_report(open_device(), ["fresnel"])
    return {row.family: row for row in [*map(part_of, FAMILIES), *fresnel]}


@pytest.mark.parametrize("family", [*FAMILIES, "fresnel"])
def test_family(rows: dict[str, Row], family: str) -> None:
    row = rows[family]
    assert row.cases >= 25
    assert row.wrong == ()
    assert row.worst <= BOUND
    # most of what is measured must be able to fail
    assert sum(bool(m.errors) for m in row.measured) >= 25


def test_most_families_have_firm_decisions(rows: dict[str, Row]) -> None:
    assert sum(row.firm >= 25 for row in rows.values()) >= len(rows) - 1  # not the shared edges


def test_the_table_and_the_figure_show_every_family(rows: dict[str, Row], tmp_path: Path) -> None:
    text = table(list(rows.values()))
    assert all(name in text for name in rows)
    assert "FAILED" not in text
    write_figure(list(rows.values()), tmp_path / "stability.png")
    assert (tmp_path / "stability.png").stat().st_size > 20_000


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert stability.main(["--family", "fresnel"]) == 0
    assert "fresnel" in capsys.readouterr().out
    assert stability.main(["--family", "nonsense"]) == 2
    assert "nonsense" in capsys.readouterr().err


def command(tmp_path: Path, *absent: str, family: str) -> subprocess.CompletedProcess[str]:
    """Run the command where some modules are not installed."""
    for name in absent:
        (tmp_path / f"{name}.py").write_text("raise ImportError('absent')\n")
    path = os.pathsep.join((str(tmp_path), str(Path(__file__).resolve().parents[2])))
    return subprocess.run(
        [sys.executable, "-m", "photizon_cl.stability", "--family", family],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


def test_without_many_digits_it_says_what_to_install(tmp_path: Path) -> None:
    done = command(tmp_path, "mpmath", "gmpy2", family="fresnel")
    assert done.returncode == 1
    assert "pip install mpmath" in done.stderr


@pytest.mark.parametrize(
    "family", ["fresnel", pytest.param("sphere, chord", marks=pytest.mark.slow)]
)
def test_both_libraries_of_many_digits_measure_the_same(tmp_path: Path, family: str) -> None:
    found = [command(tmp_path, *absent, family=family) for absent in ((), ("gmpy2",))]
    assert [done.returncode for done in found] == [0, 0]
    tables = [re.sub(r"\d+\.\d+ s", "", done.stdout) for done in found]
    assert family in tables[0]
    assert tables[0] == tables[1]


@pytest.mark.parametrize(
    "family",
    ["cpc, rims", "lens, rim"]
    + [pytest.param(f, marks=pytest.mark.slow) for f in ("tube, corners", "lens, inside")],
)
def test_lane_widths_give_the_same_bits(family: str) -> None:
    """A ray's neighbours in a packet do not change its answer: every case, scene by scene."""
    scenes: dict[tuple[Element, ...], list[Case]] = {}
    for case in FAMILIES[family]():
        scenes.setdefault(case.elements, []).append(case)
    for elements, cases in scenes.items():
        compiled = compile_elements(elements)
        rays = np.array([[*np.subtract(c.origin, compiled.shift), *c.direction] for c in cases])
        left = np.array([state_of(compiled, c.left) for c in cases])
        one, many = (
            probe_faces(open_device(), compiled.tables, rays, lanes, left) for lanes in (1, 8)
        )
        assert one[1].tobytes() == many[1].tobytes()
        hit = one[1] >= 0
        assert one[0][hit].tobytes() == many[0][hit].tobytes()
