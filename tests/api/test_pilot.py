"""A pilot tells before a run what the generation cap will cut, and after it why it did."""

from __future__ import annotations

import re

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.result.pilot import NEGLIGIBLE
from photizon_cl.run import pilot as module
from photizon_cl.run.pilot import pilot

pytestmark = pytest.mark.usefixtures("built_quickly")

LAMP = pz.IsotropicPoint(name="lamp", flux=1, position=(0.001, -0.002, 0.003))


def scene(*elements, source=LAMP, **run):
    settings = pz.RunSettings(**{"rays_per_batch": 1024, **run})
    return pz.Scene(name="pilot", source=(source,), element=elements, run=settings)


def ball(surface, **parameters):
    return pz.Sphere(
        name="ball", position=(0, 0, 0), axis="+z", radius=1.0, surface=surface, **parameters
    )


def cube(surface, half=0.01):
    """Return six faces that look outwards, around the origin."""
    found = []
    for n, letter in enumerate("xyz"):
        for sign, word in ((-1.0, "-"), (1.0, "+")):
            at = [0.0, 0.0, 0.0]
            at[n] = sign * half
            found.append(
                pz.Rectangle(name=f"face {word}{letter}", position=tuple(at),
                             axis=f"{word}{letter}", half_width=half, half_height=half,
                             surface=surface)
            )  # fmt: skip
    return found


def glass_cube(**run):
    return scene(*cube(pz.Fresnel(1.5)), ball(pz.Absorber()), **{"generation_cap": 300, **run})


def white_box(**run):
    """Return a closed white box with a small black body in it."""
    body = pz.Sphere(
        name="body", position=(0.3, 0, 0), axis="+z", radius=0.2, surface=pz.Absorber()
    )
    return scene(*cube(pz.Lambertian(1.0), half=1.0), body, **run)


# -- what it measures ----------------------------------------------------------------------------


def test_a_decay_by_absorption_is_measured_exactly():
    found = pilot(scene(ball(pz.Mirror(0.9))))
    assert [m for m, _ in found.left] == [16, 32, 64, 128, 256]
    assert [part for _, part in found.left] == pytest.approx([0.9**m for m, _ in found.left], 1e-12)
    assert (found.interactions, found.missed, found.complete) == (32.0, 0.0, True)
    assert found.needed_cap == 140  # ln 1e-6 / ln 0.9 = 131.1, to two digits
    assert "raise generation_cap to about 140" in found.before(1024)
    assert "by the decay up to" not in found.before(1024)


def test_the_cap_that_it_names_leaves_what_it_says():
    cut = scene(ball(pz.Lambertian(0.97)))
    found = pilot(cut)
    mended = cut.replace({"run.generation_cap": found.needed_cap})
    assert pilot(mended).capped <= NEGLIGIBLE
    assert pilot(mended).before(1024) == ""
    result = pz.trace(mended, batches=2)
    assert 0.0 < result.ledger.depth_capped.value <= NEGLIGIBLE
    assert not [text for text in result.advisories if "generation cap" in text]


def test_a_decay_by_escape_is_measured_by_the_rays_that_are_left():
    found = pilot(scene(ball(pz.Lambertian(1.0), port_fraction=0.05)))
    assert 200 <= found.needed_cap <= 350  # ln 1e-6 / ln 0.95 = 269
    assert found.left[-1][1] == 0.0


def test_what_escapes_without_an_interaction():
    away = pz.CollimatedDisk(name="beam", flux=3, position=(5, 0, 0), axis="+x", radius=0.1)
    at = pz.CollimatedDisk(name="at", flux=1, position=(5, 0, 0), axis="-x", radius=0.1)
    both = pz.Scene(name="two", source=(away, at), element=(ball(pz.Absorber()),))
    found = pilot(both)
    assert (found.missed, found.interactions) == (0.75, 0.25)
    assert found.before(1024) == ""


# -- light that is trapped -----------------------------------------------------------------------


def test_light_in_total_reflection_is_told_as_trapped():
    text = pilot(glass_cube()).before(1024)
    assert "nothing of that is lost" in text
    assert "It is trapped" in text
    assert "a higher cap does not help" in text
    assert "raise generation_cap" not in text


@pytest.mark.parametrize("surface", [pz.Mirror(1.0), pz.Lambertian(1.0)], ids=["mirror", "white"])
def test_a_closed_body_that_takes_nothing_never_lets_go(surface):
    found = pilot(scene(ball(surface)))
    assert {part for _, part in found.left} == {1.0}
    assert found.needed_cap is None
    assert "nothing of that is lost from 16 interactions on" in found.before(1024)


def test_what_decays_more_slowly_than_any_cap_is_said_as_both_possibilities():
    found = pilot(scene(ball(pz.Mirror(1.0 - 1e-6))))
    assert found.needed_cap is None
    text = found.before(1024)
    assert "Either most of it is trapped" in text
    assert "so slowly that it would take a cap of about 1e+07" in text


def test_a_slow_decay_is_not_called_trapped():
    found = pilot(scene(ball(pz.Mirror(0.999))))
    assert found.needed_cap == pytest.approx(13800, rel=0.02)  # ln 1e-6 / ln 0.999 = 13809
    assert "trapped" not in found.before(1024)
    assert "by the decay up to a cap of" in found.before(1024)


def test_a_closed_white_box_is_told_beforehand():
    found = pilot(white_box())
    assert 0.3 < found.capped < 0.8
    assert 500 <= found.needed_cap <= 1000
    assert pilot(white_box(generation_cap=found.needed_cap)).before(1024) == ""


