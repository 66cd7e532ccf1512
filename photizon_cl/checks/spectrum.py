"""What a spectrum does not reach: tables that end before it does, path tables over all of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from photizon_cl.errors import show
from photizon_cl.scene.curves import Curve
from photizon_cl.scene.media.catalogue import glasses, known_glass
from photizon_cl.scene.spectral import curves_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.media.medium import Medium
    from photizon_cl.scene.model import Scene

__all__ = ["other_glasses", "paths_of_all", "tables_that_end", "tiny_waves"]

_OPTICAL_NM: Final = 10.0
"""Wavelength below which no lens, mirror or coating acts as the scene's do: X-rays."""


def other_glasses(scene: Scene) -> Iterator[str]:
    """Give a sentence for each medium that has a glass's name, and the numbers of another one."""
    for medium in scene.medium:
        if medium.glass is not None and glasses():
            known = known_glass(medium.glass)
            if known != medium.dispersion:
                yield (
                    f'medium "{medium.name}": its dispersion is not that of {show(medium.glass)} '
                    "in the catalogue that is installed here: the dispersion counts, and the name "
                    "is only that; leave out the dispersion to have the glass looked up"
                )


def paths_of_all(scene: Scene) -> Iterator[str]:
    """Give a sentence for each detector that is told by wavelength, and has a path table."""
    for element in scene.element:
        detector = element.detector
        if detector is not None and detector.wavelengths and detector.paths is not None:
            yield (
                f'element "{element.name}": the path table of its detector is over all wavelengths '
                "together, and tells none of them apart; for one alone, let the spectrum of every "
                "source have no power elsewhere"
            )


def tables_that_end(scene: Scene) -> Iterator[str]:
    """Give a sentence for each table over wavelength outside of which light is traced."""
    spectrum = scene.spectrum
    if spectrum is None:
        return
    things: tuple[Medium | Element, ...] = (*scene.medium, *scene.element)
    for thing in things:
        for path, table in curves_of(thing):
            ends = getattr(table, "wavelength_nm", None)
            if ends is None or getattr(table, "domain", None) is not None:
                continue  # what is refused outside is none of these
            asked = spectrum.edges_nm or spectrum.middles_nm
            before = [nm for nm in asked if nm < ends[0]]
            behind = [nm for nm in asked if nm > ends[-1]]
            if before or behind:
                values = table.values
                at = f"{(before or behind)[0]:.9g} nm"
                end, value = (ends[0], values[0]) if before else (ends[-1], values[-1])
                n = len(before) + len(behind)
                more = f" and {n - 1} more" if n > 1 else ""
                unit = "" if isinstance(table, Curve) else " per m"
                yield (
                    f'{thing.label} "{thing.name}": {path} is given from {ends[0]:.9g} to '
                    f"{ends[-1]:.9g} nm; at {at}{more} it is taken as at its end: "
                    f"{value:.6g}{unit} as at {end:.9g} nm"
                )


def tiny_waves(scene: Scene) -> Iterator[str]:
    """Give a sentence where all light is X-rays by its wavelengths."""
    longest = scene.spectrum.ends_nm[1] if scene.spectrum is not None else _OPTICAL_NM
    if longest < _OPTICAL_NM:
        yield (
            f"the longest wavelength of [spectrum] is {longest:.9g} nm, which is an X-ray: "
            f"wavelengths are given in nanometres, so that {longest:.9g} µm is "
            f"{1e3 * longest:.9g}"
        )
