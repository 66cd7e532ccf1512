"""Scales: of colours, as a reader asks for them or as values need them, and logarithmic axes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import (
    FuncFormatter,
    LogFormatterSciNotation,
    LogLocator,
    MaxNLocator,
    NullFormatter,
)

from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from numpy.typing import NDArray

__all__ = ["PEAKED", "colour_norm", "extends", "is_log", "log_ticks"]

PEAKED: Final = 0.05
"""Where half of the bins are below this part of the highest, a linear scale shows none of them."""
_TINY: Final = 5e-324


def colour_norm(
    values: NDArray[np.float64],
    norm: str | Normalize | None,
    vmin: float | None,
    vmax: float | None,
    *,
    peaked: bool = False,
) -> Normalize:
    """Return the scale of a map's colours.

    Parameters
    ----------
    values : ndarray, shape (n,), float64
        What the limits that are not given are taken from.
    norm : {"linear", "log"} or matplotlib.colors.Normalize or None
        None is a linear scale, but see `peaked`.
    vmin, vmax : float or None
        Its limits; by default 0 and the highest value, on a logarithmic scale the lowest above 0
        and the highest.
    peaked : bool, optional
        Whether, with neither scale nor limits given, values of which half are below `PEAKED` of the
        highest get a logarithmic scale.

    Raises
    ------
    ArgumentError
        Where `norm` is something else, a limit is not finite, not above 0 on a logarithmic scale,
        or stands beside a norm that has its own, or `vmin` is not below `vmax`.
    """
    if isinstance(norm, Normalize):
        if vmin is not None or vmax is not None:
            raise ArgumentError(
                "norm: found a matplotlib norm beside vmin or vmax, expected one of the two: give "
                "the limits to the norm"
            )
        if len(values):
            norm.autoscale_None(values)
        return norm
    if norm not in (None, "linear", "log"):
        raise ArgumentError(
            f'norm: found {show(norm)}, expected "linear", "log" or a matplotlib norm'
        )
    for name, limit in (("vmin", vmin), ("vmax", vmax)):
        if limit is not None and not math.isfinite(limit):
            raise ArgumentError(f"{name}: found {limit}, expected a finite number")
        if limit is not None and norm == "log" and limit <= 0.0:
            raise ArgumentError(
                f"{name}: found {limit}, expected a number above 0 on a logarithmic scale"
            )
    free = norm is None and vmin is None and vmax is None
    if peaked and free and len(values) and np.median(values) < PEAKED * values.max():
        norm = "log"
    top = float(values.max(initial=0.0))
    if norm == "log":
        above = values[values > 0.0]
        if not len(above):
            above = np.array([vmin or vmax or 1.0])
        low = float(above.min()) if vmin is None else vmin
        high = float(above.max()) if vmax is None else vmax
        if low == high:  # a single value, or a limit at it: a scale has an extent
            low = low / 10.0 if vmin is None else low
            high = high * 10.0 if vmin is not None and vmax is None else high
        _ascending(low, high)
        return LogNorm(low, high)
    low = 0.0 if vmin is None else vmin
    if vmax is not None:
        high = vmax
    elif len(values) and vmin is not None:
        high = top
    else:  # where nothing is coloured, any scale will do
        high = top if top > low else low + 1.0
    _ascending(low, high)
    return Normalize(low, high)


def _ascending(low: float, high: float) -> None:
    if not low < high:
        raise ArgumentError(
            f"vmin, vmax: the scale would run from {low:.6g} to {high:.6g}, expected vmin below "
            "vmax (what is not given is taken from the bins)"
        )


def is_log(norm: Normalize) -> bool:
    """Say whether a scale is logarithmic."""
    return isinstance(norm, LogNorm)


def positive(values: Any, norm: Normalize) -> Any:
    """Return values that a logarithmic scale can show: 0 as what is below all of it."""
    if not is_log(norm):
        return values
    return np.ma.masked_array(np.where(values.data <= 0.0, _TINY, values.data), mask=values.mask)


def extends(values: Any, norm: Normalize) -> str:
    """Return at which ends of its bar a scale is overrun by a masked array's values."""
    found = values.compressed()
    below = norm.vmin is not None and bool((found < norm.vmin).any())
    above = norm.vmax is not None and bool((found > norm.vmax).any())
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get(
        (below, above), "neither"
    )


def log_ticks(axis: Axis, low: float, high: float, most: float = math.inf) -> None:
    """Set ticks of a logarithmic axis: two or more that are labelled, and none that crowd.

    Parameters
    ----------
    axis : Axis
        The axis.
    low, high : float
        What it shows, above 0.
    most : float, optional
        Above this no tick stands: no power is more than what was emitted.
    """
    span = high / low
    if span < 4.0:
        locator: Any = MaxNLocator(4, steps=[1, 2, 2.5, 5, 10])
    elif span < 100.0:
        locator = LogLocator(subs=(1.0, 2.0, 3.0, 5.0) if span < 10.0 else (1.0, 2.0, 5.0))
    else:
        locator = LogLocator(numticks=9)
    plain = low > 0.9e-3 and high < 1.1e4
    said = LogFormatterSciNotation(minor_thresholds=(99.0, 99.0))
    said.set_axis(axis)

    def text(value: float, _: int | None = None) -> str:
        if value > most * (1.0 + 1e-9):
            return ""
        return f"{value:.6g}" if plain or span < 4.0 else str(said(value))

    axis.set_major_locator(locator)
    axis.set_major_formatter(FuncFormatter(text))
    axis.set_minor_formatter(NullFormatter())
