"""Results on disk: a directory with a summary, the scene, labelled arrays and figures.

``result.nc`` is the result. Its top level holds every array with dimensions, coordinates and units,
for any reader of netCDF-4; its group ``tally`` holds the exact integers that they come from, with
which a run goes on. `open_result` reads the integers and derives the rest as the run did, so that
every number comes back to the bit.
"""

from __future__ import annotations

import json
import os
import tempfile
import tomllib
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.compile import compile_scene
from photizon_cl.errors import PhotizonError, ResultError, show
from photizon_cl.result import RESULT_SCHEMA, Result, RunInfo
from photizon_cl.result_arrays import dataset
from photizon_cl.scene_io import load, to_toml
from photizon_cl.statistics import Accumulator, AccumulatorState
from photizon_cl.stopping import Goal

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray as xr

__all__ = ["check_target", "open_result", "prepare_target", "save"]

_ARRAYS: Final = "result.nc"
_GROUP: Final = "tally"
_OURS: Final = frozenset({"summary.json", "scene.toml", _ARRAYS, "figures", "recipe.txt"})
_STATE: Final = ("limbs", "count", "mean", "m2")


def check_target(path: str | os.PathLike[str]) -> Path:
    """Return the directory that a result may be written into; makes nothing.

    Raises
    ------
    ResultError
        Where it is a file, or a directory that holds something and no result.
    """
    folder = Path(os.fsdecode(path))
    shown = show(str(folder))
    try:
        if folder.is_symlink() and not folder.exists():
            raise ResultError(f"{shown} is a link that leads nowhere: give another directory")
        if not folder.exists():
            return folder
        if not folder.is_dir():
            raise ResultError(f"{shown} is a file: give a directory to write the result into")
        there = {entry.name for entry in folder.iterdir()}
    except (OSError, ValueError) as error:
        raise ResultError(f"{shown} cannot be used: {_reason(error)}") from None
    if there and _ARRAYS not in there and not there <= _OURS:
        raise ResultError(
            f"{shown} holds files and no photizon result: give a new or empty directory, so that "
            "nothing is overwritten"
        )
    if _ARRAYS in there:
        open_result(folder)  # something else of that name is not ours to replace
    return folder


