"""Total integrated scatter: what a lobe sends into the hemisphere.

In the plane of direction cosines it is the integral of the BSDF over the unit disc, seen from β₀
within it. With ρ the way from β₀ to a place of the rim at the polar angle ψ, and G(ρ) the integral
of BSDF(s) s ds from 0 to ρ, it is one over the rim (Green):

    TIS = ∫ G(ρ)/ρ² (1 − b cos ψ) dψ,   ρ² = d² + 4 b sin²(ψ/2),   b = |β₀|, d = 1 − b.

Near the rim, at grazing incidence, no difference of nearly equal numbers is left: d is
cos²θ/(1 + sin θ). With t = tan(ψ/4) everything is rational; the integral over t goes by Gauss's
rule on panels that halve towards 0, since the integrand's scales are d and the lobe's width.

For the kernels TIS(d) is cut into pieces that are polynomials, finer until each is within `WITHIN`
of the greatest TIS where it is asked between its nodes. All of it is made of operations that are
the same bits on every machine.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from photizon_cl.scene.scatters.functions import gauss_nodes, polynomial

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.scatters.base import Scatter

__all__ = ["TERMS", "WITHIN", "Array", "Pieces", "greatest", "pieces_of", "total_at", "within_of"]

Array: TypeAlias = NDArray[np.float64]

WITHIN: Final = 2e-9
"""How far a piece may be from the integral between its nodes, in parts of the greatest TIS."""
TERMS: Final = 8
"""Coefficients of a piece."""
_NOTHING: Final = 1e-8
"""Below so many parts of the greatest TIS a piece is 0: rounding has no direction."""
_MOST_PIECES: Final = 4096
_NODES: Final = 12
_FINEST: Final = 2.0**-44
_PLACES: Final = (-0.980785, -0.83147, -0.55557, -0.19509, 0.19509, 0.55557, 0.83147, 0.980785)
"""Near the zeros of Chebyshev's polynomial; any eight that are different do."""
_BETWEEN: Final = (-1.0, -0.92, -0.71, -0.38, 0.0, 0.38, 0.71, 0.92, 1.0)


@dataclass(frozen=True, eq=False)
class Pieces:
    """A function of d in [0, 1] in pieces.

    Parameters
    ----------
    edges : ndarray, shape (n + 1,)
        Where pieces begin, and 1.
    terms : ndarray, shape (n, 8)
        Coefficients of each in x = 2 (d − edge)/(next edge − edge) − 1, the constant first.
    """

    edges: Array
    terms: Array

    def __call__(self, d: Array) -> Array:
        """Return the function's values."""
        at = np.clip(np.searchsorted(self.edges, d, side="right") - 1, 0, len(self.terms) - 1)
        low, high = self.edges[at], self.edges[at + 1]
        x = np.clip((d - low) * (2.0 / (high - low)) - 1.0, -1.0, 1.0)
        return np.maximum(polynomial([self.terms[at, k] for k in range(TERMS)], x), 0.0)


@lru_cache(maxsize=256)
def pieces_of(model: Scatter) -> Pieces:
    """Return TIS(d) of a model in pieces."""
    scale = max(float(np.max(total_at(model, np.array([0.25, 0.5, 0.75, 1.0])))), 0.0)
    edges = _first_edges(model)
    low, high = np.array(edges[:-1]), np.array(edges[1:])
    lows: list[float] = []
    terms: list[list[float]] = []
    while len(low):
        x = np.array(_PLACES)
        d = _between(low, high, x)
        values = total_at(model, d.ravel()).reshape(d.shape)
        scale = max(scale, float(values.max()))
        made = _fitted(values)
        y = np.array(_BETWEEN)
        d = _between(low, high, y)
        wanted = total_at(model, d.ravel()).reshape(d.shape)
        got = polynomial([made[:, k, None] for k in range(TERMS)], np.broadcast_to(y, d.shape))
        off = np.abs(got - wanted).max(axis=1)
        good = (off <= WITHIN * scale) | (high - low <= _FINEST)
        made[values.max(axis=1) <= _NOTHING * scale] = 0.0
        good |= len(terms) + len(low) > _MOST_PIECES
        lows += low[good].tolist()
        terms += made[good].tolist()
        middle = 0.5 * (low[~good] + high[~good])
        low, high = (
            np.concatenate((low[~good], middle)), np.concatenate((middle, high[~good]))
        )  # fmt: skip
    order = np.argsort(lows)
    return Pieces(np.append(np.array(lows)[order], 1.0), np.array(terms)[order])


