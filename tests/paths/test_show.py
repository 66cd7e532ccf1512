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
