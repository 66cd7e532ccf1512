"""What a device needs of a scene: flat tables and the program they are for. Pickles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.program.structs import LAUNCH, numpy_dtype

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hostcode.program.spec import ProgramSpec

__all__ = ["DeviceTables", "launch_of"]


@dataclass(frozen=True, eq=False)
class DeviceTables:
    """The compiled scene as the kernels read it.

    Parameters
    ----------
    spec : ProgramSpec
        Which program; lanes and stages are left to the device.
    geometry : ndarray, shape (n_elements * spec.strides.row, …), float64
        Row of each element, in file order.
    materials : ndarray, float64
        Row of each distinct surface.
    sources : ndarray, float64
        Row of each source.
    codes : ndarray, int64
        Class bounds, element codes by class, and the tables that `launch` points into.
    detector_numbers, edges : ndarray, float64
        Frames of the detectors; edges of every bin.
    launch : dict
        Members of the launch structure that the scene fixes.
    n_cells : int
        Cells of one batch's tally.
    """

    spec: ProgramSpec
    geometry: NDArray[np.float64]
    materials: NDArray[np.float64]
    sources: NDArray[np.float64]
    codes: NDArray[np.int64]
    detector_numbers: NDArray[np.float64]
    edges: NDArray[np.float64]
    launch: dict[str, Any]
    n_cells: int


def launch_of(tables: DeviceTables, **members: int) -> NDArray[np.void]:
    """Return the launch structure of a scene, with those members that a launch adds.

    Returns
    -------
    ndarray, shape ()
        In the kernels' layout; members that neither gives are 0.
    """
    launch = np.zeros((), numpy_dtype(LAUNCH + tables.spec.launch_members))
    for name, value in {**tables.launch, "n_cells": tables.n_cells, **members}.items():
        launch[name] = value
    return launch
