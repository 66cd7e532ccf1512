"""Four lanes at most for directories whose tests ask for no width: their conftest imports this.

A program of four lanes builds in half the time of one of sixteen. That lanes change no bit is shown
by tests/exact and tests/structure, at every width. ``python tests/narrow.py MODULE …`` is
``python -m MODULE …`` on four lanes.
"""

from __future__ import annotations

import runpy
import sys
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator


def narrow(patch: pytest.MonkeyPatch) -> None:
    """Have what this process traces and probes take four lanes, or fewer where that is usual."""
    from hostcode.device.opened import preferred_lanes

    def four_at_most(*arguments) -> int:
        return min(preferred_lanes(*arguments), 4)

    for place in ("hostcode.run.usual", "photizon_cl.run.probing"):
        patch.setattr(f"{place}.preferred_lanes", four_at_most)


@pytest.fixture(scope="module", autouse=True)
def four_lanes() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        narrow(patch)
        yield


if __name__ == "__main__":
    narrow(pytest.MonkeyPatch())
    del sys.argv[0]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
