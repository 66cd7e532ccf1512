"""Every check and timing that needs a GPU, in one command: ``make gpu``.

    python3 benchmarks/gpu.py [--out DIR] [--device SELECTOR] [--quick]

Runs on a bare checkout with Python 3.11 or newer, numpy, mako and pyopencl; takes at most eight
minutes, prints the most important facts last and ends with status 0 (all is well), 1 (a check
failed) or 2 (no device to check). ``--device cpu`` takes the same path without a GPU.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).absolute().parents[1]


def main(arguments: list[str] | None = None) -> int:
    summary = "every check and timing that needs a GPU; see benchmarks/README.md"
    parser = argparse.ArgumentParser(prog="benchmarks/gpu.py", description=summary)
    parser.add_argument("--device", default="gpu", help="selector of the device, default gpu")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where the .txt and .json go")
    parser.add_argument("--quick", action="store_true", help="fewer plans and shorter timings")
    parser.add_argument(
        "--seconds", type=float, default=420.0, help="no new timing is started after so many"
    )
    asked = parser.parse_args(arguments)
    # As a script, this directory comes first on the path: the checkout's root belongs there.
    if sys.path and Path(sys.path[0] or ".").absolute() == Path(__file__).absolute().parent:
        sys.path.pop(0)
    sys.path.insert(0, str(ROOT))
    if asked.device == "gpu":
        from benchmarks import icd

        given = sys.argv[1:] if arguments is None else arguments
        icd.start_anew_with_gpu([str(Path(__file__).absolute()), *given])
    try:
        from benchmarks import gpu_run
    except ImportError as error:
        print(f"benchmarks/gpu.py: {error}; install numpy, mako and pyopencl", file=sys.stderr)
        return 2
    from benchmarks import icd

    try:
        return gpu_run.run(asked.device, asked.out, quick=asked.quick, seconds=asked.seconds)
    finally:
        icd.clean()


if __name__ == "__main__":
    sys.exit(main())
