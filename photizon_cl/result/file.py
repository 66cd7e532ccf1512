"""The file of a result: labelled arrays, and the exact integers that they come from.

The top level of the netCDF-4 file holds every array with dimensions, coordinates and units, for any
reader; its group ``tally`` holds the exact integers, with which a run goes on. `read_file` reads
the integers and derives the rest as the run did, so that every number comes back to the bit. A
checkpoint is such a file without the arrays.
"""

from __future__ import annotations

import dataclasses
import errno
import hashlib
import json
import os
import shutil
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.atomic import reason
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.errors import ResultError, printable, show
from photizon_cl.result.arrays import dataset
from photizon_cl.result.estimates import RESULT_SCHEMA, Estimates
from photizon_cl.result.path_file import (
    check_path_shapes,
    check_path_sums,
    keyed_state,
    path_arrays,
    trails_of,
)
from photizon_cl.result.sealing import deaf_libraries_end, seal, sealed
from photizon_cl.result.soundness import (
    check_shapes,
    check_tally,
    integer,
    read_info,
    read_precision,
)
from photizon_cl.result.statistics import Accumulator, AccumulatorState
from photizon_cl.scene.files import load, parse_toml
from photizon_cl.scene.writing import to_toml

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    import h5netcdf
    import xarray as xr
    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.scene.model import Scene

__all__ = [
    "read_file",
    "read_made_by",
    "read_scene",
    "read_scene_text",
    "write_arrays",
    "write_state",
]

_GROUP: Final = "tally"
_LONGEST: Final = 300  # characters of what a library says of a damaged file
_OVERHEAD: Final = 1 << 18  # bytes of a file beside its arrays, rounded up
_TALLIES: Final = "tallies"  # names of the effects with labelled cells among the file's
_STATE: Final = ("limbs", "count", "mean", "m2")
_HISTORY: Final = ("batches", "seconds", "sigma")


def write_arrays(result: Estimates, path: Path) -> None:
    """Write every labelled array, and what a run goes on from."""
    arrays, tally = _named(result, dataset(result)), _tally_dataset(result)
    _check_room(path.parent, arrays, tally)
    _write(arrays, path, "w", None)
    _write(tally, path, "a", _GROUP)
    seal(path)


def write_state(result: Estimates, path: Path) -> None:
    """Write what a run goes on from, and no arrays."""
    import xarray as xr

    tally = _tally_dataset(result)
    _check_room(path.parent, tally)
    _write(_named(result, xr.Dataset()), path, "w", None)
    _write(tally, path, "a", _GROUP, packed=False)
    seal(path)


def _named(result: Estimates, arrays: xr.Dataset) -> xr.Dataset:
    arrays.attrs["schema"] = RESULT_SCHEMA
    arrays.attrs["scene"] = to_toml(result.scene)
    return arrays


def _check_room(folder: Path, *arrays: xr.Dataset) -> None:
    """Refuse before HDF5 runs out of room: it cannot end a file that has none, and may crash."""
    needed = sum(a.nbytes for a in arrays) + _OVERHEAD
    if shutil.disk_usage(folder).free < needed:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _write(
    arrays: xr.Dataset, path: Path, mode: Any, group: str | None, *, packed: bool = True
) -> None:
    how = {"zlib": True, "complevel": 4, "shuffle": True}
    encoding = {name: how for name, a in arrays.variables.items() if packed and a.size > 1024}
    arrays.to_netcdf(path, mode=mode, group=group, engine="h5netcdf", encoding=encoding)


