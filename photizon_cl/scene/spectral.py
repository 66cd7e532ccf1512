"""What of a scene depends on wavelength, and whether its spectrum suits it."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import Problem, counted, join, show
from photizon_cl.scene.curves import BoundedCurve
from photizon_cl.scene.described import Described, Known, parameters_of
from photizon_cl.scene.media.catalogue import known_glass
from photizon_cl.scene.spectrum import Spectrum

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

__all__ = ["curves_of", "spectral_problems"]


_LOOKED_AT: Final = 64
"""Places in a band at which an index is asked for."""


def spectral_problems(known: Known, groups: Sequence[str]) -> list[Problem]:
    """Return the problems between a scene's spectrum and what depends on wavelength.

    Parameters
    ----------
    known : Known
        The scene's good values.
    groups : sequence of str
        Keys of its lists of objects.
    """
    things = [
        (f"{group}[{i}]", thing, f"{group} {show(thing.get('name'))}")
        for group in groups
        for i, thing in enumerate(known.get(group) or ())
        if thing is not None
    ]
    spectrum = known.get(Spectrum.label)
    if spectrum is None:
        hint = "what depends on wavelength needs it: [spectrum] wavelengths_nm = [..]"
        return [
            Problem(where, _shown(value), "the table [spectrum] in the scene", None, hint, owner)
            for path, thing, owner in things
            for where, value in _dependent(thing, path)
        ]
    key = next((k for k in ("wavelengths_nm", "edges_nm") if spectrum.get(k) is not None), None)
    if key is None:
        return []
    wavelengths, bands = spectrum.get(key), key == "edges_nm"
    n = len(wavelengths) - bands
    problems: list[Problem] = []
    for path, thing, owner in things:
        problems += [
            replace(problem, owner=owner) for problem in _outside(thing, path, wavelengths)
        ]
        for item, parameter in parameters_of(thing.cls).items():
            value = thing.get(item)
            listed = parameter.needs_spectrum and isinstance(value, tuple)
            if listed and len(value) != n:
                what = "band" if bands else "line"
                expected = f"{counted(n, 'number')}, one for each {what} of [spectrum]"
                found = f"{len(value)} of them"
                problems.append(Problem(join(path, item), found, expected, owner=owner))
            if item == "glass" and value is not None and thing.get("dispersion") is None:
                value = known_glass(value)
            if hasattr(value, "fault"):
                where = f"{Spectrum.label}.{key}"
                about = value, join(path, item), thing.get("name"), wavelengths
                own = _faults(*about, where)
                problems += own or (_gaps(*about) if bands else [])
    return problems


def _outside(value: Any, path: str, wavelengths: Sequence[float]) -> Iterator[Problem]:
    """Give the problem of each table in an object that is refused outside, and ends too early."""
    if isinstance(value, BoundedCurve):
        low, high = value.domain
        wrong = [nm for nm in wavelengths if not low <= nm <= high]
        if wrong:
            more = f" and {len(wrong) - 1} more" if len(wrong) > 1 else ""
            expected = f"a table that reaches {wrong[0]:.9g} nm{more}, as [spectrum] does"
            hint = "what a coating does is not extrapolated"
            yield Problem(path, f"one from {low:.9g} to {high:.9g} nm", expected, hint=hint)
    elif isinstance(value, Known):
        for item in parameters_of(value.cls):
            yield from _outside(value.get(item), join(path, item), wavelengths)


def _faults(
    dispersion: Any, path: str, name: object, wavelengths: Sequence[float], key: str
) -> list[Problem]:
    """Return the problem of the wavelengths at which a medium has no index, told of the first."""
    wrong = [i for i, nm in enumerate(wavelengths) if dispersion.fault(nm)]
    if not wrong:
        return []
    domain, nm = dispersion.domain, wavelengths[wrong[0]]
    where = "a wavelength at which"
    if domain is not None:
        where = f"a wavelength from {domain[0]:.9g} to {domain[1]:.9g} nm, where"
    more = f", and none at {len(wrong) - 1} more" if len(wrong) > 1 else ""
    return [
        Problem(
            f"{key}[{wrong[0]}]",
            show(nm),
            f"{where} the medium {show(name)} has an index",
            hint=f"{path}: {dispersion.fault(nm)}{more}",
        )
    ]


def _gaps(dispersion: Any, path: str, name: object, edges: Sequence[float]) -> list[Problem]:
    """Return the problem of a band in which a medium has no index somewhere, though at its edges.

    That is looked for at resonances, and at places so many that none but such is missed.
    """
    places = [
        a + k / _LOOKED_AT * (b - a) for a, b in pairwise(edges) for k in range(1, _LOOKED_AT)
    ]
    wrong = [nm for nm in dispersion.resonances_nm if edges[0] < nm < edges[-1]]
    wrong = wrong or [nm for nm in places if dispersion.fault(nm)][:1]
    if not wrong:
        return []
    band = bisect_right(edges, wrong[0]) - 1
    shown = f"{edges[band]:.9g} to {edges[band + 1]:.9g} nm"
    expected = f"a band in which the medium {show(name)} has an index everywhere"
    hint = f"{path}: it has none at {wrong[0]:.9g} nm"
    return [Problem(f"{Spectrum.label}.edges_nm[{band}]", shown, expected, hint=hint)]


def _dependent(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Give path and value of all in an object that depends on wavelength."""
    if not isinstance(value, Known):
        return
    for item, parameter in parameters_of(value.cls).items():
        where, found = join(path, item), value.get(item)
        if item == "glass" and not (value.get("dispersion") is value.get("index") is None):
            continue  # a name alone, or a problem of its own
        if isinstance(found, Known):
            yield from _dependent(found, where)
        elif getattr(found, "over_wavelength", False) or (parameter.needs_spectrum and found):
            yield where, found


def _shown(value: Any) -> str:
    if isinstance(value, Described):
        return show(value.to_table())
    return show(list(value) if isinstance(value, tuple) else value)


def curves_of(thing: Described, path: str = "") -> Iterator[tuple[str, Any]]:
    """Give path and value of every table over wavelength in an object."""
    for item in parameters_of(type(thing)):
        value = getattr(thing, item)
        if isinstance(value, Described):
            where = join(path, item) if path else item
            if value.over_wavelength:
                yield where, value
            else:
                yield from curves_of(value, where)
