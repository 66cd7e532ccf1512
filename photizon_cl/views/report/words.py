"""Figures in words: the text that stands in for each, with its numbers, and its caption."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.result.text import lit_percent, with_error
from photizon_cl.views.figures.map_plots import length_unit
from photizon_cl.views.report.far_field import place_of, row_name, row_of, span_of
from photizon_cl.views.report.numbers import percent, plain_amount
from photizon_cl.views.report.paths import describe_ghosts, describe_paths
from photizon_cl.views.report.tables import peak

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.far_field import FarFieldResult
    from photizon_cl.result.maps import IrradianceMap
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.filters.base import Axis

__all__ = ["describe"]

_MOST_NAMED: Final = 6  # values that an alternative text reads out


def describe(result: Estimates, kind: str, element: str) -> tuple[str, str]:
    """Return a figure's alternative text, which has its numbers, and its caption.

    Parameters
    ----------
    result : Estimates
        What the figure shows.
    kind : str
        What its file's name begins with.
    element : str
        Name of the element that it is about; empty where there is none.
    """
    if kind in _WORDS:
        return _WORDS[kind](result, element)
    title = kind.replace("-", " ").replace("_", " ")
    alt = (
        f"Figure “{title}” of {result.scene.heading}, from {result.rays} rays; "
        "its numbers stand in the tables of this page."
    )
    return alt, title[:1].upper() + title[1:] + "."


def _value(value: float, sigma: float | None, unit: str) -> str:
    text, error = with_error(value, sigma)
    known = f"{text} ± {error}" if sigma else text
    return f"{known} {unit}".replace("-", "−")


def _named(texts: Iterable[str], more: str) -> str:
    """Return a list of texts with the number of those that are too many."""
    every = list(texts)
    left = len(every) - _MOST_NAMED
    return "; ".join(every[:_MOST_NAMED]) + (f"; {left} {more}" if left > 0 else "")


def _surfaces(element: Element) -> str:
    return " and ".join(dict.fromkeys(surface.kind for surface in element.surfaces))


# -- the whole result ----------------------------------------------------------------------------


def _layout(result: Estimates, _: str) -> tuple[str, str]:
    from photizon_cl.views.drawing.view import bounding_box

    scene = result.scene
    size = " by ".join(plain_amount(float(x), 3) for x in bounding_box(scene).extent)
    elements = _named((f"{e.name}, {e.kind}, {_surfaces(e)}" for e in scene.element), "more")
    sources = _named((f"{s.name}, {s.kind}" for s in scene.source), "more")
    alt = (
        f"Three sections through the centre of the scene, which fills {size} m in x, y and z as "
        f"drawn. Elements: {elements or 'none'}. Sources: {sources}."
    )
    return alt, (
        "The scene to scale, in sections through its centre: solid lines where the plane cuts an "
        "element, thin ones its edges seen through."
    )


def _ledger(result: Estimates, _: str) -> tuple[str, str]:
    ledger = result.ledger
    rows = sorted(ledger.rows(), key=lambda item: -abs(item[1].value))
    lit = [(name, row) for name, row in rows if row.value != 0.0]
    named = _named((f"{n} {_value(r.value, r.sigma, 'W')}" for n, r in lit), "smaller rows")
    dark = len(rows) - len(lit)
    zero = f"; {dark} row{' is' if dark == 1 else 's are'} zero" if dark else ""
    emitted = plain_amount(ledger.emitted.value, 6)
    alt = f"Dot plot of the energy ledger. Of {emitted} W emitted: {named}{zero}."
    return alt, "The rows of the ledger with ± σ, against the emitted power."


def _by_wavelength(result: Estimates, _: str) -> tuple[str, str]:
    from photizon_cl.views.figures.spectrum_plot import curves

    spectrum = result.scene.spectrum
    assert spectrum is not None
    emitted = [part.value for part in result.ledger.emitted.by_wavelength]
    texts = []
    for name, row in curves(result):
        parts = [
            part.value / launched
            for part, launched in zip(row.by_wavelength, emitted, strict=True)
            if launched
        ]
        texts.append(f"{name}, from {percent(min(parts))} to {percent(max(parts))}")
    alt = (
        f"Parts of the emitted power over wavelength, {spectrum.about}: "
        f"{_named(texts, 'smaller rows') or 'no row has power'}."
    )
    word = spectrum.word
    return alt, f"Where each {word}'s power went, as parts of what that {word} emitted, with ± σ."


def _convergence(result: Estimates, _: str) -> tuple[str, str]:
    from photizon_cl.views.figures.convergence_plot import history

    waves = history(result)
    caption = f"The {result.sigma_is} as the run went on, against rays and against time."
    good = waves[np.isfinite(waves["sigma"]) & (waves["sigma"] > 0.0)]
    start = f"Two graphs of the {result.sigma_is} at {len(waves)} points, against rays and seconds"
    if not len(good):
        return start + "; none has a σ to draw.", caption
    ends = (
        f"{percent(float(wave['sigma']))} after {int(wave['rays'])} rays and "
        f"{plain_amount(float(wave['seconds']), 3)} s"
        for wave in (good[0], good[-1])
    )
    target = result.info.goal.target
    aim = "" if target is None else f"; the target was {percent(target)}"
    return f"{start}: from {' to '.join(ends)}{aim}.", caption


# -- maps ----------------------------------------------------------------------------------------


def _map_of(result: Estimates, element: str) -> IrradianceMap:
    m = result.detectors[element].map
    assert m is not None
    return m


def _irradiance(result: Estimates, element: str) -> tuple[str, str]:
    m = _map_of(result, element)
    caption = (
        f"Irradiance on {element}, bin by bin and not smoothed; bins with fewer than 10 arrivals "
        "are hatched, bins without area blank."
    )
    ny, nx = m.count.shape
    start = f"Irradiance map on {element}, {nx} by {ny} bins; "
    if not m.lit.any():
        return start + "no bin has 10 or more arrivals, so that all of it is hatched.", caption
    high, error, (j, i) = peak(m.irradiance, m.sigma, m.decisive)
    low, _, _ = peak(m.irradiance, m.sigma, m.decisive, -1.0)
    lengths = length_unit(m)
    where = f"{_middle(m.bins.x.axis, i, *lengths)}, {_middle(m.bins.y.axis, j, *lengths)}"
    cut = m.lit & ~m.decisive
    them = "Those that no rim cuts to less than three quarters" if cut.any() else "Those"
    mean = result.detectors[element].power.value / float(m.area.sum())
    alt = (
        f"{start}{lit_percent(m.lit_fraction)} of them have 10 or more arrivals. {them} range from "
        f"{plain_amount(low)} to {_value(high, error, 'W/m²')}, highest at {where}; the mean over "
        f"the area is {plain_amount(mean)} W/m²."
    )
    return alt, caption


def _middle(axis: Axis, k: int, factor: float, unit: str) -> str:
    """Say where the middle of a bin is."""
    value = float(0.5 * (axis.edges[k] + axis.edges[k + 1]))
    if axis.units == "rad":
        return f"{axis.said} {plain_amount(float(np.degrees(value)))}°"
    if axis.units == "1":
        return f"{axis.said} {plain_amount(value)}"
    return f"{axis.said} {plain_amount(factor * value)} {unit}"


def _sigma(result: Estimates, element: str) -> tuple[str, str]:
    m = _map_of(result, element)
    caption = (
        f"Standard error over irradiance of each bin on {element}; hatched where fewer than 10 "
        "arrivals make σ itself unreliable, grey where there is no value."
    )
    start = f"Map of the relative standard error of the irradiance on {element}: "
    known = m.lit & (m.irradiance > 0.0) & np.isfinite(m.sigma)
    if not known.any():
        return start + "no bin has 10 or more arrivals and a σ.", caption
    part = m.sigma[known] / m.irradiance[known]
    low, middle, high = (percent(float(p)) for p in np.quantile(part, [0.0, 0.5, 1.0]))
    alt = (
        f"{start}of the bins with 10 or more arrivals the median has {middle}, the best {low}, the "
        f"worst {high}."
    )
    return alt, caption


# -- ladder --------------------------------------------------------------------------------------


def _ladder(result: Estimates, element: str) -> tuple[str, str]:
    rungs = [rung for rung in result.detectors[element].ladder or () if rung.count]
    named = _named(
        (f"after {r.generation}, {_value(r.value, r.sigma, 'W')}" for r in rungs), "more"
    )
    alt = (
        f"Power on {element} by the number of surface interactions before the arrival: "
        f"{named or 'nothing arrived, 0 W'}."
    )
    return alt, (
        f"Power on {element} by the number of surface interactions before the arrival, with ± σ."
    )


# -- far field -----------------------------------------------------------------------------------


def _far(result: Estimates) -> FarFieldResult:
    assert result.far_field is not None
    return result.far_field


def _far_field(result: Estimates, _: str) -> tuple[str, str]:
    far, escaped = _far(result), result.ledger.escaped
    caption = (
        "Intensity of what escaped over φ and cos θ; every bin has the same solid angle, and bins "
        "with fewer than 10 rays are hatched."
    )
    if far.by_theta:
        caption = (
            "Intensity of what escaped over φ and θ; bins with fewer than 10 rays are hatched."
        )
    n_rows, n_phi = far.count.shape
    lit = ~far.hatched
    start = (
        f"Far-field map of intensity, {n_phi} bins in φ by {n_rows} in {row_name(far)}; "
        f"{lit_percent(float(np.mean(lit)))} of them have 10 or more rays"
    )
    if not lit.any():
        return start + ".", caption
    value, sigma, (j, i) = peak(far.intensity, far.sigma, lit)
    alt = (
        f"{start}. The highest intensity is {_value(value, sigma, 'W/sr')}, "
        f"at {place_of(far, j, i)}; "
        f"in all {_value(escaped.value, escaped.sigma, 'W')} escaped."
    )
    return alt, caption


def _cuts(result: Estimates, _: str) -> tuple[str, str]:
    far = _far(result)
    caption = (
        f"Polar cuts through the far field with bands of ± σ, angles from {far.axis_words[2]}; "
        "thin arcs are bins with fewer than 10 rays."
    )
    n = far.count.shape[1]
    said = []
    for phi in (0, 90, 180, 270):
        i = phi * n // 360
        j = int(np.argmax(far.intensity[:, i]))
        sigma = float(far.sigma[j, i])
        high = _value(float(far.intensity[j, i]), None if np.isnan(sigma) else sigma, "W/sr")
        said.append(f"φ = {phi}°, {high} at {row_of(far, j)}")
    return (
        f"Polar cuts through the far field; the highest intensity around {'; '.join(said)}.",
        caption,
    )


def _over_theta(result: Estimates, _: str) -> tuple[str, str]:
    far = _far(result)
    caption = (
        f"Intensity of what escaped over the angle θ from {far.axis_words[2]}, on a logarithmic "
        "axis, with ± σ; open dots are bins with fewer than 10 rays."
    )
    rows, columns = far.count.shape
    lit = ~far.hatched
    start = f"Intensity over θ in {rows} bins from {span_of(far)}"
    start += f", in {columns} parts of the turn" if columns > 1 else ""
    if not lit.any():
        return f"{start}; no bin has 10 or more rays.", caption
    ends = (peak(far.intensity, far.sigma, lit, sign) for sign in (1.0, -1.0))
    high, low = (
        f"{_value(value, sigma, 'W/sr')} at {place_of(far, *at)}" for value, sigma, at in ends
    )
    return (
        f"{start}; of those with 10 or more rays the highest has {high}, the lowest {low}.",
        caption,
    )


_WORDS: Final[dict[str, Callable[[Estimates, str], tuple[str, str]]]] = {
    "layout": _layout,
    "ledger": _ledger,
    "by-wavelength": _by_wavelength,
    "convergence": _convergence,
    "map": _irradiance,
    "sigma": _sigma,
    "ladder": _ladder,
    "paths": describe_paths,
    "ghosts": describe_ghosts,
    "far-field-theta": _over_theta,
    "far-field": _far_field,
    "far-field-cuts": _cuts,
}
"""What is said of each kind of figure."""
