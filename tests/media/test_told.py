"""What is said of media: before a run, of its outcome, and in its texts."""

from __future__ import annotations

import math

import pytest
from oracles.scenes import BLACK, beam, wall
from scipy.integrate import quad

import photizon_cl as pz
from photizon_cl.checks.advisories import _passing, advisories
from photizon_cl.checks.coarse import coarse
from photizon_cl.run.media import clashing_media
from photizon_cl.views.report.story import summary

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

WATER = {"name": "water", "index": 1.333, "absorption_per_m": 2.0}


def scene(*elements, medium=WATER, **parts):
    """A beam along +z that starts in the medium, before a black plate."""
    lamp = {"name": "lamp", **beam((0, 0, 0), "+z", 1e-9), "medium": medium["name"]}
    names = [{"name": f"element {n}", **e} for n, e in enumerate(elements)]
    return pz.load({
        "schema": "photizon/1", "name": "s", "source": [lamp], "element": names,
        "medium": [medium], "run": {"rays_per_batch": 64}, **parts,
    })  # fmt: skip


def window(z, axis, **surface):
    return {**wall((0, 0, z), axis), "surface": {"kind": "fresnel", **surface}}


def plate(z, **more):
    return {**wall((0, 0, z), "-z"), **BLACK, **more}


def test_a_window_of_indices_in_what_absorbs_is_told():
    """Behind it nothing is absorbed: by indices no medium is named."""
    one = {"index": 1.5, "index_outside": 1.333}
    by_index = scene(window(1.0, "-z", **one), window(1.1, "+z", **one), plate(2.0))
    said = [text for text in advisories(by_index) if "leads to no medium" in text]
    assert len(said) == 2
    assert 'its index of 1.333 is that of medium "water"' in said[0]
    near = scene(window(1.0, "-z", index=1.5, index_outside=1.33), plate(2.0))
    assert any("leads to no medium" in text for text in advisories(near))
    # an index that is not the water's: how light bends says it
    dry = scene(window(1.0, "-z", index=1.5), window(1.1, "+z", index=1.5), plate(2.0))
    assert not any("leads to no medium" in text for text in advisories(dry))
    (text,) = clashing_media(dry)
    assert text.startswith('light that leaves the sources in a medium of index 1.333 meets "')
    clear = scene(window(1.0, "-z", **one), plate(2.0), medium={**WATER, "absorption_per_m": 0.0})
    assert not any("leads to no medium" in text for text in advisories(clear))


def test_where_all_is_in_water_and_says_so_nothing_is_asked():
    """A bubble: light meets it as from water, and ends in water."""
    bubble = {
        "kind": "sphere", "position": [0, 0, 1], "axis": "+z", "radius": 0.3,
        "surface": {"kind": "fresnel", "medium": "vacuum", "medium_outside": "water"},
    }  # fmt: skip
    assert clashing_media(scene(bubble, plate(2.0))) == []


def test_light_that_meets_nothing_is_not_said_to_escape_where_it_is_absorbed():
    fog = {"name": "fog", "index": 1.0, "absorption_per_m": 1e4}
    result = pz.trace(scene(plate(1.0), medium=fog), batches=2)
    (said,) = [text for text in result.advisories if "not one ray" in text]
    assert 'is absorbed in "fog"' in said
    assert "all of the power escapes" not in said
    assert "1 W in media" in repr(result.ledger)
    assert "was absorbed in fog" in str(summary(result)[0])


def test_a_run_without_detectors_goes_for_what_media_absorb():
    fog = {"name": "fog", "index": 1.0, "absorption_per_m": 1e4}
    result = pz.trace(scene(plate(1.0), medium=fog), max_seconds=30.0)
    assert result.converged
    assert result.achieved_sigma == 0.0
    assert result.batches < 100


@pytest.mark.parametrize("depth", [0.0, 1e-6, 4e-5, 6e-5, 1e-3, 0.3, 2.0, 40.0])
def test_matt_light_across_a_ball_is_dimmed_by_its_mean(depth):
    expected, _ = quad(lambda mu: 2.0 * mu * math.exp(-2.0 * depth * mu), 0.0, 1.0, epsabs=1e-14)
    assert _passing(depth) == pytest.approx(expected, rel=2e-8)


def test_a_cavity_that_is_full_of_dye_is_not_said_to_trap_light():
    def of(alpha):
        dye = {"name": "dye", "index": 1.0, "absorption_per_m": alpha}
        white = {
            "name": "wall", "kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.1,
            "surface": {"kind": "lambertian", "reflectance": 1.0},
        }  # fmt: skip
        return [t for t in advisories(scene(white, medium=dye)) if "still alive" in t]

    assert len(of(0.0)) == len(of(0.01)) == 1
    assert of(20.0) == []


def test_a_border_that_rounding_moves_by_more_than_a_film_leaves_is_told():
    film = {"name": "film", "index": 1.0, "absorption_per_m": 1e5}
    thin = scene(
        window(0.7, "-z", medium="film"), window(0.70001, "+z", medium="film"), plate(1.0),
        medium=film,
    )  # fmt: skip
    texts = [t for t in coarse(thin, 2.0**-24) if 'a border of medium "film"' in t]
    assert len(texts) == 2
    assert not any("a border of medium" in t for t in coarse(thin))
    many = scene(*(window(0.1 * n, "-z", medium="film") for n in range(1, 23)), medium=film)
    texts = list(coarse(many, 2.0**-24))
    assert texts[-1] == "2 more elements are such borders"
    far = thin.replace({
        f'element."element {n}".position': (0.0, 0.0, 1e6 + z)
        for n, z in enumerate((0.7, 0.70001))
    })  # fmt: skip
    assert any("a border of medium" in t for t in coarse(far))


def test_arrivals_too_faint_for_the_tallys_unit_are_told():
    fog = {"name": "fog", "index": 1.0, "absorption_per_m": 1.0}

    def said(alpha):
        made = scene(plate(1.0, detector={}), medium={**fog, "absorption_per_m": alpha})
        return [t for t in pz.trace(made, batches=2).advisories if "in units of" in t]

    (text,) = said(60.0)
    assert '"element 0" has 8.8e-27 of the weight' in text
    assert said(50.0) == []


@pytest.mark.parametrize("length", [-1.0, math.nan, -math.inf, True, "x", None])
def test_a_way_that_is_no_length_is_refused(length):
    with pytest.raises(pz.PhotizonError, match="a way is"):
        pz.Medium("glass", 1.5, 20.0).transmittance(length)


def test_what_names_media_has_no_numbers_by_itself():
    glass = pz.Fresnel(medium="water")
    ball = pz.Sphere(name="ball", position=(0, 0, 0), axis="+z", radius=0.1, surface=glass)
    lamp = pz.IsotropicPoint(name="lamp", flux=1.0, position=(0, 0, 1))
    water = pz.Medium(name="water", index=1.333)
    with pytest.raises(pz.ArgumentError, match=r'media "water" and "vacuum" by name, expected ind'):
        _ = glass.critical_angle_deg
    whole = pz.Scene("s", (lamp,), (ball,), medium=(water,)).optics[glass]
    assert whole.normal_reflectance == pytest.approx((0.333 / 2.333) ** 2, rel=1e-15)
