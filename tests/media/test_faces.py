"""Media of bodies whose faces have surfaces of their own."""

from __future__ import annotations

import math

import pytest

import photizon_cl as pz

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


def scene(*elements, medium="vacuum", alpha=0.0):
    return {
        "schema": "photizon/1", "name": "faces", "run": {"rays_per_batch": 2048},
        "medium": [{"name": "water", "index": 1.333, "absorption_per_m": alpha},
                   {"name": "crown", "index": 1.5168, "absorption_per_m": 5.0 * alpha},
                   {"name": "flint", "index": 1.62, "absorption_per_m": 2.0 * alpha}],
        "source": [{"name": "beam", "kind": "collimated-disk", "flux": 1.0, "axis": "-z",
                    "position": [0.0, 0.0, 0.2], "radius": 0.015, "medium": medium}],
        "element": [*elements,
                    {"name": "stop", "kind": "disk", "position": [0.0, 0.0, -0.2], "axis": "+z",
                     "radius": 1.0, "surface": {"kind": "absorber"}, "detector": {}}],
    }  # fmt: skip


def border(inside, outside="vacuum"):
    return {"kind": "fresnel", "medium": inside, "medium_outside": outside}


def sag(radius, aperture):
    return radius - math.sqrt(radius * radius - aperture * aperture)


def lens(name, surface, *, z=0.0, front=0.05, back=0.06, thickness):
    return {
        "name": name, "kind": "lens", "position": [0.0, 0.0, z], "axis": "+z",
        "front_radius": front, "back_radius": back, "aperture_radius": 0.02,
        "thickness": thickness, "surface": surface,
    }  # fmt: skip


def test_a_lens_of_three_faces_absorbs_as_one_of_two_does():
    water = border("crown", "water")
    two = {"name": "lens", "kind": "biconvex", "position": [0.0, 0.0, 0.0], "axis": "+z",
           "front_radius": 0.05, "back_radius": 0.06, "aperture_radius": 0.02,
           "surface": water}  # fmt: skip
    one, other = (
        pz.trace(scene(body, medium="water", alpha=1.0), batches=2)
        for body in (two, lens("lens", water, thickness=sag(0.05, 0.02) + sag(0.06, 0.02) + 1e-9))
    )
    for name, row in one.ledger.absorbed_in.items():
        # a nanometre of edge between the caps
        assert other.ledger.absorbed_in[name].value == pytest.approx(row.value, abs=1e-7)
    assert other.counts["media_mismatches"] == 0
    assert abs(other.ledger.closure) < 1e-15


def doublet():
    crown = lens("crown", {}, front=0.06185, back=0.04468, thickness=0.008)
    flint = lens("flint", {}, front=-0.04468, back=0.12956, thickness=0.0025, z=-0.0043096412447237)
    for body in (crown, flint):
        body["aperture_radius"] = 0.0125
    return crown, flint


def cemented(alpha):
    crown, flint = doublet()
    crown |= {"surface": border("crown"), "back": border("crown", "flint")}
    flint |= {"surface": border("flint"), "front": {"kind": "clear"}}
    tables = scene(crown, flint, alpha=alpha)
    tables["source"][0]["radius"] = 0.01
    return tables


def test_cemented_lenses_go_from_one_medium_into_the_other():
    dyed = pz.trace(cemented(1.0), batches=2)
    lost = {name: row.value for name, row in dyed.ledger.absorbed_in.items()}
    assert lost["water"] == 0.0
    # 6 to 8 mm of 5 a metre, 2.5 to 6 mm of 2 a metre
    assert 0.025 < lost["crown"] < 0.04
    assert 0.004 < lost["flint"] < 0.012
    assert dyed.counts["media_mismatches"] == 0
    assert abs(dyed.ledger.closure) < 1e-15


@pytest.mark.slow
def test_cemented_lenses_that_absorb_nothing_are_those_of_indices():
    media = pz.trace(cemented(0.0), batches=2)
    tables = cemented(0.0)
    crown, flint = doublet()
    tables["medium"] = []
    tables["element"][:2] = [
        crown | {"surface": glass(1.5168), "back": glass(1.5168, 1.62)},
        flint | {"surface": glass(1.62), "front": {"kind": "clear"}},
    ]
    plain = pz.trace(tables, batches=2)
    assert media.detectors["stop"].power.value == plain.detectors["stop"].power.value
    assert media.counts["media_mismatches"] == 0
    assert 0.85 < plain.detectors["stop"].power.value < 0.92


def glass(index, outside=1.0):
    return {"kind": "fresnel", "index": index, "index_outside": outside}