def prepare_target(path: str | os.PathLike[str]) -> Path:
    """Make the directory that a result will be written into, and see that it can be.

    Raises
    ------
    ResultError
        Where `check_target` refuses it, or nothing can be written there.
    """
    folder = check_target(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ResultError(
            f"{show(str(folder))} cannot be written: {_reason(error)}; give another directory"
        ) from None
    return folder


def save(result: Result, path: str | os.PathLike[str], *, figures: bool = True) -> None:
    """Write a result, see `Result.save`."""
    folder = check_target(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        stale = _figures_of(folder)
        with _replacing(folder / "scene.toml") as temporary:
            temporary.write_text(to_toml(result.scene), encoding="utf-8")
        with _replacing(folder / _ARRAYS) as temporary:
            _write_arrays(result, temporary)
        drawn = _draw(result, folder / "figures") if figures else set()
        for name in stale - drawn:
            (folder / "figures" / name).unlink(missing_ok=True)
        with _replacing(folder / "summary.json") as temporary:
            text = json.dumps(result.summary(), indent=2, ensure_ascii=False, allow_nan=False)
            temporary.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise ResultError(f"{show(str(folder))} cannot be written: {_reason(error)}") from error


def _figures_of(folder: Path) -> set[str]:
    """Return the names of the figures of the result that is in a directory."""
    from photizon_cl.plots import figure_names

    if not (folder / _ARRAYS).exists():
        return set()
    return set(figure_names(open_result(folder)))


def _draw(result: Result, folder: Path) -> set[str]:
    from photizon_cl.plots import draw_all

    folder.mkdir(exist_ok=True)
    names = set()
    for name, draw in draw_all(result):
        with _replacing(folder / name) as temporary:
            draw(temporary)
        names.add(name)
    return names


@contextmanager
def _replacing(target: Path) -> Iterator[Path]:
    """Give a temporary path beside `target` that takes its place when all went well."""
    handle, name = tempfile.mkstemp(prefix=".", suffix=target.suffix, dir=target.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


# -- writing -------------------------------------------------------------------------------------


def _write_arrays(result: Result, path: Path) -> None:
    arrays = dataset(result)
    arrays.attrs["schema"] = RESULT_SCHEMA
    arrays.attrs["scene"] = to_toml(result.scene)
    _write(arrays, path, "w", None)
    _write(_tally_dataset(result), path, "a", _GROUP)


def _write(arrays: xr.Dataset, path: Path, mode: Any, group: str | None) -> None:
    packed = {"zlib": True, "complevel": 4, "shuffle": True}
    encoding = {name: packed for name, a in arrays.variables.items() if a.size > 1024}
    arrays.to_netcdf(path, mode=mode, group=group, engine="h5netcdf", encoding=encoding)


def _tally_dataset(result: Result) -> xr.Dataset:
    import xarray as xr

    state, info = result.tally.state(), result.info
    return xr.Dataset(
        {
            "limbs": (("cell", "limb"), state.limbs, {"long_name": "exact totals"}),
            "count": (("cell",), state.count, {"units": "1", "long_name": "arrivals"}),
            "mean": (("quantity",), state.mean, {"long_name": "running mean (Welford)"}),
            "m2": (("quantity",), state.m2, {"long_name": "sum of squared deviations (Welford)"}),
        },
        attrs={
            "description": "in launched weights; limbs are of 2^1, 2^-31, 2^-63, 2^-95",
            "batches": state.batches,
            "digest": state.digest.hex(),
            "device": info.device,
            "precision": info.precision,
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


# -- reading -------------------------------------------------------------------------------------


def open_result(path: str | os.PathLike[str]) -> Result:
    """Read a result, see `photizon_cl.open_result`."""
    given = Path(os.fsdecode(path))
    shown = show(str(given))
    try:
        file = given / _ARRAYS if given.is_dir() else given
        if not file.is_file():
            what = f"holds no {_ARRAYS}" if given.is_dir() else "is not there"
            raise ResultError(
                f"{shown} {what}: give the directory that a run wrote, or the {_ARRAYS} in it"
            )
    except (OSError, ValueError) as error:
        if isinstance(error, ResultError):
            raise
        raise ResultError(f"{shown} cannot be read: {_reason(error)}") from None
    try:
        return _read(file)
    except ResultError:
        raise
    except (
        OSError,
        ValueError,
        KeyError,
        TypeError,
        PhotizonError,
        tomllib.TOMLDecodeError,
    ) as error:
        raise ResultError(
            f"{shown} is damaged or not a photizon result: {' '.join(str(error).split())}"
        ) from error


def _read(file: Path) -> Result:
    import xarray as xr

    with xr.open_dataset(file, engine="h5netcdf", decode_cf=False) as top:
        if top.attrs.get("schema") != RESULT_SCHEMA:
            found = show(top.attrs.get("schema"))
            raise ResultError(
                f"{show(str(file))}: found the schema {found}, expected {show(RESULT_SCHEMA)}"
            )
        scene = load(tomllib.loads(top.attrs["scene"]))
    with xr.open_dataset(file, engine="h5netcdf", group=_GROUP, decode_cf=False) as group:
        arrays = {name: np.array(group[name].values) for name in _STATE}
        attrs = dict(group.attrs)
    compiled = compile_scene(scene, scene.run)
    layout = compiled.layout
    state = AccumulatorState(int(attrs["batches"]), **arrays, digest=bytes.fromhex(attrs["digest"]))
    if len(state.count) != layout.n_cells:
        raise ValueError(f"{len(state.count)} cells, and its scene has {layout.n_cells}")
    tally = Accumulator.restore(state, [(layout.killed, layout.boosted)])
    info = RunInfo(
        device=str(attrs["device"]),
        precision=str(attrs["precision"]),
        interactions=int(attrs["interactions"]),
        seconds=float.fromhex(attrs["seconds"]),
        build_seconds=float.fromhex(attrs["build_seconds"]),
        worst_closure=int(attrs["worst_closure"]),
        goal=Goal(*json.loads(attrs["goal"])),
    )
    return Result(compiled, tally, info)
