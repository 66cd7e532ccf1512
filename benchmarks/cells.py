"""What is measured beside what: compositions, lane widths, scenes; each with a plan that suits it.

Every composition gets the sizes that it likes, so that what is compared is compositions and not
one composition's sizes. Sizes were chosen by measurement on a 2-core CPU with PoCL 3.1; README.md
says how. None of them changes a bit of a result, which every run of the benchmark asserts.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hostcode.device.device import preferred_lanes
from hostcode.program.plan import ExecutionPlan, default_plan

if TYPE_CHECKING:
    from hostcode.device.device import DeviceRecord

SCENES: Final = ("integrating-sphere", "box-room", "ghost-ladder")
LANES: Final = (1, 4, 8, 16)

WHOLE_PATH: Final = "whole path, scalar"
PACKETS: Final = "packets, K large"
PACKETS_4: Final = "packets, K = 4"
PACKETS_1: Final = "packets, K = 1"
CLASSICAL: Final = "classical wavefront"
COMPOSITIONS: Final = (PACKETS, PACKETS_4, PACKETS_1, CLASSICAL)


@dataclass(frozen=True)
class Cell:
    """One thing that is measured.

    Parameters
    ----------
    composition : str
        One of the names above.
    plan : ExecutionPlan
        How.
    cores : int
        Compute units that it runs on.
    default : bool
        Whether this is what a trace does unless it is told otherwise.
    """

    composition: str
    plan: ExecutionPlan
    cores: int
    default: bool = False

    @property
    def lanes(self) -> int:
        """Rays a work-item holds at once."""
        return self.plan.lanes


def composition_plan(
    record: DeviceRecord, composition: str, lanes: int, *, splitting: bool
) -> ExecutionPlan:
    """Return the plan of a composition with the sizes that suit it.

    Parameters
    ----------
    record : DeviceRecord
        The device, with as many compute units as are used.
    composition : str
        One of the names above.
    lanes : int
        Lane width.
    splitting : bool
        Whether rays of the scene split, so that queues grow.
    """
    plan = default_plan(record, lanes)
    gpu = record.type == "gpu"
    if composition == PACKETS:
        return plan
    if composition in (PACKETS_4, PACKETS_1):
        # Few steps a launch: many more lanes must be in flight, or launches are all there is.
        items = plan.items if gpu else 512 * record.compute_units
        steps = 4 if composition == PACKETS_4 else 1
        return plan.with_(max_bounces=steps, items=items, stack_rays=4 * lanes)
    if composition == CLASSICAL:
        if splitting and not gpu:  # two places a ray: a smaller wave stays in the caches
            return plan.with_(composition="classical", wave_rays=16384)
        return plan.with_(composition="classical")
    if composition == WHOLE_PATH:
        rays = 1 << 20 if gpu else 1 << 18
        return plan.with_(
            composition="whole-path",
            lanes=1,
            refill=1,
            wave_rays=rays // 4 if splitting else rays,
            local_size=64,
            stack_rays=8,
        )
    raise ValueError(composition)


def part(record: DeviceRecord, cores: int) -> DeviceRecord:
    """Return the record as if the device had so many compute units: plans are sized by them."""
    return dataclasses.replace(record, compute_units=cores)


def cells(
    record: DeviceRecord,
    cores: tuple[int, ...],
    *,
    splitting: bool,
    lanes: tuple[int, ...] = LANES,
    compositions: tuple[str, ...] = COMPOSITIONS,
) -> list[Cell]:
    """Return the cells of a scene: the scalar whole path first, then compositions by lane width.

    The device's default is among them, whatever it is.
    """
    preferred = preferred_lanes(record)
    made: list[Cell] = []
    for n in cores:
        of = part(record, n)
        default = default_plan(of, preferred)
        first = composition_plan(of, WHOLE_PATH, 1, splitting=splitting)
        made.append(Cell(WHOLE_PATH, first, n, first == default))
        for composition in compositions:
            for width in lanes:
                plan = composition_plan(of, composition, width, splitting=splitting)
                made.append(Cell(composition, plan, n, plan == default))
        if not any(cell.default and cell.cores == n for cell in made):
            made.append(Cell("default", default, n, default=True))
    return made
