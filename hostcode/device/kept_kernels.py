"""Compiled kernels that are kept from one process to the next, and trusted only where they may be.

A program's files, or its binary, are one file under a digest of everything that they were compiled
from. In it stands the SHA-256 of its content: what does not fit was damaged, is said, removed and
compiled anew. While kept kernels are loaded and first run a mark stands beside them, so that what
ended a process is not loaded again.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import os
import secrets
import shutil
import tempfile
import threading
import warnings
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final

from hostcode.device import kernel_cache
from hostcode.device.capability import is_nvidia
from hostcode.errors import CacheWarning

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pyopencl as cl

    from hostcode.device.opened import OpenDevice

__all__ = ["are_kept", "build", "build_anew", "digest_of", "keep", "program_key"]

_HEAD: Final = b"photizon kernels 1\n"
_BINARY: Final = "binary"
"""Name of what a driver without a cache of its own gave as a program's binary."""


@dataclass
class _Known:
    """A program that was built in this process."""

    folders: set[str]
    digest: str
    seen: list[tuple[str, int, int]] = field(default_factory=list)
    mark: tuple[Path, int] | None = None


_known: dict[str, _Known] = {}
_lock = threading.RLock()


def program_key(device: OpenDevice, source: str, options: Sequence[str]) -> str:
    """Return a digest of everything that a program's binary follows from."""
    text = "\0".join((device.record.key, source, *options, *_added(device)))
    return hashlib.sha256(text.encode()).hexdigest()


def _added(device: OpenDevice) -> list[str]:
    """Return what PoCL adds to the options of every build because the environment names it."""
    return os.environ.get("POCL_EXTRA_BUILD_FLAGS", "").split() if device.record.is_pocl else []


def are_kept(device: OpenDevice) -> bool:
    """Return whether a device's programs are kept here, and not by its driver."""
    # NVIDIA's keeps them in ~/.nv; nothing but the vendor's name tells
    return device.record.is_pocl or not is_nvidia(device.record.vendor)


def build(device: OpenDevice, key: str, source: str, options: Sequence[str]) -> cl.Program:
    """Build a program, from what is kept of it where that is whole.

    Parameters
    ----------
    device : OpenDevice
        The device.
    key : str
        `program_key` of these.
    source : str
        OpenCL.
    options : sequence of str
        Of the compiler.

    Raises
    ------
    pyopencl.Error
        Where the compiler refuses it.
    """
    import pyopencl as cl

    with _lock:  # what the compiler writes meanwhile is this program's
        if not device.record.is_pocl:
            return _build_binary(device, key, source, options)
        found = None if key in _known else _fetch(key)
        there = _folders()
        # named here as well: PoCL finds its directory by the options of the call alone, and would
        # load what was built without them, or with others, in this process
        options = [*options, *_added(device)]
        try:
            program = _built(cl.Program(device.context, source), options)
        except cl.Error:
            if found is None:
                raise
            _refuse(key, found)
            found, there = None, _folders()
            program = _built(cl.Program(device.context, source), options)
        except BaseException:  # an interrupt, which is no fault of what is kept
            if found is not None:
                _unmark(found)
            raise
        made = _folders() - there
        if key not in _known:
            _known[key] = _Known(
                made or (found.folders if found else set()),
                found.digest if found and not made else "",
                mark=found.mark if found else None,
            )
    return program


def build_anew(device: OpenDevice, source: str, options: Sequence[str]) -> cl.Program:
    """Build a program as if none had been kept, and have none of it kept.

    What is kept stays as it is. Runtimes keep programs by text and options: a macro that no text
    asks for, and that is another one each time, lets none of them find it.

    Raises
    ------
    pyopencl.Error
        Where the compiler refuses it.
    """
    import pyopencl as cl

    with _lock:
        program = cl.Program(device.context, source)
        return _built_by_others(program, [*options, f"-DPHOTIZON_{secrets.token_hex(8)}=1"])


def _built(program: cl.Program, options: Sequence[str]) -> cl.Program:
    built: cl.Program = program.build(options=list(options))
    return built