def _tally_dataset(result: Estimates) -> xr.Dataset:
    import xarray as xr

    state, info = result.tally.state(), result.info
    made = xr.Dataset(
        {
            "limbs": (("cell", "limb"), state.limbs, {"long_name": "exact totals"}),
            "count": (("cell",), state.count, {"units": "1", "long_name": "arrivals"}),
            "mean": (("quantity",), state.mean, {"long_name": "running mean (Welford)"}),
            "m2": (("quantity",), state.m2, {"long_name": "sum of squared deviations (Welford)"}),
            **{
                f"history_{name}": (("wave",), result.history[name], {"units": unit})
                for name, unit in zip(_HISTORY, ("1", "s", "1"), strict=True)
            },
        },
        attrs={
            "description": "in launched weights; limbs are of 2^1, 2^-31, 2^-63, 2^-95",
            "batches": state.batches,
            "digest": state.digest.hex(),
            "device": info.device,
            "precision": info.precision,
            "stopped": info.stopped,
            "version": info.version,
            "engine": info.engine,
            # HDF5 has no integers of any length, and its floats would round.
            "interactions": str(info.interactions),
            "worst_closure": str(info.worst_closure),
            "seconds": info.seconds.hex(),
            "build_seconds": info.build_seconds.hex(),
            "goal": json.dumps(
                [info.goal.batches, info.goal.target, info.goal.max_seconds], allow_nan=False
            ),
        },
    )
    if state.batch_values is not None:
        about = {"long_name": "scalars of each batch, in launched weights"}
        made["batch_values"] = (("batch", "scalar"), state.batch_values, about)
    if not info.portable:
        made.attrs["portable"] = "no"
    if info.pilot is not None:
        made.attrs["pilot"] = info.pilot.text()
    if info.forecast is not None:
        made.attrs["forecast"] = info.forecast.text()
    if state.cells is not None:  # of very many cells, those that are not zero
        about = {"long_name": "which cells these are; all others are zero"}
        made["cells"] = (("cell",), state.cells, about)
    # only where there are any: files of scenes without are what they always were
    path_arrays(made, state.keyed, info.trails)
    labelled = result.compiled.layout.labelled
    if labelled:
        made.attrs[_TALLIES] = json.dumps([group.effect for group in labelled])
    arrays = {str(name): made[name].values for name in made.data_vars}
    made.attrs["checksum"] = _checksum(arrays, made.attrs, to_toml(result.scene))
    return made


