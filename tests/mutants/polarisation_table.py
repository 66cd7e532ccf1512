"""Defects of polarised light."""

from __future__ import annotations

from mutants.mutant import Mutant
from oracles import brewster, polarised

MUTANTS = (
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
)  # fmt: skip
