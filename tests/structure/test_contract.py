"""What every row of the registry must hold: a new kind is covered by being there.

The scenes are those of the kinds' own pages, and one that has every kind at once. Beside this file
stand the contracts of effects, filters and lanes, of files, and of what is drawn at random.
"""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
from contract import (
    GROUPS,
    ROWS,
    WIDE,
    every_kind,
    everything,
    of_kind,
    shown,
    surface,
    traced,
    turned,
)
from oracles.engine import PLAN, compiled, scene_of, trace
from oracles.scenes import beam, wall
from photizon_docs.parts import page

import photizon_cl as pz
from hostcode.assets import kernels_dir
from hostcode.program.source import program_source
from photizon_cl.compile.effects.table import EFFECT_ROWS, EFFECTS
from photizon_cl.compile.packing import POSITION, SOURCE
from photizon_cl.geometry.outlines import cut, edges, facets
from photizon_cl.scene.coatings.base import HEAD as COATING
from photizon_cl.scene.registry import DETECTORS, ELEMENTS, SURFACES
from photizon_cl.scene.scatters.base import HEAD

# the scene of everything builds for half a minute otherwise
pytestmark = pytest.mark.usefixtures("built_quickly")

UNIT_ROUNDOFF = 2.0**-53


@every_kind
def test_rows_stand_in_the_tables_under_their_names(group, kind):
    scene = shown(group, kind)
    thing, made = of_kind(scene, group, kind), compiled(scene)
    spec, tables = made.tables.spec, made.tables
    places = dict(spec.columns)
    first = {
        "element": len(POSITION), "surface": 0, "source": len(SOURCE), "scatter": 0,
        "coating": max(len(cls.row) for cls in {type(e.surface) for e in scene.element}),
    }[group]  # fmt: skip
    constants = thing.row.constants(first)
    if group == "scatter":  # its columns are an effect's own
        places = dict(entry for part in spec.parts for entry in part.parameters)
    assert constants.items() <= places.items()
    if group == "element":
        at = scene.element.index(thing)
        row = tables.geometry[at * spec.strides.row :]
        cls = next(c for c in spec.classes if c.kind == thing.kernel)
        far = tuple(max(abs(a), abs(b)) for a, b in zip(
            np.subtract(thing.position, made.shift), thing.position, strict=True
        ))  # fmt: skip
        packed = thing.packed(far, cls.axis, (1.0,) * 4)
    elif group == "scatter":
        at = next(n for n, e in enumerate(scene.element) if e.surface.lobe is thing)
        head = int(tables.codes[tables.launch["scatter"] + at]) >> 1
        row = tables.geometry[tables.codes[head + HEAD.constants(0)["SCATTER_ROW"]] :]
        packed = thing.packed()
    elif group == "coating":
        at = next(n for n, e in enumerate(scene.element) if e.surface.coat is thing)
        row = tables.materials[int(tables.codes[tables.launch["material_of"] + at]) :]
        packed = thing.packed(scene.element[at].surface.indices, scene.wavelengths[0])
        head = int(tables.codes[tables.launch["coatings"] + at]) >> 1
        nodes = int(tables.codes[head + COATING.constants(0)["COATING_NODES"]])
        there = np.ravel(np.array(thing.nodes))
        assert tables.geometry[nodes : nodes + len(there)].tolist() == there.tolist()
    elif group == "source":
        row = tables.sources[scene.source.index(thing) * spec.strides.source :]
        packed = thing.packed()
    else:
        at = next(n for n, e in enumerate(scene.element) if e.surface is thing)
        row = tables.materials[int(tables.codes[tables.launch["material_of"] + at]) :]
        packed = thing.packed()
    got = [row[constants[name]] for name in constants]
    assert got == thing.row.pack(packed)


# -- columns and kernels ---------------------------------------------------------------------------

_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*|^[ \t]*##[^\n]*|<%doc>.*?</%doc>", re.S | re.M)
_CONSTANT = re.compile(r"\b[A-Z][A-Z0-9]*(?:_[A-Z0-9]+)+\b")
_DEFINED = re.compile(r"^[ \t]*#define[ \t]+(\w+)", re.M)


def words(text: str) -> set[str]:
    """Return the whole identifiers in capitals that a text uses, comments and definitions aside."""
    return set(_CONSTANT.findall(_DEFINED.sub("", _COMMENT.sub("", text))))


