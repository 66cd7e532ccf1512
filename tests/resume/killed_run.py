"""A run that checkpoints at every wave, to be killed: ``FOLDER BATCHES run|resume``."""

import sys

import photizon_cl as pz
from hostcode.plan import ExecutionPlan
from photizon_cl import checkpoint

folder, batches, verb = sys.argv[1:]
checkpoint.PERIOD = 0.0
checkpoint._SHARE = 1e9
plan = ExecutionPlan(lanes=8, items=2, wave_rays=512)  # a wave for each batch
said = []


def progress(now):
    if not said:
        said.append(now.batches)
        print("tracing", flush=True)


print("ready", flush=True)
if verb == "run":
    pz.trace(
        "box-room", rays_per_batch=512, batches=int(batches), max_seconds=600.0,
        checkpoint=folder, plan=plan, progress=progress,
    )  # fmt: skip
else:
    pz.resume(folder, plan=plan, progress=progress)
