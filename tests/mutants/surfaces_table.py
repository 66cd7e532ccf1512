"""Defects of what surfaces and coatings send on."""

from __future__ import annotations

from mutants.mutant import Mutant
from mutants.short_gates import ghosts, reference
from oracles import coatings, gates

MUTANTS = (
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
)  # fmt: skip