SOME_PRESETS = ("integrating-sphere", "plano-convex-condenser", "box-room")

# -- silence -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "preset",
    [
        # a path that is long, one that splits, one of many elements; the others say no more
        pytest.param(name, marks=() if name in SOME_PRESETS else pytest.mark.slow)
        for name in pz.presets()
    ],
)
def test_nothing_is_said_of_the_presets(preset):
    loaded = pz.load(preset)
    found = pilot(loaded)
    assert found.complete
    assert found.before(loaded.run.rays_per_batch) == ""


# -- what it costs and changes -------------------------------------------------------------------


def test_it_changes_no_bit_and_builds_the_program_of_the_trace(monkeypatch):
    from hostcode.program import build

    loaded = white_box(generation_cap=8)
    loaded = loaded.replace({"run.seed": 11})
    digest = pz.trace(loaded, batches=2).tally_digest
    programs = dict(build._CACHE)
    found = pilot(loaded)
    assert pilot(loaded) == found
    assert pilot(loaded.replace({"run.seed": 12})) == found  # a stream of its own
    assert programs == build._CACHE
    assert pz.trace(loaded, batches=2).tally_digest == digest


def test_large_maps_take_no_memory(monkeypatch):
    cells = []

    class Counted(module.Engine):
        def __init__(self, device, tables, plan):
            cells.append(tables.n_cells)
            super().__init__(device, tables, plan)

    monkeypatch.setattr(module, "Engine", Counted)
    plate = pz.Rectangle(name="plate", position=(0, 0, 0), axis="+z", half_width=1, half_height=1,
                         surface=pz.Absorber(), detector=pz.Detector(map=(4096, 4096)))  # fmt: skip
    pilot(scene(plate))
    assert max(cells) < 20


def test_rays_that_split_without_end_are_given_up_and_told(monkeypatch):
    monkeypatch.setattr(module, "_BUDGET", 1 << 16)
    slabs = [
        pz.Rectangle(name=f"s{n}", position=(0, 0, 0.01 * n), axis="+z", half_width=9.0,
                     half_height=9.0, surface=pz.Fresnel(4.0, 1.0))
        for n in range(1, 12)
    ]  # fmt: skip
    found = pilot(scene(*slabs, generation_cap=64, roulette_floor=0.0))
    assert not found.complete
    assert "and had not ended at the generation cap of 64" in found.before(2**24)
    assert found.before(1024) == ""  # a batch of so few is no matter


# -- check, run, files ---------------------------------------------------------------------------


def test_check_and_run_say_the_same_of_trapped_light(tmp_path, capsys):
    path = tmp_path / "cube.toml"
    glass_cube().save(path)
    assert main(["check", str(path)]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "pilot: 512 rays, " in told
    assert "% is left at the cap of 300" in told
    assert "advisories: 1 - by a pilot" in told
    assert "a higher cap does not help" in told
    result = pz.trace(path, batches=2)
    (text,) = [text for text in result.advisories if "generation cap" in text]
    assert "a higher cap does not help" in text
    assert "raise generation_cap" not in text
    result.save(tmp_path / "out", figures=False)
    again = pz.open_result(tmp_path / "out")
    assert again.info.pilot == result.info.pilot
    assert again.advisories == result.advisories


def test_check_says_where_no_pilot_can_be_traced(monkeypatch, capsys):
    monkeypatch.setenv("PHOTIZON_DEVICE", "no such device")
    assert main(["check", "box-room"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "pilot: none was traced: device: " in out
    assert "advisories: none" in out


def test_check_tells_the_time_where_a_source_is_too_weak_for_few_rays(tmp_path, capsys):
    lamps = [
        pz.IsotropicPoint(name=name, flux=flux, position=(0, 0, 0.5))
        for name, flux in (("lamp", 1.0), ("weak", 1e-18))
    ]
    wall = pz.Disk(name="wall", position=(0, 0, 0), axis="+z", radius=1.0, surface=pz.Absorber())
    weak = pz.Scene(name="weak", source=tuple(lamps), element=(wall,))
    weak.save(tmp_path / "weak.toml")
    assert main(["check", str(tmp_path / "weak.toml")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "the pilot's rays take too long" not in out
    assert "its rays carry" not in out
    assert re.search(r"time: .*\d s", out)


def test_check_says_why_no_time_is_told(monkeypatch, capsys):
    def fails(*_, **__):
        raise pz.RunError("the device is on fire")

    monkeypatch.setattr("photizon_cl.run.outlay.outlay", fails)
    assert main(["check", "box-room"]) == 0
    assert "the device is on fire" in capsys.readouterr().out


def test_without_a_pilot_both_possibilities_are_said(monkeypatch):
    from photizon_cl.errors import RunError

    def fails(*_, **__):
        raise RunError("no room")

    monkeypatch.setattr(module, "pilot", fails)
    result = pz.trace(glass_cube(), batches=2)
    (text,) = [text for text in result.advisories if "generation cap" in text]
    assert "raise generation_cap; where a higher one cuts as much, the light is trapped" in text


def test_a_run_that_caps_nothing_traces_no_pilot(monkeypatch):
    monkeypatch.setattr(module, "pilot", lambda *_, **__: pytest.fail("a pilot"))
    assert pz.trace("box-room", batches=1, rays_per_batch=64).info.pilot is None
