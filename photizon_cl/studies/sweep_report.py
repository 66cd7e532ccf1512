"""The report of a sweep that was kept."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from photizon_cl.run.ours import REPORT
from photizon_cl.studies.sweeps import open_sweep

if TYPE_CHECKING:
    from photizon_cl.views.report.writing import Written

__all__ = ["write_sweep_report"]


def write_sweep_report(
    folder: str | os.PathLike[str], out: str | os.PathLike[str] | None = None
) -> Written:
    """Write the report of a sweep.

    Parameters
    ----------
    folder : str or path
        Its directory.
    out : str or path, optional
        The file; default ``report.html`` in that directory.

    Raises
    ------
    ResultError
        Where there is no sweep, or it is damaged.
    ArgumentError
        Where the file cannot be written, or is something else than a report.
    """
    home = Path(os.fsdecode(folder))
    found = open_sweep(home)

    from photizon_cl.views.report.sweep import render_sweep  # matplotlib, not for a wrong path
    from photizon_cl.views.report.writing import Written, check_page, write_text

    page = home / REPORT if out is None else Path(os.fsdecode(out))
    check_page(page)
    write_text(page, render_sweep(found))
    return Written(page, (), ())
