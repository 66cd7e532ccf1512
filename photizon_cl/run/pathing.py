"""Following a few rays: every segment of their paths, for drawing and for debugging."""

from __future__ import annotations

import dataclasses
import math
import operator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.run.paths import trace_paths
from hostcode.run.tally import values, whole_of
from photizon_cl.checks.precision import DEFAULT, fitting_mode
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import ArgumentError, SceneError, show
from photizon_cl.result.paths import ENDINGS, Paths
from photizon_cl.run.distribution import device_failures, open_chosen
from photizon_cl.scene.files import load
from photizon_cl.scene.settings import MAX_RAYS_PER_BATCH

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

    from hostcode.device.device import DeviceRecord
    from hostcode.run.paths import RawPaths
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.scene.model import Scene

__all__ = ["paths"]

_ESCAPED: Final = ENDINGS.index("escaped")
_MOST_SEGMENTS: Final = 2**20


def paths(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    rays: int = 50,
    seed: int | None = None,
    *,
    generation_cap: int | None = None,
    max_segments: int = 4096,
    escape_length: float | None = None,
    device: DeviceRecord | str | int | None = None,
    precision: str = DEFAULT,
) -> Paths:
    """Follow a few rays through a scene and return every segment of their paths.

    The rays are those of the first batch of ``photizon_cl.trace(scene, rays_per_batch=rays,
    seed=seed)``, by the very kernels of the trace and with the same bits.

    Parameters
    ----------
    scene : Scene, str, path or mapping
        A scene, or what `photizon_cl.load` makes one of.
    rays : int, optional
        Launched rays, at least one for each source.
    seed : int, optional
        The random stream; default that of the scene's ``[run]``.
    generation_cap : int, optional
        Surface interactions at most; default that of the scene's ``[run]``.
    max_segments : int, optional
        Segments written down of one launched ray and its children. What is cut off is said in
        `Paths.cut` and `Paths.advisories`, and the segments there end as ``"not followed"``.
    escape_length : float, optional
        Metres that an escaping segment is drawn; default half the size of the scene.
    device : str, int or DeviceRecord, optional
        As in `photizon_cl.trace`.
    precision : str, optional
        As in `photizon_cl.trace`.

    Returns
    -------
    Paths
        Segments as arrays; iterating over it gives polylines.

    Raises
    ------
    SceneError, ArgumentError
        Where the scene or an argument is not valid.
    RunError
        Where there is no usable device, or it fails.
    """
    loaded = load(scene)
    n_rays = _whole("rays", rays, max(len(loaded.source), 1), MAX_RAYS_PER_BATCH)
    most = _whole("max_segments", max_segments, 1, _MOST_SEGMENTS)
    as_run = _as_run(loaded, rays_per_batch=n_rays, seed=seed, generation_cap=generation_cap)
    length = _size(as_run) / 2.0 if escape_length is None else escape_length
    if not (isinstance(length, int | float) and 0.0 < length < math.inf):
        raise ArgumentError(f"escape_length: found {show(length)}, expected a positive length in m")
    compiled = compile_scene(as_run, as_run.run, precision=fitting_mode(precision, as_run).name)
    opened = open_chosen(str(device) if isinstance(device, int) else device)
    with device_failures(opened.record.label):
        raw = trace_paths(opened, compiled.tables, most)
    return _finish(compiled, raw, float(length))


def _finish(compiled: CompiledScene, raw: RawPaths, escape_length: float) -> Paths:
    path, generation, element, parent, begins, ending = raw.wholes.T
    shift = np.array(compiled.shift)
    start, end = raw.reals[:, 0:3] + shift, raw.reals[:, 3:6].copy()
    escaped = ending == _ESCAPED
    end[escaped] = raw.reals[escaped, 0:3] + escape_length * end[escaped]
    layout = compiled.layout
    watts = values(whole_of(raw.cells, 0, layout.n_rows)) * compiled.unit_power
    names = [f"absorbed by {element.name}" for element in compiled.scene.element]
    ledger = dict(zip(names, watts[: len(names)].tolist(), strict=True))
    titles = [row.title for row in layout.rows]
    amounts = watts[layout.n_elements : layout.n_rows].tolist()
    ledger |= dict(zip(titles, amounts, strict=True))
    return Paths(
        scene=compiled.scene,
        ray=raw.ray,
        start=start,
        end=end + shift,
        weight=raw.reals[:, 6].copy(),
        generation=generation.copy(),
        path=path.copy().view(np.uint64),
        element=element.copy(),
        parent=parent.copy(),
        begins=begins.astype(bool),
        ending=ending.copy(),
        unit_power=compiled.unit_power,
        escape_length=escape_length,
        ledger=ledger,
        cut=np.flatnonzero(raw.cut),
    )


def _size(scene: Scene) -> float:
    """Return the diagonal in metres of a box around everything, 1 for a point alone."""
    boxes = [(np.array(e.position), e.reach) for e in scene.element]
    boxes += [(np.array(s.position), s.reach) for s in scene.source]
    low = np.min([at - reach for at, reach in boxes], axis=0)
    high = np.max([at + reach for at, reach in boxes], axis=0)
    return float(np.linalg.norm(high - low)) or 1.0


def _as_run(scene: Scene, **settings: Any) -> Scene:
    given = {name: value for name, value in settings.items() if value is not None}
    try:
        return dataclasses.replace(scene, run=dataclasses.replace(scene.run, **given))
    except SceneError as error:
        lines = [str(dataclasses.replace(problem, owner="")) for problem in error.problems]
        raise ArgumentError("\n".join(lines)) from None


def _whole(name: str, value: object, least: int, most: int) -> int:
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = least - 1
    if isinstance(value, bool) or not least <= number <= most:
        why = f" ({least} sources launch one each at least)" if name == "rays" and least > 1 else ""
        raise ArgumentError(
            f"{name}: found {show(value)}, expected an integer from {least} to {most}{why}"
        )
    return number
