"""What a number in a result file rests on: the device, the versions, the day."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
import re
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hostcode.device.device import DeviceRecord

ROOT = Path(__file__).absolute().parents[1]


def processor() -> str:
    """Return the host processor's name as the system gives it; empty where it gives none."""
    with suppress(OSError):
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
        found = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
        if found:
            return found[1].strip()
    return platform.processor()


def version(package: str) -> str:
    """Return an installed package's version, ``none`` where it is not installed."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "none"


def commit() -> str:
    """Return the checkout's commit, marked ``+changes`` where files differ; empty without git."""
    try:
        said = subprocess.run(
            ["git", "describe", "--always", "--abbrev=10", "--dirty=+changes", "--exclude=*"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=20,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return said.stdout.strip()


def load() -> float | None:
    """Return the system's one-minute load average, None where it has none."""
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None


def facts(record: DeviceRecord) -> dict[str, Any]:
    """Return the conditions of a measurement; no names of machines, people or directories."""
    now = datetime.datetime.now(datetime.UTC)
    return {
        "device": record.name,
        "device_type": record.type,
        "platform": record.platform,
        "platform_version": record.platform_version,
        "driver": record.driver,
        "compute_units": record.compute_units,
        "clock_mhz": record.clock_mhz,
        "native_vector_width_double": record.native_vector_width_double,
        "processor": processor(),
        "host_threads": os.cpu_count(),
        "load_at_start": load(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "packages": {name: version(name) for name in ("numpy", "mako", "pyopencl")},
        "commit": commit(),
        "date": now.strftime("%Y-%m-%d %H:%M UTC"),
    }


def lines(known: dict[str, Any]) -> list[str]:
    """Return the facts as lines of text."""
    packages = ", ".join(f"{name} {number}" for name, number in known["packages"].items())
    units, lanes = known["compute_units"], known["native_vector_width_double"]
    kind = f"{known['device_type']}, {units} compute units, {lanes} native fp64 lanes"
    host = f"{known['processor']}, {known['host_threads']} threads, {known['system']}"
    return [
        f"device     {known['device']} ({kind})",
        f"runtime    {known['platform']}, {known['platform_version']}, driver {known['driver']}",
        f"host       {host}, load {known['load_at_start']} at the start",
        f"software   Python {known['python']}, {packages}, commit {known['commit'] or 'unknown'}",
        f"date       {known['date']}",
    ]


def slug(text: str) -> str:
    """Return a text as a part of a file name."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
