"""In which precision a scene may be run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hostcode.program.precision import FP64, PRECISIONS, Precision
from photizon_cl.checks.coarse import lost
from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

__all__ = ["DEFAULT", "Precision", "fitting_mode", "mode_of"]

DEFAULT: Final = FP64.name


def mode_of(precision: str) -> Precision:
    """Return the mode of a name.

    Raises
    ------
    ArgumentError
        Where there is none of that name.
    """
    mode = PRECISIONS.get(precision) if isinstance(precision, str) else None
    if mode is None:
        known = "; ".join(f"{show(known.name)}: {known.what}" for known in PRECISIONS.values())
        raise ArgumentError(
            f"precision: found {show(precision)}, expected one of "
            f"{', '.join(map(show, PRECISIONS))} ({known})"
        )
    return mode


def fitting_mode(precision: str, scene: Scene) -> Precision:
    """Return the mode of a name, in which a scene can be run.

    Raises
    ------
    ArgumentError
        Where there is none of that name, or it cannot carry what the scene holds.
    """
    mode = mode_of(precision)
    why = lost(scene, mode.roundoff)
    if why:
        raise ArgumentError(
            f"precision: found {show(precision)}, expected {show(DEFAULT)} for the scene "
            f"{show(scene.name)}: {why}"
        )
    return mode