@cache
def rendered() -> tuple[str, ...]:
    """Return the programs of the pages, with and without contact, and of all at once."""
    pages = [compiled(shown(*row)) for row in ROWS]
    touching = [
        compiled(shown(*row), frozenset({"contact"})) for row in ROWS if row[0] == "element"
    ]
    # without divergence a program has no text for it
    beam = pz.CollimatedDisk(name="s", flux=1.0, position=(0.0, 0.0, 0.0), axis="+z", radius=0.1,
                             divergence_deg=5.0)  # fmt: skip
    more = (compiled(pz.Scene(name="beam", source=(beam,))), compiled(everything()))
    specs = {made.tables.spec for made in (*pages, *touching, *more)}
    return tuple(program_source(spec.for_device(1, ("wave",))) for spec in specs)


def declared() -> dict[str, str]:
    """Return every declared column's constant, and the row that it is of."""
    rows = [POSITION, SOURCE, *(cls.row for kinds in GROUPS.values() for cls in kinds.values())]
    rows += [cls.reads for cls in GROUPS["coating"].values()] + [COATING]
    return {name: name.removesuffix(f"_{c.name.upper()}") for row in rows
            for name, c in zip(row.constants(0), row.columns, strict=True)}  # fmt: skip


def strangers(text: str) -> set[str]:
    """Return what looks like a column of a declared row, and is none nor defined in the text."""
    prefixes = tuple(f"{row}_" for row in {*declared().values()})
    known = declared().keys() | set(_DEFINED.findall(_COMMENT.sub("", text)))
    return {word for word in words(text) if word.startswith(prefixes)} - known


@every_kind
def test_every_declared_column_is_read_by_a_kernel(group, kind):
    used = set().union(*map(words, rendered()))
    cls = GROUPS[group][kind]
    names = [*cls.row.constants(0), *(cls.reads.constants(0) if group == "coating" else ())]
    assert not [name for name in names if name not in used]


def test_a_kernel_reads_no_column_that_no_class_declares():
    """In the templates themselves, whose branches no scene need have, and in what they become."""
    # the ledger's rows are defined in a loop
    ledger = {
        f"ROW_{name.upper().replace('.', '_')}"
        for name in compiled(everything()).tables.spec.ledger
    }
    templates = "\n".join(p.read_text(encoding="utf-8") for p in kernels_dir().rglob("*.mako"))
    assert not strangers(templates) - ledger
    for text in rendered():
        assert not strangers(text)


def test_a_column_in_a_comment_or_a_longer_name_is_not_read():
    text = "// MIRROR_REFLECTANCE\n## CONE_FOOT\n/* CPC_B\n */ x = row[SPHERE_RIMS];"
    assert words(text) == {"SPHERE_RIMS"}
    assert strangers(text) == {"SPHERE_RIMS"}


# -- documentation, drawings -----------------------------------------------------------------------


@pytest.fixture(scope="session")
def some_result() -> pz.Result:
    """What pages print numbers of; what those of each page are is shown by tests/docs."""
    return pz.trace(shown("element", "rectangle"), batches=2, rays_per_batch=64)


@every_kind
def test_it_is_documented_listed_and_priced(group, kind, capsys, monkeypatch, some_result):
    from photizon_cl.cli.main import main

    monkeypatch.setattr(pz, "trace", lambda *_, **__: some_result)
    cls = GROUPS[group][kind]
    text, _ = page(group, kind, cls)
    assert text.startswith(f"# {kind}\n")
    assert f"`photizon_cl.{cls.__name__}`" in text
    assert getattr(pz, cls.__name__) is cls
    assert main(["kinds", kind]) == 0
    assert kind in capsys.readouterr().out
    row = EFFECT_ROWS[f"{group}.{kind}"]
    assert row.what
    assert row.costs


def test_detectors_have_a_page(monkeypatch, some_result):
    monkeypatch.setattr(pz, "trace", lambda *_, **__: some_result)
    for kind, cls in DETECTORS.items():
        assert page("detector", kind, cls)[0].startswith(f"# {kind}\n")


def test_effects_are_told(capsys):
    from photizon_cl.cli.main import main

    for effect in EFFECTS:
        assert main(["kinds", effect.name]) == 0
        assert effect.what.split()[0] in capsys.readouterr().out


def test_a_figure_has_every_kind_and_the_rays(tmp_path):
    from photizon_cl.views.drawing.plot import draw_scene

    found = pz.paths(everything(), rays=24)
    assert set(found.scene.source) == set(everything().source)
    figure = draw_scene(found)
    with (tmp_path / "all.svg").open("wb") as file:
        figure.savefig(file, format="svg")
    assert (tmp_path / "all.svg").stat().st_size > 0
    assert all(source.outline() for source in everything().source)
    drawn = {h.get_label() for legend in figure.legends for h in legend.get_patches()}
    drawn |= {t.get_text() for legend in figure.legends for t in legend.get_texts()}
    labels = {e.surface.label_text for e in everything().element if e.detector is None}
    assert labels | {"detector", "source"} <= drawn


