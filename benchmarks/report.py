"""Lines that are printed as they come and kept for a file; plain tables; medians with spread."""

from __future__ import annotations

import json
import statistics
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path


class Report:
    """Prints lines and keeps them.

    Parameters
    ----------
    quiet : bool
        Keep only.
    """

    def __init__(self, *, quiet: bool = False) -> None:
        self.quiet = quiet
        self.kept: list[str] = []

    def say(self, *lines: str) -> None:
        """Print lines and keep them."""
        for line in lines:
            self.kept.append(line)
            if not self.quiet:
                print(line, flush=True)

    def heading(self, text: str) -> None:
        """Print a heading."""
        self.say("", text, "-" * len(text))

    def write(self, folder: Path, stem: str, data: dict[str, Any]) -> list[Path]:
        """Write the lines to ``stem.txt`` and the data to ``stem.json``; return both paths."""
        folder.mkdir(parents=True, exist_ok=True)
        text, tables = folder / f"{stem}.txt", folder / f"{stem}.json"
        text.write_text("\n".join(self.kept).strip() + "\n", encoding="utf-8")
        dumped = json.dumps(data, indent=1, allow_nan=False)
        tables.write_text(dumped + "\n", encoding="utf-8")
        return [text, tables]


@dataclass(frozen=True)
class Spread:
    """Median, quartiles and extremes of a few numbers."""

    median: float
    low: float
    high: float
    least: float
    most: float
    n: int

    @classmethod
    def of(cls, values: Iterable[float]) -> Spread:
        """Return the spread of at least one number."""
        sample = sorted(values)
        middle = statistics.median(sample)
        if len(sample) > 1:
            low, _, high = statistics.quantiles(sample, n=4, method="inclusive")
        else:
            low = high = middle
        return cls(middle, low, high, sample[0], sample[-1], len(sample))

    def text(self, digits: int = 1, scale: float = 1.0) -> str:
        """Return ``median [lower quartile–upper quartile]``, times `scale`."""
        middle, low, high = (scale * x for x in (self.median, self.low, self.high))
        return f"{middle:.{digits}f} [{low:.{digits}f}–{high:.{digits}f}]"

    def data(self) -> dict[str, float]:
        """Return the numbers by name, to four places."""
        names = ("median", "low", "high", "least", "most")
        return {name: float(f"{getattr(self, name):.6g}") for name in names}


def table(header: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> list[str]:
    """Return a table as lines, its first `left` columns aligned to the left."""
    cells = [tuple(header), *(tuple(row) for row in rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(header))]
    out = []
    for row in cells:
        parts = [
            text.ljust(width) if k < left else text.rjust(width)
            for k, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        out.append("  ".join(parts).rstrip())
    out.insert(1, "  ".join("-" * width for width in widths))
    return out
