"""Results on disk: a directory with a summary, the scene, labelled arrays and figures.

``result.nc`` is the result. Its top level holds every array with dimensions, coordinates and units,
for any reader of netCDF-4; its group ``tally`` holds the exact integers that they come from, with
which a run goes on. `open_result` reads the integers and derives the rest as the run did, so that
every number comes back to the bit.

While a run is under way, ``checkpoint.nc`` stands there as well, see `photizon_cl.checkpoint`.
"""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import shutil
import tempfile
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.atomic import TEMPORARY, reason, replacing
from photizon_cl.compile import compile_scene
from photizon_cl.errors import ResultError, show
from photizon_cl.result import RESULT_SCHEMA, Result, RunInfo
from photizon_cl.result_arrays import dataset
from photizon_cl.scene_io import load, to_toml
from photizon_cl.statistics import Accumulator, AccumulatorState
from photizon_cl.stopping import Goal

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr

__all__ = [
    "CHECKPOINT",
    "check_target",
    "open_result",
    "prepare_target",
    "read",
    "save",
    "unfinished",
    "write_state",
]

CHECKPOINT: Final = "checkpoint.nc"
"""The file of a run that is under way, or was killed."""
_ARRAYS: Final = "result.nc"
_GROUP: Final = "tally"
_OVERHEAD: Final = 1 << 18  # bytes of a file beside its arrays, rounded up
_OURS: Final = frozenset(
    {
        "summary.json",
        "scene.toml",
        _ARRAYS,
        CHECKPOINT,
        "figures",
        "recipe.txt",
        "ledger.csv",
        "detectors.csv",
    }
)
_STATE: Final = ("limbs", "count", "mean", "m2")
_HISTORY: Final = ("batches", "seconds", "sigma")


def check_target(path: str | os.PathLike[str], result: Result | None = None) -> Path:
    """Return the directory that a result may be written into; makes nothing.

    Parameters
    ----------
    path : str or path
        The directory.
    result : Result, optional
        What is to be written there; its own checkpoint may be there.

    Raises
    ------
    ResultError
        Where it is a file, or a directory that holds something and no result, or one with the
        checkpoint of another run.
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
        there = {e.name for e in folder.iterdir() if not e.name.startswith(TEMPORARY)}
    except (OSError, ValueError) as error:
        if isinstance(error, ResultError):
            raise
        raise ResultError(f"{shown} cannot be used: {reason(error)}") from None
    if there and _ARRAYS not in there and not there <= _OURS:
        raise ResultError(
            f"{shown} holds files and no photizon result: give a new or empty directory, so that "
            "nothing is overwritten"
        )
    if _ARRAYS in there:
        read(folder)  # something else of that name is not ours to replace
    if CHECKPOINT in there:
        _check_unfinished(folder, result)
    return folder


def _check_unfinished(folder: Path, result: Result | None) -> None:
    """Refuse to lose the batches of a run that was killed."""
    left = _open(folder / CHECKPOINT)
    own = result is not None and (
        left.scene.digest() == result.scene.digest()
        and left.scene.run.seed == result.scene.run.seed
        and left.batches <= result.batches
    )
    if left.batches and not own:
        raise ResultError(
            f"{show(str(folder))} holds an unfinished run of {left.scene.name!r} with "
            f"{left.batches} batches: `photizon resume` goes on with it; to start anew, give "
            f"another directory or remove {CHECKPOINT} there"
        )


def _check_longer(folder: Path, result: Result) -> None:
    """Refuse to lose batches of the very stream that is written."""
    if not (folder / _ARRAYS).is_file():
        return
    there = read(folder)
    same = there.scene.digest() == result.scene.digest() and there.info.engine == result.info.engine
    if same and there.batches > result.batches:
        raise ResultError(
            f"{show(str(folder))} holds {there.batches} batches of this run, more than these "
            f"{result.batches}, and is kept: give another directory, or remove {_ARRAYS} there"
        )


def prepare_target(path: str | os.PathLike[str], result: Result | None = None) -> Path:
    """Make the directory that a result will be written into, and see that it can be.

    Raises
    ------
    ResultError
        Where `check_target` refuses it, or nothing can be written there.
    """
    folder = check_target(path, result)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ResultError(
            f"{show(str(folder))} cannot be written: {reason(error)}; give another directory"
        ) from None
    return folder


def save(
    result: Result,
    path: str | os.PathLike[str],
    *,
    figures: bool = True,
    formats: Sequence[str] = ("png",),
) -> None:
    """Write a result, see `Result.save`."""
    from photizon_cl.csv_tables import detectors_csv, ledger_csv
    from photizon_cl.recipe import Recipe

    folder = check_target(path, result)
    _check_longer(folder, result)
    if figures:
        from photizon_cl.figures import figure_names

        figure_names(result, formats)  # an unknown format is told before anything is written
    try:
        folder.mkdir(parents=True, exist_ok=True)
        stale = _figures_of(folder)
        with replacing(folder / "scene.toml") as temporary:
            temporary.write_text(to_toml(result.scene), encoding="utf-8")
        with replacing(folder / _ARRAYS) as temporary:
            _write_arrays(result, temporary)
            # never beside another run's arrays
            for name in ("summary.json", "recipe.txt", "ledger.csv", "detectors.csv"):
                (folder / name).unlink(missing_ok=True)
        (folder / CHECKPOINT).unlink(missing_ok=True)  # the result holds as much and more
        with replacing(folder / "recipe.txt") as temporary:
            temporary.write_text(Recipe.of(result).token + "\n", encoding="ascii")
        with replacing(folder / "ledger.csv") as temporary:
            temporary.write_text(ledger_csv(result), encoding="utf-8", newline="")
        if result.detectors:
            with replacing(folder / "detectors.csv") as temporary:
                temporary.write_text(detectors_csv(result), encoding="utf-8", newline="")
        with replacing(folder / "summary.json") as temporary:
            text = json.dumps(result.summary(), indent=2, ensure_ascii=False, allow_nan=False)
            temporary.write_text(text + "\n", encoding="utf-8")
        _drop_report(folder / "report.html")
        drawn = _draw(result, folder / "figures", formats) if figures else set()
        for name in stale - drawn:
            (folder / "figures" / name).unlink(missing_ok=True)
    except OSError as error:
        raise ResultError(f"{show(str(folder))} cannot be written: {reason(error)}") from error


def _drop_report(page: Path) -> None:
    """Remove the report of the result before; nobody else's page."""
    from photizon_cl.report.writing import is_report

    if page.is_file() and is_report(page):
        page.unlink()


