"""Which devices are known to have passed their self-test, and how fast, between processes.

They are in ``$XDG_CACHE_HOME/photizon_cl/selftest.json`` (default ``~/.cache``), by device and
driver. A file that is absent, damaged or cannot be written costs a test, nothing else.
"""

from __future__ import annotations

import json
import os
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Final

from hostcode.device.kernel_cache import cache_home

__all__ = ["cache_file", "count", "forget", "of", "rate_of", "remember", "remember_rate"]


def cache_file() -> Path:
    """Return the file that remembers passes; neither it nor its directory need exist."""
    return cache_home() / "photizon_cl" / "selftest.json"


def count() -> int:
    """Return how many devices are remembered to have passed."""
    return len(_read(_PASSED))


def forget() -> int:
    """Have every device tested again; return how many were remembered."""
    known = count()
    with suppress(OSError):
        cache_file().unlink(missing_ok=True)
    return known


def of(key: str, *, single: bool = False) -> str:
    """Return what is remembered of a device's pass, empty where nothing is.

    Parameters
    ----------
    key : str
        Of the device's record.
    single : bool
        Whether of the test of its single precision.
    """
    return _read(_SINGLE if single else _PASSED).get(key, "")


def remember(key: str, verdict: str, *, single: bool = False) -> None:
    """Remember a pass.

    Parameters
    ----------
    key : str
        Of the device's record.
    verdict : str
        What the pass is about.
    single : bool
        Whether of the test of its single precision.
    """
    _write(_SINGLE if single else _PASSED, key, verdict)


def rate_of(key: str, test: str) -> float | None:
    """Return a device's rate that was measured with a version of the test, or None.

    Parameters
    ----------
    key : str
        Of the device's record.
    test : str
        What was timed.
    """
    version, _, rate = _read(_RATES).get(key, "").partition(" ")
    try:
        return float(rate) if version == test else None
    except ValueError:
        return None


def remember_rate(key: str, test: str, rate: float) -> None:
    """Remember a device's rate, as `rate_of` gives it."""
    _write(_RATES, key, f"{test} {rate!r}")


_PASSED: Final = "passed"
_SINGLE: Final = "passed_single"
_RATES: Final = "rates"


def _write(part: str, key: str, value: str) -> None:
    # A cache directory that cannot be written costs a second at the next start, nothing else.
    with suppress(OSError, RuntimeError):
        path = cache_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        content: dict[str, object] = {"schema": 1}
        content |= {name: _read(name) for name in (_PASSED, _SINGLE, _RATES)}
        content[part] = {**_read(part), key: value}
        # Written beside and renamed, so that another process never reads half a file.
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".tmp")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                json.dump(content, file, indent=1, sort_keys=True)
            os.replace(name, path)
        except OSError:
            Path(name).unlink(missing_ok=True)
            raise


def _read(part: str) -> dict[str, str]:
    try:
        content = json.loads(cache_file().read_text(encoding="utf-8"))
        return {str(key): str(value) for key, value in content[part].items()}
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RuntimeError):
        return {}  # absent, unreadable, damaged, or no home directory: the test simply runs
