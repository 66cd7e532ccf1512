"""What every row of the registry must hold: a new kind is covered by being there.

The scenes are those of the kinds' own pages. Random gates have fixed seeds, false alarms
of at most one in 1.7 million each (5 σ) and no reruns.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled
from oracles.scenes import beam, wall

import photizon_cl as pz
from hostcode.assets import kernels_dir
from photizon_cl.compile.effects.table import EFFECT_ROWS, EFFECTS
from photizon_cl.compile.layout import CellGroup
from photizon_cl.compile.packing import POSITION, SOURCE
from photizon_cl.geometry.outlines import cut, edges, facets
from photizon_cl.scene.files import load
from photizon_cl.scene.registry import DETECTORS, ELEMENTS, FILTERS, SOURCES, SURFACES

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "_ext"))

from photizon_docs.emit import as_toml  # noqa: E402
from photizon_docs.examples import example, guess  # noqa: E402
from photizon_docs.parts import page  # noqa: E402

GROUPS = {"element": ELEMENTS, "surface": SURFACES, "source": SOURCES}
ROWS = [(group, kind) for group, kinds in GROUPS.items() for kind in kinds]
every_kind = pytest.mark.parametrize(("group", "kind"), ROWS, ids=[f"{g}-{k}" for g, k in ROWS])


@cache
def shown(group: str, kind: str) -> pz.Scene:
    return example(group, kind, GROUPS[group][kind])


def of_kind(scene: pz.Scene, group: str, kind: str) -> Any:
    things = {
        "element": scene.element, "source": scene.source,
        "surface": [e.surface for e in scene.element],
    }[group]  # fmt: skip
    return next(thing for thing in things if thing.kind == kind)


@every_kind
def test_lanes_change_no_bit_and_the_ledger_closes(group, kind):
    made = compiled(shown(group, kind), rays_per_batch=256)
    wide = trace_compiled(made, plan=PLAN.with_(lanes=16, refill=4))
    narrow = trace_compiled(made, plan=PLAN.with_(lanes=1))
    assert wide.digest == narrow.digest
    assert wide.interactions == narrow.interactions
    assert max(map(abs, wide.closures())) <= Fraction(1, 10**15)
    assert wide.interactions > 0 or kind == "clear"  # which makes none


@every_kind
def test_rows_stand_in_the_tables_under_their_names(group, kind):
    scene = shown(group, kind)
    thing, made = of_kind(scene, group, kind), compiled(scene)
    spec, tables = made.tables.spec, made.tables
    places = dict(spec.columns)
    first = {"element": len(POSITION), "surface": 0, "source": len(SOURCE)}[group]
    constants = thing.row.constants(first)
    assert constants.items() <= places.items()
    if group == "element":
        at = scene.element.index(thing)
        row = tables.geometry[at * spec.strides.row :]
        cls = next(c for c in spec.classes if c.kind == thing.kernel)
        far = tuple(max(abs(a), abs(b)) for a, b in zip(
            np.subtract(thing.position, made.shift), thing.position, strict=True
        ))  # fmt: skip
        packed = thing.packed(far, cls.axis, (1.0,) * 4)
    elif group == "source":
        row = tables.sources[scene.source.index(thing) * spec.strides.source :]
        packed = thing.packed()
    else:
        at = next(n for n, e in enumerate(scene.element) if e.surface is thing)
        row = tables.materials[int(tables.codes[tables.launch["material_of"] + at]) :]
        packed = thing.packed()
    got = [row[constants[name]] for name in constants]
    assert got == thing.row.pack(packed)


@every_kind
def test_every_declared_column_is_read_by_a_kernel(group, kind):
    cls = GROUPS[group][kind]
    text = "".join(p.read_text(encoding="utf-8") for p in kernels_dir().rglob("*.mako"))
    # the edges of flat faces are named by their letter in a loop
    text += "".join(
        f"FLAT_{w}_{e}" for w in ("OUTER", "INNER", "OUTER_MINUS", "INNER_MINUS") for e in "UV"
    )
    assert not [name for name in cls.row.constants(0) if name not in text]


@every_kind
def test_files_give_back_what_they_hold(group, kind, tmp_path):
    scene = shown(group, kind)
    assert load(scene.to_dict()) == scene
    (tmp_path / "scene.toml").write_text(as_toml(scene), encoding="utf-8")
    again = load(tmp_path / "scene.toml")
    assert of_kind(again, group, kind) == of_kind(scene, group, kind)


@every_kind
def test_it_is_documented_listed_and_priced(group, kind, capsys):
    from photizon_cl.cli.main import main

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


@pytest.mark.parametrize("kind", ELEMENTS)
def test_an_element_can_be_drawn_and_holds_what_hits_it(kind):
    element = of_kind(shown("element", kind), "element", kind)
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
    hits = pz.probe(scene, starts, along)
    met = hits.element >= 0
    assert met.sum() > 50
    points = hits.point[met]
    assert np.linalg.norm(hits.normal[met], axis=1) == pytest.approx(1.0, abs=1e-14)
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


# -- surfaces --------------------------------------------------------------------------------------


def plate(surface: Any) -> Any:
    """A slanting beam on a plate that all else leaves: what is reflected goes up, the rest down."""
    lamp = {**beam((0.0, 0, 0.5), "-z", 1e-3), "tilt_deg": [20.0, 0.0]}
    board = {**wall((0, 0, 0), "+z", 50.0), "surface": {"kind": "absorber"}}
    scene = scene_of([lamp], [board], far_field={"n_mu": 2, "n_phi": 4})
    element = replace(scene.element[0], surface=surface)
    return trace(replace(scene, element=(element,)), rays_per_batch=1024, generation_cap=4)


def traits_hold(surface: Any) -> None:
    """What a surface's class says of it is what it does to a beam from one side."""
    found = plate(surface)
    assert max(map(abs, found.closures())) <= Fraction(1, 10**15)
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
    cls = SURFACES[kind]
    traits_hold(cls(**guess(cls)))


