"""Words for the strongest paths to detectors: their example rays are followed once more."""

from __future__ import annotations

import dataclasses
import warnings
from typing import TYPE_CHECKING

import numpy as np

from hostcode.run.trails import follow_trails
from photizon_cl.errors import PhotizonError, RunWarning
from photizon_cl.result.path_table import strongest
from photizon_cl.result.trails import Trails
from photizon_cl.run.distribution import device_failures, open_chosen

if TYPE_CHECKING:
    from collections.abc import Callable

    from hostcode.device.device import DeviceRecord
    from photizon_cl.result.estimates import Estimates, RunInfo

__all__ = ["with_trails"]


def with_trails(
    result: Estimates, device: DeviceRecord | str | None, interrupted: Callable[[], bool]
) -> RunInfo:
    """Return the info of a result with the steps of the paths that its tables show.

    A path whose example needs too many interactions, and all that are left where the run is
    interrupted, have none. Where this process has no device the tables are there without words.

    Warns
    -----
    RunWarning
        Where no device can be had.
    """
    compiled, sums = result.compiled, result.tally.keyed
    assert sums is not None
    shown = [
        strongest(sums, number, d.paths)
        for number, d in enumerate(compiled.layout.detectors)
        if d.paths
    ]
    mine = np.concatenate(shown)
    keys, rays, interactions = sums.keys[mine], sums.first[mine], sums.about[mine] & 0xFFFFFFFF
    try:
        opened = open_chosen(device)
        with device_failures(opened.record.label):
            steps = follow_trails(opened, compiled.tables, keys, rays, interactions, interrupted)
    except PhotizonError as error:
        warnings.warn(
            f"the paths have no words, since their rays cannot be followed here: {error}",
            RunWarning,
            stacklevel=5,
        )
        return result.info
    return dataclasses.replace(result.info, trails=Trails.of(keys.tolist(), steps))
