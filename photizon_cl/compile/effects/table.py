"""The table of effects, in the order in which they are asked."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from photizon_cl.compile.effects.acceleration import Acceleration
from photizon_cl.compile.effects.choice import Choice
from photizon_cl.compile.effects.coatings import Coatings
from photizon_cl.compile.effects.coincidence import Coincidence
from photizon_cl.compile.effects.contact import Contact
from photizon_cl.compile.effects.detector import Detector
from photizon_cl.compile.effects.face_surfaces import FaceSurfaces
from photizon_cl.compile.effects.far_field import FarField
from photizon_cl.compile.effects.importance import Importance
from photizon_cl.compile.effects.media import Media
from photizon_cl.compile.effects.opening import Opening
from photizon_cl.compile.effects.path_table import PathTable
from photizon_cl.compile.effects.polarisation import Polarisation
from photizon_cl.compile.effects.roulette import Roulette
from photizon_cl.compile.effects.scatter import Scatter
from photizon_cl.compile.effects.shares import Shares
from photizon_cl.compile.effects.spectrum import Spectrum
from photizon_cl.compile.effects.splitting import Splitting
from photizon_cl.compile.effects.tallies import Ladder, Map
from photizon_cl.compile.effects.tilt import Tilt
from photizon_cl.compile.kinds import ALL_KINDS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.compile.effects.base import Effect

__all__ = ["EFFECTS", "EFFECT_ROWS", "EffectRow"]

EFFECTS: Final[tuple[Effect, ...]] = (
    Splitting(),
    Choice(),
    Shares(),
    Roulette(),
    Tilt(),
    Acceleration(),
    Contact(),
    Coincidence(),
    FaceSurfaces(),
    Opening(),
    PathTable(),
    Spectrum(),
    Media(),
    Polarisation(),
    Coatings(),
    Importance(),
    Scatter(),
    Detector(),
    Map(),
    Ladder(),
    FarField(),
)
"""Every effect; one that asks what another has prepared stands behind it."""


@dataclass(frozen=True)
class EffectRow:
    """What is told of an effect, or of a kind as one.

    Parameters
    ----------
    name : str
        ``group.kind`` for the kinds of the registry, a word for the others.
    what, costs : str
        What it does, and what the device does more because of it, in one line each.
    group : str
        ``source``, ``element`` or ``surface`` for a kind, ``effect`` for an effect.
    """

    name: str
    what: str
    costs: str
    group: str


def _rows() -> dict[str, EffectRow]:
    rows = [EffectRow(name, cls.does, cls.costs, cls.label) for name, cls in ALL_KINDS.items()]
    rows += [EffectRow(effect.name, effect.what, effect.costs, "effect") for effect in EFFECTS]
    return {row.name: row for row in rows}


EFFECT_ROWS: Final[Mapping[str, EffectRow]] = MappingProxyType(_rows())
"""Every kind and every effect by name."""
