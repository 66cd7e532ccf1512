"""Stacks of films: the kernels against another program's matrices, and against 50 digits."""

from __future__ import annotations

import math
from functools import cache
from itertools import product

import numpy as np
import pytest
from oracles import coatings
from oracles.coatings import BAND, MGF2, MIRROR_OF_12, glass, in_digits, met, plates, stack

import photizon_cl as pz

LINES = [400.0, 550.0, 700.0, 1064.0]
ANGLES = [0.0, 5.0, 20.0, 41.0, 42.0, 60.0, 75.0, 85.0]
"""Two of them are around the critical angle of glass in air."""
METAL = stack((1.46, 80.0), (0.05, 15.0, 3.9), (2.3, 60.0, 0.02))
CASES = {
    "MgF2 on glass": glass(MGF2),
    "12 layers": glass(MIRROR_OF_12),
    "a filter that lets a band pass": glass(BAND),
    "metal and dielectrics": glass(METAL),
    "on dense glass, out into water": glass(MIRROR_OF_12, 1.8, 1.333),
    "from glass into air": glass(METAL, 1.0, 1.5),
    "one film": glass(stack((2.0, 137.5))),
    "equal indices on both sides": glass(METAL, 1.5, 1.5),
}


@cache
def kernels(lanes: int = 1, precision: str = "fp64"):
    """Return what the kernel gives of all cases, lines, angles and sides, and which is which."""
    made = plates(list(CASES.values()), precision, spectrum={"wavelengths_nm": LINES})
    which = list(product(range(len(CASES)), range(len(LINES)), ANGLES, (False, True)))
    element, line, angle, inside = map(np.array, zip(*which, strict=True))
    return made, which, met(made, element, line, angle, inside, lanes)


def by_tmm(tmm, surface, nm, angle, inside):
    """Return R and T of another program (S. J. Byrnes, arXiv:1603.02720)."""
    index = [complex(y.index, y.extinction) for y in surface.coating.layers]
    thickness = [y.thickness_nm for y in surface.coating.layers]
    before, behind = surface.index_outside, surface.index
    if inside:
        index, thickness, before, behind = index[::-1], thickness[::-1], behind, before
    parts = [
        tmm.coh_tmm(
            polarisation, [before, *index, behind], [math.inf, *thickness, math.inf],
            math.radians(angle), nm,
        )
        for polarisation in "sp"
    ]  # fmt: skip
    r, t = (sum(part[name] for part in parts) / 2 for name in "RT")
    return r, 0.0 if before * math.sin(math.radians(angle)) >= behind else t


def test_every_part_is_that_of_another_program():
    """From both sides, below and beyond the critical angle, to 1e-12."""
    tmm = pytest.importorskip("tmm")
    made, which, found = kernels()
    for (n, line, angle, inside), r, t in zip(which, *found, strict=True):
        surface = made.scene.element[n].surface
        wanted = by_tmm(tmm, surface, LINES[line], angle, inside)
        assert (r, t) == pytest.approx(wanted, abs=1e-12), (n, line, angle, inside)


def test_every_part_is_that_of_fifty_digits():
    coatings.stacks_in_digits()


@pytest.mark.parametrize("lanes", [8, pytest.param(16, marks=pytest.mark.slow)])
def test_lanes_change_no_bit(lanes):
    for one, many in zip(kernels()[2], kernels(lanes)[2], strict=True):
        assert one.tobytes() == many.tobytes()


@pytest.mark.parametrize(
    ("precision", "room"),
    [("mixed", 2e-5), pytest.param("fp32", 2e-5, marks=pytest.mark.slow)],
)
def test_single_precision_is_as_good_as_its_phases(precision, room):
    """Films of up to 12 times a quarter wave: phases of some ten radians, rounded to 6e-8."""
    for one, other in zip(kernels()[2], kernels(1, precision)[2], strict=True):
        assert np.abs(one - other).max() < room


def test_a_stack_without_extinction_takes_nothing():
    """To the rounding of the split: of the two the larger one is what the smaller leaves."""
    made, which, (r, t) = kernels()
    lossless = [made.scene.element[n].surface.coating.lossless for n, *_ in which]
    whole = (r + t)[lossless]
    assert len(whole) > 100
    assert np.abs(whole - 1.0).max() <= 2.0**-53
    assert ((r + t)[np.invert(lossless)] < 1.0).all()


def test_beyond_the_critical_angle_nothing_passes():
    made, which, (r, t) = kernels()
    seen = 0
    for (n, _, angle, inside), reflected, passed in zip(which, r, t, strict=True):
        s = made.scene.element[n].surface
        before, behind = (s.index, s.index_outside) if inside else (s.index_outside, s.index)
        if before * math.sin(math.radians(angle)) > behind:
            seen += 1
            assert passed == 0.0
            assert (reflected == 1.0) == s.coating.lossless
    assert seen > 100


def test_the_same_passes_from_both_sides():
    """T is the same for a ray and for the one that goes back, whatever the layers absorb."""
    made = plates([glass(METAL)], spectrum={"wavelengths_nm": LINES})
    outside = np.array([10.0, 40.0, 70.0, 85.0])
    within = np.degrees(np.arcsin(np.sin(np.radians(outside)) / 1.5))
    _, there = met(made, 0, 1, outside, inside=False)
    _, back = met(made, 0, 1, within, inside=True)
    assert there == pytest.approx(back, rel=1e-13)
    assert (there > 0.0).all()


