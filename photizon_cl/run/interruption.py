"""Signals that end a run with what is there."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["ends_a_run", "interruptible"]


class _Run:
    """Whether the run that goes on was asked to end."""

    def __init__(self) -> None:
        self.asked = False


_runs: list[_Run] = []
"""The runs of the main thread, the innermost last."""


def ends_a_run(number: int, frame: object) -> None:
    """Handle a signal: the run that goes on ends with what is there; without one, as by Ctrl-C.

    A terminal that closes may send its signal twice, so that a second one changes nothing.
    """
    if not _runs:
        raise KeyboardInterrupt
    for run in _runs:
        run.asked = True


def _by_ctrl_c(number: int, frame: object) -> None:
    if _runs[-1].asked:
        raise KeyboardInterrupt
    ends_a_run(number, frame)


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Give a function that says whether the run was asked to end.

    A second Ctrl-C ends it at once.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    run = _Run()
    before = signal.getsignal(signal.SIGINT)
    # one that is not Python's to replace, or that was asked to be ignored, stays
    ours = before is not None and before is not signal.SIG_IGN
    _runs.append(run)
    if ours:
        signal.signal(signal.SIGINT, _by_ctrl_c)
    try:
        yield lambda: run.asked
    finally:
        _runs.remove(run)
        if ours:
            signal.signal(signal.SIGINT, before)
