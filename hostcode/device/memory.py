"""How much memory this process may still take, and what sets the limit."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

__all__ = ["Room", "room"]

_UNLIMITED: Final = 1 << 60
"""Limits from here on are none."""


@dataclass(frozen=True, slots=True)
class Room:
    """Memory that a process may still take.

    Parameters
    ----------
    left : int
        Bytes that are left, beside what it has already.
    limit : int
        Bytes of the limit itself.
    what : str
        What sets it, fit to stand behind "of".
    """

    left: int
    limit: int
    what: str


def room(proc: Path = Path("/proc"), cgroups: Path = Path("/sys/fs/cgroup")) -> Room | None:
    """Return the least of what the limits of process, cgroup and machine leave; None if unknown.

    Parameters
    ----------
    proc, cgroups : Path, optional
        Where Linux tells.
    """
    found = [*_of_process(proc), *_of_cgroup(proc, cgroups), *_of_machine(proc)]
    return min(found, key=lambda room: room.left, default=None)


def _of_process(proc: Path) -> list[Room]:
    """Return what ``ulimit -v`` and ``ulimit -d`` leave."""
    try:
        import resource
    except ImportError:  # a system without
        return []
    found = []
    for which, flag, line in (("RLIMIT_AS", "-v", "VmSize"), ("RLIMIT_DATA", "-d", "VmData")):
        limit, _ = resource.getrlimit(getattr(resource, which))
        if 0 <= limit < _UNLIMITED:
            used = _table(proc / "self" / "status").get(line, 0)
            found.append(Room(max(limit - used, 0), limit, f"`ulimit {flag}`"))
    return found


def _of_machine(proc: Path) -> list[Room]:
    table = _table(proc / "meminfo")
    if "MemAvailable" in table:
        left = table["MemAvailable"]
        return [Room(left, table.get("MemTotal", left), "this machine, of which others have some")]
    with suppress(AttributeError, OSError, ValueError):
        whole = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        return [Room(whole, whole, "this machine")] if whole > 0 else []
    return []


def _of_cgroup(proc: Path, cgroups: Path) -> list[Room]:
    """Return what the cgroup of this process, and those around it, leave; both versions."""
    found = []
    for line in _text(proc / "self" / "cgroup").splitlines():
        number, names, path = [*line.split(":", 2), "", ""][:3]
        if number == "0" and not names:
            base, files, prefix = cgroups, ("memory.max", "memory.current"), ""
        elif "memory" in names.split(","):
            base = cgroups / "memory"
            files, prefix = ("memory.limit_in_bytes", "memory.usage_in_bytes"), "total_"
        else:
            continue
        at = base / path.lstrip("/")
        for folder in (at, *at.parents):
            found += _of_folder(folder, *files, prefix)
            if folder == base:
                break
    return found


def _of_folder(folder: Path, limit_file: str, used_file: str, prefix: str) -> list[Room]:
    limit, used = (_text(folder / name).strip() for name in (limit_file, used_file))
    if not (limit.isascii() and limit.isdigit() and used.isascii() and used.isdigit()):
        return []  # there is none, or "max"
    if int(limit) >= _UNLIMITED:
        return []
    # files that the kernel keeps as long as nobody needs the room, in either of its lists
    names, kept = (f"{prefix}inactive_file", f"{prefix}active_file"), 0
    for line in _text(folder / "memory.stat").splitlines():
        name, _, value = line.partition(" ")
        if name in names and value.strip().isdigit():
            kept += int(value)
    left = int(limit) - int(used) + min(kept, int(used))
    return [Room(max(left, 0), int(limit), "its control group (a container's, say)")]


def _table(file: Path) -> dict[str, int]:
    """Return the lines ``name: number kB`` of a file, in bytes."""
    found = {}
    for line in _text(file).splitlines():
        name, _, rest = line.partition(":")
        words = rest.split()
        if len(words) == 2 and words[1] == "kB" and words[0].isdigit():
            found[name] = int(words[0]) << 10
    return found


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""