def greatest(model: Scatter) -> tuple[float, float]:
    """Return the greatest value of TIS within its pieces, and the angle in degrees."""
    pieces = pieces_of(model)
    steps = np.linspace(0.0, 1.0, 9)
    d = (pieces.edges[:-1, None] + np.diff(pieces.edges)[:, None] * steps).ravel()
    values = pieces(d)
    at = int(np.argmax(values))
    return float(values[at]), math.degrees(math.asin(min(max(1.0 - float(d[at]), 0.0), 1.0)))


def within_of(model: Scatter, radius: Array) -> Array:
    """Return ∫ BSDF(s) s ds from 0 to radii in (0, 2]."""
    return _by_square(model)(radius) * (radius * radius)


def total_at(model: Scatter, d: Array) -> Array:
    """Return TIS of an array of d = 1 − |β₀|, by quadrature."""
    b = 1.0 - d
    edges = _panels(model, d, b)
    nodes, weights = _gauss()
    total = np.zeros_like(d)
    over = _by_square(model)
    for low, high in itertools.pairwise(edges):
        half, middle = 0.5 * (high - low), 0.5 * (high + low)
        part = np.zeros_like(d)
        for node, weight in zip(nodes, weights, strict=True):
            t = middle + node * half
            tt = t * t
            s = 2.0 * t / (1.0 + tt)
            ss = s * s
            rho = np.sqrt(d * d + 4.0 * b * ss)
            part = part + weight * (over(rho) * (d + 2.0 * b * ss) / (1.0 + tt))
        total = total + half * part
    return 8.0 * total


# -- quadrature ----------------------------------------------------------------------------------


@cache
def _gauss() -> tuple[tuple[float, ...], tuple[float, ...]]:
    return gauss_nodes(_NODES)


def _octaves(model: Scatter, more: int) -> int:
    """Return how often 1 is halved until the lobe is wide beside what is left."""
    return max(math.frexp(1.0 / min(model.width, 1.0))[1], 1) + more


def _panels(model: Scatter, d: Array, b: Array) -> list[Array]:
    """Return the edges of the panels in t, ascending, for each d."""
    edges = [np.zeros_like(d)]
    for k in range(_octaves(model, 8), 0, -1):
        edges.append(np.full_like(d, 2.0**-k))
        if model.sharpness > 4:
            edges.append(np.full_like(d, 1.5 * 2.0**-k))
    edges.append(np.ones_like(d))
    for kink in model.kinks:  # where the way to the rim is one at which the BSDF is not smooth
        square = np.maximum((kink - d) * (kink + d), 0.0)
        s = np.sqrt(np.minimum(square / np.maximum(4.0 * b, 2.0**-1000), 1.0))
        edges.append(s / (1.0 + np.sqrt((1.0 - s) * (1.0 + s))))
    return list(np.sort(np.array(edges), axis=0)) if model.kinks else edges


def _by_square(model: Scatter) -> _BySquare:
    return _BySquare(model)


