"""How a value and its standard error, and the lit part of a map, are written for people."""

from __future__ import annotations

from math import floor, log10

__all__ = ["batches", "lit_percent", "with_error"]


def batches(number: int) -> str:
    """Return how many batches there are, in words."""
    return "1 batch" if number == 1 else f"{number} batches"


def lit_percent(part: float) -> str:
    """Return the lit part of the bins in percent.

    Rounded down, so that 100 % means every bin and 50.0 % is never said beside a warning of less.
    """
    return f"{floor(round(1e3 * part, 9)) / 10.0:.1f} %"


def with_error(value: float, sigma: float | None) -> tuple[str, str]:
    """Return a value and its σ, rounded to what the σ supports: two digits of it."""
    if sigma is None:
        return f"{value:.6g}", "unknown"
    if sigma == 0.0:
        return f"{value:.9g}", "0"
    largest = max(abs(value), sigma)
    if not 1e-4 <= largest < 1e5:
        # Both with the exponent of the larger one's digits, e.g. 1.2300e-07 and 4.5e-10.
        digits = max(floor(log10(largest)) - floor(log10(sigma)) + 1, 1)
        return f"{value:.{min(digits, 12)}e}", f"{sigma:.1e}"
    decimals = min(max(1 - floor(log10(sigma)), 0), 12)
    small = f"{sigma:.{decimals}f}" if decimals <= 9 else f"{sigma:.1e}"
    return f"{value:.{decimals}f}", small