def _figures_of(folder: Path) -> set[str]:
    """Return the names of the figures of the result that is in a directory."""
    from photizon_cl.figures import FORMATS, figure_names

    if not (folder / _ARRAYS).exists():
        return set()
    return set(figure_names(read(folder), FORMATS))


def _draw(result: Result, folder: Path, formats: Sequence[str]) -> set[str]:
    from photizon_cl.figures import draw_all

    folder.mkdir(exist_ok=True)
    names = set()
    for name, draw in draw_all(result, formats):
        with replacing(folder / name) as temporary:
            draw(temporary)
        names.add(name)
    return names


# -- writing -------------------------------------------------------------------------------------


def _write_arrays(result: Result, path: Path) -> None:
    arrays, tally = _named(result, dataset(result)), _tally_dataset(result)
    _check_room(path.parent, arrays, tally)
    _write(arrays, path, "w", None)
    _write(tally, path, "a", _GROUP)


def write_state(result: Result, path: Path) -> None:
    """Write what a run goes on from, and no arrays."""
    import xarray as xr

    tally = _tally_dataset(result)
    _check_room(path.parent, tally)
    _write(_named(result, xr.Dataset()), path, "w", None)
    _write(tally, path, "a", _GROUP, packed=False)


def _named(result: Result, arrays: xr.Dataset) -> xr.Dataset:
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


def _tally_dataset(result: Result) -> xr.Dataset:
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
    made.attrs["checksum"] = _checksum(made, to_toml(result.scene))
    return made


def _checksum(tally: xr.Dataset, scene: str) -> str:
    """Return a digest over everything that a result is derived from."""
    total = hashlib.sha256(scene.encode())
    for name in sorted(map(str, tally.data_vars)):
        array = np.ascontiguousarray(tally[name].values)
        total.update(f"{name} {array.dtype.str} {array.shape}".encode() + array.tobytes())
    for name in sorted(map(str, tally.attrs)):
        if name != "checksum":
            total.update(f"{name}={tally.attrs[name]}\0".encode())
    return total.hexdigest()


