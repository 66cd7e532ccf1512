"""Whether what stands in a file of a result can be a result at all.

A file may be damaged, or made up. Its checksum tells the one, not the other, and files of the first
version have none. So nothing in it is taken on trust: how large it says that its arrays are, before
they are read; that they are totals of batches that close; and every number beside them.
"""

from __future__ import annotations

import json
import math
import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program.precision import PRECISIONS
from hostcode.run.tally import UNIT_EXPONENT
from photizon_cl.compile.compiled import MAX_RAY_NUMBER
from photizon_cl.result.batch_values import MOST_VALUES
from photizon_cl.result.estimates import RunInfo
from photizon_cl.result.forecast import Forecast
from photizon_cl.result.ledger import closure_limit
from photizon_cl.result.pilot import Pilot
from photizon_cl.result.stopping import Goal
from photizon_cl.result.sums import totals_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.result.statistics import Accumulator, AccumulatorState
    from photizon_cl.scene.settings import RunSettings

__all__ = ["check_shapes", "check_tally", "integer", "read_info", "read_precision"]

_PACKED: Final = 1100
"""Bytes that a byte of a file may stand for: zlib packs 1032 into one at most."""
_SMALL: Final = 1 << 20
"""Bytes that a file may declare whatever its size."""
_WAVES: Final = 4096
"""Rows of the history; a run keeps an eighth of that."""
_DIGITS: Final = 40
_TEXT: Final = 400
_BLOCK: Final = 1 << 18
"""Cells that are looked at together, so that the look takes little memory."""
_LOW: Final = 1 << 32
_AGREES: Final = 1e-6
"""Part of a mean, or of its scatter, by which Welford's mean may miss the exact total's."""
_STOPPED: Final = ("", "target", "batches", "time", "interrupt", "memory")


def check_shapes(variables: Mapping[str, Any], layout: TallyLayout, file_bytes: int) -> None:
    """See, before any is read, that a file's arrays are those of its scene and can be in it.

    Parameters
    ----------
    variables : mapping
        By name; each has a shape and a dtype.
    layout : TallyLayout
        Of the file's scene.
    file_bytes : int
        Size of the file.

    Raises
    ------
    ValueError
        Where they are not.
    """
    n = layout.n_cells
    sparse = "cells" in variables
    if sparse:  # of very many cells a file has those that are not zero
        cells = variables["cells"]
        if len(cells.shape) != 1 or cells.shape[0] > n or np.dtype(cells.dtype) != np.dtype("i8"):
            raise ValueError(f"its cells are none of {n}")
        n = int(cells.shape[0])
    for name, kind, ends in (
        ("limbs", "i8", (4,)), ("count", "i8", ()), ("mean", "f8", ()), ("m2", "f8", ()),
    ):  # fmt: skip
        if name not in variables:
            raise ValueError(f"it holds no {name}")
        found = variables[name]
        # the roulette balance has an error of its own, in whole and in parts
        more = 1 + layout.parts if kind == "f8" else 0
        # the first version had no cell of its own for interactions
        lengths = (n + more,) if sparse else (n + more, n + more - 1)
        fits = tuple(found.shape) in [(length, *ends) for length in lengths]
        if not fits or np.dtype(found.dtype) != np.dtype(kind):
            raise ValueError(
                f"its {name} are {found.dtype} of the shape {tuple(found.shape)}, and its scene "
                f"has {layout.n_cells} cells"
            )
    _check_batch_values(variables, layout)
    total = 0
    for name, variable in variables.items():
        if str(name).startswith("history_") and (
            len(variable.shape) != 1 or variable.shape[0] > _WAVES
        ):
            raise ValueError(f"its {name} has the shape {tuple(variable.shape)}")
        total += math.prod(map(int, variable.shape)) * np.dtype(variable.dtype).itemsize
    if total > _SMALL + _PACKED * file_bytes:
        raise ValueError(
            f"it declares {total} bytes, more than a file of {file_bytes} bytes can hold"
        )


