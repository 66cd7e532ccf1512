"""In which precision a run may be, and what that means for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hostcode.program.precision import PRECISIONS
from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    from hostcode.program.precision import Precision

__all__ = ["mode_of"]


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
