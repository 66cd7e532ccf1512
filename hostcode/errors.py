"""What can go wrong between the host and a device.

`photizon_cl` wraps or passes on these; `hostcode` never imports the other package.
"""

from __future__ import annotations

__all__ = [
    "Abandoned",
    "CacheWarning",
    "DeviceError",
    "HostError",
    "KernelBuildError",
    "QueueFull",
]


class HostError(Exception):
    """Base of every error that `hostcode` raises on purpose."""


class QueueFull(HostError):  # noqa: N818 - what it is, as `Abandoned`
    """More rays wait to be followed than there may be room for."""


class DeviceError(HostError):
    """No usable device, a device refused for a stated reason, or a selector that matches nothing.

    Parameters
    ----------
    message : str
        Complete: what was asked, why it cannot be, and what to do about it.
    reason : str, optional
        The bare reason, a clause that completes "refused: …"; default the message.
    """

    def __init__(self, message: str, reason: str = "") -> None:
        super().__init__(message)
        self.reason = reason or message

    def __reduce__(self) -> tuple[type[DeviceError], tuple[str, str]]:
        # Errors travel back from worker processes; without this the reason would stay there.
        return type(self), (str(self), self.reason)


class KernelBuildError(HostError):
    """A kernel could not be rendered or compiled.

    Parameters
    ----------
    template : str
        The kernel template's path relative to the kernels directory, with forward slashes, or
        ``hook <place> of <effect>`` for a statement that an effect brings.
    line : int or None
        Line in the template or statement, counted from 1; None where the compiler named none.
    message : str
        What the template engine or the device's compiler said, in one line where possible.
    excerpt : str
        A few source lines around the place, or the compiler's whole log; may be empty.
    """

    def __init__(self, template: str, line: int | None, message: str, excerpt: str = "") -> None:
        self.template = template
        self.line = line
        self.message = message
        self.excerpt = excerpt
        where = template if line is None else f"{template}:{line}"
        text = f"kernel {where}: {message}"
        super().__init__(f"{text}\n{excerpt}" if excerpt else text)

    def __reduce__(self) -> tuple[type[KernelBuildError], tuple[str, int | None, str, str]]:
        # Exception's own reduce would call the class with the one joined message; a build error
        # that happens in a worker process must arrive whole.
        return type(self), (self.template, self.line, self.message, self.excerpt)


class Abandoned(Exception):  # noqa: N818 - no error: the caller asked for it
    """A wave was given up at the caller's wish before all its rays had ended; it does not count."""


class CacheWarning(UserWarning):
    """Compiled kernels cannot be kept where they should be."""
