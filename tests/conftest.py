"""What the whole suite shares: the device under test, and caches that leave no trace."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

    from hostcode.device.device import DeviceRecord, OpenDevice

ROOT = Path(__file__).resolve().parents[1]

# Before anything touches OpenCL, which reads these once. The suite neither reads nor writes the
# caches of the person who runs it; PoCL's compiled kernels alone are kept between runs, beside
# pytest's own cache, which makes the second run fast. `make clean` makes it cold again.
_cache = tempfile.TemporaryDirectory(prefix="photizon-tests-")
os.environ["XDG_CACHE_HOME"] = _cache.name
os.environ.setdefault("POCL_CACHE_DIR", str(ROOT / ".pytest_cache" / "pocl"))
Path(os.environ["POCL_CACHE_DIR"]).mkdir(parents=True, exist_ok=True)
# No figure may ask for a display.
os.environ.setdefault("MPLBACKEND", "agg")


# A shell that starts the suite in the background has it ignore Ctrl-C, which tests send.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def _remove_cache() -> Iterator[None]:
    yield
    _cache.cleanup()


@pytest.fixture(scope="session")
def device() -> OpenDevice:
    """Return the chosen device, open: that of PHOTIZON_DEVICE, or the best of this machine."""
    from hostcode.device.device import choose, open_device

    return open_device(choose())


@pytest.fixture(scope="session")
def usable_devices() -> list[DeviceRecord]:
    """Return every device of this machine that qualifies and passes its self-test."""
    from hostcode.device.device import enumerate_devices, qualify

    return [record for record in enumerate_devices() if not qualify(record, self_test=True)]


@pytest.fixture(scope="session", params=["debian", "pypi"])
def pocl(request: pytest.FixtureRequest, usable_devices: list[DeviceRecord]) -> DeviceRecord:
    """Return Debian's PoCL, then that of PyPI; skips where one is not installed."""
    for record in usable_devices:
        if record.origin == request.param:
            return record
    pytest.skip(f"no usable PoCL of {request.param} on this machine")


@pytest.fixture
def few_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have results draw two figures: where files matter, two do as well as the six of a room."""
    from photizon_cl.views import figures
    from photizon_cl.views.figures import table

    few = tuple(kind for kind in table.FIGURES if kind.stem in ("ledger", "convergence"))
    for module in (figures, table):
        monkeypatch.setattr(module, "FIGURES", few)


@pytest.fixture(scope="module")
def one_lane() -> Iterator[None]:
    """Have runs take one lane where nothing that is said depends on it: that builds fastest.

    That lanes change no bit is shown by tests/exact and tests/structure, at every width.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hostcode.run.usual.preferred_lanes", lambda *_: 1)
        yield


_quick: dict[str, dict[Any, Any]] = {"_CACHE": {}, "_BUILT": {}}
"""What `hostcode.program.build` has built without optimising; nobody else is to run it."""


@pytest.fixture(scope="session")
def quickly(request: pytest.FixtureRequest) -> Callable[[], AbstractContextManager[None]]:
    """Return a context in which PoCL builds without optimising, here and in processes begun in it.

    A program is there in less than half the time, gives the same bits, and runs 3 to 12 times as
    long: for many programs and few rays each. Not for what is about optimised code: digests of
    presets and of every way to run, the families of hard cases, platforms.
    """

    @contextmanager
    def building() -> Iterator[None]:
        with pytest.MonkeyPatch.context() as patch:
            # whoever asks for slow tests has all of them run what users run
            if "not slow" in request.config.getoption("markexpr"):
                # at each build PoCL adds these to the program's own options
                patch.setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-opt-disable")
                for name, programs in _quick.items():
                    patch.setattr(f"hostcode.program.build.{name}", programs)
            yield

    return building


@pytest.fixture(scope="module")
def built_quickly(quickly: Callable[[], AbstractContextManager[None]]) -> Iterator[None]:
    """Have all programs of a module built so."""
    with quickly():
        yield


@pytest.fixture
def itself_built_quickly(quickly: Callable[[], AbstractContextManager[None]]) -> Iterator[None]:
    """Have those of one test built so, in a module that has others."""
    with quickly():
        yield


@pytest.fixture(scope="session")
def run_python() -> Callable[..., str]:
    """Return a function that runs Python code in a process of its own and gives what it prints."""

    def run(code: str, environment: dict[str, str] | None = None) -> str:
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=ROOT,
            env={**os.environ, **(environment or {})},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode == 0, f"exit status {done.returncode}:\n{done.stderr}"
        return done.stdout

    return run


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Keep on one worker, where there are several, what shares costly fixtures."""
    from xdist.scheduler import LoadFileScheduling

    class Scheduler(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            folder = nodeid.partition("::")[0].rpartition("/")[0]
            # these build the documentation, and reports, once for all files of the directory
            if folder in ("tests/docs", "tests/report"):
                return folder
            # and these a scene of everything
            if nodeid.startswith("tests/structure/test_contract"):
                return "tests/structure/test_contract"
            return str(super()._split_scope(nodeid))

    return Scheduler(config, log)


def pytest_collection_finish() -> None:
    """Leave out of every later collection of garbage what is there until the end of the suite.

    Walking a million objects that live on took one part in 25 of the time of all tests.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("gpu"):
        from hostcode.device.device import enumerate_devices

        if not any(record.type == "gpu" for record in enumerate_devices()):
            pytest.skip("no GPU on this machine")
