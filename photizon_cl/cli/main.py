"""The command line: ``photizon VERB …``.

Exit status 0 success, 1 a run failed, 2 bad input. What the person asked for goes to standard
output, everything else to standard error; bad input gives messages, never a traceback.

A verb is a row of `VERBS` and a module with two functions, ``add_arguments(parser)`` and
``call(arguments)``, which returns the exit status. The module is imported when its verb is used,
and imports what is heavy only in ``call``: help and bad input answer at once.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
import warnings
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final, NoReturn

from hostcode.errors import CacheWarning
from photizon_cl.errors import PhotizonError, RunWarning, printable, printable_lines
from photizon_cl.run.interruption import ends_a_run
from photizon_cl.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

__all__ = ["VERBS", "main", "parser"]

_DESCRIPTION: Final = (
    "Non-sequential Monte-Carlo ray tracing for illumination and stray light: power, irradiance "
    "and intensity with error bars."
)

VERBS: Final = (
    (
        "presets",
        "list the presets with the anchor that each pins, or print one",
        "photizon_cl.cli.presets",
    ),
    (
        "kinds",
        "list what a scene can hold, with parameters, units and defaults",
        "photizon_cl.cli.kinds",
    ),
    (
        "check",
        "validate a scene, print its derived geometry and advisories",
        "photizon_cl.cli.check",
    ),
    ("run", "trace a scene", "photizon_cl.cli.run"),
    ("resume", "go on with a run or a sweep that ended or was killed", "photizon_cl.cli.resume"),
    ("sweep", "trace a scene at many values of its parameters", "photizon_cl.cli.sweep"),
    ("compare", "show how two runs differ, with errors", "photizon_cl.cli.compare"),
    ("paths", "show which paths bring light to detectors, by power", "photizon_cl.cli.paths"),
    (
        "cost",
        "show what accuracy costs in time: settings, σ, bias, seconds",
        "photizon_cl.cli.cost",
    ),
    (
        "effects",
        "show what is compiled for a scene and why, and measure what it costs",
        "photizon_cl.cli.effects",
    ),
    ("recipe", "print a token that reproduces a run bit for bit", "photizon_cl.cli.recipe"),
    (
        "report",
        "write a saved result or sweep as one self-contained HTML page",
        "photizon_cl.cli.report",
    ),
    ("show", "draw a scene with traced ray paths", "photizon_cl.cli.show"),
    (
        "stability",
        "measure hard cases against 60-digit arithmetic",
        "photizon_cl.cli.stability",
    ),
    (
        "devices",
        "list every OpenCL device, whether it qualifies, and why not",
        "photizon_cl.cli.devices",
    ),
    ("cache", "show where compiled kernels are kept, or clear them", "photizon_cl.cli.cache"),
)
"""Name, what it does, and module of every verb, in the order in which help lists them."""


_LONGEST: Final = 500
"""Characters of a message about the arguments."""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line and the exit status of bad input."""

    def error(self, message: str) -> NoReturn:
        # argparse repeats what was given, whatever it holds
        if len(message) > _LONGEST:
            message = message[: _LONGEST - 1] + "…"
        self.exit(2, f"{self.prog}: {printable(message)} (see {self.prog} --help)\n")


class VerbParser(_Parser):
    """The parser of a verb, which asks its module for the arguments when it is first used."""

    module: str = ""

    def fill(self) -> None:
        """Have the arguments declared."""
        if self.module:
            verb = import_module(self.module)
            self.module = ""
            verb.add_arguments(self)
            self.set_defaults(call=verb.call)

    def parse_known_args(self, *args: Any, **kwargs: Any) -> Any:
        """Parse, with the verb's own arguments."""
        self.fill()
        return super().parse_known_args(*args, **kwargs)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = _Parser(prog="photizon", description=_DESCRIPTION, allow_abbrev=False)
    made.add_argument("--version", action="version", version=f"photizon {__version__}")
    verbs = made.add_subparsers(metavar="VERB", required=True, dest="verb", parser_class=VerbParser)
    for name, does, module in VERBS:
        verb = verbs.add_parser(
            name, help=does, description=does[0].upper() + does[1:] + ".", allow_abbrev=False
        )
        verb.module = module
    return made


@contextmanager
def _plain_warnings() -> Iterator[None]:
    """Say what the engine warns of in one line, without the place in its source."""
    usual = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if issubclass(category, CacheWarning | RunWarning):
            print(f"photizon: {printable(str(message))}", file=sys.stderr)
        else:
            usual(message, category, *where, **more)

    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = usual


@contextmanager
def _other_signals() -> Iterator[None]:
    """Have signals that would end the process do what Ctrl-C does: what there is is saved.

    One that was asked to be ignored, as by nohup, stays ignored.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    known = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    ours = [number for number in known if signal.getsignal(number) is signal.SIG_DFL]
    for number in ours:
        signal.signal(number, ends_a_run)
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)


def _open_streams() -> None:
    """Have what was closed (``>&-``) lead nowhere.

    Else text for it has no place, or another one's, and the next file that is opened gets its
    number, and with it whatever a library prints.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
        if getattr(sys, name) is None:
            mode = "w" if number else "r"
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115


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
    _open_streams()
    # A locale that cannot print σ or W/m² must not end a run.
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        arguments, unknown = parser().parse_known_args(argv)
        if unknown:
            _Parser(prog=f"photizon {arguments.verb}").error(
                f"unrecognized arguments: {' '.join(unknown)}"
            )
    except SystemExit as leaving:  # --help, --version, or a message that is out already
        return leaving.code if isinstance(leaving.code, int) else 0
    try:
        with _plain_warnings(), _other_signals():
            status: int = arguments.call(arguments)
        sys.stdout.flush()
        return status
    except PhotizonError as error:
        _tell(printable_lines(str(error)))
        return error.exit_code
    except BrokenPipeError:
        # The reader had enough. Python flushes at its end: give it somewhere to flush to.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # standard output that cannot be written: a full disk, say
        _tell(f"photizon: the output cannot be written ({error.strerror})")
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except MemoryError:  # where others took what was there when it was looked
        _tell("photizon: no memory is left for this; `photizon check SCENE` says what a run takes")
        return 1
    except KeyboardInterrupt:
        _tell("interrupted")
        return 1


def _tell(text: str) -> None:
    """Print to standard error, where that still leads anywhere."""
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