def test_a_surface_whose_traits_are_wrong_is_caught():
    lossless = type("Lossless", (pz.Mirror,), {"absorbs": False})
    transparent = type("Transparent", (pz.Absorber,), {"transmits": True})
    uncounted = type("Uncounted", (pz.Mirror,), {"counts": False})
    for wrong in (lossless(0.5), transparent(), uncounted(0.5)):
        with pytest.raises(AssertionError):
            traits_hold(wrong)


@pytest.mark.parametrize("kind", [k for k, cls in SURFACES.items() if cls.reflects])
def test_a_reflector_is_reciprocal(kind):
    """A small lamp and a small target change places: the same power, within 5 σ of both."""
    cls = SURFACES[kind]
    surface, power = cls(**guess(cls)), []
    for here, there in (((-0.6, 0.0, 0.5), (0.4, 0.1, 0.8)), ((0.4, 0.1, 0.8), (-0.6, 0.0, 0.5))):
        lamp = {
            "kind": "lambertian-disk",
            "flux": 1.0,
            "position": list(here),
            "axis": "-z",
            "radius": 0.2,
        }
        target = {"kind": "disk", "position": there, "axis": "-z", "radius": 0.2,
                  "surface": {"kind": "absorber"}, "detector": {}}  # fmt: skip
        scene = scene_of(
            [lamp], [{**wall((0, 0, 0), "+z", 3.0), "surface": {"kind": "absorber"}}, target]
        )
        scene = replace(
            scene, element=(replace(scene.element[0], surface=surface), scene.element[1])
        )
        result = pz.trace(scene, batches=16, rays_per_batch=8192)
        power.append(result.detectors["element 1"].power)
    a, b = power
    assert a.value > 0.0
    assert abs(a.value - b.value) < 5.0 * math.hypot(a.sigma, b.sigma)


# -- sources ---------------------------------------------------------------------------------------

