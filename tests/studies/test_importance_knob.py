"""A cost study tries other shares of the rays that are sent towards targets, and none."""

from __future__ import annotations

import dataclasses
import json

import pytest

import photizon_cl as pz
from photizon_cl.studies.knobs import KNOBS, as_it_stands
from photizon_cl.studies.trial import Trial

KNOB = "importance.fraction"


@pytest.fixture(scope="module")
def scene():
    """A matt plate under a beam, and a small sensor that gets 4e-4 of what it scatters."""
    return pz.load({
        "schema": "photizon/1", "name": "far sensor",
        "run": {"rays_per_batch": 2048},
        "importance": {"toward": ["sensor"]},
        "source": [{"name": "beam", "kind": "collimated-disk", "flux": 1.0,
                    "position": [0.0, 0.0, 0.1], "axis": "-z", "radius": 1e-6}],
        "element": [
            {"name": "plate", "kind": "rectangle", "position": [0.0, 0.0, 0.0], "axis": "+z",
             "half_width": 10.0, "half_height": 10.0,
             "surface": {"kind": "lambertian", "reflectance": 0.8}},
            {"name": "sensor", "kind": "disk", "position": [0.0, 0.0, 1.0], "axis": "-z",
             "radius": 0.02, "surface": {"kind": "absorber"}, "detector": {}},
        ],
    })  # fmt: skip


def options_of(scene):
    return [option for knob in KNOBS for option in knob(scene, 64) if option.knob == KNOB]


def test_each_share_but_the_scenes_own(scene):
    for own, others in ((0.5, [0.0, 0.25, 0.75]), (0.25, [0.0, 0.75]), (0.0, [0.25, 0.75])):
        given = dataclasses.replace(
            scene, importance=dataclasses.replace(scene.importance, fraction=own)
        )
        found = options_of(given)
        assert [option.value for option in found] == others
        for option in found:
            path, _, value = option.written.partition(" = ")
            # as a user writes it: --set importance.fraction=0.25
            assert given.replace({path: json.loads(value)}) == option.scene


def test_none_where_nothing_is_sent(scene):
    assert options_of(dataclasses.replace(scene, importance=None)) == []
    black = dataclasses.replace(scene.element[0], surface=pz.Absorber())
    assert options_of(dataclasses.replace(scene, element=(black, scene.element[1]))) == []


@pytest.mark.slow
def test_none_of_them_is_biased_and_sending_none_is_noisier(scene):
    rows = {}
    for option in (as_it_stands(scene), *options_of(scene)):
        trial = Trial(option, "detectors.sensor.power", None)
        trial.advance(64, lambda: False)
        reference = rows.setdefault("reference", trial)
        rows[option.name] = trial.row(reference)
    none, own = rows["no importance"], rows["fp64"]
    # 3.2e-4 W arrive: by some 50 rays of 131 072, or by half of all. The σ of 64 batches is known
    # to 9 %; 0.2 of it is more than ten times as far as chance goes
    assert own.sigma < 0.2 * none.sigma
    assert own.estimate == pytest.approx(3.2e-4 / 1.0004, rel=5.0 * own.relative_sigma)
    assert not any(rows[option.name].is_biased for option in options_of(scene))
