"""Building a program for a device, once a process."""

from __future__ import annotations

import hashlib
import re
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from hostcode.device import kept_kernels, single
from hostcode.errors import KernelBuildError
from hostcode.program.source import hook_name, program_source

if TYPE_CHECKING:
    import pyopencl as cl

    from hostcode.device.device import OpenDevice
    from hostcode.program.spec import ProgramSpec

__all__ = ["OPTIONS", "Program", "build"]

OPTIONS: Final[tuple[str, ...]] = ("-cl-std=CL1.2",)
"""Build options; no ``-cl-*-math`` option may ever stand here."""


@dataclass(frozen=True)
class Program:
    """A program built for one device."""

    spec: ProgramSpec
    source: str
    digest: str
    build_seconds: float
    built: cl.Program
    kept: str

    def keep(self) -> None:
        """Have the compiled kernels kept; call it when they have run and the device is done."""
        kept_kernels.keep(self.kept)

    def binary_bytes(self) -> int | None:
        """Return the size of what the compiler made of it; None where the device does not say."""
        import pyopencl as cl

        try:
            given: Any = self.built.get_info(cl.program_info.BINARIES)
            return sum(map(len, given)) or None
        except (cl.Error, TypeError):
            return None

    def kernel(self, name: str) -> cl.Kernel:
        """Return a new kernel object; keep it, each call makes another."""
        import pyopencl as cl

        return cl.Kernel(self.built, name)


_CACHE: dict[tuple[int, ProgramSpec], Program] = {}
_BUILT: dict[tuple[int, str], Program] = {}
"""By their text: specs that differ in what a text makes no use of have one."""
_MESSAGE = re.compile(
    r'(?:^|\s)"?(?:kernels/(?P<name>[\w/]+\.mako)|(?P<hook>hook \w+ of [\w -]+))"?'
    r":(?P<line>\d+):(?P<rest>.*)"
)


def _build_error(log: str, spec: ProgramSpec) -> KernelBuildError:
    """Turn a compiler's log into an error that points into a template or an effect's statement."""
    from hostcode.assets import kernels_dir

    matches = [m for m in map(_MESSAGE.search, log.splitlines()) if m]
    found = next((m for m in matches if "error" in m["rest"]), matches[0] if matches else None)
    if found is None:
        return KernelBuildError("(program)", None, "the compiler refused it", log)
    name, line = found["name"], int(found["line"])
    if name is None:
        hooks = [(hook_name(part, hook[0]), hook[1]) for part in spec.parts for hook in part.hooks]
        excerpt = "\n".join(f"> {text}" for hook, text in hooks if hook == found["hook"])
        return KernelBuildError(found["hook"], line, found["rest"].strip(), f"{excerpt}\n\n{log}")
    text = (kernels_dir() / name).read_text(encoding="utf-8").splitlines()
    near = range(max(line - 2, 1), min(line + 2, len(text)) + 1)
    excerpt = "\n".join(f"{'>' if n == line else ' '}{n:5d} | {text[n - 1]}" for n in near)
    return KernelBuildError(name, line, found["rest"].strip(), f"{excerpt}\n\n{log}")


def build(device: OpenDevice, spec: ProgramSpec, *, anew: bool = False) -> Program:
    """Build (or take from this process's cache) the program of a spec on a device.

    Parameters
    ----------
    device : OpenDevice
        An open device; programs are cached for each context.
    spec : ProgramSpec
        What the program must do.
    anew : bool
        Whether the compiler is to work whatever is kept, to see how long it takes. Nothing of that
        is kept.

    Raises
    ------
    KernelBuildError
        Where a template does not render or the compiler refuses the text, with its line.
    HostError
        Where an effect names a place or a type that there is not.
    DeviceError
        Where the program is in single precision, and the device's gives wrong answers.
    """
    import pyopencl as cl

    key = (device.context.int_ptr, spec)
    if key in _CACHE and not anew:
        return _CACHE[key]
    source = program_source(spec)
    if spec.real == "float":
        single.trust(device)
    options = single.options_of(device, spec.real)
    digest = hashlib.sha256("\0".join((source, *options)).encode()).hexdigest()
    if (same := _BUILT.get((key[0], digest))) is not None and not anew:
        _CACHE[key] = replace(same, spec=spec, build_seconds=0.0)
        return _CACHE[key]
    started = time.perf_counter()
    kept = "" if anew else kept_kernels.program_key(device, source, options)
    try:
        if anew:
            built = kept_kernels.build_anew(device, source, options)
        else:
            built = kept_kernels.build(device, kept, source, options)
    except cl.RuntimeError as error:
        raise _build_error(str(error), spec) from error
    made = Program(spec, source, digest, time.perf_counter() - started, built, kept)
    if anew:
        return made
    _CACHE[key] = _BUILT[key[0], digest] = made
    return made
