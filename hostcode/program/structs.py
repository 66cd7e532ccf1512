"""The structures that host and kernels share, declared once.

Every member has eight bytes, so numpy's layout and every device's agree without padding.
"""

from __future__ import annotations

from typing import Final

import numpy as np

__all__ = ["ITEM", "LAUNCH", "LAUNCH_TYPES", "STATUS", "c_struct", "numpy_dtype"]

LAUNCH: Final[tuple[tuple[str, str, str], ...]] = (
    ("seed", "ulong", "key of every draw"),
    ("ray_base", "ulong", "number of the first ray of slot 0"),
    ("rays_per_batch", "ulong", "rays of one batch"),
    ("n_sources", "ulong", "rows of the source table"),
    ("n_elements", "ulong", "rows of the geometry table, and of the ledger before its named ones"),
    ("n_cells", "ulong", "cells of one batch's tally"),
    ("slots", "ulong", "batches in flight that the tally has room for"),
    ("generation_cap", "ulong", "interactions a path may make"),
    ("items", "ulong", "work-items that own a queue segment"),
    ("max_bounces", "ulong", "steps of a persistent packet in one launch"),
    ("refill", "ulong", "empty lanes that make a packet refill"),
    ("fill", "ulong", "rays that the generate stage keeps waiting in a segment"),
    ("stack_capacity", "ulong", "rays that a queue segment holds"),
    ("record_capacity", "ulong", "records that a segment holds"),
    (
        "material_of",
        "ulong",
        "where in codes the elements' places in the material table stand (MATERIAL_OF)",
    ),
    ("material_of_kind", "ulong", "where in codes each surface kind's first such place stands"),
)
"""What one launch is told: name, C type, meaning; effects add members of their own."""

ITEM: Final[tuple[tuple[str, str, str], ...]] = (
    ("next", "ulong", "next ray of the batch to launch"),
    ("end", "ulong", "behind the last ray of its range"),
    ("slot", "ulong", "which of the batches in flight"),
    ("stack", "ulong", "rays waiting in its segment"),
    ("base", "ulong", "first of them that this step works on"),
    ("records", "ulong", "records in its segment"),
)
"""State of one work-item between launches."""

STATUS: Final = ("unfinished", "blocked", "interactions", "passed")
"""Counters that the last stage of a launch adds to: work-items with work left, work-items whose
segment is too small to go on, surface interactions made, surfaces passed without one."""

_NUMPY: Final = {"ulong": np.uint64, "double": np.float64}

LAUNCH_TYPES: Final = tuple(_NUMPY)
"""C types that members of these structures may have."""


def numpy_dtype(fields: tuple[tuple[str, str, str], ...]) -> np.dtype[np.void]:
    """Return the numpy layout of a structure."""
    return np.dtype([(name, _NUMPY[ctype]) for name, ctype, _ in fields])


def c_struct(name: str, fields: tuple[tuple[str, str, str], ...]) -> str:
    """Return the structure's C declaration, one member a line with its meaning."""
    members = "".join(f"    {ctype} {member};  // {meaning}\n" for member, ctype, meaning in fields)
    return f"typedef struct {{\n{members}}} {name};"
