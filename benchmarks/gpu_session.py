"""What the GPU's checks and timings share: the device, the report, what failed."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hostcode.device.device import preferred_lanes
from hostcode.program.plan import default_plan

if TYPE_CHECKING:
    from benchmarks.report import Report
    from hostcode.device.device import OpenDevice
    from hostcode.program.plan import ExecutionPlan


@dataclass
class Session:
    """One run of the checks.

    Parameters
    ----------
    device : OpenDevice
        The device under test.
    report : Report
        Where lines go.
    quick : bool
        Fewer plans, shorter timings.
    deadline : float
        On `time.perf_counter`'s clock; no timing is started behind it.
    until : float
        The same for the part that is under way.
    failures, notes : list of str
        What went wrong, and what is good to know.
    data : dict
        Everything that goes into the JSON file.
    """

    device: OpenDevice
    report: Report
    quick: bool
    deadline: float
    until: float = math.inf
    failures: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    data: dict[str, Any] = field(default_factory=dict)

    def share(self, parts: int) -> None:
        """Set `until` so that the first of so many parts leaves the others as much time."""
        now = time.perf_counter()
        self.until = now + max(self.deadline - now, 0.0) / parts

    @property
    def plan(self) -> ExecutionPlan:
        """The device's default plan."""
        record = self.device.record
        return default_plan(record, preferred_lanes(record))

    def late(self) -> bool:
        """Return whether no new timing may be started."""
        return time.perf_counter() > min(self.until, self.deadline)

    def fail(self, text: str) -> None:
        """Note a failure and print it."""
        self.failures.append(text)
        self.report.say(f"FAILED: {text}")
