"""A tree of boxes, eight to a node, over many elements, for the nearest hit of one ray at a time.

Built from the root down, a whole level at once: every node divides its elements seven times, each
time the group whose box has the largest area, where a binned surface-area heuristic finds least
cost (Wald, *On fast construction of SAH-based bounding volume hierarchies*, 2007). The kernels take
every box larger by a bound of the rounding, so the tree only saves tests: a hit has the same bits
as with the plain scan (gated).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.elements.base import ROUNDOFF

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.frames import Vec3

__all__ = ["BREAK_EVEN", "TREE_STACK", "TREE_WIDTH", "build_tree", "world_boxes"]

TREE_WIDTH: Final = 8
"""Children of a node."""
TREE_STACK: Final = 169
"""Places of the kernels' stack: seven stay behind at each of up to 24 levels, and one."""

BREAK_EVEN: Final = 48
"""Number of elements from which the tree is faster than the plain scan, measured by
``benchmarks/acceleration.py``."""
_BINS: Final = 16
"""Places of a possible division along each axis."""
_BY_AREA: Final = 8
"""Levels divided by the heuristic, which may peel off one element at a time; those below divide at
the median, so that the depth, and with it the kernels' stack, has a bound."""
_DEEPEST: Final = (TREE_STACK - 1) // (TREE_WIDTH - 1)
"""Levels for which the kernels' stack has room."""


def world_boxes(
    elements: Sequence[Element],
    shift: Vec3,
    at_edges: NDArray[np.float64] | None = None,
    roundoff: float = ROUNDOFF,
) -> NDArray[np.float64]:
    """Return each element's box in the device's coordinates.

    Parameters
    ----------
    elements : sequence of Element
        At least one.
    shift : tuple of float
        Taken off every position, in metres.
    at_edges : ndarray, shape (n,), float64, optional
        Largest factor of the bounds at an element's edges, from
        `photizon_cl.geometry.wedges.edge_factors`; default all 1.
    roundoff : float, optional
        Unit roundoff of the coordinates that the kernels compute in.

    Returns
    -------
    ndarray, shape (n, 6), float64
        Low corner, high corner, in metres.
    """
    local = np.array([e.local_box for e in elements])
    low, high = local[:, 0], local[:, 1]
    frames = np.array([e.frame for e in elements])
    positions = np.array([e.position for e in elements])
    centres = positions - np.array(shift)
    middle = np.einsum("nij,ni->nj", frames, 0.5 * (low + high))
    half = np.einsum("nij,ni->nj", np.abs(frames), 0.5 * (high - low))
    # faces count as hit, or are noted, within some roundings of the positions as given: up to 64
    # times the bounds in `geometry_table` (kernels/lib/flat.mako)
    given = np.max(np.abs(positions), axis=1, keepdims=True)
    far = given
    if roundoff != ROUNDOFF:
        far = np.max(np.abs(centres), axis=1, keepdims=True)
        far = np.maximum(far, given * (ROUNDOFF / roundoff))
    half += 2.0**11 * roundoff * far
    if at_edges is not None:
        size = np.max(high - low, axis=1, keepdims=True)
        half += 2.0**10 * roundoff * (far + size) * (at_edges[:, None] - 1.0)
    return np.concatenate((centres + middle - half, centres + middle + half), axis=1)


