"""Exact areas of map bins."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.scene.areas import circle_areas, even_areas, zone_areas


@pytest.mark.parametrize(
    ("nx", "ny"), [(1, 1), (2, 3), (5, 1), (10, 10), (32, 32), (33, 17), (400, 401)]
)
def test_disk_bins_add_up_to_the_disk(nx, ny):
    areas = circle_areas(0.3, nx, ny)
    assert areas.shape == (ny, nx)
    assert math.fsum(areas.ravel()) == pytest.approx(math.pi * 0.09, rel=1e-14)
    assert (areas >= 0.0).all()
    assert (areas <= 0.36 / (nx * ny) * (1 + 1e-15)).all()
    assert (areas == areas[::-1]).all()
    assert (areas == areas[:, ::-1]).all()


@pytest.mark.parametrize("inner", [1e-3, 0.1, 0.29, 0.3 * (1 - 1e-6), 0.3 * (1 - 1e-12)])
@pytest.mark.parametrize(("nx", "ny"), [(1, 1), (2, 3), (10, 10), (33, 17), (400, 401)])
def test_annulus_bins_add_up_to_the_annulus(nx, ny, inner):
    areas = circle_areas(0.3, nx, ny, inner)
    want = math.pi * (0.3 - inner) * (0.3 + inner)
    assert math.fsum(areas.ravel()) == pytest.approx(want, rel=1e-11)
    assert (areas >= 0.0).all()
    assert (areas <= circle_areas(0.3, nx, ny)).all()
    assert (areas == areas[::-1]).all()
    assert (areas == areas[:, ::-1]).all()


@pytest.mark.parametrize("radius", [1e-150, 1.0, 1e150])
@pytest.mark.parametrize(("nx", "ny"), [(1, 1), (4, 4), (3, 5)])
def test_the_smallest_holes_leave_every_bin_a_number(nx, ny, radius):
    whole = circle_areas(radius, nx, ny)
    for ratio in (0.5, 1e-8, 2e-16, 1.2e-16, 1.1e-16, 5e-17, 1e-20, 1e-160, 1e-300, 5e-324):
        inner = max(radius * ratio, 5e-324)
        areas = circle_areas(radius, nx, ny, inner)
        assert np.isfinite(areas).all()
        assert (areas >= 0.0).all()
        assert (areas <= whole).all()
        want = math.pi * (radius - inner) * (radius + inner)
        assert areas.sum() == pytest.approx(want, rel=1e-14, abs=0.0)


def test_all_that_a_port_leaves_is_in_the_first_zone():
    areas = zone_areas(1.0, 1.0 - 2.0**-53, 1, 3)
    assert areas[:, 0] == pytest.approx([4.0 * math.pi * 2.0**-53, 0.0, 0.0], rel=1e-12, abs=0.0)


def test_bins_in_the_hole_have_no_area_and_those_around_it_keep_theirs():
    whole, ring = circle_areas(1.0, 8, 8), circle_areas(1.0, 8, 8, 0.5)
    assert (ring == 0.0).sum() == 4 + 4  # in the middle, and at the corners
    assert (ring[0] == whole[0]).all()
    # a corner at (0.3, 0.4) stands on the hole's rim, whatever the rounding of tenths
    ring = circle_areas(1.0, 20, 20, 0.5)
    assert ring[13, 12] == ring[12, 13] == 0.0
    assert ring[13, 13] > 0.0


def primitive(r, x, y):
    """Return the area of [0, x] × [0, y] within a circle around the origin, odd in both."""
    sign, x, y = mp.sign(x) * mp.sign(y), min(abs(x), r), min(abs(y), r)
    if x * x + y * y <= r * r:
        return sign * x * y
    begin = mp.sqrt(r * r - y * y)
    below = lambda u: (u * mp.sqrt(r * r - u * u) + r * r * mp.asin(u / r)) / 2  # noqa: E731
    return sign * (begin * y + below(x) - below(begin))


@pytest.mark.parametrize("inner", [0.3, 0.7, 1 - 1e-5, 1 - 1e-10])
@pytest.mark.parametrize(("nx", "ny"), [(1, 2), (6, 7), (16, 16)])
def test_each_annulus_bin_against_closed_forms(nx, ny, inner):
    areas = circle_areas(1.0, nx, ny, inner)
    with mp.workdps(50):
        for j in range(ny):
            for i in range(nx):
                x0, x1 = (mp.mpf(2 * (i + k) - nx) / nx for k in (0, 1))
                y0, y1 = (mp.mpf(2 * (j + k) - ny) / ny for k in (0, 1))
                want = sum(
                    s * (primitive(mp.mpf(r), x1, y1) - primitive(mp.mpf(r), x0, y1)
                         - primitive(mp.mpf(r), x1, y0) + primitive(mp.mpf(r), x0, y0))
                    for r, s in ((1.0, 1), (inner, -1))
                )  # fmt: skip
                assert abs(areas[j, i] - want) <= 1e-12 * want + 1e-22


def shared(x0, x1, y0, y1):
    """Return the area that a rectangle shares with the unit disk, to 40 digits."""
    with mp.workdps(40):

        def height(x):
            root = mp.sqrt(max(1 - x * x, mp.mpf(0)))
            return max(min(y1, root) - max(y0, -root), mp.mpf(0))

        ends = {x0, x1}
        for y in (y0, y1):
            if abs(y) <= 1:
                ends |= {s * mp.sqrt(1 - y * y) for s in (-1, 1)}
        ends |= {mp.mpf(-1), mp.mpf(1)}
        points = sorted(x for x in ends if x0 <= x <= x1)
        return mp.quad(height, points)


@pytest.mark.parametrize(("nx", "ny"), [(6, 7), (9, 4)])
def test_each_disk_bin_against_quadrature(nx, ny):
    areas = circle_areas(1.0, nx, ny)
    for j in range(ny):
        for i in range(nx):
            with mp.workdps(40):
                x = [mp.mpf(2 * k - nx) / nx for k in (i, i + 1)]
                y = [mp.mpf(2 * k - ny) / ny for k in (j, j + 1)]
            expected = float(shared(*x, *y))
            assert areas[j, i] == pytest.approx(expected, rel=1e-13, abs=1e-18)


def test_a_bin_whose_corner_stands_on_the_circle_has_no_area():
    # 10 bins of a diameter: the corner (3, 4)/5 is on the circle, exactly.
    areas = circle_areas(1.0, 10, 10)
    assert areas[9, 8] == 0.0
    assert areas[8, 9] == 0.0
    assert areas[8, 8] > 0.0
    assert (circle_areas(1.0, 32, 32) == 0.0).sum() == 168


@pytest.mark.parametrize("fraction", [0.0, 0.05, 0.5, 0.3337])
@pytest.mark.parametrize(("nx", "ny"), [(1, 1), (8, 20), (7, 33)])
def test_sphere_bins_add_up_to_the_wall(fraction, nx, ny):
    areas = zone_areas(0.1, fraction, nx, ny)
    wall = 4.0 * math.pi * 0.01 * (1.0 - fraction)
    assert math.fsum(areas.ravel()) == pytest.approx(wall, rel=1e-14)


def test_sphere_bins_in_the_port_have_no_area():
    areas = zone_areas(1.0, 0.05, 4, 20)  # the port is the last row, exactly
    assert (areas[-1] == 0.0).all()
    assert areas[:-1] == pytest.approx(4.0 * math.pi / 80, rel=1e-15)
    assert 0.0 < zone_areas(1.0, 0.04, 4, 20)[-1, 0] < areas[0, 0]


@pytest.mark.parametrize("tenths", range(10))
def test_a_port_of_some_tenths_masks_whole_rows(tenths):
    areas = zone_areas(0.1, tenths / 10, 2, 20)
    assert np.count_nonzero(areas[:, 0]) == 20 - 2 * tenths
    assert areas[: 20 - 2 * tenths] == pytest.approx(4.0 * math.pi * 0.01 / 40, rel=1e-14)


def test_rectangle_bins_are_the_stated_product():
    areas = even_areas(1.0, 1.0, 32, 32)
    assert (areas == (2 / 32) * (2 / 32)).all()


def test_an_element_without_maps_is_refused():
    lens = pz.Biconvex(
        name="lens", position=(0, 0, 0), axis="+z", front_radius=1.0, back_radius=1.0,
        aperture_radius=0.5, surface=pz.Absorber(),
    )  # fmt: skip
    with pytest.raises(NotImplementedError, match="no map on a biconvex"):
        lens.map_bins(2, 2)


@pytest.mark.parametrize("side", [4, 2048])
@pytest.mark.parametrize("kind", ["rectangle", "disk", "sphere"])
def test_areas_are_for_reading_whatever_the_size_and_kind(kind, side):
    """Equal areas are one number in memory: one that is changed would change all."""
    shapes = {
        "rectangle": {"axis": "+z", "half_width": 0.1, "half_height": 0.2},
        "disk": {"axis": "+z", "radius": 0.1},
        "sphere": {"axis": "+z", "radius": 0.1, "port_fraction": 0.1},
    }
    tables = pz.load("cosine-fourth").to_dict()
    plate = {"name": "t", "kind": kind, "position": [0.0, 0.0, 0.0], **shapes[kind]}
    tables["element"] = [{**plate, "surface": {"kind": "absorber"}}]
    areas = pz.load(tables).element[0].map_bins(side, side).areas
    with pytest.raises(ValueError, match="read-only"):
        areas[0, 0] = 1.0
    changed = areas.copy()
    changed[0, 0] = 1.0
    assert areas[0, 0] != 1.0