def _check_batch_values(variables: Mapping[str, Any], layout: TallyLayout) -> None:
    if "batch_values" not in variables:  # earlier versions, or too many to keep
        return
    found = variables["batch_values"]
    scalars = sum(n for _, n in layout.scalars)
    shape = tuple(map(int, found.shape))
    fits = len(shape) == 2 and shape[1] == scalars and math.prod(shape) <= MOST_VALUES
    if not fits or np.dtype(found.dtype) != np.dtype("f8"):
        raise ValueError(
            f"its batch values are {found.dtype} of the shape {shape}, and its scene has {scalars} "
            "scalars"
        )


def integer(value: Any, name: str, most: int = MAX_RAY_NUMBER) -> int:
    """Return a number that a file gives as one or as text.

    Raises
    ------
    ValueError
        Where it is none, or not from 0 to `most`.
    """
    text = str(value) if isinstance(value, str | int | np.integer) else ""
    if not re.fullmatch(rf"[0-9]{{1,{_DIGITS}}}", text) or int(text) > most:
        raise ValueError(f"its {name} is no number from 0 to {most}")
    return int(text)


def _agree(tally: Accumulator) -> None:
    """See that the values of single batches have the means and the scatter of the sums."""
    table = tally.batch_values.table()
    if table is None:
        return
    if len(table) != tally.batches:
        raise ValueError(f"it has {len(table)} batch values of {tally.batches} batches")
    if not np.isfinite(table).all():
        raise ValueError("it has batch values that are no numbers")
    if not table.size:
        return
    column = 0
    for first, n in tally.batch_values.ranges:
        part = table[:, column : column + n]
        column += n
        mean, scatter = tally.mean(first, n), part.std(axis=0)
        room = _AGREES * (np.abs(mean) + scatter)
        if not (np.abs(part.mean(axis=0) - mean) <= room).all():
            raise ValueError("its batch values have other means than its totals")
        if len(table) > 1:
            error = scatter / math.sqrt(len(table) - 1)
            if not (np.abs(error - tally.standard_error(first, n)) <= room).all():
                raise ValueError("its batch values have another scatter than its totals")


def _text(attrs: Mapping[str, Any], name: str, default: str | None = None) -> str:
    value = attrs[name] if default is None else attrs.get(name, default)
    if not isinstance(value, str) or len(value) > _TEXT or not value.isprintable():
        raise ValueError(f"its {name} is no line of text")
    return value


def _seconds(attrs: Mapping[str, Any], name: str) -> float:
    value = float.fromhex(_text(attrs, name))
    if not (math.isfinite(value) and value >= 0.0):
        raise ValueError(f"its {name} are no time")
    return value


def _goal(attrs: Mapping[str, Any]) -> Goal:
    batches, target, limit = json.loads(_text(attrs, "goal"))
    for value, kinds in ((batches, (int,)), (target, (int, float)), (limit, (int, float))):
        if value is not None and not (type(value) in kinds and 0 < value < float(2**63)):
            raise ValueError("its goal is none")
    return Goal(batches, target, limit)


def _history(
    arrays: Mapping[str, NDArray[Any]],
) -> tuple[tuple[int, float, float | None], ...]:
    columns = [  # results of the first version have none
        arrays[name].tolist() if name in arrays else []
        for name in ("history_batches", "history_seconds", "history_sigma")
    ]
    rows = []
    for b, t, s in zip(*columns, strict=True):
        known = not math.isnan(s)
        if type(b) is not int or b < 1 or not 0.0 <= t < math.inf or (known and not s >= 0.0):
            raise ValueError("its history is none")
        rows.append((b, float(t), float(s) if known else None))
    return tuple(rows)


def read_precision(attrs: Mapping[str, Any]) -> str:
    """Return the mode of a result, from the attributes of its group.

    Raises
    ------
    ValueError, KeyError
        Where it is missing or unknown.
    """
    precision = _text(attrs, "precision")
    if precision not in PRECISIONS:
        raise ValueError("it was run in a way that this version does not know")
    return precision


