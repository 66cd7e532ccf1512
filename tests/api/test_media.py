"""Faces that say different things of the medium between them are told before a run."""

from __future__ import annotations

import dataclasses

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.run.media import clashing_media
from photizon_cl.scene.presets import preset_names

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

GLASS = pz.Fresnel(1.5)
LAMP = pz.CollimatedDisk(name="lamp", flux=1.0, position=(0, 0, -1), axis="+z", radius=0.1)
PLATE = pz.Disk(name="plate", position=(0, 0, 1), axis="-z", radius=1.0, surface=pz.Absorber())


def face(name, z, axis, surface=GLASS, **more):
    return pz.Disk(name=name, position=(0, 0, z), axis=axis, radius=0.5, surface=surface, **more)


def scene(*elements, source=LAMP, **run):
    settings = {"rays_per_batch": 256, "generation_cap": 8, **run}
    return pz.Scene("media", (source,), (*elements, PLATE), run=pz.RunSettings(**settings))


FRONT, BACK = face("front", 0.0, "-z"), face("back", 0.01, "+z")


def test_a_window_whose_faces_look_outwards_says_nothing():
    assert clashing_media(scene(FRONT, BACK)) == []


@pytest.mark.parametrize("turned", ["front", "back"])
@pytest.mark.parametrize("tilt", [(20.0, -30.0), pytest.param((0.0, 0.0), marks=pytest.mark.slow)])
def test_a_face_that_is_turned_round_is_told(turned, tilt):
    opposite = {"-z": "+z", "+z": "-z"}
    faces = [
        dataclasses.replace(f, axis=opposite[f.axis] if f.name == turned else f.axis, tilt_deg=tilt)
        for f in (FRONT, BACK)
    ]
    (said,) = clashing_media(scene(*faces))
    left, met = ("1", "1.5") if turned == "front" else ("1.5", "1")
    assert f'leaves "front" in a medium of index {left} meets "back" as from one of {met}' in said
    assert '"front" or "back" is the wrong way round, and the opposite axis turns it' in said


def test_what_passes_or_reflects_between_them_changes_no_medium():
    clear = face("clear", 0.005, "+z", pz.Clear())
    assert clashing_media(scene(FRONT, clear, BACK)) == []
    turned = dataclasses.replace(BACK, axis="-z")
    (said,) = clashing_media(scene(FRONT, clear, turned))[:1]
    assert 'leaves "front"' in said
    # a mirror in glass: the light comes back to the face that it came in by
    mirror = face("mirror", 0.01, "-z", pz.Mirror(0.9))
    assert clashing_media(scene(FRONT, mirror)) == []


def test_where_every_face_is_turned_it_is_asked():
    """All of it would have to be in glass; a lamp in a body of glass says nothing."""
    faces = [dataclasses.replace(FRONT, axis="+z"), dataclasses.replace(BACK, axis="-z")]
    (said,) = clashing_media(scene(*faces))
    assert 'meets "front" as from a medium of index 1.5, and most of it ends in that' in said
    lamp = dataclasses.replace(LAMP, position=(0.0, 0.0, 0.005))
    assert clashing_media(scene(FRONT, BACK, source=lamp)) == []


def test_a_lens_that_little_light_reaches_is_told():
    """One ray of 400 meets it; what counts is what of the light at a face is wrong."""
    lamp = pz.CosinePoint(name="led", flux=1.0, position=(0, 0, -0.2), axis="+z")
    faces = [dataclasses.replace(f, axis="-z", radius=0.01) for f in (FRONT, BACK)]
    (said,) = clashing_media(scene(*faces, source=lamp))
    assert '"front" or "back" is the wrong way round' in said


@pytest.mark.slow
def test_a_fault_behind_many_sane_faces_is_told():
    slabs = []
    for n in range(8):
        slabs += [face(f"in {n}", 0.02 * n, "-z"), face(f"out {n}", 0.02 * n + 0.01, "+z")]
    slabs[-1] = dataclasses.replace(slabs[-1], axis="-z")
    (said,) = clashing_media(scene(*slabs, generation_cap=64))
    assert 'leaves "in 7"' in said


def test_indices_that_are_the_same_to_six_digits_are_no_clash():
    for other in (1.5000000000000002, 1.5000001):
        assert (
            clashing_media(scene(FRONT, dataclasses.replace(BACK, surface=pz.Fresnel(other)))) == []
        )


