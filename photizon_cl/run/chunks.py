"""What travels between a run and its workers: a task, and the chunk of batches that answers it.

Whoever carries a chunk may lose, repeat, swap or damage it. So a worker seals it, with the numbers
of its batches, the scene, the engine and a checksum over all of that and every cell, and `checked`
holds the seal against the task before anything is added to a result.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.run.keyed import KeyedRows
from hostcode.run.tally import CELL, SparseTally
from photizon_cl.errors import printable
from photizon_cl.result.engine import engine_digest

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from hostcode.run.tables import DeviceTables

__all__ = ["Chunk", "RefusedError", "Seal", "Task", "checked", "numbers", "sealed", "tables_digest"]

_LONGEST_LABEL: Final = 400


class RefusedError(Exception):
    """An answer is not what the task asked for; says why, as a clause that follows "it"."""


@dataclass(frozen=True)
class Seal:
    """What a chunk says of itself.

    Parameters
    ----------
    first, n : int
        Number of the first batch, and how many there are.
    n_cells : int
        Cells of each.
    scene : str
        Digest of the scene, as the task named it.
    tables : str
        Digest of the tables that the worker traced, see `tables_digest`.
    engine : str
        `engine_digest` of the worker.
    checksum : str
        SHA-256 over all of this, the device, and every cell.
    """

    first: int
    n: int
    n_cells: int
    scene: str
    tables: str
    engine: str
    checksum: str = ""


@dataclass(frozen=True, eq=False)
class Chunk:
    """Consecutive batches, computed.

    Parameters
    ----------
    first : int
        Number of the first batch.
    cells : tuple of ndarray, each shape (n_cells, 4), int64, or of SparseTally
        Canonical tallies in batch order.
    device : str
        Label of the device.
    build_seconds : float
        Time that the device's compiler took for the program.
    portable : bool
        Whether the device promises these bits, see `DeviceRecord.promises`.
    seal : Seal or None
        None where it did not leave the process.
    keyed : tuple of KeyedRows
        Cells by key in batch order; empty where the scene keeps none.
    """

    first: int
    cells: tuple[NDArray[np.int64] | SparseTally, ...]
    device: str
    build_seconds: float
    portable: bool = True
    seal: Seal | None = None
    keyed: tuple[KeyedRows, ...] = ()


@dataclass(frozen=True, eq=False)
class Task:
    """A range of batches for a worker. Pickles.

    Parameters
    ----------
    key : str
        Equal for tasks that one engine can serve.
    scene : str
        Digest of the scene.
    digest : str
        That of `tables`, before they were sent.
    tables : DeviceTables
        The compiled scene.
    device : DeviceRecord, str or None
        A device, or what the worker chooses its own by.
    plan : ExecutionPlan or None
        How; None takes the worker's device's default.
    first, n : int
        The range.
    seconds : float or None
        After how long the worker may give the task up, since nobody waits for it any more.
    """

    key: str
    scene: str
    digest: str
    tables: DeviceTables
    device: DeviceRecord | str | None
    plan: ExecutionPlan | None
    first: int
    n: int
    seconds: float | None = None


def numbers(first: int, n: int) -> str:
    """Name a range of batches."""
    return f"batch {first}" if n == 1 else f"batches {first} to {first + n - 1}"


def tables_digest(tables: DeviceTables) -> str:
    """Return a digest of what a scene's tables hold; scene, engine and mode fix the program."""
    modes = tables.spec.real, tables.spec.weight
    total = hashlib.sha256(repr((sorted(tables.launch.items()), tables.n_cells, modes)).encode())
    for name in ("geometry", "materials", "sources", "codes", "detector_numbers", "edges"):
        array = np.ascontiguousarray(getattr(tables, name))
        total.update(f"{name} {array.dtype.str} {array.shape}".encode() + array.tobytes())
    return total.hexdigest()


def _checksum(chunk: Chunk, seal: Seal) -> str:
    told = replace(seal, checksum="")
    total = hashlib.sha256(
        repr((told, chunk.device, chunk.build_seconds.hex(), chunk.portable)).encode()
    )
    for cells in chunk.cells:
        arrays = (cells.numbers, cells.rows) if isinstance(cells, SparseTally) else (cells,)
        for array in arrays:
            total.update(np.ascontiguousarray(array, dtype="<i8").data)
    for rows in chunk.keyed:
        total.update(str(len(rows)).encode())
        for array in rows.arrays:
            total.update(np.ascontiguousarray(array, dtype="<i8").data)
    return total.hexdigest()