@pytest.mark.parametrize("kind", ELEMENTS)
def test_an_element_can_be_drawn_and_holds_what_hits_it(kind):
    element = turned(kind)
    assert edges(element)
    assert facets(element)
    assert any(
        cut(element, axis, element.position[axis] + 1e-3 * element.reach) for axis in range(3)
    )
    lamp = pz.IsotropicPoint(name="s", flux=1.0, position=(9.0, 9.0, 9.0))
    scene = pz.Scene(name="probe", source=(lamp,), element=(element,))
    random = np.random.default_rng(5)
    middle = np.array(element.position) + np.array(element.frame[2]) * 0.5 * element.local_box[1][2]
    starts = middle + random.normal(size=(4000, 3)) * element.reach
    along = middle + random.normal(size=(4000, 3)) * 0.3 * element.reach - starts
    along /= np.linalg.norm(along, axis=1)[:, None]
    hits = pz.probe(scene, starts, along, lanes=1)
    met = hits.element >= 0
    assert met.sum() > 50
    points = hits.point[met]
    assert np.linalg.norm(hits.normal[met], axis=1) == pytest.approx(1.0, abs=64 * UNIT_ROUNDOFF)
    travelled = starts[met] + hits.distance[met, None] * along[met]
    assert np.abs(points - travelled).max() < 1e-12 * element.reach
    assert np.linalg.norm(points - element.position, axis=1).max() <= element.reach * (1.0 + 1e-12)
    assert all(
        element.touches(element.local(tuple(p)), 1e-12 * element.reach) for p in points.tolist()
    )
    assert set(hits.face[met].tolist()) <= set(element.face_names)


@pytest.mark.parametrize("kind", [k for k, cls in ELEMENTS.items() if cls.has_map])
def test_the_bins_of_a_map_are_its_area(kind):
    element = of_kind(shown("element", kind), "element", kind)
    bins = element.map_bins(7, 5)
    assert bins.areas.shape == (5, 7)
    assert bins.areas.sum() == pytest.approx(element.area, rel=1e-13)
    assert bins.areas.min() >= 0.0


# -- surfaces, conservation ------------------------------------------------------------------------


def conserved(found: Any) -> None:
    """Each batch: in = out + absorbed, to the last bit of exact integers.

    Where a ray goes on as two one weight is the difference of two others, and rounds.
    """
    slack = Fraction(1, 10**15) if found.compiled.tables.spec.splits else 0
    assert max(map(abs, found.closures())) <= slack


# at other widths the bits are the same: test_contract_effects.py
@pytest.mark.parametrize(
    "lanes", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in (WIDE, 16))]
)
def test_nothing_is_lost_in_a_scene_of_everything(lanes):
    conserved(traced("everything", lanes))


def plate(surface: Any) -> Any:
    """A slanting beam on a plate that all else leaves: what is reflected goes up, the rest down."""
    lamp = {**beam((0.0, 0, 0.5), "-z", 1e-3), "tilt_deg": [20.0, 0.0]}
    board = {**wall((0, 0, 0), "+z", 50.0), "surface": {"kind": "absorber"}}
    scene = scene_of([lamp], [board], far_field={"n_mu": 2, "n_phi": 4})
    element = replace(scene.element[0], surface=surface)
    plan = PLAN.with_(lanes=1)
    return trace(replace(scene, element=(element,)), plan=plan, rays_per_batch=1024)


def traits_hold(surface: Any) -> None:
    """What a surface's class says of it is what it does to a beam from one side."""
    found = plate(surface)
    conserved(found)
    taken = found.absorbed("element 0")
    assert (taken == 0) or surface.absorbs
    assert found.interactions == (1024 if surface.counts else 0)
    # cos theta > 0 is the side that the beam came from
    down, up = found.far_field_counts.sum(axis=1).tolist()
    assert bool(up) == surface.reflects
    assert bool(down) == surface.transmits
    assert (up + down > 1024) == bool(surface.splits)


@pytest.mark.parametrize("kind", SURFACES)
def test_the_traits_of_a_surface_hold(kind):
    traits_hold(surface(kind))


def test_a_surface_whose_traits_are_wrong_is_caught():
    lossless = type("Lossless", (pz.Mirror,), {"absorbs": False})
    transparent = type("Transparent", (pz.Absorber,), {"transmits": True})
    uncounted = type("Uncounted", (pz.Mirror,), {"counts": False})
    for wrong in (lossless(0.5), transparent(), uncounted(0.5)):
        with pytest.raises(AssertionError):
            traits_hold(wrong)
