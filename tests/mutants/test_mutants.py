"""Engines broken on purpose: for each defect the gate that exists for it must fail.

A mutant is another text at named points of the kernels. Each gate passes on the engine as it is
(the tests in ``exact`` and ``statistical`` say so; it is asserted here once a gate) and fails on
its mutants.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING

import pytest
from oracles import (
    aiming,
    branching,
    brewster,
    chance,
    coatings,
    contacts,
    gates,
    kernels,
    media,
    packets,
    polarised,
    scattering,
    spectra,
    spectra_scatter,
    trails,
)
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, cube, matt, wall

from hostcode import templates
from hostcode.assets import kernels_dir
from hostcode.errors import HostError, KernelBuildError
from hostcode.program import build

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from _pytest.mark.structures import ParameterSet

# a program a mutant; what a gate sees of it no optimiser decides
pytestmark = pytest.mark.usefixtures("built_quickly")


@dataclass(frozen=True)
class Mutant:
    """A defect: what stands at some points of the kernels, and the gate that must notice."""

    name: str
    points: Mapping[str, str | int]
    gate: Callable[[], object]


def scatter() -> None:
    chance.lambertian_scatter(rays=1 << 15)


def tilted_scatter() -> None:
    chance.lambertian_scatter("-x", "back", rays=1 << 15)


def furnace() -> None:
    gates.closed_cube(matt(), rays=4096, cap=40)


def lobes() -> None:
    for name in ("gaussian", "harvey-shack", "abg", "table"):
        scattering.follows_the_bsdf(name, rays=1 << 13, angles=(80.0,))


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
        'scatter without the cosine',
        {'directions.sine': 'sqrt(u * (2.0 - u))', 'directions.cosine': '1.0 - u'},
        scatter,
    ),
    Mutant(
        'scatter with cosine and sine swapped (the same law from another draw)',
        {'directions.sine': 'sqrt(1.0 - u)', 'directions.cosine': 'sqrt(u)'},
        reference,
    ),
    Mutant(
        'scatter about the normal, not the side that was hit',
        {'directions.other_side': 'splat(1.0)'},
        tilted_scatter,
    ),
    Mutant(
        'scatter over a half circle only',
        {'directions.turn': '0.5 * v'},
        scatter,
    ),
    Mutant(
        'a matt wall that sends on a thousandth too much',
        {'lambertian.weight': 'WT(1.001) * p->w * weight_number(material, LAMBERTIAN_REFLECTANCE)'},
        furnace,
    ),
    Mutant(
        'a ray that survives roulette with what it had',
        {'roulette.weight': 'p->w'},
        roulette,
    ),
    Mutant(
        'the other child is chosen',
        {'choice.chance': '~WEIGHT_LT(TO_WEIGHT(u) * sum, outcome->second_w)'},
        branching.chooses,
    ),
    Mutant(
        'the chosen child has its own weight alone',
        {'choice.weight': 'outcome->w'},
        branching.chooses,
    ),
    Mutant(
        'what the sum of two children is rounded by is not booked',
        {'choice.booked': 'image_difference(sent, sent)'},
        branching.rounds,
    ),
    Mutant(
        'roulette survives 45 times in 100',
        {'roulette.chance': 'splat(0.45)'},
        roulette,
    ),
    Mutant(
        'what roulette adds is not booked',
        {'roulette.added': 'image_difference(before, before)'},
        gates.busy_room_closes,
    ),
    Mutant(
        'Fresnel reflectance counted twice',
        {'fresnel.reflectance': 'fma(rs, rs, rp * rp)'},
        ghosts,
    ),
    Mutant(
        'transmitted light keeps the reflected share',
        {'fresnel.transmitted': 'p->w'},
        gates.busy_room_closes,
    ),
    Mutant(
        'refraction as from the other side',
        {'fresnel.ratio_plus': 'FRESNEL_RATIO_MINUS', 'fresnel.ratio_minus': 'FRESNEL_RATIO_PLUS'},
        reference,
    ),
    Mutant(
        'reflected child lost',
        {'fresnel.splits': 'NO_LANES'},
        gates.busy_room_closes,
    ),
    Mutant(
        'decision left out of the counter',
        {'philox.decision': '0u'},
        gates.counter_layout,
    ),
    Mutant(
        'generation left out of the counter',
        {'philox.generation': '0u'},
        gates.counter_layout,
    ),
    Mutant(
        'every bounce of a ray draws the same numbers (correlated streams)',
        {'philox.generation': '0u'},
        reference,
    ),
    Mutant(
        'ray number cut to 32 bits',
        {'philox.ray': '0u'},
        gates.counter_layout,
    ),
    Mutant(
        'siblings share a counter',
        {'children.sibling': '(p << 1)'},
        gates.paths_are_unique,
    ),
    Mutant(
        'siblings share a counter beyond 54 splits',
        {'children.mixed_sibling': ''},
        lambda: gates.paths_are_unique(2**54, 6),
    ),
    Mutant(
        'nine rounds of Philox',
        {'philox.rounds': 9},
        gates.counter_layout,
    ),
    Mutant(
        'uniforms in (0, 1]',
        {'philox.low_word': 'TO_REAL((lo >> 11) + 1u)'},
        gates.unit_interval,
    ),
    Mutant(
        'isotropic in theta instead of cos theta',
        {'isotropic_point.cosine': 'fma(splat(-2.0), u, splat(1.0)) * u'},
        isotropic,
    ),
    Mutant(
        'cosine source without the cosine',
        {'cosine_point.sine': 'sqrt(u * (2.0 - u))', 'cosine_point.cosine': '1.0 - u'},
        cosine_source,
    ),
    Mutant(
        'disk source bright in the middle',
        {'collimated_disk.radius': 'pu'},
        disk_source,
    ),
    Mutant(
        "every source's rays weigh the same",
        {'generate.weight': 'splat(1.0)'},
        gates.shares_are_unbiased,
    ),
    Mutant(
        'a launched ray hits the face it starts on',
        {'faces.launched': 'ALL_LANES', 'faces.launched_in_contact': 'ALL_LANES'},
        gates.launched_rays_leave_their_face,
    ),
    Mutant(
        'of equal distances the last named is hit',
        {'meet.first_named': 'IGT(hit_code, h->code)'},
        gates.first_named_is_hit,
    ),
    Mutant(
        'glass that is left has no precedence where bodies touch',
        {'coincidence.refracting': 'lsplat(2L)'},
        contacts.have_a_film,
    ),
    Mutant(
        'rounding decides which of the faces in one place is nearer',
        {'coincidence.room': 'R(0.0)'},
        contacts.have_a_film,
    ),
    Mutant(
        'a clear face takes the place in the file that it has',
        {'coincidence.clear': 'lsplat(2L)'},
        contacts.clear_lies_in_front,
    ),
    Mutant(
        'a wall and the floor on which it stands count as in one place',
        {'coincidence.parallel': 'ALL_LANES'},
        contacts.walls_stand_on_floors,
    ),
    Mutant(
        "a ray taken in turn goes on among another's boxes",
        {'acceleration.ray': 'walks[0].ray'},
        gates.rays_in_turn_keep_apart,
    ),
    Mutant(
        'a careful search ends that of the rays beside it',
        {'nearest.searched': '= 0u'},
        gates.rays_in_turn_keep_apart,
    ),
    Mutant(
        'faces in contact are never crossed',
        {'flat.crossed': 'NO_LANES'},
        gates.contact_behind_glass,
    ),
    Mutant(
        'the sides of the faces in a corner are forgotten',
        {'faces.known': 'NO_LANES'},
        gates.corners_hold,
    ),
    Mutant(
        'a tube does not know its sides',
        {'baffled_tube.beside': 'on'},
        gates.curved_corners_hold,
    ),
    Mutant(
        'a lens does not know its sides',
        {'solid.beside_first': '0.0 * q0.near', 'solid.beside_second': '0.0 * q1.near'},
        gates.curved_corners_hold,
    ),
    Mutant(
        "what a ray notes of a concentrator depends on its neighbours",
        {"cpc.around": "nowhere"},
        packets.neighbours_decide_nothing,
    ),
    Mutant(
        'a concentrator does not know its sides',
        {'cpc.beside': 'splat(most / 64.0)'},
        gates.curved_corners_hold,
    ),
    Mutant(
        'edges are open',
        {'rectangle.edge': 'LT(ax, splat(row[FLAT_INNER_U]))'},
        gates.edges_hold,
    ),
    Mutant(
        'rims are open',
        {'disk.rim': 'LT(r2, splat(row[FLAT_INNER_U] * row[FLAT_INNER_U]))'},
        gates.edges_hold,
    ),
    Mutant(
        'far field off by one bin',
        {'far_field.column': '(i + 1) % (int)launch->n_phi'},
        gates.far_field_bins,
    ),
    Mutant(
        'a direction on an edge in theta belongs below it',
        {'far_field_about.passed': 'edges[2 * k] * across > edges[2 * k + 1] * along'},
        gates.far_field_edges,
    ),
    Mutant(
        'edges in theta by their cosines alone',
        {'far_field_about.passed': 'edges[2 * k] >= along'},
        gates.far_field_edges,
    ),
    Mutant(
        'detector counts both sides',
        {'detector.other_side': 'false'},
        gates.one_sided_detectors,
    ),
    Mutant(
        'ladder off by one generation',
        {'generation.entry': '(long)a->generation + 1'},
        ghosts,
    ),
    Mutant(
        'depth-capped row dropped',
        {'survive.booked': ''},
        gates.busy_room_closes,
    ),
    Mutant(
        'one interaction too many',
        {'survive.at_cap': 'IGT'},
        cap,
    ),
    Mutant(
        'of a split surface nothing but the first child is booked',
        {'shade.sent': 'image_of(outcome.w)'},
        splits_and_absorbs,
    ),
    Mutant(
        'passing a surface counts as an interaction',
        {'shade.met': 'found'},
        passing,
    ),
    Mutant(
        'what passes stays on its side',
        {'clear.side': 'event->c->came_plus'},
        passing,
    ),
    Mutant(
        "a map's bins along the other axis",
        {'along.coordinate': 'a->v'},
        lambda: gates.preset_agrees("box-room"),
    ),
    Mutant(
        "a map's bins from the other axis in azimuth",
        {'azimuth.plane': 'a->v, a->u'},
        reference,
    ),
    Mutant(
        "no tally's form is known",
        {'detector.form': 'false'},
        reference,
    ),
    Mutant(
        'interactions are booked on no row',
        {'ledger.interactions': '0L'},
        cap,
    ),
    Mutant(
        'the faces in a corner are not remembered',
        {'faces.remembered': 'lsplat(-1L)'},
        gates.corners_hold,
    ),
    Mutant(
        'the face that was left is not remembered',
        {'faces.departed': 'lsplat(NO_SLOT)'},
        gates.corners_hold,
    ),
    Mutant(
        'a cone that is dense on its axis',
        {'cone_point.height': 'u * u'},
        chance.cone_is_uniform,
    ),
    Mutant(
        'a beam that diverges with uniform intensity on its rim',
        {'collimated_disk.sine': 'u'},
        chance.beam_has_uniform_radiance,
    ),
    Mutant(
        'a rectangle that shines from a half of it',
        {'lambertian_rectangle.across': 'pv'},
        chance.rectangle_lamp_is_even,
    ),
    Mutant(
        'a mixed surface that keeps what the larger child has',
        {'mixed.larger': 'fmin(s, d)'},
        gates.mixed_shares,
    ),
    Mutant(
        'a mixed surface without its mirror',
        {'mixed.first': 'x'},
        gates.mixed_shares,
    ),
    Mutant(
        'mirror without loss',
        {'mirror.weight': 'p->w'},
        gates.periscope,
    ),
    Mutant(
        'floating-point sums in the map',
        {'cells.begin': '*(__global double *)cell += w; return; const double s = '},
        gates.order_does_not_matter,
    ),
    Mutant(
        'chord of a sphere too short',
        {'sphere.chord': '1.5 * fabs(b)'},
        sphere,
    ),
    Mutant(
        'port on the other side',
        {'sphere.height': '-fma(t, dh, h)'},
        lambda: gates.preset_agrees("integrating-sphere"),
    ),
    Mutant(
        "what is reflected in a hollow does not meet it again",
        {"lens.hollow": "NO_LANES"},
        gates.hollow_faces_are_met_again,
    ),
    Mutant(
        "a disk's rim is no part of the wall that ends there",
        {"revolved.beside": "near"},
        gates.round_corners_hold,
    ),
    Mutant(
        "a tube ends before its rim",
        {"cylinder.rim": "-64.0 * along"},
        gates.round_corners_hold,
    ),
    Mutant(
        "a ray gets out through an apex",
        {"revolved.latest": "lsplat(0L)"},
        gates.round_corners_hold,
    ),
    Mutant(
        "a steep sheet is clamped to its upper rim",
        {"conic.height": "SEL(beyond, high, clamp(z, low, high))"},
        gates.round_corners_hold,
    ),
    Mutant(
        "a path is counted by half",
        {"keyed.weight": "(0.5 * w)"},
        trails.plate,
    ),
    Mutant(
        "the last ray of a path is its example",
        {"keyed.first": "seen == 0 || seen > early"},
        trails.plate,
    ),
    Mutant(
        "of a run of one path the last ray is its example",
        {"keyed.earliest": "early"},
        trails.beam,
    ),
    Mutant(
        "whatever follows a path is counted there",
        {"keyed.other": "!keyed->key"},
        trails.plate,
    ),
    Mutant("a path forgets what it met", {"path_table.trail": "trail"}, trails.plate),
    Mutant(
        'points of a target drawn by area, without the cosine',
        {'importance.by_area': 'rr * R(t[TARGET_PER_AREA])'},
        aiming.disk_over_a_plate,
    ),
    Mutant(
        'the mixture has half of the targets',
        {'importance.mixture': 'R(0.5) * density'},
        aiming.disk_over_a_plate,
    ),
    Mutant(
        'what is aimed keeps its weight',
        {'importance.ratio': 'splat(1.0)'},
        aiming.disk_over_a_plate,
    ),
    Mutant(
        'what aiming takes is not booked',
        {'importance.booked': 'image_of(w)'},
        aiming.disk_over_a_plate,
    ),
    Mutant(
        'a density of scattering that is too large',
        {'directions.density': '0.5'},
        aiming.disk_over_a_plate,
    ),
    Mutant(
        'a cone that is denser in its middle',
        {'importance.height': 'u * u'},
        aiming.ball_over_a_plate,
    ),
    Mutant(
        'weights that grow with every bounce',
        {'importance.heaviest': '16.0'},
        aiming.weights_are_bounded,
    ),
    Mutant("all of a lobe is above the horizon", {"scatter.horizon": "splat(9.0)"}, lobes),
    Mutant("radii of a lobe that are uniform", {"gaussian.radius": "far * sigma * u"}, lobes),
    Mutant("a shoulder that is too wide", {"harvey_shack.radius": "R(2.0) * r"}, lobes),
    Mutant("all that is tried under a power is taken", {"abg.chance": "splat(1.0)"}, lobes),
    Mutant("a table that is steps", {"table.line": "most"}, lobes),
    Mutant(
        "a density of a lobe without the horizon",
        {"scatter.density": "bsdf * up"},
        scattering.aimed_ring,
    ),
    Mutant(
        "a share that is half", {"scatter.total": "R(0.5) * total"}, scattering.both_parts_go_on
    ),
    Mutant(
        "the same share at every angle",
        {"scatter.share": "R(0.2)"},
        scattering.both_parts_go_on,
    ),
    Mutant(
        "what scatters stays besides", {"scatter.stays": "whole"}, scattering.closes
    ),
    Mutant(
        "what black paint scatters ends there too",
        {"scatter.booked": "none"},
        scattering.closes,
    ),
    Mutant(
        "one of two by even chances",
        {"scatter.chance": "LT(u, splat(0.5))"},
        scattering.one_of_two_goes_on,
    ),
    Mutant(
        "the plane of incidence is not turned into",
        {"polarisation.turned": "p->stokes_q"},
        brewster.malus,
    ),
    Mutant(
        "the mean reflectance, however light is polarised",
        {"fresnel.polarised": "R(0.5) * fma(rs, rs, rp * rp)"},
        brewster.plate_by_its_parts,
    ),
    Mutant(
        "the mean reflectance of films, however light is polarised",
        {"stack.polarised": "R(0.5) * (reflected_part(&s) + reflected_part(&p))"},
        polarised.coated_chain,
    ),
    Mutant(
        "what s and p transmit is swapped",
        {"fresnel.transmits": "a, b"},
        brewster.plate_by_its_parts,
    ),
    Mutant(
        "total reflection without a phase", {"fresnel.in_phase": "splat(1.0)"}, brewster.rhomb
    ),
    Mutant(
        "a metal that leaves the field as it is",
        {"polarisation.conductor": "splat(1.0)"},
        brewster.metal,
    ),
    Mutant(
        "the chosen child has the light of the other",
        {"choice.light": "outcome->stokes_q"},
        brewster.chooses_one_child,
    ),
    Mutant(
        "one of two that scatters stays polarised",
        {"event.unpolarised": "NO_LANES"},
        brewster.scattered_light_is_unpolarised,
    ),
    Mutant(
        "matt light stays polarised",
        {"mixed.polarised": "event->m"},
        polarised.replays_a_room,
    ),
    Mutant(
        "a turn from u towards v is right-handed about every ray",
        {"polarisation.along": "ALL_LANES"},
        polarised.replays_a_room,
    ),
    Mutant(
        'roulette ends what was aimed',
        {'roulette.aimed': 'floor_weight'},
        aiming.roulette_spares_what_is_aimed,
    ),
    Mutant(
        'what a segment loses is taken twice',
        {'media.left': 'left * TO_REAL(kept)'},
        media.slab,
    ),
    Mutant(
        'what leaves the scene is not absorbed on its way',
        {'media.left': 'SEL_WEIGHT(h->found, left, p->w)'},
        media.slab,
    ),
    Mutant(
        'what a medium takes is not booked',
        {'media.booked': 'image_of(p->w)'},
        media.slab,
    ),
    Mutant(
        'absorption sees half of a segment',
        {'media.length': 'TO_WIDE(h->t) * 0.5'},
        media.slab,
    ),
    Mutant(
        'a ray keeps the medium that it was launched in',
        {'media.crosses': 'NO_LANES'},
        media.nested,
    ),
    Mutant(
        'every medium is the right one',
        {'media.wrong': 'NO_LANES'},
        media.wrong,
    ),
    Mutant(
        'a stack reflects as if all light were s',
        {'stack.reflected': 'reflected_part(&s)'},
        coatings.stacks_in_digits,
    ),
    Mutant(
        'p passes a stack as s does',
        {'stack.passed': 'passed_part(&s)'},
        coatings.stacks_in_digits,
    ),
    Mutant(
        'layers stand in one order from either side',
        {'stack.order': 'lsplat(k)'},
        coatings.stacks_in_digits,
    ),
    Mutant(
        'light comes from outside, whichever side it is on',
        {'coatings.side': 'ALL_LANES'},
        coatings.table_from_both_sides,
    ),
    Mutant(
        'a table is read at the angle inside',
        {'table.angle': 'degrees_of(sine, film->ci)'},
        coatings.table_from_both_sides,
    ),
    Mutant(
        'what would pass beyond the critical angle is lost',
        {'coatings.total': 'r'},
        coatings.beyond_the_critical_angle,
    ),
    Mutant(
        'a stack without extinction loses by rounding',
        {'coatings.lossless': 'NO_LANES'},
        coatings.nothing_is_made_or_lost,
    ),
    Mutant(
        'what a coating takes is not booked',
        {'shade.takes': 'NO_LANES'},
        coatings.absorbed_to_the_last_bit,
    ),
    Mutant(
        'all rays are of the first line',
        {'spectrum.line': '0L'},
        spectra.prism,
    ),
    Mutant(
        'all rays of a band have the wavelength of its beginning',
        {'spectrum.in_band': 'splat(0.0)'},
        spectra.prism_of_bands,
    ),
    Mutant(
        'what depends on wavelength is that of where pieces begin',
        {'event.number': 'gather(material->table + column, material->row)'},
        spectra.prism_of_bands,
    ),
    Mutant(
        'the ledger books every line as the first',
        {'spectrum.booked': 'lsplat(0L)'},
        spectra.tables,
    ),
    Mutant(
        'a medium absorbs every line as the first',
        {'media.line': 'p->medium * (long)launch->lines'},
        spectra.tables,
    ),
    Mutant(
        'a detector counts every line as the first',
        {'wavelength.line': '0L'},
        spectra.tables,
    ),
    Mutant(
        'a medium absorbs as where pieces of bands begin',
        {'media.along': '(wide)(0.0)'},
        spectra_scatter.nested_of_bands,
    ),
    Mutant(
        'a mirror that scatters reflects as where pieces of bands begin',
        {'event.weight': 'gather_weight(material->table + column, material->row)'},
        spectra_scatter.scattering_of_bands,
    ),
    Mutant(
        'what is scattered at glass and mirrors is of the first line',
        {'spectrum.line': '0L'},
        spectra_scatter.scattering_of_lines,
    ),
)  # fmt: skip


def _clear() -> None:
    kernels._program.cache_clear()


@pytest.fixture
def engine(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Mutant], None]]:
    """Return a function that breaks the engine until the test ends."""

    def break_it(mutant: Mutant) -> None:
        assert mutant.points.keys() <= POINTS, "no such point"
        monkeypatch.setattr(templates, "MUTATIONS", dict(mutant.points))
        monkeypatch.setattr(build, "_CACHE", {})
        _clear()

    yield break_it
    monkeypatch.undo()
    _clear()


POINTS = set(
    re.findall(
        r'point\("([\w.]+)"',
        "".join(path.read_text(encoding="utf-8") for path in kernels_dir().rglob("*.mako")),
    )
)


def test_every_point_has_a_mutant_and_stands_in_its_own_file() -> None:
    assert {name for mutant in MUTANTS for name in mutant.points} == POINTS
    for path in kernels_dir().rglob("*.mako"):
        text = path.read_text(encoding="utf-8")
        stems = {name.split(".")[0] for name in re.findall(r'point\("([\w.]+)"', text)}
        assert stems <= {path.stem}


def test_production_renders_what_stands_there() -> None:
    assert templates.MUTATIONS == {}
    assert templates.point("mirror.weight", "w") == "w"


BUILDS_LONG = (
    "what a ray notes of a concentrator depends on its neighbours",
    "a ray taken in turn goes on among another's boxes",
    "a disk's rim is no part of the wall that ends there",
    "a clear face takes the place in the file that it has",
    "scatter with cosine and sine swapped (the same law from another draw)",
    "what roulette adds is not booked",
    "chord of a sphere too short",
    "what scatters stays besides",
    "what black paint scatters ends there too",
    "a density of a lobe without the horizon",
)
"""Mutants that are slow whatever else their gates catch: many programs, or long runs."""


@cache
def passes_when_healthy(gate: Callable[[], object]) -> None:
    """Run a gate on the engine as it is, once however many mutants it is for."""
    gate()


def _first_of_each_gate() -> Iterator[ParameterSet]:
    """Give the mutants; those are slow whose gate has caught another one already."""
    seen: set[object] = set()
    for mutant in MUTANTS:
        again = mutant.gate in seen or mutant.name in BUILDS_LONG
        marks = [pytest.mark.slow] if again else []
        seen.add(mutant.gate)
        yield pytest.param(mutant, id=mutant.name, marks=marks)


@pytest.mark.parametrize("mutant", list(_first_of_each_gate()))
def test_gate_catches(mutant: Mutant, engine: Callable[[Mutant], None]) -> None:
    """By the gate itself, or before it by the host; a mutant that is no program is no mutant."""
    passes_when_healthy(mutant.gate)
    engine(mutant)
    with pytest.raises((AssertionError, HostError)) as caught:
        mutant.gate()
    assert not isinstance(caught.value, KernelBuildError)


def test_the_engine_is_whole_again_after_a_mutant() -> None:
    gates.counter_layout()
    gates.first_named_is_hit()