def read_info(
    attrs: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], settings: RunSettings
) -> RunInfo:
    """Return how a result came about, from the attributes and arrays of its group.

    Parameters
    ----------
    attrs, arrays : mapping
        By name.
    settings : RunSettings
        Of the file's scene.

    Raises
    ------
    ValueError, KeyError
        Where something is missing or cannot be.
    """
    precision, stopped = read_precision(attrs), _text(attrs, "stopped", "")
    if stopped not in _STOPPED:
        raise ValueError("it was run in a way that this version does not know")
    pilot = Pilot.read(attrs["pilot"], settings.generation_cap) if "pilot" in attrs else None
    return RunInfo(
        device=_text(attrs, "device"),
        precision=precision,
        portable=_text(attrs, "portable", "yes") == "yes",
        stopped=stopped,
        version=_text(attrs, "version", ""),
        engine=_text(attrs, "engine", ""),
        interactions=integer(attrs["interactions"], "interactions", 2**96),
        seconds=_seconds(attrs, "seconds"),
        build_seconds=_seconds(attrs, "build_seconds"),
        worst_closure=integer(attrs["worst_closure"], "worst_closure", 2**126),
        goal=_goal(attrs),
        history=_history(arrays),
        pilot=pilot,
        forecast=Forecast.read(attrs["forecast"]) if "forecast" in attrs else None,
    )


def check_tally(
    compiled: CompiledScene, state: AccumulatorState, tally: Accumulator, info: RunInfo
) -> None:
    """See that totals can be those of so many batches of a scene.

    Parameters
    ----------
    compiled : CompiledScene
        The scene.
    state : AccumulatorState
        As the file has it, perhaps without a cell that the first version had not.
    tally : Accumulator
        Made of it.
    info : RunInfo
        From the file.

    Raises
    ------
    ValueError
        Where they cannot.
    """
    layout, batches = compiled.layout, tally.batches
    if batches * compiled.settings.rays_per_batch > MAX_RAY_NUMBER:
        raise ValueError(f"it has {batches} batches, more than there are")
    limit = closure_limit(compiled)
    if info.worst_closure > limit * compiled.emitted:
        raise ValueError("a batch of it does not close")
    n = len(state.count)
    _agree(tally)
    if not batches:
        if state.limbs.any() or state.count.any() or state.mean.any() or state.m2.any():
            raise ValueError("it has totals and no batches")
        return
    # a row may miss zero by the rounding of splits, as the ledger may miss what was emitted
    least = -float(limit * compiled.emitted) * 2.0**UNIT_EXPONENT
    lowest = np.full(n, least)
    signed = [layout.row(row.name) for row in layout.rows if row.signed]
    signed += [layout.part(cell, k) for cell in signed for k in range(layout.parts)]
    if state.cells is not None:
        signed = np.flatnonzero(np.isin(state.cells, signed)).tolist()
    lowest[signed] = -math.inf
    for first in range(0, n, _BLOCK):
        part = slice(first, first + _BLOCK)
        limbs, mean = state.limbs[part], state.mean[:n][part]
        if (limbs[:, 1:] < 0).any() or (limbs[:, 1:] >= _LOW).any():
            raise ValueError("its limbs are not canonical")
        if (state.count[part] < 0).any():
            raise ValueError("it has negative counts")
        exact = totals_of(limbs) / batches
        if (exact < lowest[part]).any():
            raise ValueError("it has negative powers")
        scatter = np.sqrt(np.maximum(state.m2[:n][part], 0.0))
        # NaN fails every comparison
        if not (np.abs(mean - exact) <= _AGREES * (np.abs(exact) + scatter) - least).all():
            raise ValueError("its means are not those of its totals")
    if not (np.isfinite(state.mean).all() and np.isfinite(state.m2).all()):
        raise ValueError("it has means or squares that are no numbers")
    if (state.m2 < 0.0).any():
        raise ValueError("it has negative squares")
    totals = [tally.exact(cell) for cell in range(layout.n_rows)]
    signs = [1] * layout.n_elements + [row.sign for row in layout.rows]
    missed = batches * compiled.emitted - sum(s * t for s, t in zip(signs, totals, strict=True))
    if abs(missed) > limit * batches * compiled.emitted:
        raise ValueError("its ledger does not close")
    for row in range(layout.n_rows if layout.parts else 0):
        parts = [tally.exact(layout.part(row, k)) for k in range(layout.parts)]
        if sum(parts) != totals[row]:
            raise ValueError("its ledger's parts by wavelength are not their sum")
