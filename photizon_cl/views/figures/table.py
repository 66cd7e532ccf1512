"""The table of figures: which a result has, what their files are called, and how they are drawn."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import in_any_locale
from photizon_cl.errors import ArgumentError, show
from photizon_cl.views.figures.convergence_plot import draw_convergence, history
from photizon_cl.views.figures.far_field_plots import draw_far_field, draw_far_field_cuts
from photizon_cl.views.figures.far_field_theta import draw_far_field_theta
from photizon_cl.views.figures.ladder_plot import draw_ladder
from photizon_cl.views.figures.layout_plot import MOST_ELEMENTS, draw_layout
from photizon_cl.views.figures.ledger_plot import draw_ledger
from photizon_cl.views.figures.map_plots import draw_irradiance, draw_relative_sigma
from photizon_cl.views.figures.path_plots import MOST_FACES, draw_ghosts, draw_paths
from photizon_cl.views.figures.spectrum_plot import draw_by_wavelength
from photizon_cl.views.figures.style import FORMATS, replace_figure, write

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from matplotlib.figure import Figure

    from photizon_cl.result.estimates import Estimates

__all__ = ["FIGURES", "Kind", "draw_all", "figure_names", "possible_names", "write_all"]


@dataclass(frozen=True)
class Kind:
    """A kind of figure.

    Parameters
    ----------
    stem : str
        What the names of its files begin with.
    draw : callable
        Draws it: given the result, and what `subjects` returns.
    subjects : callable
        Given a result, returns the arguments for each figure of this kind; none where there is
        nothing to draw.
    """

    stem: str
    draw: Callable[..., Figure]
    subjects: Callable[[Estimates], list[tuple[str, ...]]]


def _once(_: Estimates) -> list[tuple[str, ...]]:
    return [()]


def _small(result: Estimates) -> list[tuple[str, ...]]:
    return [()] if len(result.scene.element) <= MOST_ELEMENTS else []


def _with_spectrum(result: Estimates) -> list[tuple[str, ...]]:
    return [] if result.scene.spectrum is None else [()]


def _with_history(result: Estimates) -> list[tuple[str, ...]]:
    return [()] if len(history(result)) else []


def _with_map(result: Estimates) -> list[tuple[str, ...]]:
    return [(name,) for name, d in result.detectors.items() if d.map is not None]


def _with_ladder(result: Estimates) -> list[tuple[str, ...]]:
    return [(name,) for name, d in result.detectors.items() if d.ladder is not None]


def _with_paths(result: Estimates) -> list[tuple[str, ...]]:
    return [(name,) for name, d in result.detectors.items() if d.paths is not None]


def _with_ghosts(result: Estimates) -> list[tuple[str, ...]]:
    return [
        (name,)
        for name, d in result.detectors.items()
        if d.paths is not None
        and len(d.paths.ghosts().faces) <= MOST_FACES
        and d.paths.ghosts().pairs()
    ]


def _with_turns(result: Estimates) -> list[tuple[str, ...]]:
    """Give a far field that is more than one row of bins in θ."""
    far = result.scene.far_field
    return [] if far is None or (far.by_theta and far.n_phi == 1) else [()]


def _with_theta(result: Estimates) -> list[tuple[str, ...]]:
    far = result.scene.far_field
    return [()] if far is not None and far.by_theta else []


FIGURES: Final = (
    Kind("layout", draw_layout, _small),
    Kind("ledger", draw_ledger, _once),
    Kind("by-wavelength", draw_by_wavelength, _with_spectrum),
    Kind("convergence", draw_convergence, _with_history),
    Kind("map", draw_irradiance, _with_map),
    Kind("sigma", draw_relative_sigma, _with_map),
    Kind("ladder", draw_ladder, _with_ladder),
    Kind("paths", draw_paths, _with_paths),
    Kind("ghosts", draw_ghosts, _with_ghosts),
    Kind("far-field-theta", draw_far_field_theta, _with_theta),
    Kind("far-field", draw_far_field, _with_turns),
    Kind("far-field-cuts", draw_far_field_cuts, _with_turns),
)
"""Every kind of figure, in the order in which a report shows them."""


def draw_all(
    result: Estimates, formats: str | Sequence[str] = ("png",)
) -> Iterator[tuple[str, Callable[[Path], None]]]:
    """Give each figure's file name and a function that draws it into a file.

    Parameters
    ----------
    result : Result
        The result.
    formats : str or sequence of str, optional
        Of ``"png"``, ``"svg"`` and ``"pdf"``; each figure comes once in each.

    Raises
    ------
    ArgumentError
        Where a format is another one.
    """
    if isinstance(formats, str):
        formats = (formats,)
    unknown = [kind for kind in formats if kind not in FORMATS]
    if unknown:
        raise ArgumentError(
            f"formats: found {show(unknown[0])}, expected some of {', '.join(FORMATS)}"
        )
    used: set[str] = set()
    for kind in FIGURES:
        for subject in kind.subjects(result):
            stem = _stem(kind, *subject)
            name, n = stem, 2
            while name in used:
                name, n = f"{stem}-{n}", n + 1
            used.add(name)
            for suffix in dict.fromkeys(formats):
                draw = partial(kind.draw, result, *subject)
                yield f"{name}.{suffix}", partial(write, draw, kind=suffix)


def _stem(kind: Kind, *subject: str) -> str:
    return re.sub(r"[^\w+.-]+", "_", "-".join([kind.stem, *subject])).lower()[:100]


def possible_names(elements: Iterable[str]) -> list[str]:
    """Return the file names that figures may have of a run that has no batch yet.

    Parameters
    ----------
    elements : iterable of str
        Names of the scene's elements.
    """
    subjects = [(), *((name,) for name in elements)]
    return [f"{_stem(kind, *s)}.{form}" for kind in FIGURES for s in subjects for form in FORMATS]


def write_all(
    result: Estimates, folder: str | os.PathLike[str], formats: str | Sequence[str] = ("png",)
) -> list[Path]:
    """Draw every figure of a result into files, and return these.

    The same result gives the same files, byte for byte, under one version of matplotlib.

    Parameters
    ----------
    result : Result
        The result.
    folder : str or path
        An existing directory; figures of the same names in it are replaced.
    formats : str or sequence of str, optional
        Of ``"png"``, ``"svg"`` and ``"pdf"``.

    Raises
    ------
    ArgumentError
        Where a format is another one, or a file of such a name is no figure that was written here.
    """
    written = []
    for name, draw in draw_all(result, formats):
        written.append(Path(folder) / in_any_locale(name))
        replace_figure(written[-1], draw)
    return written


def figure_names(result: Estimates, formats: str | Sequence[str] = ("png",)) -> list[str]:
    """Return the file names of a result's figures, see `draw_all`."""
    return [name for name, _ in draw_all(result, formats)]
