"""A directory that a result is about to be written into: looked at, made, and held."""

from __future__ import annotations

import os
import tempfile
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import TEMPORARY, Lock, reason, sweep
from photizon_cl.errors import ResultError, show
from photizon_cl.result.cost_file import COST_FIGURE, COST_NUMBERS
from photizon_cl.run.ours import ARRAYS, CHECKPOINT, DERIVED, FIGURES, REPORT, is_report

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["check_target", "claim", "held", "refuse"]

_OURS: Final = frozenset({ARRAYS, CHECKPOINT, FIGURES, COST_NUMBERS, COST_FIGURE, *DERIVED})

_TRIES: Final = 10
_PAUSE: Final = 0.02


def check_target(path: str | os.PathLike[str]) -> Path:
    """Return the directory that a result may be written into; makes and reads nothing.

    Raises
    ------
    ResultError
        Where it is a file, or a directory that holds something and no result.
    """
    folder = Path(os.fsdecode(path))
    shown = show(str(folder))
    try:
        if folder.is_symlink() and not folder.exists():
            raise ResultError(f"{shown} is a link that leads nowhere: give another directory")
        if not folder.exists():
            return folder
        if not folder.is_dir():
            raise ResultError(f"{shown} is a file: give a directory to write the result into")
        there = {e.name for e in folder.iterdir() if not e.name.startswith(TEMPORARY)}
    except (OSError, ValueError) as error:
        if isinstance(error, ResultError):
            raise
        raise ResultError(f"{shown} cannot be used: {reason(error)}") from None
    others = there - _OURS if ARRAYS not in there else set()
    if REPORT in others and is_report(folder / REPORT):
        others.remove(REPORT)
    if others:
        raise ResultError(
            f"{shown} holds files and no photizon result ({_named(sorted(others))}): give a new or "
            "empty directory, so that nothing is overwritten"
        )
    return folder


def refuse(folder: Path, names: list[str]) -> None:
    """Refuse to replace files that are not ours.

    Raises
    ------
    ResultError
        Where there are any.
    """
    if names:
        raise ResultError(
            f"{show(str(folder))} holds {_named(names)}, which photizon did not write or which was "
            "changed since, and a result there would replace: give another directory, or move "
            f"{'it' if len(names) == 1 else 'them'} away"
        )


def _named(names: list[str]) -> str:
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(map(show, names[:3])) + more


def claim(folder: Path) -> Lock:
    """Make a directory, hold it for this process, and clear what killed writers left there.

    Raises
    ------
    ResultError
        Where nothing can be written there, or another process holds it.
    """
    shown = show(str(folder))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = _lock(folder)
    except BlockingIOError:
        raise ResultError(
            f"{shown} is being written to by another run: wait for it, or give another directory"
        ) from None
    except OSError as error:
        raise ResultError(
            f"{shown} cannot be written: {reason(error)}; give another directory"
        ) from None
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        lock.free()
        raise ResultError(
            f"{shown} cannot be written: {reason(error)}; give another directory"
        ) from None
    sweep(folder, held=True)
    sweep(folder / FIGURES, held=True)
    return lock


def _lock(folder: Path) -> Lock:
    for _ in range(_TRIES):
        with suppress(BlockingIOError):
            return Lock(folder)
        time.sleep(_PAUSE)  # who only clears up there is done at once
    return Lock(folder)


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold a directory while something is written there, see `claim`."""
    lock = claim(folder)
    try:
        yield
    finally:
        lock.free()
