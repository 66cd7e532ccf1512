"""The verb ``show``, and what a drawing shows."""

from __future__ import annotations

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.views.drawing.plot import draw_scene
from photizon_cl.views.drawing.view import bounding_box, shown_rays


@pytest.fixture
def run(capsys):
    def call(*arguments):
        status = main(["show", *map(str, arguments)])
        out, err = capsys.readouterr()
        return status, out, err

    return call


@pytest.mark.parametrize(
    ("name", "by", "suffix", "magic"),
    [
        ("square-lightpipe", "generation", ".png", b"\x89PNG"),
        ("ghost-ladder", "weight", ".svg", b"<?xml"),
        ("lambertian-sphere", "weight", ".pdf", b"%PDF"),
    ],
)
def test_files(name, by, suffix, magic, run, tmp_path):
    path = tmp_path / f"drawn{suffix}"
    status, out, err = run(name, "--rays", 8, "--seed", 3, "--by", by, "--out", path)
    assert (status, err) == (0, "")
    assert str(path) in out
    assert path.read_bytes().startswith(magic)
    again = path.read_bytes()
    run(name, "--rays", 8, "--seed", 3, "--by", by, "--out", path)
    if suffix != ".svg":  # ids of clip paths are matplotlib's, random
        assert path.read_bytes() == again


def test_without_out_it_says_where(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, _ = run("box-room", "--rays", 5)
    assert status == 0
    assert "written to box-room.png" in out
    assert (tmp_path / "box-room.png").stat().st_size > 20000


def test_every_segment_end_is_inside_the_box():
    found = pz.paths("baffled-tube", 50)
    box = bounding_box(found.scene)
    rays = shown_rays(found, box)
    size = 1e-12 * box.extent.max()
    for points in (rays.start, rays.end):
        assert (points >= box.low - size).all()
        assert (points <= box.high + size).all()
    assert (box.unit, box.scale) == ("mm", 1e3)


def test_escaping_rays_go_on_to_the_edge():
    found = pz.paths("cosine-fourth", 30)
    box = bounding_box(found.scene)
    rays = shown_rays(found, box)
    gap = np.minimum(rays.end - box.low, box.high - rays.end).min(axis=1)
    landed = rays.end[:, 2] == 0.0
    assert gap[~landed] == pytest.approx(0.0, abs=1e-12)


def test_drawing_says_what_it_leaves_out():
    figure = draw_scene(pz.paths("ghost-ladder", 4, max_segments=40))
    text = " ".join(item.get_text() for item in figure.texts)
    assert "4 of 4 rays" in text
    assert "segments of weight below 1e-06 are not drawn" in text
    panels = [axes.get_title(loc="left") for axes in figure.axes]
    assert [title[:10] for title in panels if "section" in title] == [
        "xz section", "yz section", "xy section",
    ]  # fmt: skip


@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e5])
def test_scenes_of_every_size_without_elements_too(scale):
    tables = {
        "schema": "photizon/1",
        "name": "$x_1$",
        "title": "costs $5 \\ _x",
        "source": [
            {"name": "s", "kind": "lambertian-sphere", "flux": 1.0, "position": [scale, 0.0, 0.0],
             "radius": scale},
        ],
    }  # fmt: skip
    figure = draw_scene(pz.paths(tables, 3))
    figure.canvas.draw()
    unit = {1e-8: "nm", 1.0: "m", 1e5: "km"}[scale]
    assert figure.axes[0].get_xlabel() == f"x in {unit}"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["box-room", "--out", "x.jpg"], "--out: found"),
        (["box-room", "--out", "missing/x.png"], "its directory does not exist"),
        (["box-room", "--rays", "0"], "rays: found 0"),
        (["box-room", "--seed", "-1"], "seed: found -1"),
        (["box-room", "--by", "colour"], "invalid choice"),
        (["box-rom"], "did you mean box-room"),
    ],
)
def test_bad_input(arguments, message, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert message in err
    assert "Traceback" not in err
    assert not list(tmp_path.iterdir())


def arrows(scene):
    """Return the arrows of the three sections: axes, their direction in the panel's coordinates."""
    figure = draw_scene(pz.paths(scene, rays=4))
    found = []
    for axes in figure.axes:
        for text in axes.texts:
            if getattr(text, "arrow_patch", None) is not None:
                ends = np.array([text.xyann, text.xy])
                found.append((axes.get_xlabel()[0] + axes.get_ylabel()[0], ends[1] - ends[0]))
    return found


@pytest.mark.parametrize("tilt", [(30.0, 0.0), (0.0, 30.0), (20.0, 50.0)])
@pytest.mark.parametrize("length", [0.1, 1.0, 3.0])
def test_an_arrow_has_the_angle_of_the_beam(tilt, length):
    """However long the scene is beside its width."""
    beam = pz.CollimatedDisk(
        name="beam", flux=1.0, position=(0, 0, 0), axis="+z", tilt_deg=tilt, radius=0.05
    )
    stop = pz.Rectangle(name="stop", position=(0, 0, length), axis="-z", surface=pz.Absorber(),
                        half_width=1.0, half_height=0.5)  # fmt: skip
    shown = arrows(pz.Scene(name="tilted", source=(beam,), element=(stop,)))
    assert shown
    for panel, drawn in shown:
        along = np.array([beam.frame[2]["xyz".index(name)] for name in panel])
        assert drawn @ along > 0.0
        assert abs(drawn[0] * along[1] - drawn[1] * along[0]) < 1e-9 * np.hypot(*drawn)


@pytest.mark.parametrize(("side", "sign"), [("front", 1.0), ("back", -1.0)])
def test_a_detector_looks_to_the_side_that_it_counts(side, sign):
    lamp = pz.IsotropicPoint(name="lamp", flux=1.0, position=(0, 0, 0.5))
    plate = pz.Disk(name="plate", position=(0, 0, 0), axis="+z", surface=pz.Absorber(), radius=0.3,
                    detector=pz.Detector(side=side))  # fmt: skip
    shown = arrows(pz.Scene(name="sides", source=(lamp,), element=(plate,)))
    assert len(shown) == 2
    for panel, drawn in shown:
        assert drawn[panel.index("z")] * sign > 0.0
