"""What all figures share: page, title, footer, colours, units, and files that can be made again.

A figure is as wide as a page's text, 7 in, so that it is printed at its own size, where no letter
is smaller than 8 pt. Colours are safe for colour-blind readers (M. Okabe and K. Ito, Color
Universal Design, 2008; viridis) and never the only sign of a difference.
"""

from __future__ import annotations

import functools
import math
import warnings
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, ParamSpec

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from photizon_cl.atomic import reason, replacing, sweep
from photizon_cl.errors import ArgumentError, show
from photizon_cl.result.statistics import LIT_COUNT, known_part
from photizon_cl.result.text import lit_percent
from photizon_cl.views.figures.words import fitted, percent, wrapped
from photizon_cl.views.shown import ShownFigure

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from photizon_cl.result.estimates import Estimates

__all__ = [
    "BLUE",
    "FORMATS",
    "GRID",
    "INK",
    "LABEL",
    "ORANGE",
    "QUIET",
    "SMALL",
    "WIDTH",
    "Page",
    "blank",
    "check_figure",
    "is_figure",
    "judged_by",
    "metadata",
    "replace_figure",
    "sheet",
    "styled",
    "whole",
    "write",
]

FORMATS: Final = ("png", "svg", "pdf")
"""Formats of files; the latter two hold vectors, with maps of bins as pictures in them."""

WIDTH: Final = 7.0
"""Inches across every figure."""
SMALL: Final = 8.0
LABEL: Final = 9.0
INK: Final = "#222222"
QUIET: Final = "#5f5f5f"
GRID: Final = "#dddddd"
BLUE: Final = "#0072b2"
ORANGE: Final = "#d55e00"
_WARNING: Final = "#a03c00"

_WHOSE: Final = "photizon_cl"
"""What marks a figure's file as ours: one without it is not replaced."""

_DPI: Final = {"png": 160, "svg": 300, "pdf": 300}
_MARGIN: Final = 0.14
_TITLE: Final = 11.0
_STEP: Final = 0.25
"""Heights are whole multiples of this many inches: 40 pixels of a PNG file."""
_OURS: Final = ("axes", "axes3d", "errorbar", "figure", "font", "grid", "hatch", "image",
                    "legend", "lines", "mathtext", "patch", "path", "pcolor", "pcolormesh", "pdf",
                    "polaraxes", "savefig", "svg", "text", "xtick", "xaxis", "ytick",
                    "yaxis")  # fmt: skip
_RC: Final = {
    **{k: v for k, v in matplotlib.rcParamsDefault.items() if k.split(".")[0] in _OURS},
    "svg.hashsalt": "photizon_cl",  # names inside a file come from its contents alone
    "pdf.fonttype": 42,  # publishers refuse the default, Type 3
}

P = ParamSpec("P")


@contextmanager
def _own_settings() -> Iterator[None]:
    # A reader's matplotlibrc must not change what a result's figures look like.
    with matplotlib.rc_context(_RC):
        yield


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Have a function draw with the project's own settings of matplotlib."""

    @functools.wraps(draw)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> Figure:
        if kwargs.get("ax") is not None:  # a reader's own axes keep the reader's own settings
            return draw(*args, **kwargs)
        with _own_settings():
            return draw(*args, **kwargs)

    return wrapped


def whole(axes: Axes) -> Figure:
    """Return the figure that axes are in."""
    figure: Any = axes.figure
    while not isinstance(figure, Figure):  # a part of a figure
        figure = figure.figure
    return figure


def write(draw: Callable[[], Figure], path: Path, kind: str) -> None:
    """Draw a figure into a file.

    Nothing of the moment goes in: the same result gives the same file, byte for byte, under one
    version of matplotlib.

    Parameters
    ----------
    draw : callable
        Makes the figure.
    path : Path
        The file.
    kind : str
        One of `FORMATS`.
    """
    with _own_settings(), warnings.catch_warnings():
        # A name in a script that the font lacks is drawn as boxes; that is no reason to speak up.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        draw().savefig(path, format=kind, dpi=_DPI[kind], metadata=metadata(kind))


