"""Hard cases in single precision: judged in its own units, and lost where it cannot hold them."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from oracles.engine import PLAN, open_device, trace
from oracles.walks import SILVER, follow, unit

import photizon_cl as pz
from benchmarks.leaks import closed_bodies
from hostcode.run.probe import NO_FACE
from photizon_cl.cli.main import main
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.frames import frame
from photizon_cl.stability.build import aimed, black
from photizon_cl.stability.families_mixed import room
from photizon_cl.stability.fresnel import fresnel_cases, measure_fresnel
from photizon_cl.stability.measure import measure
from photizon_cl.stability.report import BOUND, FAMILIES, Row, table
from photizon_cl.stability.rounding import rounded_elements, single, what_is_lost

SINGLE = 2.0**-24


def row(family, n, precision):
    found = measure(open_device(), islice(FAMILIES[family](), n), precision=precision)
    return Row(family, tuple(found), 0.0)


@pytest.mark.parametrize("family", ["sphere, tangent", "flat, tilt", "round, inside"])
def test_errors_keep_their_bound_in_units_of_the_mode(family):
    found = row(family, 40, "fp32")
    assert found.passed
    assert found.worst <= BOUND
    # the same answers are far off in units of doubles: it is another precision
    distances = [m.forward for m in found.measured if m.errors]
    assert max(distances) * SINGLE > 1e-9


def test_what_is_below_the_rounding_is_lost_and_not_passed():
    found = row("nearly coincident", 100, "mixed")
    assert not found.wrong
    assert 0 < len(found.lost) < found.cases
    assert found.verdict == f"{len(found.lost)} lost"
    text = table([found], "mixed")
    assert "in mixed 0 of 1 families survive whole, 1 in part" in text
    assert "u = 2^-24" in text
    assert "m apart in it" in text
    none = Row("all of it", found.lost, 0.0)
    assert not none.passed
    assert none.verdict == "LOST"
    # in double precision the same are asked, and pass
    assert not row("nearly coincident", 100, "fp64").verdict


def test_inputs_are_rounded_before_they_are_judged():
    (disk,) = rounded_elements((black(Disk, radius=0.1, at=(0.3, 0.0, 0.0)),))
    assert (disk.radius, disk.position[0]) == (single(0.1), single(0.3))
    case = aimed("rim", (disk,), (0.0, 0.0, 1.0), (0.05, 0.0, 0.0))
    (found,) = measure(open_device(), [case], precision="fp32")
    assert found.right
    assert found.worst < BOUND


def test_a_gap_that_rounding_closes_is_lost():
    near = [black(Disk, radius=1.0, at=(0.0, 0.0, z), name=f"d{z}") for z in (0.5, 0.5 + 1e-9)]
    assert "lengths 1.0e-09 m apart are 0.0e+00 m apart in it" in what_is_lost(tuple(near), SINGLE)
    far = [black(Disk, radius=1.0, at=(0.0, 0.0, z), name=f"d{z}") for z in (0.5, 0.75)]
    assert what_is_lost(tuple(far), SINGLE) == ""


def test_fresnel_in_single_precision():
    cases = list(islice(fresnel_cases(), 40))
    found = Row("fresnel", tuple(measure_fresnel(open_device(), cases, "fp32")), 0.0)
    assert not found.wrong
    assert found.worst <= BOUND
    assert any("off a face" in m.lost for m in found.measured)


CLOSED = ("tilted room of mirrors", "biconvex, mirrors")


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n in CLOSED else pytest.mark.slow) for n in closed_bodies()],
)
def test_nothing_leaks_out_of_closed_bodies(name):
    """10^6 interactions with roundings so coarse see more edges than 10^14 in double precision."""
    found = trace(
        closed_bodies()[name], rays_per_batch=500, generation_cap=2000, seed=1, plan=PLAN,
        precision="fp32", splitting=False, roulette_floor=0.0,
    )  # fmt: skip
    assert found.interactions == 500 * 2000
    assert found.escaped == 0


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (33.3, 0.0)])
def test_rays_at_edges_and_corners_stay_inside(tilt):
    rows = np.array(frame("+z", tilt))
    for low, high in (
        ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)),
        ((0.1, 0.1, 0.1), (0.4, 0.5, 0.7)),
        ((1e6, 2e6, -1e6), (1e6 + 0.7, 2e6 + 1.3, -1e6 + 0.2)),
    ):
        r = np.random.default_rng(6)
        corners, size = np.array((low, high)), np.subtract(high, low)
        ends = np.take_along_axis(corners, r.integers(0, 2, (2000, 3)), axis=0)
        along, edge = r.integers(0, 3, 2000), r.random(2000) < 0.6
        anywhere = corners[0] + size * r.random((2000, 3))
        ends[edge, along[edge]] = anywhere[edge, along[edge]]
        starts = corners[0] + size * r.uniform(0.1, 0.9, (2000, 3))
        found = follow(
            room(low, high, tilt, SILVER), starts @ rows, unit((ends - starts) @ rows), 30, "fp32"
        )
        assert (found.left != NO_FACE).all()
        assert not np.isnan(found.point).any()


def test_the_command_refuses_an_unknown_mode(capsys):
    assert main(["stability", "--precision", "fp8"]) == 2
    assert 'expected one of "fp64", "mixed", "fp32"' in capsys.readouterr().err
    with pytest.raises(pz.ArgumentError):
        pz.advisories(pz.load("box-room"), "fp8")
