"""Runs that checkpoint at every wave, to be killed.

They are given ``[FOLDER, BATCHES, "run" or "resume", MOMENT]``.
"""

from oracles.kills import Moment, serve

import photizon_cl as pz
from hostcode.program.plan import ExecutionPlan
from photizon_cl.run import simulation  # noqa: F401


def run(folder: str, batches: int, verb: str, moment: tuple[str, int]) -> None:
    plan = ExecutionPlan(lanes=8, items=2, wave_rays=512)  # a wave for each batch
    at = Moment(*moment)
    if verb == "run":
        pz.trace(
            "box-room", rays_per_batch=512, batches=batches, max_seconds=600.0,
            checkpoint=folder, plan=plan, progress=lambda now: at.batch(),
        )  # fmt: skip
    else:
        pz.resume(folder, plan=plan, progress=lambda now: at.batch())


serve(run)
