"""A kind's name stands in its own file and in the registry: nothing else knows it.

So that a new kind is one class, one kernel and one row. What tests, documentation and presets say
is theirs.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from kind_names import KINDS, in_kernel, in_python, places

ROOT = Path(__file__).resolve().parents[2]

KNOWN = {
    "hostcode/program/program.py": "sphere",
    "kernels/lib/local.mako": "baffled-tube",
    "kernels/lib/shade.mako": "absorber fresnel lambertian mirror",
    "photizon_cl/checks/advisories.py": (
        "absorber fresnel lambertian lambertian-sphere mirror sphere"
    ),
    "photizon_cl/checks/flush.py": "disk",
    "photizon_cl/compile/effects/table.py": (
        "absorber baffled-tube biconvex collimated-disk cosine-point cpc disk fresnel "
        "isotropic-point lambertian lambertian-disk lambertian-sphere mirror plano-convex "
        "rectangle sphere"
    ),
    "photizon_cl/compile/packing.py": "sphere",
    "photizon_cl/geometry/areas.py": "disk rectangle sphere",
    "photizon_cl/geometry/contact.py": "baffled-tube sphere",
    "photizon_cl/geometry/outlines.py": (
        "baffled-tube biconvex cpc disk plano-convex rectangle sphere"
    ),
    "photizon_cl/geometry/wedges.py": "baffled-tube disk rectangle sphere",
    "photizon_cl/result/maps.py": "sphere",
    "photizon_cl/scene/elements/base.py": (
        "absorber disk fresnel lambertian mirror rectangle sphere"
    ),
    "photizon_cl/views/drawing/plot.py": "absorber fresnel lambertian mirror",
    "photizon_cl/views/drawing/view.py": "isotropic-point lambertian-sphere",
    "photizon_cl/views/figures/maps.py": "disk",
    "photizon_cl/views/report/claims.py": "fresnel",
}
"""Files that still name kinds, and which. It only ever shrinks: what is gone must go from here."""


def test_no_kind_is_named_outside_its_own_file():
    found = places(ROOT)
    new = [
        f"{file}:{line}: {kind}"
        for file, line, kind in found
        if kind not in KNOWN.get(file, "").split()
    ]
    assert not new, "\n".join(["a kind is named here:", *new])


def test_what_is_known_is_still_there():
    there = {(file, kind) for file, _, kind in places(ROOT)}
    gone = [
        f"{file}: {kind}"
        for file, kinds in KNOWN.items()
        for kind in kinds.split()
        if (file, kind) not in there
    ]
    assert not gone, "\n".join(["no longer named, take it off the list:", *gone])


# -- the test itself -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("x = Sphere", ["sphere"]),
        ("from a.elements.baffled_tube import BaffledTube", ["baffled-tube"] * 2),
        ("def sphere_areas(): pass", ["sphere"]),
        ("if kind == 'fresnel': pass", ["fresnel"]),
        ("x = 'surface.fresnel'", ["fresnel"]),
        ("x = f'a {kind} mirror'", ["mirror"]),
        ("x = 'lambertian-sphere'", ["lambertian-sphere"]),
        ("x = 'lambertian_sphere'", ["lambertian-sphere"]),
        ("x = 'BaffledTube'", ["baffled-tube"]),
        ("x = getattr(pz, 'Sphere')", ["sphere"]),
        ("SPHERE = 1", ["sphere"]),
        ("x = 'Lambertian scatterers, and mirrors'", []),
        ("hemisphere, spheres, cpcs = 1, 2, 3", []),
        ("# a sphere", []),
        ("def f():\n    '''Of a sphere.'''", []),
        ("x: int = 1\n'''A disk.'''", []),
        ("shutil.disk_usage(x)", []),
    ],
)
def test_what_counts_in_python(code, expected):
    assert [kind for _, kind in in_python(code, KINDS)] == expected


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ('% if cls.kind == "baffled_tube":', ["baffled-tube"]),
        ("meet_fresnel(m, p);", ["fresnel"]),
        ("#define SPHERE 1", ["sphere"]),
        ("x = 1.0; // on the sphere", []),
        ("## of a sphere", []),
        ("/* a\n * sphere */ x", []),
        ("<%doc>\nsphere\n</%doc>", []),
    ],
)
def test_what_counts_in_kernels(code, expected):
    assert [kind for _, kind in in_kernel(code, KINDS)] == expected


def test_places_have_their_lines():
    assert list(in_python("\n\nx = Disk\n", KINDS)) == [(3, "disk")]
    assert list(in_kernel("/*\n*/\nhit_disk();\n", KINDS)) == [(3, "disk")]