def test_turning_is_offered_only_where_it_would_help():
    def said(*elements):
        (text,) = clashing_media(scene(*elements))
        return text

    air = dataclasses.replace(FRONT, surface=pz.Fresnel(1.5, index_outside=1.000293))
    before = face("before", -0.1, "+z", pz.Fresnel(1.5))
    first = face("first", -0.2, "-z", pz.Fresnel(1.5))
    text = said(first, before, air, BACK)
    assert "wrong way round" not in text
    assert "1.000293" in text
    ball = pz.Sphere(name="ball", position=(0, 0, 0.005), axis="+z", radius=0.004,
                     surface=pz.Fresnel(1.0))  # fmt: skip
    bubble = said(FRONT, ball, BACK)
    assert '"ball" is the wrong way round' not in bubble
    assert "index_outside of one is not what is meant" in bubble


def test_very_many_faces_in_one_place_cost_no_time():
    many = [face(f"window {n}", 0.0, "-z") for n in range(1001)]
    assert clashing_media(scene(*many)) == []


def test_an_index_that_is_not_the_bodys_is_told():
    other = dataclasses.replace(BACK, surface=pz.Fresnel(1.6))
    (said,) = clashing_media(scene(FRONT, other))[:1]
    assert 'leaves "front" in a medium of index 1.5 meets "back" as from one of 1.6' in said
    cement = dataclasses.replace(BACK, surface=pz.Fresnel(1.5, index_outside=1.6))
    end = face("end", 0.02, "+z", pz.Fresnel(1.6))
    assert clashing_media(scene(FRONT, cement, end)) == []


def test_lamps_in_glass_and_bodies_of_glass_say_nothing():
    ball = pz.Sphere(name="ball", position=(0, 0, 0), axis="+z", radius=0.5, surface=GLASS)
    lens = pz.PlanoConvex(
        name="lens", position=(0, 0, 0.7), axis="+z", curvature_radius=0.3, aperture_radius=0.2,
        surface=GLASS,
    )  # fmt: skip
    lamp = pz.IsotropicPoint(name="lamp", flux=1.0, position=(0.01, 0.02, 0.03))
    assert clashing_media(scene(ball, lens, source=lamp)) == []


def test_faces_in_contact_say_nothing():
    """Between them is a film, as `check` says of each pair."""
    second = [
        face("third", 0.01, "-z", pz.Fresnel(1.8)),
        face("fourth", 0.02, "+z", pz.Fresnel(1.8)),
    ]
    assert clashing_media(scene(FRONT, BACK, *second)) == []


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=() if n == "aspheric-condenser" else pytest.mark.slow)
        for n in preset_names()
        if any(e.surface.refracts for e in pz.load(n).element)
    ],
)
def test_nothing_is_said_of_the_presets(name):
    assert clashing_media(pz.load(name)) == []


def test_check_says_it(tmp_path, capsys):
    turned = dataclasses.replace(BACK, axis="-z")
    file = tmp_path / "window.toml"
    scene(FRONT, turned).save(file)
    assert main(["check", str(file)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert 'light that leaves "front" in a medium of index 1.5 meets "back"' in out
    assert main(["check", str(file), "--no-pilot"]) == 0
    assert "in a medium of index" not in capsys.readouterr().out


def test_the_faces_of_lenses_are_asked_one_by_one():
    where = {"axis": "-z", "aperture_radius": 0.3}
    crown = pz.Lens(name="crown", position=(0, 0, 0), front_radius=0.6, back_radius=0.5,
                    thickness=0.25, surface=pz.Fresnel(1.5), back=pz.Fresnel(1.5, 1.7),
                    **where)  # fmt: skip
    flint = pz.Lens(name="flint", position=(0, 0, 0), front_radius=-0.5, back_radius=2.0,
                    thickness=0.1, surface=pz.Fresnel(1.7), front=pz.Clear(), **where)  # fmt: skip
    flint = dataclasses.replace(flint, position=(0, 0, flint.vertices[0] - crown.vertices[1]))
    lamp = pz.CollimatedDisk(name="lamp", flux=1.0, position=(0, 0, -1), axis="+z", radius=0.2)
    assert clashing_media(scene(crown, flint, source=lamp)) == []
    wrong = dataclasses.replace(crown, back=pz.Fresnel(1.6))
    (said,) = clashing_media(scene(wrong, source=lamp))[:1]
    assert (
        'light that leaves front of "crown" in a medium of index 1.5 meets back of "crown"' in said
    )
    assert "as from one of 1.6" in said