# -- the ends --------------------------------------------------------------------------------------

ENDS = {
    "nothing on glass": stack((1.38, 0.0)),
    "of the glass itself": stack((1.5, 400.0)),
    "of what is outside": stack((1.0, 400.0)),
    "a millimetre of metal": stack((0.2, 1e6, 6.0)),
    "a tenth of a millimetre that absorbs a little": stack((1.4, 1e5, 1e-5), (2.0, 50.0)),
    "metal beneath films": stack(*[(1.45, 95.0), (2.3, 60.0)] * 4, (0.2, 1e5, 6.0)),
    "a gap of air": stack((1.0, 200.0), (1.5, 50.0), (1.0, 3000.0)),
    "the most refracting": stack((1000.0, 1.0), (0.001, 1.0), (3.0, 2.0, 1000.0)),
    "a faint loss": stack((1.38, 99.6, 1e-12)),
}


def test_no_end_of_the_parameters_is_worse_than_its_phases():
    """Thick, absorbing, equal, none: within the rounding of the phases, and never no number."""
    lines = [250.0, 550.0]
    cases = [glass(coating) for coating in ENDS.values()]
    made = plates(cases, spectrum={"wavelengths_nm": lines})
    # straight on, around the critical angles of the glass and of a layer, and along the face
    angles = [
        0.0,
        1e-6,
        30.0,
        math.degrees(math.asin(1 / 1.5)),
        41.8103148,
        41.81032,
        80.0,
        89.9999,
    ]
    which = list(product(range(len(cases)), range(2), angles, (False, True)))
    element, line, angle, inside = map(np.array, zip(*which, strict=True))
    r, t = met(made, element, line, angle, inside)
    assert (r >= 0.0).all()
    assert (t >= 0.0).all()
    for (n, k, a, within), reflected, passed in zip(which, r, t, strict=True):
        surface = made.scene.element[n].surface
        turn = math.radians(a)
        wanted = in_digits(surface, lines[k], math.sin(turn), math.cos(turn), inside=within)
        waves = sum(y.thickness_nm * y.index for y in surface.coating.layers) / lines[k]
        # an angle is known to rounding, which counts as its root at a critical one
        hard = a in angles[3:6] and within
        room = 2e-13 * (1.0 + waves) + (1e-6 if hard else 0.0)
        assert (reflected, passed) == pytest.approx(wanted, abs=room), (n, k, a, within)


def test_what_hardly_passes_is_known_in_parts_of_itself():
    """A filter that blocks 1e-10: what stray light is made of."""
    blocking = stack(*[(2.3, 59.8), (1.45, 94.8)] * 25)
    made = plates([glass(blocking)], spectrum={"wavelengths_nm": [550.0]})
    r, t = met(made, 0, 0, np.array([0.0, 10.0]), inside=False)
    surface = made.scene.element[0].surface
    for k, angle in enumerate((0.0, 10.0)):
        turn = math.radians(angle)
        _, wanted = in_digits(surface, 550.0, math.sin(turn), math.cos(turn), inside=False)
        assert wanted < 1e-9
        assert t[k] == pytest.approx(wanted, rel=1e-11)
        assert r[k] == 1.0 - t[k]


def test_along_the_face_everything_is_reflected():
    made = plates([glass(MGF2), glass(METAL)], spectrum={"wavelengths_nm": [550.0]})
    for n, inside in product(range(2), (False, True)):
        r, t = met(made, n, 0, np.array([90.0]), inside=inside)
        assert t[0] < 1e-290
        assert r[0] == 1.0


# -- in Python -------------------------------------------------------------------------------------


def test_python_says_what_kernels_do():
    made, which, (r, t) = kernels()
    for (n, line, angle, inside), reflected, passed in zip(which, r, t, strict=True):
        s = made.scene.element[n].surface
        said = s.coating.powers(angle, s.index, s.index_outside, nm=LINES[line], inside=inside)
        assert (reflected, passed) == pytest.approx(tuple(map(float, said)), abs=1e-12)


def test_a_quarter_wave_on_glass_in_closed_form():
    coating = pz.StackCoating(layers=[pz.Layer(1.38, 550.0 / 4.0 / 1.38)])
    r, t = coating.powers(0.0, 1.5168, nm=550.0)
    assert r == pytest.approx(((1.5168 - 1.38**2) / (1.5168 + 1.38**2)) ** 2, rel=1e-13)
    assert t == pytest.approx(1.0 - r, rel=1e-15)
    waves = coating.amplitudes(0.0, 1.5168, nm=550.0)
    assert abs(waves.r_s) ** 2 == pytest.approx(r, rel=1e-13)
    assert waves.r_p == pytest.approx(-waves.r_s, abs=1e-15)
    with pytest.raises(pz.ArgumentError, match="found no wavelength"):
        coating.powers(0.0, 1.5)
    with pytest.raises(pz.ArgumentError, match="angle_deg: found 95"):
        coating.powers(95.0, 1.5, nm=550.0)
    with pytest.raises(pz.ArgumentError, match="index: found"):
        coating.powers(5.0, 0.0, nm=550.0)
    with pytest.raises(pz.ArgumentError, match="nm: found the wavelength 0"):
        coating.powers(5.0, 1.5, nm=0)
