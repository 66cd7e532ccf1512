"""Defects of lobes, and scatter that is aimed."""

from __future__ import annotations

from mutants.mutant import Mutant
from mutants.short_gates import lobes
from oracles import aiming, scattering

MUTANTS = (
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
        long=True,
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
        "what scatters stays besides", {"scatter.stays": "whole"}, scattering.closes,
        long=True,
    ),
    Mutant(
        "what black paint scatters ends there too",
        {"scatter.booked": "none"},
        scattering.closes,
        long=True,
    ),
    Mutant(
        "one of two by even chances",
        {"scatter.chance": "LT(u, splat(0.5))"},
        scattering.one_of_two_goes_on,
    ),
    Mutant(
        'roulette ends what was aimed',
        {'roulette.aimed': 'floor_weight'},
        aiming.roulette_spares_what_is_aimed,
    ),
)  # fmt: skip
