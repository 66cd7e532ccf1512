"""The base of the kinds that have code of their own on the device."""

from __future__ import annotations

from typing import ClassVar

from photizon_cl.scene.described import Described

__all__ = ["DeviceKind"]


class DeviceKind(Described):
    """An element, surface, source, scatter or coating: what all of them declare of their code."""

    kernel: ClassVar[str] = ""
    """Name of its kernel file and of the functions in it."""
    does: ClassVar[str] = ""
    """What it does, in one line."""
    costs: ClassVar[str] = ""
    """What the device does more because of it, in one line."""
    libraries: ClassVar[tuple[str, ...]] = ()
    """Kernel templates that its file needs before it (``lib/powers``), once a program."""
