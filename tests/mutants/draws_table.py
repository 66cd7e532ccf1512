"""Defects of what is drawn: counters, directions, sources, roulette, the choice of a child."""

from __future__ import annotations

from mutants.mutant import Mutant
from mutants.short_gates import (
    cosine_source,
    disk_source,
    furnace,
    isotropic,
    reference,
    roulette,
    scatter,
    tilted_scatter,
)
from oracles import branching, chance, gates, random_gates

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
        long=True,
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
        long=True,
    ),
    Mutant(
        'decision left out of the counter',
        {'philox.decision': '0u'},
        random_gates.counter_layout,
    ),
    Mutant(
        'generation left out of the counter',
        {'philox.generation': '0u'},
        random_gates.counter_layout,
    ),
    Mutant(
        'every bounce of a ray draws the same numbers (correlated streams)',
        {'philox.generation': '0u'},
        reference,
    ),
    Mutant(
        'ray number cut to 32 bits',
        {'philox.ray': '0u'},
        random_gates.counter_layout,
    ),
    Mutant(
        'siblings share a counter',
        {'children.sibling': '(p << 1)'},
        random_gates.paths_are_unique,
    ),
    Mutant(
        'siblings share a counter beyond 54 splits',
        {'children.mixed_sibling': ''},
        lambda: random_gates.paths_are_unique(2**54, 6),
    ),
    Mutant(
        'nine rounds of Philox',
        {'philox.rounds': 9},
        random_gates.counter_layout,
    ),
    Mutant(
        'uniforms in (0, 1]',
        {'philox.low_word': 'TO_REAL((lo >> 11) + 1u)'},
        random_gates.unit_interval,
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
)  # fmt: skip
