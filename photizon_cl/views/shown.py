"""Figures that show themselves in a notebook."""

from __future__ import annotations

import io
from typing import Final

from matplotlib.figure import Figure

__all__ = ["ShownFigure"]

_DPI: Final = 100


class ShownFigure(Figure):
    """A figure that a notebook shows where it is the last line of a cell.

    Matplotlib's own are shown only once pyplot, which nothing here uses, has set that up.
    """

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png", dpi=_DPI)
        return out.getvalue()
