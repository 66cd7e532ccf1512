"""Results made up cell by cell, so that figures are tested without a device and on every case."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from photizon_cl.compile.compiled import compile_scene
from photizon_cl.result.estimates import RunInfo
from photizon_cl.result.statistics import Accumulator, complete
from photizon_cl.result.stopping import Goal
from photizon_cl.run.result import Result
from photizon_cl.scene.files import load

if TYPE_CHECKING:
    from collections.abc import Callable

UNIT = 1 << 31
"""A launched weight in units of a cell's first integer."""


def tables(*elements: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Return a scene's tables with these elements and one lamp of 1 W."""
    lamp = {"name": "lamp", "kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, 1.0]}
    each = [
        {"name": f"e{n}", "position": [0.0, 0.0, -float(n)], "surface": {"kind": "absorber"}, **e}
        for n, e in enumerate(elements)
    ]
    scene = {"schema": "photizon/1", "name": "made-up", "source": [lamp], "element": each}
    return {**scene, "run": {"rays_per_batch": 1000}, **more}


def rectangle(**more: Any) -> dict[str, Any]:
    """Return a rectangle's table."""
    return {"kind": "rectangle", "axis": "+z", "half_width": 1.0, "half_height": 1.0, **more}


def make(
    scene: dict[str, Any],
    counts: Callable[[np.random.Generator, Any], np.ndarray],
    batches: int = 4,
    **info: Any,
) -> Result:
    """Return a result whose cells hold so many rays of weight 1, a new draw in each batch.

    Parameters
    ----------
    scene : dict
        Tables of a scene.
    counts : callable
        Given a random generator and the layout, returns rays of each cell, shape (n_cells,); or
        these and the cells' weights in units of 2^-31, where they are not 1.
    batches : int, optional
        Batches.
    info : optional
        Parameters of `RunInfo`.
    """
    loaded = load(scene)
    compiled = compile_scene(loaded, loaded.run)
    layout = compiled.layout
    tally = Accumulator.of(layout)
    random = np.random.default_rng(7)
    for _ in range(batches):
        cells = np.zeros((layout.n_cells, 4), np.int64)
        found = counts(random, layout)
        cells[:, 3], weights = found if isinstance(found, tuple) else (found, None)
        for d in layout.detectors:
            if d.nx and d.n_generations:  # both count the same arrivals
                cells[d.ladder : d.ladder + d.n_generations, 3] = 0
                cells[d.ladder, 3] = cells[d.map : d.map + d.nx * d.ny, 3].sum()
        cells[:, 0] = cells[:, 3] * UNIT if weights is None else weights
        tally.add(complete(layout, cells))
    return Result(compiled, tally, RunInfo(**{"goal": Goal(batches=batches), **info}))


def poisson(mean: float) -> Callable[[np.random.Generator, Any], np.ndarray]:
    """Return counts of that mean in every cell."""
    return lambda random, layout: random.poisson(mean, layout.n_cells)


def some_lit(random: np.random.Generator, layout: Any) -> np.ndarray:
    """Return counts that are poor in the first half of the cells and good in the second."""
    mean = np.where(np.arange(layout.n_cells) < 0.5 * layout.n_cells, 1.5, 40.0)
    return random.poisson(mean)
