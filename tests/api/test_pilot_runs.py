"""A pilot behind a run and in `check`: it costs a run nothing, and changes nothing if it fails."""

from __future__ import annotations

import dataclasses
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import photizon_cl as pz
from hostcode.errors import DeviceError
from photizon_cl.cli.main import main
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.rays import LEAST_WEIGHT
from photizon_cl.result.file import read_file
from photizon_cl.result.pilot import UNTOLD
from photizon_cl.run import distribution, speed
from photizon_cl.run import pilot as module
from photizon_cl.run.checkpoint import CHECKPOINT, Keeper
from photizon_cl.run.pilot import pilot

ROOT = Path(__file__).resolve().parents[2]
BALL = pz.Sphere(name="ball", position=(0, 0, 0), axis="+z", radius=1.0, surface=pz.Lambertian(0.5))


def lamp(name, **parameters):
    return pz.IsotropicPoint(name=name, position=(0.001, 0, 0), **{"flux": 1.0, **parameters})


def scene(*sources, **run):
    settings = pz.RunSettings(**{"rays_per_batch": 256, "generation_cap": 3, **run})
    return pz.Scene(name="p", source=sources or (lamp("a"),), element=(BALL,), run=settings)


def faint(rays=1 << 13):
    """Return a scene whose weakest ray is fine among a batch's, and not among a pilot's."""
    flux = 2.0 * LEAST_WEIGHT / rays
    return scene(
        lamp("a", share=1.0), lamp("b", flux=flux, share=1e-12),
        rays_per_batch=rays, generation_cap=8,
    )  # fmt: skip


def advice(result):
    (text,) = [text for text in result.advisories if "went to the depth-capped" in text]
    return text


# -- a ray that is too weak among a few hundred ---------------------------------------------------


def test_a_source_too_weak_for_few_rays_is_no_fault_of_the_scene(capsys, tmp_path):
    cut = faint()
    with pytest.raises(pz.ArgumentError, match="its rays carry"):
        compile_scene(cut, pz.RunSettings(rays_per_batch=512))
    found = pilot(cut)
    assert found.complete
    assert found.capped == pytest.approx(0.5**8, rel=1e-9)
    result = pz.trace(cut, batches=1)
    assert result.info.pilot == found
    assert f"raise generation_cap to about {found.needed_cap}" in advice(result)
    cut.save(tmp_path / "cut.toml")
    assert main(["check", str(tmp_path / "cut.toml")]) == 0
    out = capsys.readouterr().out
    assert "pilot: 512 rays" in out
    assert "its rays carry" not in out


def test_what_is_raised_changes_no_share():
    cut = faint()
    for sources in (cut.source, (lamp("a"), lamp("b", flux=1e-40), lamp("c", flux=0.3))):
        made = module.compiled_for_few(scene(*sources), pz.RunSettings(rays_per_batch=512), "fp64")
        shares = [1.0 if s.share is None else s.share for s in made.scene.source]
        assert made.rays_of_source[1] == 1
        assert sum(made.rays_of_source) == 512
        assert made.scene.source[1].flux <= 1e-13
        assert made.scene.source[0].flux == sources[0].flux
        assert shares[1] < 1e-11


def by_lines(*powers, **run):
    """Return a scene of lines, and the power of each in its source."""
    settings = pz.RunSettings(**{"rays_per_batch": 256, "generation_cap": 3, **run})
    return pz.Scene(
        name="p", source=(lamp("a", spectrum=powers),), element=(BALL,), run=settings,
        spectrum=pz.Spectrum([500.0 + k for k in range(len(powers))]),
    )  # fmt: skip


def test_a_line_too_weak_for_few_rays_is_no_fault_of_the_scene(capsys, tmp_path):
    cut = by_lines(1.0, 1e-17, 0.0, rays_per_batch=1 << 13, generation_cap=8)
    with pytest.raises(pz.ArgumentError, match="its rays of 501 nm carry"):
        compile_scene(cut, pz.RunSettings(rays_per_batch=512))
    found = pilot(cut)
    assert found.complete
    assert found.capped == pytest.approx(0.5**8, rel=1e-9)
    assert pz.trace(cut, batches=1).info.pilot == found
    cut.save(tmp_path / "cut.toml")
    assert main(["check", str(tmp_path / "cut.toml")]) == 0
    out = capsys.readouterr().out
    assert "pilot: 512 rays" in out
    assert "carry" not in out


@pytest.mark.parametrize(
    "powers", [(1.0, 1e-17), (1e150, 5e-324, 0.0, 1.0), (1e-17, 1.0, 1e-20, 2.0, 0.0)]
)
def test_weak_lines_are_raised_and_others_stay(powers):
    cut = by_lines(*powers)
    for sources in (cut.source, (*cut.source, lamp("b", flux=1e-40, spectrum=powers))):
        both = dataclasses.replace(cut, source=sources)
        made = module.compiled_for_few(both, pz.RunSettings(rays_per_batch=512), "fp64")
        raised = made.scene.source[0]
        assert raised.flux == pytest.approx(1.0, rel=1e-9)
        for before, after in zip(powers, raised.spectrum, strict=True):
            if before > 1e-10 * max(powers):
                assert after == before
            else:
                assert (after == 0.0) == (before == 0.0)
                assert after < 1e-10 * max(powers)
        assert sum(made.rays_of_source) == 512


