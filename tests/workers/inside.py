"""What workers are asked in tests: this runs in their processes."""

from __future__ import annotations

import dataclasses
import os
import sys
import threading
import time
from pathlib import Path

import executors

from photizon_cl.run import distribution
from photizon_cl.run.task import run_task


def pause(seconds):
    """Sleep, and say where."""
    time.sleep(seconds)
    return os.getpid(), threading.get_ident()


def seen():
    """Say what a worker has opened and kept."""
    from photizon_cl.run import task

    engines = getattr(task._mine, "engines", {})
    return {
        "pid": os.getpid(),
        "thread": threading.get_ident(),
        "devices": len(distribution._opened),
        "units": [d.device.max_compute_units for d in distribution._opened.values()],
        "engines": sorted(id(engine) for engine in engines.values()),
        "limits": [os.environ.get(n) for n in ("POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT")],
        "script": getattr(sys.modules["__main__"], "__file__", None),
    }


def wrong_at_first(folder, name, task):
    """Answer as one of `executors.WRONG`; rightly where a task comes again."""
    marker = Path(folder) / str(task.first)
    if marker.exists():
        return run_task(task)
    marker.touch()
    if name == "other batches":
        return run_task(dataclasses.replace(task, first=task.first + task.n))
    return executors.WRONG[name]()(task)


def kept(dask_worker):
    """Return how many answers a Dask worker keeps."""
    return len(dask_worker.data)


def late(seconds, task):
    """Answer, but late."""
    chunk = run_task(task)
    time.sleep(seconds)
    return chunk


def said():
    """Print what no answer must be mistaken for."""
    os.write(1, b"to standard output\n")
    print("and so", flush=True)
    return "answer"


def no_pickle():
    """Return what cannot be sent."""
    return threading.Lock()


def fails():
    """Raise."""
    raise KeyError("what was asked")


def ends():
    """End the process in the middle of a call."""
    os._exit(7)