def metadata(kind: str) -> dict[str, str | None]:
    """Return what to write into a figure's file: whose it is, and nothing of the moment."""
    if kind == "png":
        return {"Software": _WHOSE}
    return {"Creator": _WHOSE, {"svg": "Date", "pdf": "CreationDate"}[kind]: None}


def is_figure(path: Path) -> bool:
    """Say whether a file is a figure that was written with `metadata`."""
    marks = {
        ".png": (b"tEXtSoftware\0" + _WHOSE.encode(),),
        ".svg": (f"<dc:title>{_WHOSE}</dc:title>".encode(),),
        ".pdf": (f"/Creator ({_WHOSE})".encode(),),
    }
    data = path.read_bytes()
    return any(mark in data for mark in marks.get(path.suffix.lower(), ()))


def check_figure(path: Path) -> None:
    """See that a figure may be drawn into a file: a new one, or one of our figures.

    Raises
    ------
    ArgumentError
        Where it is another one, or not in one of `FORMATS`.
    """
    shown = show(str(path))
    if path.suffix.lower()[1:] not in FORMATS:
        endings = ", ".join(f".{form}" for form in FORMATS)
        raise ArgumentError(f"found {shown}, expected a file that ends in {endings}")
    try:
        link = path.is_symlink()
        ours = not link and (not path.exists() or (path.is_file() and is_figure(path)))
    except (OSError, ValueError) as error:
        raise ArgumentError(f"{shown} cannot be used ({reason(error)})") from None
    if not ours:
        what = "a symbolic link" if link else "no photizon figure"
        raise ArgumentError(
            f"{shown} is there and {what}, and is not replaced: give another file, or move it away"
        )


def replace_figure(path: Path, draw: Callable[[Path], object]) -> None:
    """Draw a figure into a file that is new or one of our figures, in one step.

    Parameters
    ----------
    path : Path
        The file.
    draw : callable
        Writes it, given a path.

    Raises
    ------
    ArgumentError
        Where the file is there and no figure that was written here.
    OSError
        Where it cannot be written.
    """
    check_figure(path)
    sweep(path.parent, held=False)
    with replacing(path) as temporary:
        draw(temporary)


class Page:
    """A figure with a title and a footer, and between them a body to draw in.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    height : float
        Of the figure, inches.
    bottom, body : float
        Where the body begins, and its height, in inches.
    """

    def __init__(self, figure: Figure, height: float, bottom: float, body: float) -> None:
        self.figure, self.height, self.bottom, self.body = figure, height, bottom, body

    def place(
        self, left: float, bottom: float, width: float, height: float
    ) -> tuple[float, float, float, float]:
        """Return a rectangle in parts of the figure from one in inches of the body."""
        across, up = WIDTH, self.height
        return left / across, (self.bottom + bottom) / up, width / across, height / up

    def arrange(self, above: float = 0.0) -> None:
        """Let matplotlib arrange what the body holds, but for so many inches at its top."""
        rect = self.place(0.06, 0.0, WIDTH - 0.12, self.body - above)
        self.figure.set_layout_engine("constrained", rect=rect)


def sheet(
    result: Estimates,
    what: str,
    body: float,
    notes: list[str] | None = None,
    counts: NDArray[np.int64] | None = None,
    own: tuple[str, float | None] | None = None,
) -> Page:
    """Begin a figure.

    Parameters
    ----------
    result : Result
        The scene's title, and N and σ for the footer.
    what : str
        What the figure shows, below the title.
    body : float
        Inches that the body needs at least; the whole is rounded up to a multiple of 0.25 in.
    notes : list of str, optional
        More lines for the footer.
    counts : ndarray, optional
        Rays in each of the bins shown. The footer says how many carry 10, and warns where most of
        those that rays reach do not; what stays dark is no fault.
    own : (str, float or None), optional
        Of what the figure shows and how well that is known: its σ leads the footer, before that of
        the run, which may be about something else.
    """
    room = WIDTH - 2.0 * _MARGIN
    lines = [
        (line, QUIET, "normal")
        for text in _state(result, own)
        for line in wrapped(text, SMALL, room, "normal", 2)
    ]
    if counts is not None:
        text, poor = _lit(counts)
        style = (_WARNING, "bold") if poor else (QUIET, "normal")
        lines += [(line, *style) for line in wrapped(text, SMALL, room, style[1], 2)]
    for note in notes or []:
        lines += [(line, QUIET, "normal") for line in wrapped(note, SMALL, room, "normal", 3)]
    return blank(result.scene.heading, what, body, lines)


