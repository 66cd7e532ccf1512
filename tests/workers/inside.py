"""What workers are asked in tests: this runs in their processes."""

from __future__ import annotations

import os
import sys
import threading
import time

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


def wrong(name, task):
    """Answer as one of `executors.WRONG`."""
    return executors.WRONG[name]()(task)


def swapped(task):
    """Answer as if for the batches before."""
    return run_task(executors.dataclasses.replace(task, first=max(task.first - task.n, 0)))


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
