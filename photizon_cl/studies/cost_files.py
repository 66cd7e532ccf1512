"""A cost study on disk: numbers and figure."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from photizon_cl.atomic import reason, replacing
from photizon_cl.errors import ArgumentError, ResultError, show
from photizon_cl.result.cost_file import COST_FIGURE, COST_NUMBERS, is_study, study_text

if TYPE_CHECKING:
    from photizon_cl.result.cost import CostStudy

__all__ = ["check_folder", "save"]


def check_folder(path: str | os.PathLike[str]) -> Path:
    """Return the directory that a study may be written into; makes nothing.

    Raises
    ------
    ResultError
        Where it is a file, or holds files of these names that are none of ours.
    """
    from photizon_cl.views.figures.style import check_figure

    folder = Path(os.fsdecode(path))
    shown = show(str(folder))
    try:
        if folder.exists() and not folder.is_dir():
            raise ResultError(f"{shown} is a file: give a directory to write the study into")
        numbers = folder / COST_NUMBERS
        ours = not numbers.exists() or is_study(numbers)
    except (OSError, ValueError) as error:
        raise ResultError(f"{shown} cannot be used: {reason(error)}") from None
    if not ours:
        raise ResultError(
            f"{shown} holds {show(COST_NUMBERS)}, which is no cost study and is not replaced: give "
            "another directory, or move it away"
        )
    try:
        check_figure(folder / COST_FIGURE)
    except ArgumentError as error:
        raise ResultError(str(error)) from None
    return folder


def save(study: CostStudy, path: str | os.PathLike[str]) -> list[Path]:
    """Write a study's numbers and, where anything scatters, its figure; return what was written.

    Raises
    ------
    ResultError
        Where the directory cannot be used or written, see `check_folder`.
    """
    from photizon_cl.views.figures.cost_plot import draw_cost
    from photizon_cl.views.figures.style import replace_figure, write

    folder = check_folder(path)
    numbers, figure = folder / COST_NUMBERS, folder / COST_FIGURE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(numbers) as temporary:
            temporary.write_text(study_text(study), encoding="utf-8")
        if not any(row.points for row in study):
            return [numbers]
        replace_figure(figure, lambda file: write(lambda: draw_cost(study), file, "png"))
    except ArgumentError as error:
        raise ResultError(str(error)) from None
    except OSError as error:
        raise ResultError(f"{show(str(folder))} cannot be written: {reason(error)}") from None
    return [numbers, figure]
