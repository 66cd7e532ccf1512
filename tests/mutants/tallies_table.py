"""Defects of what is counted and booked."""

from __future__ import annotations

from mutants.mutant import Mutant
from mutants.short_gates import cap, ghosts, passing, reference, splits_and_absorbs
from oracles import gates, trails

MUTANTS = (
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
        'floating-point sums in the map',
        {'cells.begin': '*(__global double *)cell += w; return; const double s = '},
        gates.order_does_not_matter,
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
)  # fmt: skip
