"""A kind's name stands in its own file and in the registry: nothing else knows it.

So that a new kind is one class, one kernel and one row. What tests, documentation and presets say
is theirs.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from kind_names import KINDS, in_kernel, in_python, places

ROOT = Path(__file__).resolve().parents[2]


def test_no_kind_is_named_outside_its_own_file():
    found = [f"{file}:{line}: {kind}" for file, line, kind in places(ROOT)]
    assert not found, "\n".join(["a kind is named here:", *found])


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
        ("clear_packet(mixed)", []),
        ("x = 'mixed paths are clear'", []),
        ("from a.surfaces.mixed import Mixed", ["mixed"]),
        ("x = kind == 'clear'", ["clear"]),
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
        ("clear_packet(p);", []),
        ("meet_clear(p);", ["clear"]),
        ('% if kind == "mixed":', ["mixed"]),
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
