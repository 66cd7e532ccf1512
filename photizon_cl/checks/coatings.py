"""Films so thick that a precision cannot carry their phases, and so thin that they do nothing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from photizon_cl.scene.elements.base import ROUNDOFF

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.model import Scene

__all__ = ["coarse_phases", "idle_films"]

_ROUNDINGS: Final = 4.0
"""Roundings of a phase: of wavelength, thickness, the root in a layer and their product."""
_NOTED: Final = 1e-6
_NOTED_SINGLE: Final = 1e-4
"""Error of a phase in radians that is worth a word, as of coordinates (`coarse`)."""


def coarse_phases(scene: Scene, roundoff: float) -> Iterator[str]:
    """Give a sentence for each element with a coating of many wavelengths.

    Parameters
    ----------
    scene : Scene
        What is looked at.
    roundoff : float
        Unit roundoff of what the kernels compute in.
    """
    if scene.spectrum is None:
        return
    noted = _NOTED if roundoff == ROUNDOFF else _NOTED_SINGLE
    shortest = scene.spectrum.ends_nm[0]
    for element in scene.element:
        coats = [coat for surface in element.surfaces if (coat := surface.coat) is not None]
        waves = max((coat.waves(shortest) for coat in coats), default=0.0)
        error = 2.0 * math.pi * waves * _ROUNDINGS * roundoff
        if error > noted:
            yield (
                f'element "{element.name}": the coating is {waves:.3g} wavelengths thick at '
                f"{shortest:.9g} nm, and its phases are rounded by {error:.1e} rad: what it "
                "reflects is as far off; "
                + ("take double precision" if noted == _NOTED_SINGLE else "make a body of it")
            )


def idle_films(scene: Scene) -> Iterator[str]:
    """Give a sentence for each element with a film that is given, and too thin to act."""
    if scene.spectrum is None:
        return
    shortest = scene.spectrum.ends_nm[0]
    for element in scene.element:
        coats = [coat for surface in element.surfaces if (coat := surface.coat) is not None]
        film = next(filter(None, (coat.idle(shortest) for coat in coats)), None)
        if film is not None:
            path, thickness = film
            yield (
                f'element "{element.name}": {path} of the coating is {thickness:.9g} nm thick, '
                f"which is next to nothing beside {shortest:.9g} nm: it does nothing; a thickness "
                "is given in nanometres"
            )
