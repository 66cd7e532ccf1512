"""Values are numbers, what is printed is short, arrays have names."""

from __future__ import annotations

import copy
import json
import math
import pickle

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.result.ledger import Estimate
from photizon_cl.result.maps import Rung


def test_a_value_is_a_number(room):
    power = room.detectors["floor"].power
    assert f"{power:.3f}" == f"{power.value:.3f}"
    assert float(power) == power.value
    assert type(float(power)) is type(power.value) is float
    assert f"{power:>12.2e}" == f"{power.value:>12.2e}"
    assert json.loads(json.dumps(power)) == power.value
    assert np.asarray([power]).dtype == np.float64
    # sums are plain: no σ of a sum follows from those of its parts
    total = sum(room.ledger.absorbed.values()) + room.ledger.escaped
    assert type(total) is float
    assert total == pytest.approx(1.0, rel=1e-12)
    assert power < 1.0 <= 2.0 * power + 1.0
    assert abs(-power) == power.value


def test_a_value_is_shown_with_its_error():
    assert str(Estimate(0.423, 0.0017)) == f"{Estimate(0.423, 0.0017)}" == "0.4230 ± 0.0017"
    assert str(Estimate(0.5, None)) == "0.5 ± unknown"
    assert repr(Estimate(0.5, 0.25, 3)) == "Estimate(value=0.5, sigma=0.25, count=3)"
    assert repr(Rung(2, 0.5, None, 3)) == "Rung(generation=2, value=0.5, sigma=None, count=3)"


def test_estimates_are_equal_where_all_of_them_is():
    one = Estimate(0.5, 0.25, 3)
    assert one == Estimate(0.5, 0.25, 3) == 0.5
    assert one != Estimate(0.5, 0.125, 3)
    assert one != Estimate(0.5, 0.25)
    assert hash(one) == hash(0.5)
    with pytest.raises(AttributeError):
        one.value = 1.0
    for made in (one, Rung(2, 0.5, None, 3)):
        for other in (copy.copy(made), copy.deepcopy(made), pickle.loads(pickle.dumps(made))):
            assert other == made
            assert repr(other) == repr(made)
    assert Rung(2, 0.5, None, 3) != Rung(1, 0.5, None, 3)


def test_what_is_printed_is_short(room):
    far = pz.trace("integrating-sphere", batches=1, rays_per_batch=1024)
    floor = room.detectors["floor"]
    for shown, holds in [
        (
            repr(floor),
            f"{floor.power} W, {floor.power.count} arrivals, 16 generations, map 32 × 32",
        ),
        (repr(floor.map), "IrradianceMap 32 × 32: "),
        (repr(room.ledger), "Ledger of 1 W: 1 W absorbed by 6"),
        (repr(room.scene), "photizon_cl.Scene 'box-room': 1 source, 6 elements"),
        (repr(far.far_field), "FarFieldResult 40 × 32: "),
        (repr(room), "photizon_cl.Result 'box-room': 3 batches"),
    ]:
        assert holds in shown
        assert len(shown) < 120
        assert "\n" not in shown


def test_arrays_have_groups_names_and_units(room, tmp_path):
    tree = room.to_dataset()
    floor = tree["floor"]
    np.testing.assert_array_equal(floor["irradiance"], room.detectors["floor"].map.irradiance)
    assert floor["irradiance"].dims == ("v", "u")
    assert floor["irradiance"].attrs["units"] == "W m-2"
    assert floor["irradiance"].attrs["long_name"] == "irradiance"
    assert floor["irradiance"].attrs["comment"].startswith("power over the exact area of the bin")
    np.testing.assert_array_equal(floor["u_edges"], np.linspace(-1.0, 1.0, 33))
    assert (
        float(tree["ledger"]["power"].sel(row="absorbed: floor")) == room.ledger.absorbed["floor"]
    )
    assert tree.attrs["tally_digest"] == room.tally_digest
    # what stands beside an axis is short, and every quantity has a unit
    for node in tree.subtree:
        for name, array in node.to_dataset().variables.items():
            assert len(array.attrs["long_name"]) <= 24, name
            assert array.dtype == object or array.attrs["units"], name
    tree.to_netcdf(tmp_path / "tree.nc", engine="h5netcdf")


def test_groups_hold_all_that_the_file_holds():
    import xarray as xr

    scene = pz.load("integrating-sphere").replace({"element.wall.name": "ledger"})
    result = pz.trace(scene, batches=2, rays_per_batch=1024)
    from photizon_cl.result.arrays import dataset

    flat, tree = dataset(result), result.to_dataset()
    assert isinstance(tree, xr.DataTree)
    assert sum(len(node.variables) for node in tree.subtree) == len(flat.variables)
    intensity = tree["far_field/intensity"]
    assert intensity.dims == ("mu", "phi")
    assert math.isclose(float(intensity.sum()) * float(tree["far_field/solid_angle"]),
                        result.ledger.escaped)  # fmt: skip


def test_figures_are_functions_by_their_short_names_too(room):
    from photizon_cl.views.figures import FIGURES

    for kind in FIGURES:
        stem = kind.draw.__name__.removeprefix("draw_")
        assert getattr(pz.figures, stem) is kind.draw
    assert pz.figures.ledger(room).axes
