"""The report of a saved result."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import Lock, sweep
from photizon_cl.errors import ResultError, show
from photizon_cl.run.directory import ARRAYS, REPORT, open_directory
from photizon_cl.run.memory import check_room
from photizon_cl.run.ours import FIGURES

if TYPE_CHECKING:
    from photizon_cl.views.report.writing import Written

__all__ = ["write_report"]

_AGAIN: Final = "run the scene again, into another directory, to have a whole one"


def write_report(
    folder: str | os.PathLike[str], out: str | os.PathLike[str] | None = None
) -> Written:
    """Write the report of a saved result, and those of its PNG figures that are missing.

    Parameters
    ----------
    folder : str or path
        The directory that a run wrote, or the ``result.nc`` in it.
    out : str or path, optional
        The file; default ``report.html`` in the directory of the result.

    Raises
    ------
    ResultError
        Where there is no result, it is damaged, or there is no memory for its arrays and figures.
    ArgumentError
        Where the file cannot be written, or is something else than a report.
    """
    given = Path(os.fsdecode(folder))
    try:
        result = open_directory(given)
    except ResultError as error:
        if given.is_file() or (given / ARRAYS).is_file():  # there, and not whole
            raise ResultError(f"{error}; {_AGAIN}") from error
        raise
    check_room(result, show(str(given)), drawn=True)

    from photizon_cl.views.report.writing import write_page  # matplotlib, not for a wrong path

    home = given if given.is_dir() else given.parent
    _clear(home)
    return write_page(result, home, home / REPORT if out is None else Path(os.fsdecode(out)))


def _clear(home: Path) -> None:
    """Remove what killed writers left beside a result, unless a run is writing there."""
    with suppress(OSError):  # a directory that is held, or that only can be read
        lock = Lock(home)
        try:
            sweep(home, held=True)
            sweep(home / FIGURES, held=True)
        finally:
            lock.free()
