"""A tree of boxes over many elements, for the nearest hit in about log n steps.

Built by splitting at the median of the elements' centres along the longest side of their box. The
kernels take every box larger by a bound of the rounding, so the tree only saves tests: a hit has
the same bits as with the plain scan (gated).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.elements import Element
    from photizon_cl.frames import Vec3

__all__ = ["BREAK_EVEN", "build_tree", "world_boxes"]

BREAK_EVEN: Final = 48
"""Number of elements from which the tree is faster than the plain scan, measured by
``benchmarks/acceleration.py``."""
LEAF: Final = 4
"""Elements of a leaf at most."""


def world_boxes(elements: Sequence[Element], shift: Vec3) -> NDArray[np.float64]:
    """Return each element's box in the device's coordinates.

    Returns
    -------
    ndarray, shape (n, 6), float64
        Low corner, high corner, in metres.
    """
    low = np.array([e.local_box[0] for e in elements])
    high = np.array([e.local_box[1] for e in elements])
    frames = np.array([e.frame for e in elements])
    centres = np.array([e.position for e in elements]) - np.array(shift)
    middle = np.einsum("nij,ni->nj", frames, 0.5 * (low + high))
    half = np.einsum("nij,ni->nj", np.abs(frames), 0.5 * (high - low))
    # faces count as hit within a few roundings of the positions as given (see `geometry_table`)
    half += 2.0**-48 * np.max(np.abs([e.position for e in elements]), axis=1, keepdims=True)
    return np.concatenate((centres + middle - half, centres + middle + half), axis=1)


def build_tree(
    boxes: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Build the tree.

    Parameters
    ----------
    boxes : ndarray, shape (n, 6), float64
        The elements' boxes, n ≥ 1.

    Returns
    -------
    nodes : ndarray, shape (m, 6), float64
        Box of each node, in preorder.
    links : ndarray, shape (m, 2), int64
        A leaf's first place in `order` and number of elements; an inner node's
        ``high child << 2 | axis`` and 0.
    order : ndarray, shape (n,), int64
        Elements in the order of the leaves.
    """
    centres = boxes[:, :3] + boxes[:, 3:]
    nodes: list[NDArray[np.float64]] = []
    links: list[tuple[int, int]] = []
    order: list[int] = []
    # (elements, node whose high child this is or -1, axis of that node)
    waiting: list[tuple[NDArray[np.int64], int, int]] = [(np.arange(len(boxes)), -1, 0)]
    while waiting:
        members, parent, axis = waiting.pop()
        here = len(nodes)
        if parent >= 0:
            links[parent] = (here << 2 | axis, 0)
        inside = boxes[members]
        nodes.append(np.concatenate((inside[:, :3].min(axis=0), inside[:, 3:].max(axis=0))))
        if len(members) <= LEAF:
            links.append((len(order), len(members)))
            order.extend(int(n) for n in np.sort(members))
            continue
        spread = np.ptp(centres[members], axis=0)
        along = int(np.argmax(spread))
        half = len(members) // 2
        # a stable sort: the same tree on every machine
        ranked = members[np.argsort(centres[members, along], kind="stable")]
        links.append((0, 0))
        waiting.append((ranked[half:], here, along))
        waiting.append((ranked[:half], -1, 0))
    return np.array(nodes), np.array(links, np.int64), np.array(order, np.int64)
