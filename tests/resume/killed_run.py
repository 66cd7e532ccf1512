"""Runs that checkpoint at every wave, to be killed: each a process of its own.

A line ``[FOLDER, BATCHES, "run" or "resume"]`` on standard input forks one, which says ``ready``
and its number, then ``tracing``; the next line asks how it ended. What is imported is imported
once: Python does not start anew for each run, and more kills fall into what is ours.
"""

import json
import os
import sys
import traceback

import h5netcdf  # noqa: F401
import pyopencl  # noqa: F401  (imported, and not asked for anything: it would not survive the fork)
import xarray  # noqa: F401

import photizon_cl as pz
from hostcode.program.plan import ExecutionPlan
from photizon_cl.run import (
    checkpoint,
    simulation,  # noqa: F401
)


def run(folder: str, batches: int, verb: str) -> None:
    checkpoint.PERIOD = 0.0
    checkpoint._SHARE = 1e9
    plan = ExecutionPlan(lanes=8, items=2, wave_rays=512)  # a wave for each batch
    said = []

    def progress(now):
        if not said:
            said.append(now.batches)
            print("tracing", flush=True)

    print(f"ready {os.getpid()}", flush=True)
    if verb == "run":
        pz.trace(
            "box-room", rays_per_batch=512, batches=batches, max_seconds=600.0,
            checkpoint=folder, plan=plan, progress=progress,
        )  # fmt: skip
    else:
        pz.resume(folder, plan=plan, progress=progress)


while line := sys.stdin.readline():
    process = os.fork()
    if process == 0:
        try:
            run(*json.loads(line))
        except BaseException:
            traceback.print_exc()
            print("failed", flush=True)  # for who waits for a word
        os._exit(0)
    sys.stdin.readline()  # not waited for before: its number stays its own until it is killed
    _, status = os.waitpid(process, 0)
    print("ended", os.waitstatus_to_exitcode(status), flush=True)