# -- one that fails -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "error",
    [pz.RunError("r"), pz.ArgumentError("a"), DeviceError("d"), MemoryError()],
    ids=lambda e: type(e).__name__,
)
def test_however_a_pilot_fails_a_run_stands_and_check_goes_on(monkeypatch, capsys, error, tmp_path):
    def fails(*_, **__):
        raise error

    monkeypatch.setattr(module, "pilot", fails)
    result = pz.trace(scene(), batches=2)
    assert result.batches == 2
    assert result.info.pilot is None
    assert f"{UNTOLD}: `photizon check` tells which" in advice(result)
    scene().save(tmp_path / "s.toml")
    assert main(["check", str(tmp_path / "s.toml")]) == 0
    assert "pilot: none was traced: " in capsys.readouterr().out


def test_what_was_run_is_kept_before_a_pilot_is_sent(monkeypatch, tmp_path):
    kept = []

    def dies(*_, **__):
        kept.append(read_file(tmp_path / CHECKPOINT))
        raise KeyboardInterrupt  # a second Ctrl-C, or what ends the process

    monkeypatch.setattr(module, "pilot", dies)
    with pytest.raises(KeyboardInterrupt):
        pz.trace(scene(), batches=3, checkpoint=tmp_path)
    (found,) = kept
    assert found.batches == 3
    assert found.info.stopped == "batches"
    assert pz.resume(tmp_path, batches=3).batches == 3


def test_a_pilot_is_kept_too(monkeypatch, tmp_path):
    found = []
    monkeypatch.setattr(Keeper, "close", lambda keeper: found.append(read_file(keeper._file)))
    result = pz.trace(scene(), batches=2, checkpoint=tmp_path)
    assert found[0].info.pilot == result.info.pilot
    assert result.info.pilot is not None


# -- its time -------------------------------------------------------------------------------------


def test_a_pilot_is_not_booked_as_the_runs_time(monkeypatch):
    send = module.pilot

    def slow(*given, **more):
        time.sleep(2.0)
        return send(*given, **more)

    pz.trace(scene(), batches=2)  # all that is built is there
    monkeypatch.setattr(module, "pilot", slow)
    result = pz.trace(scene(), batches=2)
    assert result.info.pilot is not None
    assert result.info.seconds < 2.0
    assert result.history["seconds"][-1] < 2.0


def test_no_pilot_is_sent_when_the_time_is_used_up(monkeypatch):
    monkeypatch.setattr(module, "pilot", lambda *_, **__: pytest.fail("a pilot"))
    random = scene().replace({"element.ball.port_fraction": 0.1})
    result = pz.trace(random, target=1e-9, max_seconds=0.2)
    assert result.info.stopped == "time"
    assert UNTOLD in advice(result)


def test_a_pilot_is_asked_to_end_with_the_runs_time(monkeypatch):
    asked = []

    def waits(*_, stop, **__):
        begun = time.monotonic()
        while not stop() and time.monotonic() < begun + 10.0:
            time.sleep(0.01)
        asked.append(stop())
        return module.Pilot(512, 3, 1.0, 0.0, ((1, 0.5),), complete=False)

    pz.trace(scene(), batches=2)
    monkeypatch.setattr(module, "pilot", waits)
    result = pz.trace(scene(), batches=2, max_seconds=2.0)
    assert result.info.stopped == "batches"
    assert asked == [True]
    assert result.info.pilot is None  # one that was cut short tells nothing


# -- one that is given up -------------------------------------------------------------------------


def test_a_pilot_that_was_given_up_is_not_sent_again(monkeypatch, tmp_path):
    sent = []
    send = module.pilot

    def counted(*given, **more):
        sent.append(1)
        return send(*given, **more)

    monkeypatch.setattr(module, "_BUDGET", 100)
    monkeypatch.setattr(module, "pilot", counted)
    long = scene(generation_cap=1000).replace({"element.ball.surface.reflectance": 1.0})
    result = pz.trace(long, batches=2)
    assert result.info.pilot.complete is False
    text = advice(result)
    assert UNTOLD in text
    assert "photizon check" not in text  # which would not tell either
    result.save(tmp_path / "out", figures=False)
    again = pz.resume(tmp_path / "out", batches=3)
    assert again.info.pilot == result.info.pilot
    assert advice(again).endswith(UNTOLD)
    assert sent == [1]


# -- without one ----------------------------------------------------------------------------------


def test_check_without_a_pilot_traces_nothing(monkeypatch, capsys):
    monkeypatch.setattr(module, "pilot", lambda *_, **__: pytest.fail("a pilot"))
    monkeypatch.setattr(speed, "faster_runtime", lambda *_: pytest.fail("timed"))
    monkeypatch.setattr(distribution, "open_device", lambda *_: pytest.fail("a device"))
    assert main(["check", "box-room", "--no-pilot"]) == 0
    out = capsys.readouterr().out
    assert "pilot" not in out
    assert "advisories: none" in out


def test_with_an_executor_no_pilot_is_sent_and_the_docs_say_so(monkeypatch):
    monkeypatch.setattr(module, "pilot", lambda *_, **__: pytest.fail("a pilot"))
    with ThreadPoolExecutor(1) as executor:
        result = pz.trace(scene(), batches=2, executor=executor)
    assert result.info.pilot is None
    assert f"{UNTOLD}: `photizon check` tells which" in advice(result)
    text = (ROOT / "docs" / "guarantees.md").read_text(encoding="utf-8")
    assert "light at the generation cap may differ with an executor" in text
