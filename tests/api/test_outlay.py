"""``check`` tells how long a run takes to its target."""

from __future__ import annotations

import dataclasses

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.result.outlay import Outlay
from photizon_cl.run.outlay import outlay

pytestmark = pytest.mark.usefixtures("built_quickly")


def asked(name, **run):
    scene = pz.load(name)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, **run))


def test_it_tells_as_many_rays_as_a_run_takes():
    scene = asked("box-room", target_sigma=0.02, rays_per_batch=4096)
    told = outlay(scene)
    run = pz.trace(scene)
    assert run.converged
    # the median over 1024 bins, by 131 072 rays or fewer on a slow machine
    assert told.batches == pytest.approx(run.batches, rel=0.25)
    assert told.rays >= 8 * 2048
    assert 0.0 < told.low < told.seconds < told.high


def test_what_no_ray_scatters_takes_the_fewest_batches():
    told = outlay(asked("ghost-ladder"))
    assert told.batches == 8.0


def test_nothing_is_told_where_nothing_arrives_or_bins_are_too_many():
    scene = pz.Scene(
        name="dark",
        source=[pz.CollimatedDisk(name="s", position=[0, 0, 0], axis="+z", radius=0.1, flux=1.0)],
        element=[
            pz.Rectangle(
                name="r", position=[0, 0, -1], axis="+z", half_width=1.0, half_height=1.0,
                surface=pz.Absorber(), detector=pz.Detector(map=[4, 4]),
            )
        ],
    )  # fmt: skip
    told = outlay(scene)
    assert str(told).startswith("not told: nothing arrives of ")
    (said,) = told.advice()
    assert f'of {told.rays} rays none arrives at the detector on "r": is it where' in said
    wide = dataclasses.replace(scene.element[0], detector=pz.Detector(map=(2048, 2048)))
    told = outlay(dataclasses.replace(scene, element=(wide,)))
    assert str(told).startswith("not told: the scene has very many bins")
    assert told.advice() == []


def test_a_dark_detector_beside_a_lit_one_is_told():
    tables = pz.load("cosine-fourth").to_dict()
    aside = {
        "name": "aside", "kind": "disk", "position": [0, 0, 5.0], "axis": "+z", "radius": 0.1,
        "surface": {"kind": "absorber"}, "detector": {},
    }  # fmt: skip
    told = outlay(pz.load({**tables, "element": [*tables["element"], aside]}))
    assert told.seconds > 0.0
    assert told.dark == ("aside",)
    assert any('the detector on "aside"' in text for text in told.advice())


def test_where_the_time_will_not_do_it_is_advised():
    told = Outlay(1000, 0.01, 240.0, 200.0, 300.0, 500.4, 1.0, 60.0)
    assert str(told) == (
        "about 4 min of tracing to the target of 1 % (3.3 min to 5 min), 500 batches, as 1000 rays "
        "tell"
    )
    dark = dataclasses.replace(told, lit=0.3)
    assert str(dark).endswith(
        "as 1000 rays tell; of the bins these light 30 %, and where the others come to count it "
        "may take far longer"
    )
    # four times the seconds are twice the σ
    (said,) = told.advice()
    assert said == (
        "the target of 1 % takes about 4 min here, and max_seconds ends the run after 60 s, at "
        "about 2 %: raise max_seconds, or target_sigma"
    )
    assert dataclasses.replace(told, seconds=89.0).advice() == []
    assert "at about" in dataclasses.replace(told, seconds=91.0).advice()[0]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.5, "0.5 s"), (99.0, "99 s"), (120.0, "2 min"), (7200.0, "2 h"), (8.64e6, "1e+02 days")],
)
def test_times_are_said_in_units_that_fit(seconds, text):
    assert f"about {text} of tracing to" in str(Outlay(1, 0.1, seconds, 1.0, 2.0, 1.0, 1.0, 60.0))


def test_check_says_it(capsys):
    assert main(["check", "box-room", "--target", "0.0001"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "time: about " in said
    assert "to the target of 0.01 %" in said
    assert "- the target of 0.01 % takes about" in said
    assert "max_seconds ends the run after 60 s" in said
    assert main(["check", "box-room", "--target", "2"]) == 2
    assert "target_sigma" in capsys.readouterr().err
    assert main(["check", "box-room", "--no-pilot"]) == 0
    assert "time: about" not in capsys.readouterr().out