def _checksum(arrays: Mapping[str, NDArray[Any]], attrs: Mapping[Any, Any], scene: str) -> str:
    """Return a digest over everything that a result is derived from."""
    total = hashlib.sha256(scene.encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        total.update(f"{name} {array.dtype.str} {array.shape}".encode())
        total.update(array.data if array.size else b"")
    for name in sorted(map(str, attrs)):
        if name != "checksum":
            total.update(f"{name}={attrs[name]}\0".encode())
    return total.hexdigest()


# -- reading -------------------------------------------------------------------------------------


def read_file(file: Path) -> Estimates:
    """Return what the result in a file says, with arrays or without.

    Raises
    ------
    ResultError
        Where it cannot be read, is damaged, or is something else.
    """
    with _damage_told(file):
        return _read(file)


def read_scene(file: Path) -> Scene:
    """Return the scene of a file, and read no more of it; raises as `read_file` does."""
    with _damage_told(file), _opened(file) as opened:
        return _scene(_scene_text(opened, file))


def read_scene_text(file: Path) -> str:
    """Return the scene of a file as it was written; raises as `read_file` does."""
    with _damage_told(file), _opened(file) as opened:
        return _scene_text(opened, file)


def read_made_by(file: Path) -> tuple[str, str]:
    """Return which engine made the batches of a file, empty where it is not known, and the mode."""
    with _damage_told(file), _opened(file) as opened:
        attrs = opened[_GROUP].attrs
        return str(attrs.get("engine", "")), str(attrs["precision"])


@contextmanager
def _damage_told(file: Path) -> Iterator[None]:
    """Turn what may come of a file into a ResultError that names it."""
    try:
        yield
    except ResultError:
        raise
    except PermissionError as error:
        raise ResultError(f"{show(str(file))} cannot be read: {reason(error)}") from None
    except MemoryError:
        raise ResultError(f"{show(str(file))} takes more memory than there is") from None
    except Exception as error:  # what HDF5 finds in damaged files comes as anything
        why = str(error).split("\n")[0][:_LONGEST]
        raise ResultError(
            f"{show(str(file))} is damaged or not a photizon result: {printable(why)}"
        ) from error


@contextmanager
def _opened(path: Path) -> Iterator[h5netcdf.File]:
    # of earlier versions' files nothing is known before HDF5 reads them
    with ExitStack() as stack:
        if not sealed(path):
            stack.enter_context(deaf_libraries_end())
        yield stack.enter_context(_hdf5(path))


@contextmanager
def _hdf5(path: Path) -> Iterator[h5netcdf.File]:
    import h5netcdf
    import h5py

    with h5py.File(path, "r") as raw:
        # What h5netcdf asks first: where that fails, it complains once more when it is collected.
        raw.attrs.get("_nc3_strict")
        with h5netcdf.File(raw, "r") as file:
            yield file


def _scene_text(file: h5netcdf.File, path: Path) -> str:
    schema = file.attrs.get("schema")
    if schema != RESULT_SCHEMA:
        raise ResultError(
            f"{show(str(path))}: found the schema {show(schema)}, expected {show(RESULT_SCHEMA)}"
        )
    text = file.attrs["scene"]
    if not isinstance(text, str):
        raise ValueError("its scene is no text")
    return text


def _scene(text: str) -> Scene:
    return load(parse_toml(text))


def _read(path: Path) -> Estimates:
    with _opened(path) as file:
        text = _scene_text(file, path)
        scene = _scene(text)
        group = file[_GROUP]
        attrs = dict(group.attrs)
        compiled = _compiled(path, scene, _tallied(attrs), read_precision(attrs))
        check_shapes(group.variables, compiled.layout, path.stat().st_size)
        cap = compiled.settings.generation_cap
        check_path_shapes(group.variables, compiled.layout, cap)
        arrays = {str(name): np.asarray(group[name][...]) for name in group.variables}
    _check_sum(arrays, attrs, text)
    batches = integer(attrs["batches"], "batches")
    state = AccumulatorState(
        batches,
        **{name: arrays[name] for name in _STATE},
        digest=bytes.fromhex(attrs["digest"]),
        cells=arrays.get("cells"),
        batch_values=arrays.get("batch_values"),
        keyed=keyed_state(arrays),
    )
    tally = Accumulator.of(compiled.layout, state)
    info = read_info(attrs, arrays, compiled.settings)
    info = dataclasses.replace(info, trails=trails_of(arrays))
    check_tally(compiled, state, tally, info)
    check_path_sums(compiled, tally, info.trails)
    return Estimates(compiled, tally, info)


def _tallied(attrs: Mapping[str, Any]) -> set[str]:
    names = json.loads(attrs.get(_TALLIES, "[]"))
    if not (isinstance(names, list) and all(isinstance(name, str) for name in names)):
        raise ValueError(f"its {_TALLIES} are no names")
    return set(names)


def _check_sum(arrays: Mapping[str, NDArray[Any]], attrs: Mapping[str, Any], scene: str) -> None:
    if "checksum" not in attrs:
        # the first version wrote none, and did not say which version it was
        if "version" in attrs or "engine" in attrs:
            raise ValueError("its checksum is missing")
    elif attrs["checksum"] != _checksum(arrays, attrs, scene):
        raise ValueError("its checksum does not fit")


def _compiled(file: Path, scene: Scene, tallied: set[str], precision: str) -> CompiledScene:
    """Return a file's scene with the labelled cells that the file has.

    An effect that came into the table after the file was written has none there.
    """
    known = frozenset(effect.name for effect in EFFECTS if effect.name in tallied)
    compiled = compile_scene(scene, scene.run, known, precision=precision)
    having = {group.effect for group in compiled.layout.labelled}
    gone = sorted(tallied - having)
    if gone:
        raise ResultError(
            f"{show(str(file))} has counts of {', '.join(map(show, gone))}, which this version of "
            "photizon_cl does not know: open it with the version that wrote it, or run the scene "
            "again"
        )
    newer = frozenset(having - tallied)
    if not newer:
        return compiled
    return compile_scene(scene, scene.run, known, newer, precision=precision)
