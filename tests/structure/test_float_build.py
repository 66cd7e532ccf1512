"""Every program in single precision: there the compiler keeps apart what is one C type otherwise.

OpenCL C converts no vector type silently. A build without a word from the compiler says that masks,
64-bit integers, reals, weights and wide numbers are not taken for each other, and that no double
meets a real. What such programs give, tests of precision ask.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from oracles.engine import compiled, with_tree
from oracles.scenes import everything

import photizon_cl as pz
from hostcode import templates
from hostcode.errors import KernelBuildError
from hostcode.program import build
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.files import load
from photizon_cl.scene.presets import preset_names
from photizon_cl.scene.registry import ELEMENTS, SOURCES, SURFACES

if TYPE_CHECKING:
    from hostcode.device.opened import OpenDevice
    from hostcode.program.spec import ProgramSpec

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs" / "_ext"))

from photizon_docs.examples import example

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

LANES = (1, 4)
CASES = (("scan", ()), ("scan", ("contact",)), ("tree", ("contact",)))
"""How faces are sought, and what is forced on."""


@cache
def every_kind() -> pz.Scene:
    """Return a scene of every element, surface and source in the registry."""
    groups = (("element", ELEMENTS), ("surface", SURFACES), ("source", SOURCES))
    shown = [example(group, kind, cls) for group, kinds in groups for kind, cls in kinds.items()]
    elements = [element for scene in shown for element in scene.element]
    sources = [source for scene in shown for source in scene.source]
    return pz.Scene(
        name="every kind",
        element=tuple(replace(e, name=f"element {n}") for n, e in enumerate(elements)),
        source=tuple(replace(s, name=f"source {n}") for n, s in enumerate(sources)),
        far_field=pz.FarField(n_mu=2, n_phi=2),
        importance=pz.Importance(toward=[f"element {n}" for n in range(len(elements))]),
    )


def build_silently(
    device: OpenDevice, spec: ProgramSpec, lanes: int, *stages: str, weight: str = "double"
) -> None:
    """Build a scene's program with floats; the compiler must say nothing.

    With weights in doubles it keeps them apart from reals too.
    """
    import pyopencl as cl

    # both ways to tally and both layouts of the queue are built at some width
    chosen = spec.for_device(lanes, stages, private_tallies=lanes > 1, interleaved=lanes == 1)
    for one in (chosen, chosen.for_tally()) if chosen.records else (chosen,):
        program = build.build(device, replace(one, real="float", weight=weight))
        log = program.built.get_build_info(device.device, cl.program_build_info.LOG)
        assert log.strip() == ""


@pytest.mark.parametrize("lanes", [pytest.param(1, marks=pytest.mark.slow), 4])
@pytest.mark.parametrize(
    "preset",
    [
        # the kinds of the others are in the scene of every kind
        pytest.param(n, marks=() if n in {"box-room", "ghost-ladder"} else pytest.mark.slow)
        for n in preset_names()
    ],
)
def test_presets(device: OpenDevice, preset: str, lanes: int) -> None:
    build_silently(device, compiled(preset).tables.spec, lanes, "wave")


@pytest.mark.parametrize("far_field", [{"n_theta": 4}, {"n_mu": 4, "axis": "-y"}])
def test_the_far_field_about_an_axis(device: OpenDevice, far_field: dict[str, Any]) -> None:
    bins = pz.FarField(n_phi=3, **far_field)
    spec = compiled(replace(load("cosine-fourth"), far_field=bins)).tables.spec
    build_silently(device, spec, 1, "wave")


def test_a_tree(device: OpenDevice) -> None:
    scene = load("box-room")
    made = compile_scene(scene, scene.run, **with_tree(True))
    build_silently(device, made.tables.spec, 1, "wave")


@pytest.mark.slow
@pytest.mark.parametrize("lanes", LANES)
@pytest.mark.parametrize(("search", "forced"), CASES)
def test_every_kind(device: OpenDevice, search: str, forced: tuple[str, ...], lanes: int) -> None:
    scene = every_kind()
    made = compile_scene(scene, scene.run, **with_tree(search == "tree", frozenset(forced)))
    spec = made.tables.spec
    assert {cls.kind for cls in spec.classes} == {kind.replace("-", "_") for kind in ELEMENTS}
    build_silently(device, spec, lanes, "wave", "classical")
    build_silently(device, spec, lanes, "probe", *(("follow", "paths") if lanes == 1 else ()))


@pytest.mark.parametrize(
    "lanes", [1, 8, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 16))]
)
def test_a_scene_of_everything(device: OpenDevice, lanes: int) -> None:
    one = ("whole_path",) if lanes == 1 else ()
    build_silently(device, compiled(load(everything())).tables.spec, lanes, "wave", *one)


@pytest.mark.parametrize("lanes", LANES)
def test_a_library_that_no_kind_uses_yet(device: OpenDevice, lanes: int) -> None:
    spec = compiled("cosine-fourth").tables.spec
    users = tuple(replace(kind, libraries=("lib/powers",)) for kind in spec.surfaces)
    build_silently(device, replace(spec, surfaces=users), lanes, "wave")


@pytest.mark.slow
@pytest.mark.parametrize("lanes", LANES)
def test_weights_in_floats(device: OpenDevice, lanes: int) -> None:
    spec = compiled(load(everything())).tables.spec
    build_silently(device, spec, lanes, "wave", "classical", weight="float")


MIX_UPS = {
    "a mask from an integer": ("float", {"fresnel.splits": "lsplat(0L)"}),
    "integers compared as reals": ("float", {"meet.first_named": "LT(hit_code, h->code)"}),
    "a double constant": ("float", {"mirror.weight": "0.5 * p->w"}),
    "a number of a table": ("float", {"generate.weight": "w * source[SOURCE_WEIGHT]"}),
    "a weight in a real": (
        "double",
        {"mirror.weight": "p->w * material_number(material, MIRROR_REFLECTANCE)"},
    ),
    "a weight compared as a real": ("double", {"fresnel.splits": "event->m & GT(wr, wt)"}),
}


QUICK = ("a mask from an integer", "a double constant", "a weight in a real")
"""One of each pair of types; each builds a program twice."""


@pytest.mark.parametrize(
    "mix_up",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in MIX_UPS],
)
def test_a_mix_up_does_not_build(
    device: OpenDevice, monkeypatch: pytest.MonkeyPatch, mix_up: str
) -> None:
    weight, mutations = MIX_UPS[mix_up]
    monkeypatch.setattr(templates, "MUTATIONS", mutations)
    monkeypatch.setattr(build, "_CACHE", {})
    spec = compiled(load(everything())).tables.spec.for_device(2, ("wave",))
    build.build(device, spec)  # with doubles it does
    with pytest.raises(KernelBuildError):
        build.build(device, replace(spec, real="float", weight=weight))
