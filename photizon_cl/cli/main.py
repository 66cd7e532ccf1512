"""The command line: ``photizon VERB …``.

Exit status 0 success, 1 a run failed, 2 bad input. What the person asked for goes to standard
output, everything else to standard error; bad input gives messages, never a traceback.
"""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, NoReturn

from hostcode.errors import CacheWarning
from photizon_cl.cli.report import add_arguments as add_report_arguments
from photizon_cl.errors import ArgumentError, PhotizonError
from photizon_cl.stability import add_arguments as add_stability_arguments
from photizon_cl.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

__all__ = ["main"]

_DESCRIPTION: Final = (
    "Non-sequential Monte-Carlo ray tracing for illumination and stray light: power, irradiance "
    "and intensity with error bars."
)
_SCENE: Final = "a preset's name, or a scene file (.toml or .json)"
_DIRECTORY: Final = "the directory that `photizon run --out` wrote"
_DEVICE: Final = "number, type or part of a name, see `photizon devices`"


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line and the exit status of bad input."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="photizon", description=_DESCRIPTION, allow_abbrev=False)
    parser.add_argument("--version", action="version", version=f"photizon {__version__}")
    verbs = parser.add_subparsers(metavar="VERB", required=True, dest="verb")

    def verb(name: str, does: str, call: Callable[[argparse.Namespace], int]) -> Any:
        made = verbs.add_parser(
            name, help=does, description=does[0].upper() + does[1:] + ".", allow_abbrev=False
        )
        made.set_defaults(call=call)
        return made

    verb("presets", "list the presets with the anchor that each pins", _presets)
    check = verb("check", "validate a scene, print its derived geometry and advisories", _check)
    check.add_argument("scene", metavar="SCENE", help=_SCENE)
    _add_run(verb("run", "trace a scene", _run))
    _add_resume(verb("resume", "go on with a run that ended or was killed", _resume))
    recipe = verb("recipe", "print a token that reproduces a run bit for bit", _recipe)
    recipe.add_argument("directory", metavar="DIR", help=_DIRECTORY)
    report = verb("report", "write a saved result as one self-contained HTML page", _report)
    add_report_arguments(report)
    _add_show(verb("show", "draw a scene with traced ray paths", _show))
    stability = verb("stability", "measure hard cases against 60-digit arithmetic", _stability)
    add_stability_arguments(stability)
    verb("devices", "list every OpenCL device, whether it qualifies, and why not", _devices)
    return parser


def _add_run(run: argparse.ArgumentParser) -> None:
    run.add_argument("scene", metavar="SCENE", nargs="?", help=_SCENE)
    run.add_argument("--seed", type=_integer, metavar="N", help="random stream, 0 to 2^64 - 1")
    _add_goal(run, "run exactly N batches")
    run.add_argument(
        "--rays-per-batch", type=_integer, metavar="N", help="rays launched in a batch, up to 2^24"
    )
    run.add_argument("--device", metavar="D", help=_DEVICE)
    run.add_argument("--precision", metavar="P", help="fp64")
    run.add_argument("--out", metavar="DIR", help="write summary, arrays and figures into DIR")
    run.add_argument("--json", action="store_true", help="print the summary as JSON, nothing else")
    run.add_argument(
        "--recipe", metavar="TOKEN",
        help="instead of SCENE and settings: make this run again, bit for bit; a token of "
        "`photizon recipe`, or a file that holds one",
    )  # fmt: skip


def _add_resume(resume: argparse.ArgumentParser) -> None:
    resume.add_argument("directory", metavar="DIR", help=_DIRECTORY)
    _add_goal(resume, "run until there are N batches in all", "more ")
    resume.add_argument("--device", metavar="D", help=_DEVICE)
    resume.add_argument(
        "--json", action="store_true", help="print the summary as JSON, nothing else"
    )


def _add_goal(parser: argparse.ArgumentParser, batches: str, more: str = "") -> None:
    goal = parser.add_mutually_exclusive_group()
    goal.add_argument("--batches", type=_integer, metavar="N", help=batches)
    goal.add_argument(
        "--target", type=_number, metavar="S", help="stop at a median relative σ of S, in (0, 1]"
    )
    parser.add_argument(
        "--max-seconds", type=_number, metavar="T", help=f"stop after T {more}seconds"
    )


def _add_show(show: argparse.ArgumentParser) -> None:
    show.add_argument("scene", metavar="SCENE", help=_SCENE)
    show.add_argument("--rays", type=_integer, default=50, metavar="N", help="rays, default 50")
    show.add_argument("--seed", type=_integer, metavar="N", help="random stream, 0 to 2^64 - 1")
    show.add_argument(
        "--by", choices=("generation", "weight"), default="generation", help="what colours the rays"
    )
    show.add_argument("--device", metavar="D", help=_DEVICE)
    show.add_argument(
        "--out", metavar="FILE", help="a .png, .svg or .pdf file; default NAME.png, here"
    )


def _integer(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected an integer") from None


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a number") from None


# Verbs import what they need: `photizon --help` and bad input answer at once.


def _presets(arguments: argparse.Namespace) -> int:
    from photizon_cl.cli.show import print_presets

    print_presets()
    return 0


def _check(arguments: argparse.Namespace) -> int:
    from photizon_cl.cli.show import print_check
    from photizon_cl.scene.files import load

    print_check(load(arguments.scene))
    return 0


def _devices(arguments: argparse.Namespace) -> int:
    from photizon_cl.cli.show import print_devices

    return print_devices()


def _report(arguments: argparse.Namespace) -> int:
    from photizon_cl.cli.report import report

    return report(arguments)


def _show(arguments: argparse.Namespace) -> int:
    from photizon_cl.cli.draw import draw

    return draw(arguments)


def _stability(arguments: argparse.Namespace) -> int:
    from photizon_cl.stability import run

    return run(arguments)


def _run(arguments: argparse.Namespace) -> int:
    from photizon_cl.cli.run import run

    return run(arguments)


def _resume(arguments: argparse.Namespace) -> int:
    from photizon_cl.cli.run import resume

    return resume(arguments)


def _recipe(arguments: argparse.Namespace) -> int:
    from photizon_cl.result.directory import open_result

    if not arguments.directory:
        raise ArgumentError("DIR: found nothing, expected a directory")
    print(open_result(arguments.directory).recipe)
    return 0


@contextmanager
def _plain_warnings() -> Iterator[None]:
    """Say what the engine warns of in one line, without the place in its source."""
    usual = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if issubclass(category, CacheWarning):
            print(f"photizon: {message}", file=sys.stderr)
        else:
            usual(message, category, *where, **more)

    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = usual


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; default those of the process.

    Returns
    -------
    int
        The exit status.
    """
    # A locale that cannot print σ or W/m² must not end a run.
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        arguments = _parser().parse_args(argv)
    except SystemExit as leaving:  # --help, --version, or a message that is out already
        return leaving.code if isinstance(leaving.code, int) else 0
    try:
        with _plain_warnings():
            status: int = arguments.call(arguments)
        sys.stdout.flush()
        return status
    except PhotizonError as error:
        print(str(error), file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:
        # The reader had enough. Python flushes at its end: give it somewhere to flush to.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # standard output that cannot be written: a full disk, say
        print(f"photizon: the output cannot be written ({error.strerror})", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
