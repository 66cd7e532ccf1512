"""Coatings of given numbers, and mirrors by angle: the kernels' parts from either side."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from oracles import coatings
from oracles.coatings import glass, met, plates
from oracles.engine import scene_of, trace
from oracles.kernels import LIBRARIES, run_text
from oracles.scenes import beam, wall

import photizon_cl as pz

FIXED = {"kind": "fixed", "reflectance": 0.25, "transmittance": 0.5}
TABLE = {
    "kind": "table",
    "angle_deg": [0.0, 20.0, 45.0, 60.0, 90.0],
    "reflectance": [0.05, 0.05, 0.1, 0.2, 0.75],
    "transmittance": [0.9, 0.85, 0.8, 0.6, 0.125],
}
ANGLES = np.array([0.0, 1e-7, 10.0, 20.0, 33.0, 41.0, 42.0, 45.0, 60.0, 77.0, 89.999, 90.0])


def within(index: float, outside: float = 1.0) -> np.ndarray:
    """Return which of the angles are below the critical one, behind the normal."""
    return index * np.sin(np.radians(ANGLES)) < outside


def test_two_numbers_are_the_same_from_both_sides():
    """Beyond the critical angle of either side what would pass is reflected."""
    made = plates([glass(FIXED), glass(FIXED, 1.0, 1.5)])
    for element, inside, passes in (
        (0, False, ANGLES < 91.0), (0, True, within(1.5)), (1, False, within(1.5)),
        (1, True, ANGLES < 91.0),
    ):  # fmt: skip
        r, t = met(made, element, 0, ANGLES, inside)
        assert r.tolist() == np.where(passes, 0.25, 0.75).tolist()
        assert t.tolist() == np.where(passes, 0.5, 0.0).tolist()


def test_a_table_is_read_at_the_angle_outside():
    coatings.table_from_both_sides()


def test_a_table_beyond_the_critical_angle():
    """From inside as at 90°; where outside is denser at the angle there."""
    made = plates([glass(TABLE), glass(TABLE, 1.0, 1.5)])
    r, t = met(made, 0, 0, ANGLES[~within(1.5)], inside=True)
    assert set(r.tolist()) == {0.875}
    assert not t.any()
    beyond = ANGLES[~within(1.5)]
    r, t = met(made, 1, 0, beyond, inside=False)
    both = np.array(TABLE["reflectance"]) + np.array(TABLE["transmittance"])
    assert r == pytest.approx(np.interp(beyond, TABLE["angle_deg"], both), abs=1e-15)
    assert not t.any()


@pytest.mark.parametrize("lanes", [8])
def test_lanes_change_no_bit(lanes):
    made = plates([glass(FIXED), glass(TABLE), glass(None)])
    which = np.arange(3)[:, None, None]
    sides = np.array([False, True])[:, None]
    one, many = (met(made, which, 0, ANGLES, sides, n) for n in (1, lanes))
    assert [a.tobytes() for a in one] == [a.tobytes() for a in many]
    bare = plates([glass(None)])
    assert "coated-faces" not in bare.effects


def test_a_mirror_by_angle_reflects_the_same_on_both_sides():
    """Constant beyond its nodes, and a number beside a table stays that."""
    curve = {"angle_deg": [10.0, 30.0, 80.0], "value": [0.9, 0.8, 0.5]}
    made = plates([{"kind": "mirror", "reflectance": x} for x in (curve, 0.6)])
    wanted = np.interp(ANGLES, curve["angle_deg"], curve["value"])
    for inside in (False, True):
        r, t = met(made, 0, 0, ANGLES, inside)
        assert r == pytest.approx(wanted, abs=2e-16)
        assert not t.any()
        r, _ = met(made, 1, 0, ANGLES, inside)
        assert set(r.tolist()) == {0.6}


def test_python_says_what_kernels_do():
    made = plates([glass(FIXED), glass(TABLE)])
    for n in range(2):
        coating = made.scene.element[n].surface.coating
        for inside in (False, True):
            r, t = met(made, n, 0, ANGLES, inside)
            said = coating.powers(ANGLES, 1.5, inside=inside)
            assert r == pytest.approx(said[0], abs=1e-14)
            assert t == pytest.approx(said[1], abs=1e-14)


def test_parts_that_add_up_to_one_leave_nothing():
    """0.7 + 0.3 and 0.9 + 0.1 are rounded: nothing is absorbed all the same."""
    for r in (0.3, 0.1, 0.35, 1.0 / 3.0, 0.07):
        assert pz.FixedCoating(reflectance=r, transmittance=1.0 - r).lossless
    assert pz.FixedCoating(reflectance=0.07, transmittance=0.93).lossless
    assert not pz.FixedCoating(reflectance=0.07, transmittance=0.9299999999999).lossless
    assert pz.TableCoating((0, 90), (0.1, 1.0), (0.9, 0.0)).lossless
    assert not pz.TableCoating((0, 90), (0.1, 1.0), (0.8, 0.0)).lossless
    made = plates([glass({"kind": "fixed", "reflectance": 0.07, "transmittance": 0.93})])
    r, t = met(made, 0, 0, ANGLES, inside=False)
    assert set(zip(r.tolist(), t.tolist(), strict=True)) == {(0.07, 1.0 - 0.07)}


def test_two_numbers_over_wavelength_by_line_and_in_bands():
    curve = {"wavelength_nm": [400.0, 500.0, 700.0], "value": [0.1, 0.3, 0.2]}
    coating = {"kind": "fixed", "reflectance": curve, "transmittance": 0.6}
    lines = [400.0, 450.0, 600.0, 700.0]
    made = plates([glass(coating)], spectrum={"wavelengths_nm": lines})
    r, t = met(made, 0, np.arange(4), 20.0, inside=False)
    assert r == pytest.approx([0.1, 0.2, 0.25, 0.2], abs=1e-16)
    assert set(t.tolist()) == {0.6}
    # in bands what a mirror takes of the same rays that reflects what the two come to
    both = {**curve, "value": [0.7, 0.9, 0.8]}
    absorbed = []
    for surface in (glass(coating), {"kind": "mirror", "reflectance": both}):
        board = {**wall((0, 0, 0), "+z", 9.0), "surface": surface}
        bands = {"edges_nm": [400, 500, 700]}
        found = trace(scene_of([beam((0, 0, 1), "-z")], [board], spectrum=bands), rays_per_batch=64)
        absorbed.append(float(found.absorbed("element 0") / found.emitted))
        assert max(map(abs, found.closures())) <= 1e-15
    assert absorbed[0] == pytest.approx(absorbed[1], abs=1e-12)
    assert 0.1 < absorbed[0] < 0.3


# -- angles ----------------------------------------------------------------------------------------

ATAN = """
__kernel void test(__global const double *s, __global const double *c, __global double *out) {
    const size_t i = get_global_id(0);
    STORE(degrees_of(LOAD(s, i), LOAD(c, i)), out, i);
}
"""


def test_angles_from_sine_and_cosine():
    r = np.random.default_rng(3)
    angle = np.concatenate([r.uniform(0.0, 90.0, 990), 10.0 ** r.uniform(-300, -1, 10)])
    s, c = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    s = np.concatenate([s, [0.0, 1.0, 1.0, math.sqrt(0.5), 1e-300, 1.0, 0.0, 3.0]])
    c = np.concatenate([c, [1.0, 0.0, 1.0, math.sqrt(0.5), 1.0, 1e-300, 2.0, 3.0]])
    arguments = [s, c, np.zeros(len(s))]
    found = run_text(ATAN, arguments, len(s), lanes=8, libraries=(*LIBRARIES, "lib/angles"))[2]
    assert found[-8:].tolist()[:4] == [0.0, 90.0, 45.0, 45.0]
    assert found[-2:].tolist() == [0.0, 45.0]
    with mpmath.workdps(40):
        for sine, cosine, got in zip(s, c, found, strict=True):
            exact = mpmath.degrees(mpmath.atan2(mpmath.mpf(sine), mpmath.mpf(cosine)))
            room = 3e-14 if exact > 1 else 3e-16 * float(exact)
            assert abs(float(exact - mpmath.mpf(got))) <= room
