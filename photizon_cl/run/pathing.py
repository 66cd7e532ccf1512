"""Following a few rays: every segment of their paths, for drawing and for debugging."""

from __future__ import annotations

import dataclasses
import math
import operator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.run.paths import Follower, joined, trace_paths
from hostcode.run.tally import values, whole_of
from photizon_cl.checks.precision import DEFAULT, fitting_mode
from photizon_cl.compile.compiled import MAX_RAY_NUMBER, compile_scene
from photizon_cl.errors import ArgumentError, SceneError, show
from photizon_cl.result.paths import Paths
from photizon_cl.result.statistics import complete
from photizon_cl.run.distribution import device_failures, open_chosen
from photizon_cl.run.picking import Wanted
from photizon_cl.scene.files import load
from photizon_cl.scene.settings import MAX_RAYS_PER_BATCH

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping, Sequence

    from hostcode.device.device import DeviceRecord
    from hostcode.run.paths import RawPaths
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.scene.model import Scene

__all__ = ["paths"]

_MOST_SEGMENTS: Final = 2**20


def paths(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    rays: int = 50,
    seed: int | None = None,
    *,
    ending_on: str | None = None,
    via: str | Sequence[str] = (),
    ray_numbers: Sequence[int] | None = None,
    most_launched: int = 1 << 20,
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
        Launched rays. Of fewer than the sources have lines, those of that many lines, evenly
        chosen of a batch in which each line launches one.
    seed : int, optional
        The random stream; default that of the scene's ``[run]``.
    ending_on : str, optional
        Only paths that arrive at this element, by its name, and of these rays only what leads
        there: of the first `rays` launched rays that do. The rays looked at are then those of
        ``photizon_cl.trace(scene, seed=seed)``, with the scene's own rays per batch, one after
        another, so that their numbers are those that a path table gives as examples.
    via : str or sequence of str, optional
        Elements (``window``) or faces (``window.back``) that such a path must all meet.
    ray_numbers : sequence of int, optional
        Only these launched rays of that trace, by number, instead of the first ones.
    most_launched : int, optional
        Rays that are looked at where `ending_on` is given.
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
    least = max(loaded.fewest_rays, 1)
    anew = ending_on is None and ray_numbers is None
    n_rays = _whole("rays", rays, 1, MAX_RAYS_PER_BATCH)
    if anew and n_rays < least:
        ray_numbers = [k * least // n_rays for k in range(n_rays)]
    picked = ending_on is not None or ray_numbers is not None
    if via and ending_on is None:
        raise ArgumentError("via: give ending_on as well, the element that the paths end on")
    most = _whole("max_segments", max_segments, 1, _MOST_SEGMENTS)
    per_batch = max(n_rays, least) if anew else None
    as_run = _as_run(loaded, rays_per_batch=per_batch, seed=seed, generation_cap=generation_cap)
    length = _size(as_run) / 2.0 if escape_length is None else escape_length
    if not (isinstance(length, int | float) and 0.0 < length < math.inf):
        raise ArgumentError(f"escape_length: found {show(length)}, expected a positive length in m")
    compiled = compile_scene(as_run, as_run.run, precision=fitting_mode(precision, as_run).name)
    opened = open_chosen(str(device) if isinstance(device, int) else device)
    names = (via,) if isinstance(via, str) and via else tuple(via)
    wanted = None if ending_on is None else Wanted.of(as_run, ending_on, names)
    if ray_numbers is not None:
        numbers = sorted({_whole("ray_numbers", n, 0, MAX_RAY_NUMBER - 1) for n in ray_numbers})
        launched = [(n, 1) for n in numbers]
    else:
        limit = _whole("most_launched", most_launched, 1, MAX_RAY_NUMBER)
        launched = [(0, limit)]
    with device_failures(opened.record.label):
        if not picked:
            raw = trace_paths(opened, compiled.tables, most)
        else:
            follower = Follower(opened, compiled.tables, most)
            raw = _picked(follower, compiled, launched, wanted, n_rays)
    found = _finish(compiled, raw, float(length))
    return dataclasses.replace(found, ledger={}) if picked else found


def _picked(
    follower: Follower,
    compiled: CompiledScene,
    launched: list[tuple[int, int]],
    wanted: Wanted | None,
    most: int,
) -> RawPaths:
    """Follow ranges of rays, and keep the segments of the paths that are wanted, up to `most`."""
    rays = compiled.settings.rays_per_batch
    parts: list[RawPaths] = []
    left = most
    for begin, n in launched:
        while n and left:
            batch, first = divmod(begin, rays)
            some = min(n, rays - first, follower.at_once)
            for part in follower.follow(batch, first, some):
                found = part if wanted is None else wanted.of_these(part, left)
                if wanted is not None:
                    left -= wanted.rays
                if len(found.ray):
                    parts.append(found)
            begin, n = begin + some, n - some
    return joined(parts, follower.cells())


def _finish(compiled: CompiledScene, raw: RawPaths, escape_length: float) -> Paths:
    path, generation, element, parent, begins, ending, face = raw.wholes.T
    shift = np.array(compiled.shift)
    start, end = raw.reals[:, 0:3] + shift, raw.reals[:, 3:6].copy()
    away = (element < 0) & (face < 0)  # it escapes, or is absorbed on its way out
    end[away] = raw.reals[away, 0:3] + escape_length * end[away]
    layout = compiled.layout
    cells = complete(layout, raw.cells)
    watts = values(whole_of(cells, 0, layout.n_rows)) * compiled.unit_power
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
        cut=raw.cut,
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
        raise ArgumentError(
            f"{name}: found {show(value)}, expected an integer from {least} to {most}"
        )
    return number