class _BySquare:
    """G(ρ)/ρ² of a model, by its closed form or in parts of octaves of ρ from 2 downwards."""

    def __init__(self, model: Scatter) -> None:
        self._model = model
        self._closed = model.within(np.array([1.0])) is not None
        if not self._closed:
            self._low, self._high, self._terms = _octave_parts(model)

    def __call__(self, rho: Array) -> Array:
        if self._closed:
            found = self._model.within(rho)
            assert found is not None
            return found / np.maximum(rho * rho, 2.0**-1000)
        m, e = np.frexp(rho)
        parts = self._model.sharpness
        within = np.clip(np.floor((2.0 * m - 1.0) * parts).astype(np.int64), 0, parts - 1)
        at = parts * (1 - e.astype(np.int64)) + (parts - 1 - within)
        at = np.clip(at, 0, len(self._low) - 1)
        low, high = self._low[at], self._high[at]
        x = np.clip((rho - low) * (2.0 / (high - low)) - 1.0, -1.0, 1.0)
        return polynomial([self._terms[at, k] for k in range(TERMS)], x)


@lru_cache(maxsize=256)
def _octave_parts(model: Scatter) -> tuple[Array, Array, Array]:
    """Return lower edges, upper edges and terms of G(ρ)/ρ², the widest ρ first."""
    parts = model.sharpness
    octaves = _octaves(model, 20) + 1
    edges = [2.0**-k * (1.0 + j / parts) for k in range(octaves) for j in range(parts, -1, -1)]
    high, low = (
        np.array([e for n, e in enumerate(edges) if n % (parts + 1) != skip]) for skip in (parts, 0)
    )
    count = len(low)
    nodes, weights = _gauss()

    def over(a: Array, b: Array) -> Array:
        half, middle = 0.5 * (b - a), 0.5 * (b + a)
        total = np.zeros_like(b)
        for node, weight in zip(nodes, weights, strict=True):
            r = middle + node * half
            total = total + weight * (model.bsdf_of(r) * r)
        return total * half

    each = over(low, high)
    below = np.zeros(count)
    inner = float(low[-1])
    so_far = 0.5 * inner * inner * float(model.bsdf_of(np.array([inner]))[0])
    for k in range(count - 1, -1, -1):
        below[k] = so_far
        so_far += float(each[k])
    x = np.array(_PLACES)
    rho = _between(low, high, x)
    values = (below[:, None] + over(np.broadcast_to(low[:, None], rho.shape), rho)) / (rho * rho)
    return low, high, _fitted(values)


def _between(low: Array, high: Array, x: Array) -> Array:
    return low[:, None] + (high - low)[:, None] * (0.5 * (x + 1.0))


@cache
def _inverse() -> tuple[tuple[float, ...], ...]:
    """Return what makes coefficients of values at `_PLACES`: Vandermonde's inverse, exactly."""
    places = [Fraction(x) for x in _PLACES]
    rows = [[x**k for k in range(TERMS)] + [Fraction(int(n == m)) for m in range(TERMS)]
            for n, x in enumerate(places)]  # fmt: skip
    for n in range(TERMS):
        pivot = next(m for m in range(n, TERMS) if rows[m][n])
        rows[n], rows[pivot] = rows[pivot], rows[n]
        rows[n] = [value / rows[n][n] for value in rows[n]]
        for m in range(TERMS):
            if m != n:
                rows[m] = [a - rows[m][n] * b for a, b in zip(rows[m], rows[n], strict=True)]
    return tuple(tuple(float(value) for value in row[TERMS:]) for row in rows)


def _fitted(values: Array) -> Array:
    """Return the coefficients of polynomials through values at `_PLACES`, shape (n, 8) both."""
    columns = []
    for row in _inverse():
        total = np.zeros(len(values))
        for k, factor in enumerate(row):
            total = total + factor * values[:, k]
        columns.append(total)
    return np.stack(columns, axis=1)


def _first_edges(model: Scatter) -> Sequence[float]:
    found = {0.0, 1.0, *(2.0**-k for k in range(_octaves(model, 4)))}
    for kink in model.kinks:
        found |= {d for d in (kink, 2.0 - kink) if 0.0 < d < 1.0}
    return sorted(found)
