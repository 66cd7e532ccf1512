"""Words for the strongest paths to detectors: their example rays are followed once more."""

from __future__ import annotations

import dataclasses
import time
import warnings
from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.run.trails import follow_trails
from photizon_cl.errors import PhotizonError, RunWarning
from photizon_cl.result.path_sums import strongest
from photizon_cl.result.trails import Trails
from photizon_cl.run.distribution import device_failures, open_chosen

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from hostcode.device.device import DeviceRecord
    from photizon_cl.result.estimates import Estimates, RunInfo

__all__ = ["missing", "with_trails"]

_SECONDS: Final = 60.0
"""For following rays where nothing else limits the run."""


def shown(result: Estimates) -> NDArray[np.intp]:
    """Return which rows of the sums by key the path tables show."""
    sums = result.tally.keyed
    if sums is None:
        return np.empty(0, np.intp)
    detectors = enumerate(result.compiled.layout.detectors)
    parts = [strongest(sums, number, d.paths) for number, d in detectors if d.paths]
    return np.asarray(np.concatenate(parts), np.intp)


def missing(result: Estimates) -> NDArray[np.intp]:
    """Return which rows of the sums by key a path table shows and no steps are known of."""
    rows = shown(result)
    sums, trails = result.tally.keyed, result.info.trails
    if sums is None or trails is None:
        return rows
    return np.asarray(rows[~np.isin(sums.keys[rows], trails.keys)], np.intp)


def with_trails(
    result: Estimates, device: DeviceRecord | str | None, seconds: float | None = None
) -> RunInfo:
    """Return the info of a result with the steps of the paths that its tables show.

    Those that are known already are kept where they are still shown. A path whose example needs too
    many interactions, and all that are left when the time is over, have none. Where this process
    has no device, or no memory, the tables are there without words.

    Parameters
    ----------
    result : Estimates
        The result.
    device : DeviceRecord, str or None
        Where.
    seconds : float, optional
        Time for it, once the program is built.

    Warns
    -----
    RunWarning
        Where rays cannot be followed, or not all of them in time.
    """
    compiled, sums, info = result.compiled, result.tally.keyed, result.info
    rows = missing(result)
    if sums is None or not len(rows):
        return info
    keys, rays, interactions = sums.keys[rows], sums.first[rows], sums.about[rows] & 0xFFFFFFFF
    until: list[float] = []

    def over() -> bool:
        now = time.perf_counter()
        if not until:  # the first time it is asked, the program is there
            until.append(now + (_SECONDS if seconds is None else seconds))
        return now > until[0]

    why = ""
    found: Sequence[NDArray[np.int64] | None] = [None] * len(rows)
    try:
        opened = open_chosen(device)
        with device_failures(opened.record.label):
            found = follow_trails(opened, compiled.tables, keys, rays, interactions, over)
    except (PhotizonError, MemoryError) as error:
        why = str(error) or "no memory was left"
    silent = sum(steps is None for steps in found)
    if not why and silent and until and time.perf_counter() > until[0]:
        why = f"there was no time for {silent} of {len(rows)}; `photizon resume` follows them"
    if why:
        text = f"paths have no words where their example rays are not followed: {why}"
        warnings.warn(text, RunWarning, stacklevel=5)
    trails = Trails.of(keys.tolist(), found)
    if info.trails is not None:
        trails = info.trails.and_these(trails, sums.keys[shown(result)])
    return dataclasses.replace(info, trails=trails)