def build_tree(boxes: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Build the tree.

    Parameters
    ----------
    boxes : ndarray, shape (n, 6), float64
        The elements' boxes, n ≥ 1.

    Returns
    -------
    nodes : ndarray, shape (m, 6, 8), float64
        Boxes of each node's children: low x, y, z, high x, y, z. A place without a child has a box
        that nothing meets (low +inf, high -inf).
    children : ndarray, shape (m, 8), int64
        An element's number, or ``~node`` for a node. Node 0 is the root; a node stands before its
        children, level by level.
    """
    n = len(boxes)
    size = float(np.max(boxes[:, 3:] - boxes[:, :3], initial=0.0))
    size = max(size, float(np.ptp(boxes[:, :3], axis=0).max())) or 1.0
    scaled = boxes / size  # areas neither overflow nor vanish
    order = np.arange(n)
    first, count = np.zeros(1, np.int64), np.full(1, n)
    nodes: list[NDArray[np.float64]] = []
    children: list[NDArray[np.int64]] = []
    made = 1
    for level in range(_DEEPEST):
        starts, counts = _divide(scaled, order, first, count, by_area=level < _BY_AREA)
        used = counts > 0
        ends = _grouped(boxes, order, starts[used], counts[used])
        here = np.empty((len(first), TREE_WIDTH, 6))
        here[:, :, :3], here[:, :, 3:] = np.inf, -np.inf
        here[used] = ends
        nodes.append(here.transpose(0, 2, 1))
        inner = counts > 1
        links = np.where(inner, 0, order[np.minimum(starts, n - 1)])
        links[inner] = ~(made + np.arange(np.count_nonzero(inner)))
        made += int(np.count_nonzero(inner))
        children.append(links)
        first, count = starts[inner], counts[inner]
        if not len(first):
            return np.concatenate(nodes), np.concatenate(children)
    raise AssertionError("the tree is deeper than the median's division allows")


# -- one level -----------------------------------------------------------------------------------


def _divide(
    boxes: NDArray[np.float64],
    order: NDArray[np.int64],
    first: NDArray[np.int64],
    count: NDArray[np.int64],
    *,
    by_area: bool,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Divide each node's part of `order` (changed in place) into up to eight.

    Returns
    -------
    starts, counts : ndarray, shape (nodes, 8), int64
        The parts; a count of 0 where there are fewer.
    """
    n = len(first)
    starts, counts = np.zeros((n, TREE_WIDTH), np.int64), np.zeros((n, TREE_WIDTH), np.int64)
    areas = np.full((n, TREE_WIDTH), -1.0)
    starts[:, 0], counts[:, 0] = first, count
    areas[:, 0] = 1.0
    for parts in range(1, TREE_WIDTH):
        # First what would not fit a node of its own, the largest box (or most elements) first; then
        # the fewest elements, whose node a few places save.
        whole = 1.0 + (areas if by_area else counts)
        rank = np.where(counts > TREE_WIDTH, whole, 1.0 / np.maximum(counts, 1))
        rank = np.where(counts > 1, rank, -1.0)
        chosen = rank.argmax(axis=1)
        node = np.flatnonzero(rank[np.arange(n), chosen] >= 0.0)
        if not len(node):
            break
        at = (node, chosen[node])
        begin, many = starts[at], counts[at]
        low = _split(boxes, order, begin, many, by_area=by_area)
        counts[at] = low
        starts[node, parts], counts[node, parts] = begin + low, many - low
        areas[at] = _area(_grouped(boxes, order, begin, low))
        areas[node, parts] = _area(_grouped(boxes, order, begin + low, many - low))
    return starts, counts


def _split(
    boxes: NDArray[np.float64],
    order: NDArray[np.int64],
    begin: NDArray[np.int64],
    many: NDArray[np.int64],
    *,
    by_area: bool,
) -> NDArray[np.int64]:
    """Divide parts of `order` in two (changed in place); return how many each first half has."""
    groups = len(begin)
    group, at = _places(begin, many)
    members = order[at]
    centres = boxes[members, :3] + boxes[members, 3:]
    bounds = np.concatenate(([0], np.cumsum(many)[:-1]))
    low = np.minimum.reduceat(centres, bounds)
    extent = np.maximum.reduceat(centres, bounds) - low
    along = extent.argmax(axis=1)
    least = np.full(groups, np.inf)
    if by_area:
        with np.errstate(divide="ignore", invalid="ignore"):
            place = (centres - low[group]) / extent[group] * _BINS
        bins = np.clip(np.nan_to_num(place), 0, _BINS - 1).astype(np.int64)
        least, along, cut = _best_cut(boxes[members], group, bins, groups)
        upper = bins[np.arange(len(members)), along[group]] > cut[group]
    else:
        upper = np.zeros(len(members), bool)
    # Where no division by area is possible (one place for all centres), at the median.
    middle = np.isinf(least)
    if middle.any():
        ranked = np.lexsort((members, centres[np.arange(len(members)), along[group]], group))
        rank = np.empty(len(members), np.int64)
        rank[ranked] = np.arange(len(members))
        upper = np.where(middle[group], rank - bounds[group] >= (many // 2)[group], upper)
    order[at] = members[np.lexsort((members, upper, group))]
    return many - np.bincount(group, upper, groups).astype(np.int64)


def _best_cut(
    boxes: NDArray[np.float64], group: NDArray[np.int64], bins: NDArray[np.int64], groups: int
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Return each group's least cost of a division, the axis and the last bin of its low side."""
    key = ((group[:, None] * 3 + np.arange(3)) * _BINS + bins).ravel()
    cells = groups * 3 * _BINS
    shape = (groups, 3, _BINS)
    number = np.bincount(key, minlength=cells).reshape(shape)
    corner = np.empty((6, *shape))
    for column in range(6):
        flat = np.full(cells, np.inf)
        value = np.repeat(boxes[:, column] if column < 3 else -boxes[:, column], 3)
        np.minimum.at(flat, key, value)
        corner[column] = flat.reshape(shape)
    rising = np.minimum.accumulate(corner, axis=3)[..., :-1]
    falling = np.minimum.accumulate(corner[..., ::-1], axis=3)[..., ::-1][..., 1:]
    below = np.cumsum(number, axis=2)[..., :-1]
    above = number.sum(axis=2, keepdims=True) - below
    with np.errstate(invalid="ignore"):
        cost = below * _half_area(rising) + above * _half_area(falling)
    cost = np.where((below > 0) & (above > 0), cost, np.inf).reshape(groups, -1)
    best = cost.argmin(axis=1)
    axis, cut = np.divmod(best, _BINS - 1)
    return cost[np.arange(groups), best], axis, cut


# -- parts of the order --------------------------------------------------------------------------


def _places(
    begin: NDArray[np.int64], many: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return, for every place in the given parts, the part's number and the place."""
    part = np.repeat(np.arange(len(begin)), many)
    within = np.arange(len(part)) - np.repeat(np.cumsum(many) - many, many)
    return part, begin[part] + within


def _grouped(
    boxes: NDArray[np.float64],
    order: NDArray[np.int64],
    begin: NDArray[np.int64],
    many: NDArray[np.int64],
) -> NDArray[np.float64]:
    """Return the box around each part; none is empty."""
    _, at = _places(begin, many)
    members = boxes[order[at]]
    bounds = np.cumsum(many) - many
    low = np.minimum.reduceat(members[:, :3], bounds)
    return np.concatenate((low, np.maximum.reduceat(members[:, 3:], bounds)), axis=1)


def _area(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    return _half_area(np.concatenate((boxes[:, :3], -boxes[:, 3:]), axis=1).T)


def _half_area(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Half the area of boxes given as (low x, y, z, −high x, y, z) along the first axis."""
    x, y, z = -corner[3:] - corner[:3]
    return np.asarray(x * y + y * z + z * x)