MOMENTS: dict[str, tuple[float, float, float]] = {
    # mean cosine about the axis, its mean square, mean squared distance of the start in `reach`²
    "isotropic-point": (0.0, 1 / 3, 0.0),
    "cosine-point": (2 / 3, 1 / 2, 0.0),
    "lambertian-disk": (2 / 3, 1 / 2, 1 / 2),
    "lambertian-sphere": (0.0, 1 / 3, 1.0),
    "collimated-disk": (1.0, 1.0, 1 / 2),
    "cone-point": ((1 + math.cos(math.radians(30.0))) / 2,
                   (1 + math.cos(math.radians(30.0)) + math.cos(math.radians(30.0)) ** 2) / 3, 0.0),
    "lambertian-rectangle": (2 / 3, 1 / 2, 1 / 3),
}  # fmt: skip


@pytest.mark.parametrize("kind", SOURCES)
def test_a_source_has_the_moments_of_its_density(kind):
    assert kind in MOMENTS, "give the moments of the new source here"
    cls, n = SOURCES[kind], 4096
    values = {**guess(cls), "name": "s", "flux": 1.0, "position": (0.1, 0.2, 0.3)}
    source = cls(**(values | {"axis": "-y", "tilt_deg": (20.0, 30.0)} if cls.directed else values))
    found = pz.paths(pz.Scene(name="s", source=(source,)), rays=n)
    along = found.end - found.start
    along /= np.linalg.norm(along, axis=1)[:, None]
    mu = along @ np.array(source.frame[2])
    away = np.linalg.norm(found.start - source.position, axis=1)
    size = source.reach or 1.0
    mean, square, spread = MOMENTS[kind]
    for sample, wanted in ((mu, mean), (mu**2, square), ((away / size) ** 2, spread)):
        slack = 5.0 * max(float(sample.std()) / math.sqrt(n), 1e-12)
        assert abs(float(sample.mean()) - wanted) < slack
    assert away.max() <= source.reach * (1.0 + 1e-12) + 1e-15
    assert source.draws_position == bool(source.reach)


# -- filters, detectors, effects -------------------------------------------------------------------


@pytest.mark.parametrize("kind", FILTERS)
def test_a_filter_loses_no_arrival(kind):
    cls = FILTERS[kind]
    assert (kernels_dir() / "filters" / f"{cls.kernel}.mako").is_file()
    assert cls.what
    used = 0
    for element in ("rectangle", "sphere", "cylinder"):
        scene = shown("element", element)
        black = {"surface": pz.Absorber(), "detector": pz.Detector(map=(5, 3), generations=4)}
        thing = replace(of_kind(scene, "element", element), **black)
        made = compiled(replace(scene, element=(thing,)), rays_per_batch=512)
        found = trace_compiled(made)
        (detector,) = made.layout.detectors
        for tally in detector.tallies:
            used += any(isinstance(f, cls) for f in tally.filters)
            assert found.amount(tally.first, tally.size) == found.amount(detector.power)
            for f in tally.filters:
                assert len(f.axis.edges) == f.bins + 1
                assert (np.diff(f.axis.edges) > 0.0).all()
    assert used


def test_detectors_have_a_page():
    for kind, cls in DETECTORS.items():
        assert page("detector", kind, cls)[0].startswith(f"# {kind}\n")


@pytest.mark.parametrize("effect", EFFECTS, ids=[e.name for e in EFFECTS])
def test_an_effect_says_why_and_leaves_nothing_where_it_is_not_needed(effect):
    from hostcode.program.source import program_source

    bare = load("cosine-fourth")
    lamp = replace(bare, element=(replace(bare.element[0], detector=None),), far_field=None)
    reason = effect.needed(lamp, lamp.run)
    assert reason is None
    assert effect.what
    assert effect.costs
    made = compiled(lamp)
    assert effect.name not in made.effects
    text = program_source(made.tables.spec.for_device(4, ("wave",)))
    forced = compiled(lamp, frozenset({effect.name}))
    if effect.name in forced.effects:
        assert forced.reasons[effect.name] == "it was asked for"
        for part in forced.tables.spec.parts:
            for _, template in part.templates:
                assert f'"kernels/{template}.mako"' not in text
            for field in part.ray:
                assert f" {field.name};" not in text


@pytest.mark.parametrize("labels", [("a",), ("a", "a")])
def test_no_cell_of_an_effect_has_the_label_of_another(labels):
    with pytest.raises(ValueError, match="give each cell a label of its own"):
        CellGroup("bounces", 0, (2,), labels)