def _built_by_others(program: cl.Program, options: Sequence[str]) -> cl.Program:
    """Build a program with a compiler that also tells that all is well, as Intel's does."""
    import pyopencl as cl

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cl.CompilerWarning)
        return _built(program, options)


def keep(key: str) -> None:
    """Keep a program whose kernels have run; call it when the device has finished.

    Parameters
    ----------
    key : str
        `program_key`; of a program that was built in this process.
    """
    with _lock:
        known = _known.get(key)
        if known is None:
            return
        _unmark(known)
        where = kernel_cache.place()
        if where is None or not known.folders:
            return
        with suppress(OSError):  # a compiler at work in another thread: the next call keeps it
            os.utime(where.running)  # its age tells where its lock does not
            seen = _listing(known.folders, where.running)
            if seen != known.seen:
                content = {name: (where.running / name).read_bytes() for name, *_ in seen}
                known.digest = _write(where, key, content, known.digest)
                known.seen = seen


def digest_of(key: str) -> str:
    """Return the SHA-256 of what is kept of a program, empty where nothing is.

    What is damaged is said and removed.
    """
    found = _read(key)
    return found[0] if found else ""


# -- files -----------------------------------------------------------------------------------------


def _file(key: str) -> Path | None:
    where = kernel_cache.place()
    return None if where is None else where.kept / f"{key}{kernel_cache.KEPT}"


def _read(key: str) -> tuple[str, dict[str, bytes]] | None:
    """Return digest and files of what is kept, or None; damaged files are removed."""
    file = _file(key)
    if file is None:
        return None
    try:
        data = file.read_bytes()
    except OSError:
        return None
    found = _content(data)
    if found is None:
        _drop(file, "are damaged: their digest does not fit")
    return found


def _content(data: bytes) -> tuple[str, dict[str, bytes]] | None:
    start = len(_HEAD) + 65
    digest = hashlib.sha256(data[start:]).hexdigest()
    if data[:start] != _HEAD + digest.encode() + b"\n":
        return None
    table, _, rest = data[start:].partition(b"\n")
    content, at = {}, 0
    for name, size in json.loads(table):
        content[name] = rest[at : at + size]
        at += size
    return digest, content


def _write(where: kernel_cache.Place, key: str, content: dict[str, bytes], old: str) -> str:
    """Write what is kept of a program in one step, and return its digest."""
    table = json.dumps([(name, len(data)) for name, data in content.items()]).encode()
    body = b"\n".join((table, b"".join(content.values())))
    digest = hashlib.sha256(body).hexdigest()
    if digest == old:
        return digest
    handle, name = tempfile.mkstemp(dir=where.running)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(_HEAD + digest.encode() + b"\n" + body)
        os.replace(name, where.kept / f"{key}{kernel_cache.KEPT}")
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise
    return digest


def _drop(file: Path, why: str) -> None:
    with suppress(OSError):
        file.unlink(missing_ok=True)
    warnings.warn(
        f"the kept kernels {file} {why}; they were removed, and are compiled anew",
        CacheWarning,
        stacklevel=3,
    )


# -- PoCL, which works in a directory --------------------------------------------------------------


def _folders() -> set[str]:
    """Return the directories of programs that PoCL has made in this process's directory."""
    where = kernel_cache.place()
    if where is None:
        return set()
    found = set()
    with suppress(OSError):
        for above in list(where.running.iterdir()):
            with suppress(OSError):  # no directory, or one that PoCL just renamed
                found |= {f"{above.name}/{path.name}" for path in above.iterdir() if path.is_dir()}
    return found


def _listing(folders: set[str], running: Path) -> list[tuple[str, int, int]]:
    found = []
    for folder in sorted(folders):
        for path in sorted((running / folder).rglob("*")):
            if path.is_file():
                state = path.stat()
                name = path.relative_to(running).as_posix()
                found.append((name, state.st_size, state.st_mtime_ns))
    return found


