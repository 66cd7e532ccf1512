"""Nodes and elements that the search through the tree visits, counted on the host."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.run.probe import probe_rays

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from photizon_cl.compile.compiled import CompiledScene


def visits(
    compiled: CompiledScene,
    tree: tuple[NDArray[np.float64], NDArray[np.int64]],
    device: OpenDevice,
    searches: int,
) -> tuple[float, float]:
    """Return the mean nodes and elements that a search visits.

    The rays are those of a walk: from the source, then from each hit in a random direction on the
    side it came from, anew from the source where it escapes.

    Parameters
    ----------
    compiled : CompiledScene
        The scene, compiled with the tree.
    tree : tuple of ndarray
        What `build_tree` gave for it.
    device : OpenDevice
        Where the hits are found.
    searches : int
        How many rays, in walks of eight.
    """
    g = np.random.default_rng(1)
    n = searches // 8
    start = np.subtract(compiled.scene.source[0].position, compiled.shift)
    at = np.tile(start, (n, 1))
    along = _directions(g, n)
    seen = []
    for _ in range(8):
        hits, element = probe_rays(device, compiled.tables, np.hstack([at, along]), 1)
        found = element >= 0
        best = np.where(found, hits[:, 0], np.inf)
        seen += [_visited(*tree, o, d, t) for o, d, t in zip(at, along, best, strict=True)]
        normal = hits[:, 4:7]
        back = -np.sign(np.sum(normal * along, axis=1))[:, None] * normal
        new = _directions(g, n)
        new *= np.where(np.sum(new * back, axis=1) < 0.0, -1.0, 1.0)[:, None]
        at = np.where(found[:, None], hits[:, 1:4], start)
        along = np.where(found[:, None], new, _directions(g, n))
    nodes, tests = np.mean(seen, axis=0)
    return float(nodes), float(tests)


def _directions(g: np.random.Generator, n: int) -> NDArray[np.float64]:
    vectors = g.normal(size=(n, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _visited(
    nodes: Any, children: Any, origin: Any, direction: Any, best: float
) -> tuple[int, int]:
    """Follow the kernels' order for a ray whose hit is known; before it is found nothing is cut."""
    inverse = 1.0 / direction
    up = inverse > 0.0
    waiting: list[tuple[float, int]] = [(0.0, -1)]
    reach, n_nodes, n_tests = np.inf, 0, 0
    while waiting:
        entered, link = waiting.pop()
        if entered > reach:
            continue
        if link >= 0:
            n_tests += 1
            reach = best  # the nearest box first: what is hit is found about here
            continue
        n_nodes += 1
        box = nodes[~link]
        near = np.where(up[:, None], box[:3], box[3:])
        far = np.where(up[:, None], box[3:], box[:3])
        enter = np.maximum(((near - origin[:, None]) * inverse[:, None]).max(axis=0), 0.0)
        leave = ((far - origin[:, None]) * inverse[:, None]).min(axis=0)
        met = np.flatnonzero(enter <= np.minimum(leave, reach))
        for k in met[np.argsort(-enter[met], kind="stable")]:
            waiting.append((float(enter[k]), int(children[~link][k])))
    return n_nodes, n_tests