def sealed(chunk: Chunk, task: Task, tables: str) -> Chunk:
    """Return a chunk with its seal; what a worker does before it hands it over.

    Parameters
    ----------
    chunk : Chunk
        What was computed.
    task : Task
        What for.
    tables : str
        Digest of the tables that it was computed from.
    """
    seal = Seal(
        chunk.first, len(chunk.cells), task.tables.n_cells, task.scene, tables, engine_digest()
    )
    return replace(chunk, seal=replace(seal, checksum=_checksum(chunk, seal)))


def checked(answer: object, task: Task) -> Chunk:
    """Return the batches that a task asked for, in arrays that nobody else holds.

    Raises
    ------
    RefusedError
        Where the answer is anything else.
    """
    if type(answer) is not Chunk:
        name = printable(type(answer).__name__[:40])
        raise RefusedError(f"is of the type {name} and no chunk of batches")
    try:
        return _checked(answer, task)
    except RefusedError:
        raise
    except Exception as error:  # its parts may be anything
        raise RefusedError(f"cannot be read ({type(error).__name__})") from None


def _checked(chunk: Chunk, task: Task) -> Chunk:
    seal = chunk.seal
    if type(seal) is not Seal:
        raise RefusedError("has no seal")
    for value in (chunk.first, seal.first, seal.n, seal.n_cells):
        if type(value) is not int:
            raise RefusedError("has a seal without numbers")
    # The numbers first: they say best what went wrong.
    if (seal.first, seal.n) != (task.first, task.n) or chunk.first != seal.first:
        raise RefusedError(f"holds {numbers(seal.first, max(seal.n, 1))}")
    if seal.scene != task.scene:
        raise RefusedError("is of another scene")
    if seal.engine != engine_digest():
        found = printable(str(seal.engine)[:16])
        raise RefusedError(
            f"comes from a worker with another version of photizon_cl (engine {found}, here "
            f"{engine_digest()})"
        )
    if seal.tables != task.digest:
        raise RefusedError("was computed from damaged tables")
    cells = chunk.cells
    if type(cells) is not tuple or len(cells) != task.n:
        raise RefusedError(f"does not hold {task.n} tallies")
    if not all(_is_tally(tally, task.tables.n_cells) for tally in cells):
        raise RefusedError("holds something that is no tally of the scene")
    wanted = task.n if task.tables.spec.keyed else 0
    keyed = chunk.keyed
    if type(keyed) is not tuple or len(keyed) != wanted:
        raise RefusedError(f"does not hold {wanted} tables of paths")
    for number, rows in enumerate(keyed, start=task.first):
        if type(rows) is not KeyedRows or not _are_paths(rows, task.tables, number):
            raise RefusedError("holds something that is no table of paths")
    told = type(chunk.device), type(chunk.build_seconds), type(chunk.portable)
    if told != (str, float, bool):
        raise RefusedError("does not say where it was computed")
    label = chunk.device
    if (
        len(label) > _LONGEST_LABEL
        or not label.isprintable()
        or not (math.isfinite(chunk.build_seconds) and chunk.build_seconds >= 0.0)
    ):
        raise RefusedError("does not say where it was computed")
    # Checked is what is kept: whoever made the answer may hold its arrays still.
    kept = replace(
        chunk,
        cells=tuple(tally.copy() for tally in cells),
        keyed=tuple(rows.copy() for rows in keyed),
    )
    if _checksum(kept, seal) != seal.checksum:
        raise RefusedError("is damaged (its checksum does not fit)")
    return kept


def _are_paths(rows: KeyedRows, tables: DeviceTables, batch: int) -> bool:
    """Say whether rows can be a batch's: of its rays and detectors, in canonical form."""
    if not all(type(array) is np.ndarray for array in rows.arrays):
        return False
    cells, launch = rows.rows, tables.launch
    rays, first = int(launch["rays_per_batch"]), rows.first
    which, interactions = rows.about >> 32, rows.about & 0xFFFFFFFF
    place = int(launch["path_tables"]) + which
    return bool(
        (cells[:, :3] >= 0).all()
        and (cells[:, 1:3] < 1 << 32).all()
        and (cells[:, 3] >= 1).all()
        and (first // rays == batch).all()
        and (interactions <= int(launch["generation_cap"])).all()
        and ((which >= 0) & (place < len(tables.codes))).all()
        and (tables.codes[place] == 1).all()
    )


def _is_tally(tally: object, n_cells: int) -> bool:
    """Say whether something is, in form, a tally of so many cells."""
    if type(tally) is SparseTally:
        arrays = (tally.numbers, tally.rows)
        return tally.n_cells == n_cells and all(type(array) is np.ndarray for array in arrays)
    return type(tally) is np.ndarray and tally.dtype == np.int64 and tally.shape == (n_cells, CELL)
