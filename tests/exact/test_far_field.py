"""The far field about any axis: every ray in its bin, to rounding, and none lost."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from oracles import gates
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled
from oracles.scenes import AXES, beam

import photizon_cl as pz
from photizon_cl.scene.frames import frame

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

LAMP = {"kind": "lambertian-disk", "flux": 1.0, "position": [0, 0, 0], "radius": 0.1}


def lit(where, rays=4096, **far_field):
    return trace(
        scene_of([{**LAMP, "axis": where}], [], far_field=far_field), rays_per_batch=rays
    )  # fmt: skip


@pytest.mark.parametrize("axis", ["+z", "-x"])
def test_a_direction_on_an_edge_is_above_it(axis):
    gates.far_field_edges(axis)


@pytest.mark.parametrize("bins", [{"n_mu": 7}, {"n_theta": 9}])
def test_bins_turn_with_their_axis(bins):
    """A lamp and bins about the same axis: the same integers whichever axis that is."""
    want = lit("+z", axis="+z", n_phi=5, **bins)
    for axis in AXES[:-2] + AXES[-1:]:
        found = lit(axis, axis=axis, n_phi=5, **bins)
        assert found.far_field == want.far_field, axis
        assert (found.far_field_counts == want.far_field_counts).all(), axis


def test_bins_turn_with_a_tilt():
    """Some rays in 4096 at most are at an edge to rounding."""
    lamp = {**LAMP, "axis": "+x", "tilt_deg": [20.0, -35.0]}
    far_field = {"axis": "+x", "tilt_deg": [20.0, -35.0], "n_theta": 9, "n_phi": 5}
    found = trace(scene_of([lamp], [], far_field=far_field), rays_per_batch=4096)
    want = lit("+x", axis="+x", n_theta=9, n_phi=5)
    assert (found.far_field_counts == want.far_field_counts).all()


def test_cosines_about_the_other_way_are_the_usual_ones_from_the_other_end():
    """From −z, φ runs from +y towards +x: 90° less what it is from +x towards +y."""
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0]}
    a, b = (
        trace(scene_of([lamp], [], far_field={**axis, "n_mu": 6, "n_phi": 8}), rays_per_batch=4096)
        for axis in ({}, {"axis": "-z"})
    )
    turned = a.far_field_counts[::-1, [(1 - i) % 8 for i in range(8)]]
    assert (b.far_field_counts == turned).all()


def test_the_usual_bins_are_those_about_plus_z():
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0]}
    plain, said = (
        scene_of([lamp], [], far_field=far_field)
        for far_field in ({}, {"axis": "+z", "n_mu": 40, "n_phi": 32, "tilt_deg": [0, 0]})
    )
    assert plain.digest() == said.digest()
    assert compiled(plain).tables.spec == compiled(said).tables.spec
    assert plain.to_dict()["far_field"] == {"n_mu": 40, "n_phi": 32}


def test_edges_cut_the_same_light():
    """Bins between given edges hold what even ones between the same edges do; the rest escapes."""
    even = lit("-y", axis="-y", n_theta=18, n_phi=1)
    cut = lit("-y", axis="-y", theta_edges_deg=[20, 50, 60], n_phi=1)
    assert cut.far_field == [sum(even.far_field[2:5]), even.far_field[5]]
    assert cut.escaped == even.escaped == sum(even.far_field)
    assert 0 < sum(cut.far_field) < cut.escaped


def test_the_last_edge_belongs_to_the_last_bin():
    lamps = [beam((0, 0, 0), "+z", tilt_deg=[angle, 0.0]) for angle in (90.0, 180.0)]
    for edges, want in (([0, 45, 90], [0, 1]), ([0, 179, 180], [1, 1]), ([90, 180], [2])):
        far_field = {"theta_edges_deg": edges, "n_phi": 1}
        found = trace(scene_of(lamps, [], far_field=far_field), rays_per_batch=2)
        assert found.far_field_counts[:, 0].tolist() == want


def test_solid_angles_are_those_of_zones():
    edges = [0.0, 1e-6, 0.01, 30.0, 90.0, 179.5, 180.0]
    far = pz.FarField(theta_edges_deg=edges, n_phi=3)
    sines = [math.sin(math.radians(0.5 * angle)) for angle in edges]
    want = [4 * math.pi / 3 * (b - a) * (b + a) for a, b in pairwise(sines)]
    assert far.solid_angles == pytest.approx(want, rel=1e-13)
    assert math.fsum(far.solid_angles) == pytest.approx(4 * math.pi / 3, rel=1e-15)
    even = pz.FarField(n_theta=7, n_phi=2)
    assert math.fsum(even.solid_angles) == pytest.approx(2 * math.pi, rel=1e-15)
    assert (even.whole, far.whole) == (True, True)
    assert not pz.FarField(theta_edges_deg=[0, 90]).whole


def test_a_lambertian_disk_has_its_intensity():
    """I(θ) = (Φ/π) cos θ; a bin holds Φ (sin² b − sin² a). Counts of one batch are binomial."""
    edges = [0.0, 5.0, 20.0, 40.0, 60.0, 75.0, 90.0]
    scene = scene_of(
        [{**LAMP, "axis": "-z"}], [],
        far_field={"axis": "-z", "theta_edges_deg": edges, "n_phi": 1},
    )  # fmt: skip
    result = pz.trace(scene, batches=2, rays_per_batch=1 << 15)
    far = result.far_field
    squares = np.sin(np.radians(edges)) ** 2
    part = np.diff(squares)
    error = np.sqrt(part * (1 - part) * result.rays)
    # 6 bins at 5 σ: a false alarm in 300,000 seeds
    assert (np.abs(far.count[:, 0] - part * result.rays) < 5.0 * error).all()
    power = far.intensity * far.solid_angle
    assert power.sum() == pytest.approx(result.ledger.escaped.value, rel=1e-14)
    assert far.power == power.sum()
    assert far.theta_edges == pytest.approx(np.radians(edges))
    assert far.mu_edges == pytest.approx(np.cos(np.radians(edges)), abs=3e-16)


@pytest.mark.parametrize("axis", AXES)
def test_the_frame_is_that_of_the_table(axis):
    far = pz.FarField(axis=axis, n_theta=3)
    assert far.frame == frame(axis)
    assert far.turned == (axis != "+z")


def test_a_batch_that_puts_more_into_bins_than_escaped_is_told():
    from photizon_cl.result.ledger import check_batch

    scene = scene_of(
        [{**LAMP, "axis": "-z"}], [], far_field={"theta_edges_deg": [100, 180], "n_phi": 1}
    )
    made = compiled(scene)
    cells = np.zeros((made.layout.n_cells, 4), np.int64)
    whole = made.emitted >> 64
    cells[made.layout.escaped, 0] = whole
    for inside, bad in ((0, False), (whole, False), (whole + 1, True)):
        cells[made.layout.far_field, 0] = inside
        if bad:
            with pytest.raises(pz.RunError, match="the far field's total is not what escaped"):
                check_batch(made, 0, cells)
        else:
            check_batch(made, 0, cells)


def test_bins_are_the_same_however_it_is_run():
    lamp = {**LAMP, "axis": "-x"}
    board = {
        "kind": "disk", "position": [-0.2, 0, 0], "axis": "+x", "radius": 0.15,
        "surface": {"kind": "lambertian", "reflectance": 0.5},
    }  # fmt: skip
    far_field = {"axis": "-x", "theta_edges_deg": [1e-3, 0.1, 3, 30, 120], "n_phi": 3}
    made = compiled(scene_of([lamp], [board], far_field=far_field), rays_per_batch=2048)
    want = trace_compiled(made, 2).digest
    for choice in ({"tally_copies": 0}, {"lanes": 1, "tally_copies": 2}):
        assert trace_compiled(made, 2, plan=PLAN.with_(**choice)).digest == want, choice


@pytest.mark.parametrize("precision", [pytest.param("mixed", marks=pytest.mark.slow), "fp32"])
def test_single_precision_bins_what_it_traced(precision):
    """Bins of doubles, directions rounded to floats: the same rays but for some at the edges."""
    tables = {
        "schema": "photizon/1", "name": "lamp", "source": [{**LAMP, "axis": "-z", "name": "lamp"}],
        "far_field": {"axis": "-z", "theta_edges_deg": [0, 20, 50, 90], "n_phi": 2},
    }  # fmt: skip
    want = pz.trace(tables, batches=1, rays_per_batch=4096)
    found = pz.trace(tables, batches=1, rays_per_batch=4096, precision=precision)
    assert np.abs(found.far_field.count - want.far_field.count).max() <= 2
    assert found.far_field.power == found.ledger.escaped.value == 1.0
