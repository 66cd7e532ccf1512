"""Polarisation that makes no difference."""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.scene.polarisation import Polarisation

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.model import Scene

__all__ = ["idle_polarisation"]


def idle_polarisation(scene: Scene) -> Iterator[str]:
    """Give a sentence where rays carry a polarisation that no surface acts by."""
    if scene.run.polarisation and not scene.polarises:
        yield (
            f"run.{Polarisation.label} is true, but how much the scene's surfaces send on does not "
            "depend on it: all numbers are those of a run without, which takes less time"
        )
