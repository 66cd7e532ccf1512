"""Plates, folds, Brewster's angle, Malus's law, rhombs and metals, to 1e-12."""

from __future__ import annotations

import pytest
from oracles import brewster
from oracles.brewster import pile, reflectances, through_pile
from oracles.engine import trace
from oracles.polarised import CLOSE, ON, arriving
from oracles.statistics import batch_z, z_limit


@pytest.mark.parametrize(
    ("angle", "told", "mean"), [(60, 0.84347, 0.83069), (75, 0.61481, 0.59145)]
)
def test_a_plate_at_an_angle(angle, told, mean):
    """What textbooks give of n = 1.52, and what the mean at every face gives."""
    seen, without = arriving(pile(1, 1.52, angle, **ON)), arriving(pile(1, 1.52, angle))
    assert round(seen, 5) == told
    assert round(without, 5) == mean
    r_s, r_p = reflectances(angle, 1.52)
    assert abs(seen - 0.5 * (through_pile(r_s, 1) + through_pile(r_p, 1))) < CLOSE
    assert abs(without - through_pile(0.5 * (r_s + r_p), 1)) < CLOSE


def test_a_plate_passes_each_part_of_the_light_by_itself():
    brewster.plate_by_its_parts()


@pytest.mark.parametrize(("plates", "told", "floor"), [(1, 0.923077, 0.0), (2, 0.857143, 1e-15)])
def test_piles_of_plates(plates, told, floor):
    """R = 0.04 at each of their faces, which light meets squarely."""
    seen = arriving(pile(plates, 1.5, roulette_floor=floor, **ON))
    assert round(seen, 6) == told
    assert abs(seen - through_pile(0.04, plates)) < CLOSE


@pytest.mark.statistical
@pytest.mark.parametrize(
    ("plates", "angle"), [(4, 0.0), pytest.param(8, 0.0, marks=pytest.mark.slow), (3, 65.0)]
)
def test_larger_piles(plates, angle):
    """What weighs less than 1e-6 plays roulette: a false alarm in 10^6."""
    found = trace(pile(plates, 1.5, angle, roulette_floor=1e-6, **ON), batches=32)
    parts = reflectances(angle, 1.5) if angle else (0.04, 0.04)
    wanted = 0.5 * sum(through_pile(r, plates) for r in parts)
    cell = found.detector("end").cells.power
    assert abs(batch_z(found, lambda x: x[cell], wanted)) < z_limit(1e-6, 31)
    assert abs(float(found.detector("end").power) / 32 - wanted) < 1e-4


def test_two_folds():
    brewster.two_folds()


def test_brewsters_angle():
    brewster.brewster()


def test_malus():
    brewster.malus()


def test_fresnels_rhomb():
    brewster.rhomb()


def test_the_phase_of_total_reflection():
    brewster.near_the_critical_angle()


def test_metal():
    brewster.metal()


def test_thousands_of_reflections():
    assert brewster.a_long_way() > 1500


@pytest.mark.statistical
def test_one_of_two_children_goes_on_with_its_own_light():
    brewster.chooses_one_child()


@pytest.mark.statistical
def test_what_scatters_is_unpolarised():
    brewster.scattered_light_is_unpolarised()
