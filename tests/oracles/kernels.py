"""Small test kernels around the production libraries."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.device import kept_kernels
from hostcode.device.single import options_of
from hostcode.program.fields import BASE_ENDING
from hostcode.program.source import program_source
from hostcode.templates import lane, render
from oracles.engine import open_device

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from hostcode.program.spec import ProgramSpec

LIBRARIES = ("prelude", "lib/philox", "lib/children", "lib/elementary", "lib/vectors", "lib/limbs")


def library_text(
    lanes: int, names: tuple[str, ...], effects: frozenset[str], real: str = "double"
) -> str:
    """Return the rendered libraries."""
    context: dict[str, Any] = {
        "real": real,
        "weight": "double",
        "lanes": lanes,
        "lane": lambda value, number: lane(value, number, lanes),
        "effects": effects,
        "private_tallies": False,
        "ending_fields": BASE_ENDING,
        "ending_word": (),
    }
    return "".join(render(f"{name}.mako", **context) for name in names)


@cache
def _program(device: OpenDevice, text: str, real: str) -> Any:
    return kept_kernels.build(device, _key(device, text, real), text, options_of(device, real))


def _key(device: OpenDevice, text: str, real: str) -> str:
    return kept_kernels.program_key(device, text, options_of(device, real))


def run_text(
    body: str,
    arguments: list[NDArray[Any] | np.generic],
    elements: int,
    *,
    lanes: int = 1,
    libraries: tuple[str, ...] = LIBRARIES,
    effects: frozenset[str] = frozenset(),
    spec: ProgramSpec | None = None,
    device: OpenDevice | None = None,
    real: str = "double",
) -> list[NDArray[Any]]:
    """Run kernel ``test`` of a text behind the libraries; return its arrays as they are afterwards.

    With a `spec` the whole program of a scene stands before the text instead of some libraries.

    In the text ``LOAD(p, item)`` and ``STORE(v, p, item)`` read and write one lane value.
    """
    import pyopencl as cl

    device = device or open_device()
    if lanes == 1:
        access = "#define LOAD(p, i) ((p)[i])\n#define STORE(v, p, i) ((p)[i] = (v))\n"
    else:
        access = f"#define LOAD(p, i) vload{lanes}(i, p)\n"
        access += f"#define STORE(v, p, i) vstore{lanes}(v, i, p)\n"
    if spec is None:
        before = library_text(lanes, libraries, effects, real)
    else:
        before = program_source(spec.for_device(lanes, ("wave",)))
    text = before + access + body
    program = _program(device, text, real)
    flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
    passed, read = [], []
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            content = np.ascontiguousarray(argument)
            buffer = cl.Buffer(device.context, flags, hostbuf=content)
            read.append((buffer, np.empty_like(content)))
            passed.append(buffer)
        else:
            passed.append(argument)
    kernel = cl.Kernel(program, "test")
    kernel(device.queue, (elements // lanes,), (1,), *passed)
    for buffer, result in read:
        cl.enqueue_copy(device.queue, result, buffer)
    kept_kernels.keep(_key(device, text, real))  # the next run of the suite compiles nothing
    return [result for _, result in read]
