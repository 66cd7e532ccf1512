"""Defects of which face is hit, and where: edges, corners, contact, the search."""

from __future__ import annotations

from mutants.mutant import Mutant
from mutants.short_gates import sphere
from oracles import contacts, gates, lens_guards, packets

MUTANTS = (
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
        long=True,
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
        long=True,
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
        long=True,
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
        'chord of a sphere too short',
        {'sphere.chord': '1.5 * fabs(b)'},
        sphere,
        long=True,
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
        long=True,
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
        "where edge and front meet is behind the one or the other",
        {"lens.corner": "NO_LANES"},
        lens_guards.rims_belong_to_both,
    ),
    Mutant(
        "glass of which rounding says that no way leads out",
        {"lens.lost": "NO_LANES"},
        lens_guards.glass_has_an_exit,
    ),
    Mutant(
        "coordinates are as good as where a ray starts, however far it goes",
        {"lens.grown": "+= R(0.0) *"},
        lens_guards.heights_are_rounded,
    ),
    Mutant(
        "a point from afar is put back onto its face once",
        {"lens.projections": 1},
        lens_guards.points_are_on_their_face,
    ),
    Mutant(
        "what starts on a face of a lens meets it again at once",
        {"lens.begun": "NO_LANES"},
        lens_guards.rims_hold,
    ),
    Mutant(
        "rounding beyond its rims decides whether a face has the ray within it",
        {"lens.beyond": "NO_LANES"},
        lens_guards.rims_hold,
    ),
    Mutant(
        "what goes in by a rim and out again at once passes the lens",
        {"lens.touched": "hits"},
        lens_guards.rims_hold,
    ),
    Mutant(
        "a grazing root is polished by rounding",
        {"quadric.vague": "ALL_LANES"},
        lens_guards.grazing_roots_stay,
    ),
    Mutant(
        "a root that rounding has put beyond the rims is met where it was put",
        {"lens.beside": "*t"},
        lens_guards.a_screen_hides_the_lens_behind_it,
    ),
    Mutant(
        "a chord is polished once",
        {"quadric.polished": "t"},
        lens_guards.grazing_chords_end_on_their_face,
    ),
)  # fmt: skip
