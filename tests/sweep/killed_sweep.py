"""Sweeps that checkpoint at every wave, to be killed: each a process of its own.

A line ``[FILE, FOLDER]`` on standard input forks one, which begins the sweep or goes on with it; it
says ``ready`` and its number, ``running`` after its first batch, and
``done``. The next line asks how it ended.
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
from photizon_cl.run import checkpoint, simulation  # noqa: F401
from photizon_cl.studies import sweeps  # noqa: F401
from photizon_cl.studies.sweep_folder import is_sweep


def run(file: str, folder: str) -> None:
    checkpoint.PERIOD = 0.0
    checkpoint._SHARE = 1e9
    plan = ExecutionPlan(lanes=8, items=2, wave_rays=512)  # a wave for each batch
    said = []

    def progress(now):
        if not said and now.point is not None:  # its program has been loaded
            said.append(now.number)
            print("running", flush=True)

    print(f"ready {os.getpid()}", flush=True)
    if is_sweep(folder):
        pz.open_sweep(folder).resume(plan=plan, progress=progress, figure=False)
    else:
        pz.sweep(file, out=folder, plan=plan, progress=progress, figure=False)
    print("done", flush=True)


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
