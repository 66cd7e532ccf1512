"""Nodes of the tree as the kernels read them: 128 bytes, two cache lines, for eight children.

A node's boxes stand on a grid of its own, 255 steps a side, rounded outwards (Ylitie, Karras and
Laine, *Efficient incoherent ray traversal on GPUs through compressed wide BVHs*, 2017). A search
among many elements waits for memory: with boxes in doubles a node takes 448 bytes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.geometry.tree import TREE_WIDTH, build_tree, world_boxes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from photizon_cl.compile.draft import Draft

__all__ = ["TREE_NODE", "add_tree", "pack_nodes", "unpack_nodes"]

TREE_NODE: Final = 16
"""Doubles of a node."""

_STEPS: Final = 255
_LEAST: Final = 2.0**-1000
"""The least step: a node may be flat."""
_ROUNDOFF: Final = 2.0**-50
"""More than subtraction, division and the step may round, relative."""


def pack_nodes(nodes: NDArray[np.float64], children: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the nodes' rows in the geometry table.

    Parameters
    ----------
    nodes, children : ndarray
        What `photizon_cl.geometry.tree.build_tree` gave.

    Returns
    -------
    ndarray, shape (m, 16), float64
        Low corner x, y, z of the grid; its steps along x, y, z; the bits of 48
        bytes, the children's low x, y, z and high x, y, z on the grid, eight each; the bits of
        eight int32, the children. A place without a child has a box inside out and the node's first
        child, which a ray may then meet again without any harm.
    """
    low, high = nodes[:, :3], nodes[:, 3:]
    used = np.isfinite(low[:, :1])
    origin = low.min(axis=2, keepdims=True)
    with np.errstate(invalid="ignore"):  # a place without a child is infinitely far away
        begin = np.where(used, low - origin, 0.0) * (1.0 - _ROUNDOFF)
        end = np.where(used, high - origin, 0.0) * (1.0 + _ROUNDOFF)
    extent = end.max(axis=2, keepdims=True)
    step = np.maximum(extent * ((1.0 + _ROUNDOFF) / _STEPS), _LEAST)
    grid = np.empty((len(nodes), 6, TREE_WIDTH), np.uint8)
    grid[:, :3] = np.where(used, np.floor(begin / step), _STEPS)
    grid[:, 3:] = np.where(used, np.ceil(end / step), 0)
    links = np.where(used[:, 0], children, children[:, :1]).astype(np.int32)
    rows = np.empty((len(nodes), TREE_NODE))
    rows[:, :3], rows[:, 3:6] = origin[:, :, 0], step[:, :, 0]
    rows[:, 6:12] = grid.reshape(-1, 6 * TREE_WIDTH).view(np.float64)
    rows[:, 12:] = links.view(np.float64)
    return rows


def unpack_nodes(
    rows: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the boxes and children that the kernels find in the nodes' rows.

    Parameters
    ----------
    rows : ndarray, shape (m, 16), float64
        From `pack_nodes`.

    Returns
    -------
    nodes : ndarray, shape (m, 6, 8), float64
    children : ndarray, shape (m, 8), int64
        As `photizon_cl.geometry.tree.build_tree` gives them, with larger boxes.
    """
    rows = np.ascontiguousarray(rows)
    grid = np.ascontiguousarray(rows[:, 6:12]).view(np.uint8).reshape(-1, 6, TREE_WIDTH)
    corner = np.tile(rows[:, :3], 2)[:, :, None]
    step = np.tile(rows[:, 3:6], 2)[:, :, None]
    nodes = corner + step * grid
    links = np.ascontiguousarray(rows[:, 12:]).view(np.int32)
    return nodes, links.astype(np.int64)


def add_tree(draft: Draft) -> tuple[int, NDArray[np.float64]]:
    """Return where a tree of boxes begins in the geometry table, and the table with it.

    See ``kernels/effects/acceleration.mako``.
    """
    geometry = draft.geometry
    assert geometry is not None
    boxes = world_boxes(
        draft.scene.element, draft.shift, draft.at_edges.max(axis=1), draft.precision.roundoff
    )
    rows = pack_nodes(*build_tree(boxes))
    # a node begins at a whole node from the table's beginning; the scene's size stands before the
    # first
    head = np.zeros(TREE_NODE - len(geometry) % TREE_NODE)
    head[-1] = np.max(np.abs(boxes))
    return len(geometry) + len(head), np.concatenate((geometry, head, rows.ravel()))