def _fetch(key: str) -> _Known | None:
    """Put what is kept of a program where PoCL finds it, with a mark until it has run."""
    where = kernel_cache.place()
    found = _usable(key)
    if where is None or found is None:
        return None
    digest, content = found
    folders = {str(Path(*PurePosixPath(name).parts[:2])) for name in content}
    there, written = _folders(), []
    try:
        for name, data in content.items():
            path = where.running / name
            path.parent.mkdir(parents=True, exist_ok=True)
            # PoCL's directories are by the text without comments, so that another program may have
            # loaded the file that is there: it must not change under it
            if not path.exists():
                written.append(path)
                path.write_bytes(data)
                path.chmod(0o700)
    except BaseException as error:  # a full disk, an interrupt: PoCL must not find half of a file
        for path in written:
            with suppress(OSError):
                path.unlink(missing_ok=True)
        for folder in folders - there:
            shutil.rmtree(where.running / folder, ignore_errors=True)
        if isinstance(error, OSError):
            return None
        raise
    return _Known(folders, digest, mark=_mark(key))


def _usable(key: str) -> tuple[str, dict[str, bytes]] | None:
    """Return what is kept of a program, unless a process died that loaded it."""
    file = _file(key)
    if file is None:
        return None
    marks = f"{key}.{kernel_cache.host_prefix()}*{kernel_cache.TRYING}"
    for mark in list(file.parent.glob(marks)):
        with suppress(OSError):
            handle = os.open(mark, os.O_RDWR)
            try:
                # one that went before its lock did was taken away by a process that lives
                if kernel_cache.hold(handle) and mark.exists():
                    if file.exists():
                        _drop(file, "were being loaded when a process was killed or crashed")
                    mark.unlink(missing_ok=True)
            finally:
                os.close(handle)
    return _read(key)


def _mark(key: str) -> tuple[Path, int] | None:
    """Leave a mark beside what is loaded; a process that dies does not take it away."""
    where = kernel_cache.place()
    if where is None:
        return None
    own = f"{kernel_cache.host_prefix()}{secrets.token_hex(8)}"
    path = where.kept / f"{key}.{own}{kernel_cache.TRYING}"
    try:
        return path, kernel_cache.make_held(path, where.running)
    except OSError:  # without locks nobody could tell whose mark it is
        return None


def _unmark(known: _Known) -> None:
    if known.mark is not None:
        path, handle = known.mark
        known.mark = None
        with suppress(OSError):
            path.unlink(missing_ok=True)
        os.close(handle)


def _refuse(key: str, found: _Known) -> None:
    """Remove what the driver refused, from where it works as well."""
    _unmark(found)
    where, file = kernel_cache.place(), _file(key)
    if where is None or file is None:
        return
    for folder in found.folders:
        shutil.rmtree(where.running / folder, ignore_errors=True)
    _drop(file, "were refused by the driver")


def _end() -> None:
    """Take the marks away at the end of a process that did not crash."""
    for known in _known.values():
        _unmark(known)


atexit.register(_end)


# -- drivers that give binaries --------------------------------------------------------------------


def _build_binary(device: OpenDevice, key: str, source: str, options: Sequence[str]) -> cl.Program:
    """Build a program for a driver that is no PoCL; keep its binary where the driver keeps none."""
    import pyopencl as cl

    kept = are_kept(device)
    found = _usable(key) if kept else None
    if found is not None and _BINARY in found[1]:
        mark = _Known(set(), found[0], mark=_mark(key))
        try:
            binary = found[1][_BINARY]
            program = _built_by_others(
                cl.Program(device.context, [device.device], [binary]), options
            )
        except cl.Error:
            _refuse(key, mark)
        except BaseException:
            _unmark(mark)
            raise
        else:
            _known[key] = mark
            return program
    program = _built_by_others(cl.Program(device.context, source), options)
    where = kernel_cache.place()
    if kept and where is not None:
        with suppress(OSError, cl.Error):
            given: Any = program.get_info(cl.program_info.BINARIES)
            _write(where, key, {_BINARY: bytes(given[0])}, "")
    return program
