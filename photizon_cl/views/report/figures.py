"""The figures of a report: drawn afresh from the result, embedded as far as there is room."""

from __future__ import annotations

import base64
import struct
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import in_any_locale
from photizon_cl.result.cost_file import COST_FIGURE
from photizon_cl.views.report.cost import describe_cost
from photizon_cl.views.report.words import describe

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from photizon_cl.result.cost import CostStudy
    from photizon_cl.result.estimates import Estimates

__all__ = ["MOST_BYTES", "Drawing", "Figures", "draw", "drawings", "with_cost"]

MOST_BYTES: Final = 3_200_000
"""Bytes of PNG files that a page embeds: below 4.3 MB of text, and the page below 5 MB."""

_LEAST_ROOM: Final = 15_000  # below this a page is full, since no figure is that small
_FIRST: Final = ("layout", "ledger", "map", "far-field", "ladder", "convergence")


def drawings(result: Estimates) -> Iterator[tuple[str, str, str, Callable[[Path], None]]]:
    """Give kind, element and file name of each figure, and a function that draws it into a file.

    The one place that knows where figures are drawn. The element is empty where a figure is about
    the whole result.
    """
    from photizon_cl.views.figures import FIGURES, draw_all

    about = [(kind.stem, *subject) for kind in FIGURES for subject in kind.subjects(result)]
    for (kind, *element), (name, write) in zip(about, draw_all(result), strict=True):
        yield kind, "".join(element), name, write


@dataclass(frozen=True)
class Drawing:
    """A figure on the page.

    Parameters
    ----------
    name : str
        File name.
    kind : str
        ``ledger``, ``map``, ``ladder``, ``far-field``, or the like.
    element : str
        Name of the element that it is about; empty where there is none.
    png : bytes
        The file.
    alt : str
        What the figure shows, with numbers, for those who do not see it.
    caption : str
        What stands below it.
    """

    name: str
    kind: str
    element: str
    png: bytes
    alt: str
    caption: str

    @property
    def source(self) -> str:
        """The figure as a ``data:`` address."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode("ascii")

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels, as the file's header has them."""
        width, height = struct.unpack(">II", self.png[16:24])
        return width, height


@dataclass(frozen=True)
class Figures:
    """Every figure of a result that fits the page, and the names of the others.

    Parameters
    ----------
    drawn : tuple of Drawing
        In the order of the result.
    left_out : tuple of str
        File names that the page has no room for.
    failed : tuple of (str, str)
        File name and reason of figures that could not be drawn.
    files : mapping of str to bytes
        Every file that was drawn, on the page or not.
    """

    drawn: tuple[Drawing, ...]
    left_out: tuple[str, ...]
    failed: tuple[tuple[str, str], ...]
    files: dict[str, bytes]

    def of(self, *kinds: str, element: str = "") -> list[Drawing]:
        """Return the figures of some kinds about an element."""
        return [d for d in self.drawn if d.kind in kinds and d.element == element]


def with_cost(figures: Figures, study: CostStudy) -> Figures:
    """Return the figures with that of a cost study, where anything in it scatters."""
    from photizon_cl.views.figures.cost_plot import draw_cost
    from photizon_cl.views.figures.style import write

    if not any(row.points for row in study):
        return figures
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / COST_FIGURE
        write(lambda: draw_cost(study), path, "png")
        made = Drawing(COST_FIGURE, "cost", "", path.read_bytes(), *describe_cost(study))
    return replace(figures, drawn=(*figures.drawn, made))


def draw(result: Estimates, there: Collection[str] = (), most_bytes: int = MOST_BYTES) -> Figures:
    """Draw the figures of a result.

    Where there is not room for all, the answer comes before its errors and cuts.

    Parameters
    ----------
    result : Estimates
        The result.
    there : collection of str, optional
        File names of figures that need not be drawn once the page is full.
    most_bytes : int, optional
        Bytes that the page may embed.
    """
    every = list(drawings(result))
    order = {name: n for n, (_, _, name, _) in enumerate(every)}
    every.sort(key=lambda item: _FIRST.index(item[0]) if item[0] in _FIRST else len(_FIRST))
    drawn: list[Drawing] = []
    left_out: list[str] = []
    failed: list[tuple[str, str]] = []
    files: dict[str, bytes] = {}
    room = most_bytes
    with tempfile.TemporaryDirectory() as folder:
        for kind, element, name, write in every:
            if room < _LEAST_ROOM and in_any_locale(name) in there:
                left_out.append(name)
                continue
            path = Path(folder) / "figure.png"
            try:
                write(path)
                png = path.read_bytes()
            except (ValueError, MemoryError, OverflowError) as error:
                # a figure too large to be drawn is no reason to go without the page
                failed.append((name, " ".join(str(error).split()) or "it is too large"))
                continue
            path.unlink()
            files[name] = png
            if len(png) > room:
                left_out.append(name)
                continue
            room -= len(png)
            drawn.append(Drawing(name, kind, element, png, *describe(result, kind, element)))
    drawn.sort(key=lambda d: order[d.name])
    return Figures(tuple(drawn), tuple(left_out), tuple(failed), files)
