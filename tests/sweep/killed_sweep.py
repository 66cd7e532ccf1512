"""Sweeps that checkpoint at every wave, to be killed: ``[FILE, FOLDER, MOMENT]``."""

from oracles.kills import Moment, serve

import photizon_cl as pz
from hostcode.program.plan import ExecutionPlan
from photizon_cl.run import simulation  # noqa: F401
from photizon_cl.studies import sweeps  # noqa: F401
from photizon_cl.studies.sweep_folder import is_sweep
from photizon_cl.studies.sweep_progress import SweepProgress


def run(file: str, folder: str, moment: tuple[str, int]) -> None:
    plan = ExecutionPlan(lanes=8, items=2, wave_rays=512)  # a wave for each batch
    at = Moment(*moment)

    def progress(now: SweepProgress) -> None:
        if now.point is not None:
            at.batch()

    if is_sweep(folder):
        pz.open_sweep(folder).resume(plan=plan, progress=progress, figure=False)
    else:
        pz.sweep(file, out=folder, plan=plan, progress=progress, figure=False)


serve(run)
