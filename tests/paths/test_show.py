"""The verb ``show``, and what a drawing shows."""

from __future__ import annotations

import re
from itertools import combinations, pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.views.drawing.panels import arrange
from photizon_cl.views.drawing.plot import draw_scene
from photizon_cl.views.drawing.sections import colour_key, ray_colours
from photizon_cl.views.drawing.view import ShownRays, bounding_box, shown_rays

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


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


# -- what an art editor looks for ----------------------------------------------------------------

PRESETS = [
    "aspheric-condenser", "baffled-telescope", "baffled-tube", "box-room", "cassegrain",
    "cosine-fourth", "ghost-ladder", "plano-convex-condenser", "square-lightpipe",
]  # fmt: skip


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("space", [0.0, 3.0])
def test_sections_fill_their_page_and_are_to_one_scale(name, space):
    box = bounding_box(pz.load(name))
    width = 11.0 if space else 7.0
    panels = arrange(box, width, 8.0, space=space)
    assert 0.8 * width < panels.width <= width + 1e-9 or panels.height > 7.99
    assert panels.height <= 8.0 + 1e-9
    for (h, v), (left, bottom, across, up) in zip(panels.views, panels.places, strict=True):
        assert left > 0.5  # room for ticks and label
        assert bottom > 0.4
        assert across == pytest.approx(panels.scales[h] * box.extent[h])
        assert up == pytest.approx(panels.scales[v] * box.extent[v])
    for one, other in combinations([*panels.places, panels.rest], 2):
        clear = one[0] + one[2] <= other[0] or other[0] + other[2] <= one[0]
        clear = clear or one[1] + one[3] <= other[1] or other[1] + other[3] <= one[1]
        assert clear
    true = [panels.to_scale(h, v) for h, v in panels.views]
    assert true[2]
    assert all(true) is (name != "square-lightpipe")  # twenty times longer than wide
    if not space:  # two thirds of what is left beside labels and key
        used = sum(w * h for _, _, w, h in panels.places)
        assert used > (0.25 if panels.lying else 0.3) * width * panels.height


@pytest.mark.parametrize("most", [1, 2, 7, 11, 12, 30, 300])
@pytest.mark.parametrize("inches", [1.2, 4.0])
def test_the_scale_of_generations_has_whole_numbers_only(most, inches):
    rays = ShownRays(np.zeros((most + 1, 3)), np.ones((most + 1, 3)), np.ones(most + 1),
                     np.arange(most + 1), 0)  # fmt: skip
    _, bar, label = ray_colours(rays, "generation")
    figure = Figure(figsize=(6.0, 1.0))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.1, 0.5, inches / 6.0, 0.2))
    colour_key(figure, bar, label, axes)
    figure.canvas.draw()
    shown = [text for text in axes.get_xticklabels() if text.get_text()]
    assert 1 <= len(shown) <= most + 1
    assert all(str(int(text.get_text())) == text.get_text() for text in shown)
    boxes = [text.get_window_extent() for text in shown]
    assert not any(a.overlaps(b) for a, b in pairwise(boxes))


def area(loop):
    """Return what a closed curve encloses."""
    x, y = loop.T
    return 0.5 * abs(float(x[:-1] @ np.diff(y) - y[:-1] @ np.diff(x)))


def test_lens_faces_are_drawn_alike_in_both_sections():
    lens = pz.Biconvex(
        name="lens", position=(0, 0, 0), axis="+z", surface=pz.Fresnel(index=1.5),
        front_radius=0.06, back_radius=0.09, aperture_radius=0.02,
    )  # fmt: skip
    lamp = pz.CollimatedDisk(name="lamp", flux=1.0, position=(0, 0, -0.1), axis="+z", radius=0.01)
    figure = draw_scene(pz.paths(pz.Scene(name="lens", source=(lamp,), element=(lens,)), rays=3))

    def outlines(axes):
        lines = [line.get_xydata() for line in axes.lines if line.get_linewidth() == 2.2]
        bodies = [patch.get_path().vertices for patch in axes.patches]
        filled = [area(body) for body in bodies if len(body) > 2]
        return lines, filled

    (lines_xz, filled_xz), (lines_yz, filled_yz) = (outlines(axes) for axes in figure.axes[:2])
    assert len(lines_xz) == len(lines_yz) >= 2
    for a, b in zip(lines_xz, lines_yz, strict=True):
        order = [np.lexsort(np.round(line, 6).T) for line in (a, b)]
        np.testing.assert_allclose(a[order[0]], b[order[1]], atol=1e-6)
    # The glass is one body: both of its caps together.
    (glass,) = filled_xz
    assert filled_yz == [pytest.approx(glass)]
    y = np.linspace(-0.02, 0.02, 20001)
    sag = np.sqrt(0.06**2 - y**2) + np.sqrt(0.09**2 - y**2)
    across = 1e6 * np.trapezoid(sag - sag[0], y)  # mm²
    assert glass == pytest.approx(across, rel=1e-3)