# -- reading -------------------------------------------------------------------------------------


def open_result(path: str | os.PathLike[str]) -> Result:
    """Read a result, see `photizon_cl.open_result`."""
    given = Path(os.fsdecode(path))
    left = unfinished(given) if given.name != _ARRAYS else None
    if left is None:
        return read(given)
    if (given / _ARRAYS).is_file():
        found = read(given)
        same = found.scene.digest() == left.scene.digest()
        if same and found.scene.run.seed == left.scene.run.seed:
            return left if left.batches > found.batches else found
        raise ResultError(
            f"{show(str(given))} holds a result of {found.scene.name!r} and an unfinished run of "
            f"{left.scene.name!r} (seed {left.scene.run.seed}) over it: `photizon resume` ends the "
            f"run; the {_ARRAYS} in it is the older result"
        )
    if not left.batches:
        raise ResultError(
            f"{show(str(given))} holds a run that was ended before its first batch: `photizon "
            "resume` starts it again"
        )
    return left


def unfinished(path: str | os.PathLike[str]) -> Result | None:
    """Return what the checkpoint in a directory holds, perhaps no batch; None without one.

    Raises
    ------
    ResultError
        Where it is damaged.
    """
    file = Path(os.fsdecode(path)) / CHECKPOINT
    try:
        there = file.is_file()
    except (OSError, ValueError):  # what is wrong with the path, `read` tells
        there = False
    return _open(file) if there else None


def read(path: str | os.PathLike[str]) -> Result:
    """Return the result in a directory, or in the ``result.nc`` of one."""
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
        raise ResultError(f"{shown} cannot be read: {reason(error)}") from None
    return _open(file)


def _open(file: Path) -> Result:
    try:
        return _read(file)
    except ResultError:
        raise
    except PermissionError as error:
        raise ResultError(f"{show(str(file))} cannot be read: {reason(error)}") from None
    except Exception as error:  # what HDF5 finds in damaged files comes as anything
        raise ResultError(
            f"{show(str(file))} is damaged or not a photizon result: {' '.join(str(error).split())}"
        ) from error


def _read(file: Path) -> Result:
    import xarray as xr

    with xr.open_dataset(file, engine="h5netcdf", decode_cf=False) as top:
        if top.attrs.get("schema") != RESULT_SCHEMA:
            found = show(top.attrs.get("schema"))
            raise ResultError(
                f"{show(str(file))}: found the schema {found}, expected {show(RESULT_SCHEMA)}"
            )
        text = str(top.attrs["scene"])
        scene = load(tomllib.loads(text))
    with xr.open_dataset(file, engine="h5netcdf", group=_GROUP, decode_cf=False) as group:
        arrays = {name: np.array(group[name].values) for name in _STATE}
        history = [  # results of the first version have none
            group[f"history_{name}"].values.tolist() if f"history_{name}" in group else []
            for name in _HISTORY
        ]
        attrs = dict(group.attrs)
        # files of the first version have none
        if attrs.get("checksum", "") and attrs["checksum"] != _checksum(group, text):
            raise ValueError("its checksum does not fit")
    compiled = compile_scene(scene, scene.run)
    layout = compiled.layout
    state = AccumulatorState(int(attrs["batches"]), **arrays, digest=bytes.fromhex(attrs["digest"]))
    if len(state.count) != layout.n_cells:
        raise ValueError(f"{len(state.count)} cells, and its scene has {layout.n_cells}")
    tally = Accumulator.restore(state, [(layout.killed, layout.boosted)])
    info = RunInfo(
        device=str(attrs["device"]),
        precision=str(attrs["precision"]),
        stopped=str(attrs.get("stopped", "")),
        version=str(attrs.get("version", "")),
        engine=str(attrs.get("engine", "")),
        interactions=int(attrs["interactions"]),
        seconds=float.fromhex(attrs["seconds"]),
        build_seconds=float.fromhex(attrs["build_seconds"]),
        worst_closure=int(attrs["worst_closure"]),
        goal=Goal(*json.loads(attrs["goal"])),
        history=tuple(
            (b, t, None if math.isnan(s) else s) for b, t, s in zip(*history, strict=True)
        ),
    )
    return Result(compiled, tally, info)
