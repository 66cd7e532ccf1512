"""Four lanes at most for directories whose tests ask for no width: their conftest imports this.

A program of four lanes builds in half the time of one of sixteen. That lanes change no bit is shown
by tests/exact and tests/structure, at every width.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(scope="module", autouse=True)
def four_lanes() -> Iterator[None]:
    """Have what this process traces and probes take four lanes, or fewer where that is usual."""
    from hostcode.device.opened import preferred_lanes

    def narrow(*arguments) -> int:
        return min(preferred_lanes(*arguments), 4)

    with pytest.MonkeyPatch.context() as patch:
        for place in ("hostcode.run.usual", "photizon_cl.run.probing"):
            patch.setattr(f"{place}.preferred_lanes", narrow)
        yield