def arrows(scene):
    """Return the arrows of the sections: axes, direction in their coordinates and on paper."""
    figure = draw_scene(pz.paths(scene, rays=4))
    figure.canvas.draw()
    found = []
    for axes in figure.axes:
        for text in axes.texts:
            if getattr(text, "arrow_patch", None) is not None:
                ends = np.array([text.xyann, text.xy])
                panel = axes.get_xlabel()[0] + axes.get_ylabel()[0]
                true = axes.get_aspect() == 1.0
                paper = np.diff(axes.transData.transform(ends), axis=0)[0] if true else None
                found.append((panel, ends[1] - ends[0], paper))
    return found


@pytest.mark.parametrize("tilt", [(30.0, 0.0), (0.0, 30.0), (20.0, 50.0), (-140.0, 75.0)])
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
    for panel, drawn, paper in shown:
        along = np.array([beam.frame[2]["xyz".index(name)] for name in panel])
        assert drawn @ along > 0.0
        assert abs(drawn[0] * along[1] - drawn[1] * along[0]) < 1e-9 * np.hypot(*drawn)
        if paper is not None:
            angle = np.degrees(np.arctan2(*paper) - np.arctan2(*along))
            assert abs((angle + 180.0) % 360.0 - 180.0) < 1e-3
    assert length > 1.0 or all(paper is not None for _, _, paper in shown)


@pytest.mark.parametrize(("side", "sign"), [("front", 1.0), ("back", -1.0)])
def test_a_detector_looks_to_the_side_that_it_counts(side, sign):
    lamp = pz.IsotropicPoint(name="lamp", flux=1.0, position=(0, 0, 0.5))
    plate = pz.Disk(name="plate", position=(0, 0, 0), axis="+z", surface=pz.Absorber(), radius=0.3,
                    detector=pz.Detector(side=side))  # fmt: skip
    shown = arrows(pz.Scene(name="sides", source=(lamp,), element=(plate,)))
    assert len(shown) == 2
    for panel, drawn, _ in shown:
        assert drawn[panel.index("z")] * sign > 0.0


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["integrating-sphere", "--rays", "10001"], "--rays: found 10001, expected at most 10000"),
        (["integrating-sphere", "--rays", "20"], "20 rays make .* segments, expected at most 100"),
    ],
)
def test_a_tangle_is_refused_before_it_is_drawn(arguments, told, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("photizon_cl.cli.show._SEGMENTS", 100)
    out = tmp_path / "scene.png"
    assert main(["show", *arguments, "--out", str(out)]) == 2
    assert re.search(told, capsys.readouterr().err)
    assert not out.exists()


def test_of_many_lines_fewer_rays_are_drawn(tmp_path, capsys):
    lines = [400.0 + 5.0 * n for n in range(60)]
    scene = pz.load("dispersing-prism").replace({"spectrum": pz.Spectrum(wavelengths_nm=lines)})
    scene = scene.replace({"source[0].spectrum": None})
    scene.save(tmp_path / "many.toml")
    assert main(["show", str(tmp_path / "many.toml"), "--out", str(tmp_path / "many.svg")]) == 0
    assert "50 rays" in capsys.readouterr().out
    assert "50 rays, seed 1, projected" in (tmp_path / "many.svg").read_text("utf-8")
    assert pz.paths(scene, 7).launched == 7
