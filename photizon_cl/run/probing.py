"""Probing a scene with rays of one's own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.device.device import DeviceRecord, preferred_lanes
from hostcode.run.probe import element_of, face_of, probe_faces
from photizon_cl.checks.precision import DEFAULT, fitting_mode
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import ArgumentError
from photizon_cl.run.distribution import device_failures, open_chosen
from photizon_cl.scene.files import load

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from photizon_cl.scene.model import Scene

__all__ = ["ProbeResult", "probe"]


@dataclass(frozen=True, eq=False)
class ProbeResult:
    """What rays hit first.

    Parameters
    ----------
    distance : ndarray, shape (n,), float64
        Metres along the unit direction; infinite on a miss.
    element : ndarray, shape (n,), int64
        Number of the element in the scene; −1 on a miss.
    point : ndarray, shape (n, 3), float64
        Where, in metres, put back onto the surface; NaN on a miss.
    normal : ndarray, shape (n, 3), float64
        Outward unit normal there, whatever side the ray comes from; NaN on a miss.
    face : ndarray, shape (n,), str
        Name of the element's face, for example ``"wall"`` or ``"baffle 2"``; empty on a miss. See
        `Element.face_names`.
    """

    distance: NDArray[np.float64]
    element: NDArray[np.int64]
    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    face: NDArray[np.str_]


def probe(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    origins: ArrayLike,
    directions: ArrayLike,
    device: DeviceRecord | str | int | None = None,
    *,
    lanes: int | None = None,
    precision: str = DEFAULT,
) -> ProbeResult:
    """Return what rays hit first, by the very kernels of the trace.

    A ray whose origin lies on a face within rounding is taken to leave that face.

    Parameters
    ----------
    scene : Scene, str, path or mapping
        A scene, or what `photizon_cl.load` makes one of.
    origins : array_like, shape (n, 3)
        Metres, finite.
    directions : array_like, shape (n, 3)
        Finite and not zero; of any length. They are brought to unit length, and distances are along
        the unit vectors; one that is of unit length already (its sum of squares rounds to 1) is
        taken as it is.
    device : str, int or DeviceRecord, optional
        As in `photizon_cl.trace`.
    lanes : int, optional
        Lane width 1, 2, 4, 8 or 16; default the device's. Changes no bit.
    precision : str, optional
        As in `photizon_cl.trace`; origins and directions are rounded to what it computes in.

    Returns
    -------
    ProbeResult
        Distance, element, point, normal and face.

    Raises
    ------
    SceneError, ArgumentError
        Where the scene or an argument is not valid.
    RunError
        Where there is no usable device, or it fails.
    """
    scene = load(scene)
    start = _vectors("origins", origins)
    along = _unit(_vectors("directions", directions))
    if len(start) != len(along):
        raise ArgumentError(
            f"directions: found {len(along)} rows, expected {len(start)}, one for each origin"
        )
    if lanes is not None and lanes not in (1, 2, 4, 8, 16):
        raise ArgumentError(f"lanes: found {lanes!r}, expected 1, 2, 4, 8 or 16")
    fitting_mode(precision, scene)
    compiled = compile_scene(scene, scene.run, precision=precision)
    opened = open_chosen(str(device) if isinstance(device, int) else device)
    shift = np.array(compiled.shift)
    rays = np.hstack([start - shift, along])
    width = lanes or preferred_lanes(opened.record, compiled.tables.spec.effects)
    with device_failures(opened.record.label):
        hits, left = probe_faces(opened, compiled.tables, rays, width)
    element = element_of(left)
    missed = element < 0
    distance = np.where(missed, np.inf, hits[:, 0])
    point = hits[:, 1:4] + shift
    normal = hits[:, 4:7] + 0.0  # no -0.0
    point[missed] = np.nan
    normal[missed] = np.nan
    face = _names(scene, element, face_of(left))
    return ProbeResult(distance, element, point, normal, face)


def _names(scene: Scene, element: NDArray[np.int64], number: NDArray[np.int64]) -> NDArray[np.str_]:
    """Return the names of faces by the kernels' numbers; empty where the element's is −1."""
    # one integer a pair: rows of two are far slower to sort
    faces = int(number.max(initial=0)) + 1
    keys = np.where(element < 0, -1, element * faces + number)
    met, of_ray = np.unique(keys, return_inverse=True)
    pairs = (divmod(key, faces) for key in met.tolist())
    names = [scene.element[e].face_name(f) if e >= 0 else "" for e, f in pairs]
    return np.array(names, np.str_)[of_ray.ravel()]


def _vectors(name: str, given: ArrayLike) -> NDArray[np.float64]:
    try:
        array = np.array(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name}: expected numbers of shape (n, 3): {error}") from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise ArgumentError(f"{name}: found the shape {array.shape}, expected (n, 3)")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if bad.size:
        raise ArgumentError(
            f"{name}[{bad[0]}]: found {array[bad[0]].tolist()}, expected finite numbers"
        )
    return array


def _unit(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    largest = np.max(np.abs(directions), axis=1, initial=0.0)
    zero = np.flatnonzero(largest == 0.0)
    if zero.size:
        raise ArgumentError(f"directions[{zero[0]}]: found [0, 0, 0], expected a direction")
    # By powers of two first: exact, and no square overflows or vanishes.
    scaled = np.ldexp(directions, -np.frexp(largest)[1][:, np.newaxis])
    unit = scaled / np.sqrt(np.sum(scaled * scaled, axis=1, keepdims=True))
    with np.errstate(over="ignore"):
        square = np.sum(directions * directions, axis=1, keepdims=True)
    already = np.abs(square - 1.0) <= 2.0**-52
    return np.where(already, directions, unit)
