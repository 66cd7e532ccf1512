"""Engines broken on purpose: for each defect the gate that exists for it must fail.

A mutant is a change of a template's text. Each gate passes on the engine as it is (the tests in
``exact`` and ``statistical`` say so; it is asserted here once more) and fails on its mutants.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING

import pytest
from oracles import chance, gates, kernels
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, cube, matt, wall

from hostcode import templates
from hostcode.program import build

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


@dataclass(frozen=True)
class Mutant:
    """A defect: texts replaced in one template, and the gate that must notice."""

    name: str
    template: str
    changes: tuple[tuple[str, str], ...]
    gate: Callable[[], object]


def scatter() -> None:
    chance.lambertian_scatter(rays=1 << 15)


def tilted_scatter() -> None:
    chance.lambertian_scatter("-x", "back", rays=1 << 15)


def furnace() -> None:
    gates.closed_cube(matt(), rays=4096, cap=40)


def roulette() -> None:
    chance.roulette_is_unbiased()


def ghosts() -> None:
    gates.ghost_ladder(rays=64)


def sphere() -> None:
    chance.integrating_sphere(rays=1 << 14, batches=32, sigma=1e-3)


def isotropic() -> None:
    chance.source_directions("isotropic-point", rays=1 << 15)


def cosine_source() -> None:
    chance.source_directions("cosine-point", "-y", rays=1 << 15)


def disk_source() -> None:
    chance.disk_positions("collimated-disk", rays=1 << 14)


def reference() -> None:
    gates.reference_agrees(4)


def cap() -> None:
    gates.generation_cap(7)


def splits_and_absorbs() -> None:
    """Every bounce of a closed room takes a quarter, and the ledger says so."""
    mixed = {"surface": {"kind": "mixed", "specular": 0.25, "diffuse": 0.5}}
    found = trace(scene_of([LAMP], cube(mixed)), rays_per_batch=64, generation_cap=3)
    assert found.closures() == [0]
    assert found.depth_capped == 64 * Fraction(27, 64)


def passing() -> None:
    """Two planes that light passes, between a beam and a target."""
    planes = [
        {**wall((0, 0, z), "+z"), "surface": {"kind": "clear"}, "detector": {"side": "back"}}
        for z in (0.3, 0.6)
    ]
    elements = [*planes, {**wall((0, 0, 1), "-z"), **BLACK}]
    found = trace(scene_of([beam((0, 0, 0), "+z")], elements), rays_per_batch=64)
    assert found.interactions == 64
    assert [found.detector(f"element {n}").power for n in (0, 1)] == [64, 64]
    assert found.absorbed("element 2") == 64
    ball = {
        "kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.5,
        "surface": {"kind": "clear"}, "detector": {"side": "inside"},
    }  # fmt: skip
    found = trace(scene_of([beam((0, 0, 1), "-z")], [ball]), rays_per_batch=64)
    assert found.detector("element 0").power == 64


LAMP = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}

MUTANTS = (
    Mutant(
        "scatter without the cosine",
        "lib/directions.mako",
        (("sqrt(u)", "sqrt(u * (2.0 - u))"), ("sqrt(1.0 - u)", "1.0 - u")),
        scatter,
    ),
    Mutant(
        "scatter with cosine and sine swapped (the same law from another draw)",
        "lib/directions.mako",
        (("sqrt(u)", "sqrt(1.0 - u) "), (", sqrt(1.0 - u), x", ", sqrt(u), x")),
        reference,
    ),
    Mutant(
        "scatter about the normal, not the side that was hit",
        "lib/directions.mako",
        (("splat(-1.0))", "splat(1.0))"),),
        tilted_scatter,
    ),
    Mutant(
        "scatter over a half circle only",
        "lib/directions.mako",
        (("sincos_turns(v,", "sincos_turns(0.5 * v,"),),
        scatter,
    ),
    Mutant(
        "roulette survives 45 times in 100",
        "effects/roulette.mako",
        (("LT(u, splat(0.5))", "LT(u, splat(0.45))"),),
        roulette,
    ),
    Mutant(
        "what roulette adds is not booked",
        "effects/roulette.mako",
        (("image_difference(twice, before)", "image_difference(before, before)"),),
        gates.busy_room_closes,
    ),
    Mutant(
        "Fresnel reflectance counted twice",
        "surfaces/fresnel.mako",
        (("0.5 * fma(rs, rs, rp * rp)", "fma(rs, rs, rp * rp)"),),
        ghosts,
    ),
    Mutant(
        "transmitted light keeps the reflected share",
        "surfaces/fresnel.mako",
        (("wt = p->w - wr", "wt = p->w"),),
        gates.busy_room_closes,
    ),
    Mutant(
        "refraction as from the other side",
        "surfaces/fresnel.mako",
        (
            ("FRESNEL_RATIO_PLUS", "FRESNEL_ratio_minus"),
            ("FRESNEL_RATIO_MINUS", "FRESNEL_RATIO_PLUS"),
            ("FRESNEL_ratio_minus", "FRESNEL_RATIO_MINUS"),
        ),
        reference,
    ),
    Mutant(
        "reflected child lost",
        "surfaces/fresnel.mako",
        (("event->m & ~reflects & GT(wr, splat(0.0))", "lsplat(0L)"),),
        gates.busy_room_closes,
    ),
    Mutant(
        "decision left out of the counter",
        "lib/philox.mako",
        (("(decision << 16)", "0u"),),
        gates.counter_layout,
    ),
    Mutant(
        "generation left out of the counter",
        "lib/philox.mako",
        (("word c3 = generation |", "word c3 = 0u |"),),
        gates.counter_layout,
    ),
    Mutant(
        "every bounce of a ray draws the same numbers (correlated streams)",
        "lib/philox.mako",
        (("word c3 = generation |", "word c3 = 0u |"),),
        reference,
    ),
    Mutant(
        "ray number cut to 32 bits",
        "lib/philox.mako",
        (("word c1 = ray_hi |", "word c1 = 0u |"),),
        gates.counter_layout,
    ),
    Mutant(
        "siblings share a counter",
        "lib/children.mako",
        (("(p << 1) | (ulong)side", "(p << 1)"),),
        gates.paths_are_unique,
    ),
    Mutant(
        "siblings share a counter beyond 54 splits",
        "lib/children.mako",
        (("((1UL << 55) - 1UL)) | (ulong)side", "((1UL << 55) - 1UL))"),),
        lambda: gates.paths_are_unique(2**54, 6),
    ),
    Mutant(
        "nine rounds of Philox",
        "lib/philox.mako",
        (("range(10)", "range(9)"),),
        gates.counter_layout,
    ),
    Mutant(
        "uniforms in (0, 1]",
        "lib/philox.mako",
        (("TO_REAL(lo >> 11)", "TO_REAL((lo >> 11) + 1u)"),),
        gates.unit_interval,
    ),
    Mutant(
        "isotropic in theta instead of cos theta",
        "sources/isotropic_point.mako",
        (("fma(splat(-2.0), u, splat(1.0))", "fma(splat(-2.0), u, splat(1.0)) * u"),),
        isotropic,
    ),
    Mutant(
        "cosine source without the cosine",
        "sources/cosine_point.mako",
        (("sqrt(u)", "sqrt(u * (2.0 - u))"), ("sqrt(1.0 - u)", "1.0 - u")),
        cosine_source,
    ),
    Mutant(
        "disk source bright in the middle",
        "sources/collimated_disk.mako",
        (("sqrt(pu)", "pu"),),
        disk_source,
    ),
    Mutant(
        "every source's rays weigh the same",
        "lib/generate.mako",
        (("splat(source[SOURCE_WEIGHT])", "splat(1.0)"),),
        gates.shares_are_unbiased,
    ),
    Mutant(
        "a launched ray hits the face it starts on",
        "lib/faces.mako",
        (
            ("return m & NE(p->left, lsplat(NO_FACE))", "return m"),
            ("*crosses = NE(p->left, lsplat(NO_FACE)) &", "*crosses ="),
        ),
        gates.launched_rays_leave_their_face,
    ),
    Mutant(
        "of equal distances the last named is hit",
        "lib/meet.mako",
        (("LT(hit_code, h->code)", "GT(hit_code, h->code)"),),
        gates.first_named_is_hit,
    ),
    Mutant(
        "a ray taken in turn goes on among another's boxes",
        "effects/acceleration.mako",
        (("ray = walk->ray", "ray = walks[0].ray"),),
        gates.rays_in_turn_keep_apart,
    ),
    Mutant(
        "a careful search ends that of the rays beside it",
        "lib/nearest.mako",
        (("wanted &= ~(1u << l);", "wanted = 0u;"),),
        gates.rays_in_turn_keep_apart,
    ),
    Mutant(
        "faces in contact are never crossed",
        "lib/flat.mako",
        (("cross & NE(dh, splat(0.0)), ok)", "lsplat(0L), ok)"),),
        gates.contact_behind_glass,
    ),
    Mutant(
        "the sides of the faces in a corner are forgotten",
        "lib/faces.mako",
        (("return here & m;", "return lsplat(0L);"),),
        gates.corners_hold,
    ),
    Mutant(
        "a tube does not know its sides",
        "elements/baffled_tube.mako",
        (("LE(fabs(off), 64.0 * most)", "on"),),
        gates.curved_corners_hold,
    ),
    Mutant(
        "a lens does not know its sides",
        "lib/solid.mako",
        (
            ("fabs(q0.height), 64.0 * q0.near", "fabs(q0.height), 0.0 * q0.near"),
            ("fabs(q1.height), 64.0 * q1.near", "fabs(q1.height), 0.0 * q1.near"),
        ),
        gates.curved_corners_hold,
    ),
    Mutant(
        "a concentrator does not know its sides",
        "elements/cpc.mako",
        (("splat(64.0 * most)", "splat(most / 64.0)"),),
        gates.curved_corners_hold,
    ),
    Mutant(
        "edges are open",
        "elements/rectangle.mako",
        (("LE(ax, bx + row[FLAT_OUTER_U])", "LT(ax, splat(row[FLAT_INNER_U]))"),),
        gates.edges_hold,
    ),
    Mutant(
        "rims are open",
        "elements/disk.mako",
        (("LE(r2, bound * bound)", "LT(r2, splat(row[FLAT_INNER_U] * row[FLAT_INNER_U]))"),),
        gates.edges_hold,
    ),
    Mutant(
        "far field off by one bin",
        "effects/far_field.mako",
        (("n_phi + i)", "n_phi + (i + 1) % (int)launch->n_phi)"),),
        gates.far_field_bins,
    ),
    Mutant(
        "detector counts both sides",
        "lib/detector.mako",
        (("if ((end->tag & 1u) != (uint)d[DETECTOR_SIDE]) return;", ""),),
        gates.one_sided_detectors,
    ),
    Mutant(
        "ladder off by one generation",
        "filters/generation.mako",
        (("min((long)a->generation,", "min((long)a->generation + 1,"),),
        ghosts,
    ),
    Mutant(
        "depth-capped row dropped",
        "lib/survive.mako",
        (("book_row(launch, ledger, ROW_CAPPED, capped, image_of(p->w));", ""),),
        gates.busy_room_closes,
    ),
    Mutant(
        "one interaction too many",
        "lib/survive.mako",
        (("GE(TO_LINT(p->generation)", "GT(TO_LINT(p->generation)"),),
        cap,
    ),
    Mutant(
        "of a split surface nothing but the first child is booked",
        "lib/shade.mako",
        (("image_difference(before, sent)", "image_difference(before, image_of(outcome.w))"),),
        splits_and_absorbs,
    ),
    Mutant(
        "passing a surface counts as an interaction",
        "lib/shade.mako",
        (("const mask met = found & ~outcome.passes;", "const mask met = found;"),),
        passing,
    ),
    Mutant(
        "what passes stays on its side",
        "surfaces/clear.mako",
        (("~event->c->came_plus", "event->c->came_plus"),),
        passing,
    ),
    Mutant(
        "a map's bins along the other axis",
        "filters/along.mako",
        (("a->${option}", "a->${'v' if option == 'u' else 'u'}"),),
        lambda: gates.preset_agrees("box-room"),
    ),
    Mutant(
        "mirror without loss",
        "surfaces/mirror.mako",
        (("p->w * material_number(material, MIRROR_REFLECTANCE)", "p->w"),),
        gates.periscope,
    ),
    Mutant(
        "floating-point sums in the map",
        "lib/cells.mako",
        (("const double s = w *", "*(__global double *)cell += w; return; const double s = w *"),),
        gates.order_does_not_matter,
    ),
    Mutant(
        "chord of a sphere too short",
        "elements/sphere.mako",
        (("real t = 2.0 * fabs(b);", "real t = 1.5 * fabs(b);"),),
        sphere,
    ),
    Mutant(
        "port on the other side",
        "elements/sphere.mako",
        (("return GT(fma(t, dh, h)", "return GT(-fma(t, dh, h)"),),
        lambda: gates.preset_agrees("integrating-sphere"),
    ),
)  # fmt: skip


def _clear() -> None:
    templates._template.cache_clear()
    kernels._program.cache_clear()


@pytest.fixture
def engine(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Mutant], None]]:
    """Return a function that breaks the engine until the test ends."""

    def break_it(mutant: Mutant) -> None:
        whole = templates._with_line_directives

        def changed(name: str, text: str) -> str:
            if name == mutant.template:
                for old, new in mutant.changes:
                    assert old in text, f"{name} no longer holds {old!r}: mend the mutant"
                    text = text.replace(old, new)
            return whole(name, text)

        monkeypatch.setattr(templates, "_with_line_directives", changed)
        monkeypatch.setattr(build, "_CACHE", {})
        _clear()

    yield break_it
    monkeypatch.undo()
    _clear()


@cache
def passes_when_healthy(gate: Callable[[], object]) -> None:
    """Run a gate on the engine as it is, once however many mutants it is for."""
    gate()


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda m: m.name)
def test_gate_catches(mutant: Mutant, engine: Callable[[Mutant], None]) -> None:
    passes_when_healthy(mutant.gate)
    engine(mutant)
    with pytest.raises(AssertionError):
        mutant.gate()


def test_the_engine_is_whole_again_after_a_mutant() -> None:
    gates.counter_layout()
    gates.first_named_is_hit()