def blank(heading: str, what: str, body: float, lines: Sequence[tuple[str, str, str]]) -> Page:
    """Begin a figure of anything.

    Parameters
    ----------
    heading, what : str
        Its title, and what it shows, below.
    body : float
        Inches that the body needs at least.
    lines : sequence of (str, str, str)
        Of the footer, each with its colour and weight.
    """
    room = WIDTH - 2.0 * _MARGIN
    title = wrapped(heading, _TITLE, room, "bold", 2)
    below = fitted(what, LABEL, room)
    head = _MARGIN + 0.19 * len(title) + 0.2 + 0.1
    foot = _MARGIN + 0.155 * len(lines) + 0.05
    height = _STEP * math.ceil(round((head + body + foot) / _STEP, 6))

    figure = ShownFigure(figsize=(WIDTH, height), facecolor="white")
    FigureCanvasAgg(figure)
    left = _MARGIN / WIDTH
    y = height - _MARGIN
    for line in title:
        figure.text(
            left, y / height, line, fontsize=_TITLE, weight="bold", color=INK, va="top",
            parse_math=False,
        )  # fmt: skip
        y -= 0.19
    figure.text(
        left, (y - 0.02) / height, below, fontsize=LABEL, color=QUIET, va="top", parse_math=False
    )
    y = _MARGIN + 0.155 * (len(lines) - 1)
    for line, colour, weight in lines:
        figure.text(
            left, y / height, line, fontsize=SMALL, color=colour, weight=weight, va="baseline",
            parse_math=False,
        )  # fmt: skip
        y -= 0.155
    return Page(figure, height, foot, height - head - foot)


def _state(result: Estimates, own: tuple[str, float | None] | None) -> list[str]:
    """Return N and σ: that of what is shown where it has one, and what the run achieved."""
    batches = "1 batch" if result.batches == 1 else f"{result.batches:,} batches"
    start = f"N = {result.rays:,} rays · {batches}"
    achieved, target = result.achieved_sigma, result.info.goal.target
    aim = "" if target is None else f" (target {percent(target)})"
    if achieved is None:
        unknown = result.batches < 2
        run = "σ unknown from a single batch" if unknown else "nothing has a relative σ"
    else:
        run = f"{result.sigma_is} {percent(achieved)} {judged_by(result)}{aim}"
    if own is None or result.batches < 2:
        return [f"{start} · {run}"]
    what, sigma = own
    if sigma is None:
        return [f"{start} · {what} unknown", f"the run: {run}"]
    if achieved is not None and math.isclose(sigma, achieved, rel_tol=1e-9):
        # what the run is judged by is what is shown
        return [f"{start} · {what} {percent(sigma)}{aim}"]
    return [f"{start} · {what} {percent(sigma)}", f"the run: {run}"]


def judged_by(result: Estimates) -> str:
    """Return what the achieved σ is the median over, or the largest of, in a few words."""
    on = result.scene.run.target_on
    if on:
        return f"of {on[0]}" if len(on) == 1 else f"of {len(on)} quantities"
    maps = sum(d.map is not None for d in result.detectors.values())
    if maps:
        return "over all maps" if maps > 1 else "over the map"
    return "over the detectors" if result.detectors else "over the ledger"


def _lit(counts: NDArray[np.int64]) -> tuple[str, bool]:
    if not counts.any():
        return "Warning: no ray reached any of these bins", True
    known = known_part(counts)
    if known >= 0.5:
        part = float((counts >= LIT_COUNT).mean())
        return f"{lit_percent(part)} of bins carry at least 10 rays", False
    return (
        f"Warning: only {lit_percent(known)} of the bins that rays reach carry at least 10; "
        "the median σ says nothing of the others"
    ), True
