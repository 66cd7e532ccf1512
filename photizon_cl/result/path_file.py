"""Path tables in the file of a result: sums by key, and the steps of the strongest paths."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.result.keyed_sums import (
    FOLLOWED,
    MOST_FOLLOWED_VALUES,
    KeyedState,
    admitted,
)
from photizon_cl.result.sums import TOTAL_LIMBS
from photizon_cl.result.trails import Trails

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray as xr
    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.result.statistics import Accumulator

__all__ = ["check_path_shapes", "check_path_sums", "keyed_state", "path_arrays", "trails_of"]

_SUMS: Final = {
    "path_keys": ("keys", ("path",), "i8", "keys of the paths, in order of admission"),
    "path_about": ("about", ("path",), "i8", "detector << 32 | interactions"),
    "path_first": ("first", ("path",), "i8", "number of the first ray that shows it"),
    "path_limbs": ("limbs", ("path", "limb"), "i8", "exact totals"),
    "path_count": ("count", ("path",), "i8", "arrivals"),
    "path_mean": ("mean", ("path",), "f8", "running mean (Welford)"),
    "path_m2": ("m2", ("path",), "f8", "sum of squared deviations (Welford)"),
    "path_values": ("values", ("batch", "followed_path"), "f8", "what each batch gave"),
}
_TRAILS: Final = {
    "trail_keys": ("keys", ("trail",), "i8", "keys of the paths whose steps are known"),
    "trail_ends": ("ends", ("trail",), "i8", "where the steps of each end"),
    "trail_steps": ("steps", ("step",), "i8", "element << 20 | face << 4 | event"),
}


def path_arrays(made: xr.Dataset, keyed: KeyedState | None, trails: Trails | None) -> None:
    """Add the arrays of path tables to those of the tally, where there are any."""
    if keyed is None:
        return
    for name, (attribute, dims, _, text) in _SUMS.items():
        made[name] = (dims, getattr(keyed, attribute), {"long_name": text})
    if trails is not None:
        for name, (attribute, dims, _, text) in _TRAILS.items():
            made[name] = (dims, getattr(trails, attribute), {"long_name": text})


def check_path_shapes(variables: Mapping[str, Any], layout: TallyLayout, cap: int) -> None:
    """See, before any is read, that a file has the path tables of its scene, of possible sizes.

    Raises
    ------
    ValueError
        Where it has not.
    """
    for names in (_SUMS, _TRAILS):
        there = [name for name in names if name in variables]
        if there and not layout.most_paths:
            raise ValueError("it has path tables, and its scene has none")
        if there and len(there) < len(names):
            raise ValueError("parts of its path tables are missing")
        for name in there:
            _, dims, kind, _ = names[name]
            found = variables[name]
            if len(found.shape) != len(dims) or np.dtype(found.dtype) != np.dtype(kind):
                raise ValueError(f"its {name} are {found.dtype} of the shape {tuple(found.shape)}")
    if layout.most_paths and "path_keys" not in variables:
        raise ValueError("its scene has path tables, and it has none")
    if "path_keys" in variables:
        n = variables["path_keys"].shape[0]
        wide = variables["path_values"].shape[1] > min(n, FOLLOWED)
        if n > sum(admitted(layout).values()) or wide:
            raise ValueError("it has more paths than a result keeps")
        for name, (_, dims, _, _) in _SUMS.items():
            shape = tuple(variables[name].shape)
            if dims[0] == "path" and shape not in ((n,), (n, TOTAL_LIMBS)):
                raise ValueError(f"its {name} has the shape {shape}, and it has {n} paths")
        batches = variables["path_values"].shape[0]
        if batches * variables["path_values"].shape[1] > MOST_FOLLOWED_VALUES:
            raise ValueError("it has more of single batches than a result keeps")
    if "trail_keys" in variables:
        n = variables["trail_keys"].shape[0]
        steps = variables["trail_steps"].shape[0]
        if n > layout.most_paths or variables["trail_ends"].shape != (n,):
            raise ValueError("it has steps of more paths than a result shows")
        if steps > n * cap:
            raise ValueError(f"its {n} paths have {steps} steps, and the generation cap is {cap}")


def keyed_state(arrays: Mapping[str, NDArray[Any]]) -> KeyedState | None:
    """Return the sums by key of a file, None where it has none."""
    if "path_keys" not in arrays:
        return None
    return KeyedState(*(arrays[name] for name in _SUMS))


def trails_of(arrays: Mapping[str, NDArray[Any]]) -> Trails | None:
    """Return the steps of paths of a file, None where it has none."""
    if "trail_keys" not in arrays:
        return None
    return Trails(*(arrays[name] for name in _TRAILS))


def check_path_sums(compiled: CompiledScene, tally: Accumulator, trails: Trails | None) -> None:
    """See that paths bring no more than their detectors have, and that steps are those of keys.

    Raises
    ------
    ValueError
        Where they are not.
    """
    sums = tally.keyed
    if sums is None:
        return
    which = sums.about >> 32
    detectors = compiled.layout.detectors
    having = [number for number, d in enumerate(detectors) if d.paths]
    settings = compiled.settings
    if (sums.about & 0xFFFFFFFF > settings.generation_cap).any() or (
        sums.first >= tally.batches * settings.rays_per_batch
    ).any():
        raise ValueError("it has paths of more interactions or rays than there were")
    if not np.isin(which, having).all():
        raise ValueError("it has paths to detectors that have no path table")
    for number in having:
        mine = np.flatnonzero(which == number)
        total = sum(sums.exact(row) for row in mine.tolist())
        count, power = sum(sums.count[mine].tolist()), detectors[number].power
        most, arrivals = tally.exact(power), int(tally.counts(power, 1)[0])
        whole = not sums.full(number)
        if total > most or count > arrivals or (whole and (total, count) != (most, arrivals)):
            raise ValueError("its paths bring another power than their detector has")
    if trails is not None:
        trails.check(
            dict(zip(sums.keys.tolist(), sums.about.tolist(), strict=True)), compiled.scene
        )
