"""How a device runs a scene where nobody says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hostcode.device.device import preferred_lanes
from hostcode.program.plan import default_plan

if TYPE_CHECKING:
    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from hostcode.run.tables import DeviceTables

__all__ = ["usual_plan"]


def usual_plan(record: DeviceRecord, tables: DeviceTables) -> ExecutionPlan:
    """Return the plan measured best for a kind of device, at its lane width for these tables."""
    return default_plan(record, preferred_lanes(record, tables.spec.effects))
