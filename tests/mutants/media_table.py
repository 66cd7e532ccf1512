"""Defects of absorption on the way, media and wavelengths."""

from __future__ import annotations

from mutants.mutant import Mutant
from oracles import media, spectra, spectra_scatter

MUTANTS = (
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
