"""One OpenCL program for exactly what a scene uses.

`ProgramSpec` names everything that the kernels' text depends on: the lane width, the element
classes, surfaces, sources and effects in use, and a few counts. Two scenes with equal specs share a
program; parameters live in buffers and do not recompile anything.
"""

from __future__ import annotations

import hashlib
import re
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from hostcode.errors import KernelBuildError
from hostcode.program.structs import ITEM, LAUNCH, c_struct
from hostcode.templates import lane, render

if TYPE_CHECKING:
    import pyopencl as cl

    from hostcode.device.device import OpenDevice

__all__ = [
    "CACHED_BYTES",
    "MATERIAL_STRIDE",
    "MAX_REGISTER_ELEMENTS",
    "OPTIONS",
    "ROW_FRAME",
    "ROW_STRIDE",
    "SOURCE_STRIDE",
    "TREE_NODE",
    "TREE_STACK",
    "TREE_WIDTH",
    "ElementClass",
    "Program",
    "ProgramSpec",
    "SourceKind",
    "SurfaceKind",
    "build",
    "program_source",
]

ROW_STRIDE: Final = 24
ROW_FRAME: Final = 15
MATERIAL_STRIDE: Final = 4
SOURCE_STRIDE: Final = 20
MAX_REGISTER_ELEMENTS: Final = 8
"""Up to this many elements the ledger is kept in registers."""

TREE_WIDTH: Final = 8
"""Children of a node of the tree of boxes."""
TREE_NODE: Final = 16
"""Doubles of a node."""
TREE_STACK: Final = 169
"""Places of the search's stack: seven stay behind at each of up to 24 levels, and one."""

CACHE_LINE: Final = 64
"""Bytes of a cache line."""
CACHED_BYTES: Final = 1 << 20
"""How much of a scene's tables is taken to stay in a core's cache: its second level, measured."""

OPTIONS: Final[tuple[str, ...]] = ("-cl-std=CL1.2",)
"""Build options; no ``-cl-*-math`` option may ever stand here."""


@dataclass(frozen=True)
class ElementClass:
    """Elements that one intersection function serves.

    Parameters
    ----------
    kind : str
        Stem of the kernel file in ``kernels/elements``.
    family : str
        ``flat`` (a part of a plane), ``sphere``, ``solid`` (a convex solid of two faces) or
        ``walls`` (faces in a frame of their own).
    axis : int or None
        World axis (0, 1, 2) of the normal or port; None where it is tilted or has no meaning.
    ported : bool
        Whether a part is cut out of a sphere.
    single : bool
        Whether the scene has just one element of the class.
    number : int
        Its place in the class table.
    """

    kind: str
    family: str
    axis: int | None
    ported: bool = False
    single: bool = False
    number: int = 0

    @property
    def flat(self) -> bool:
        """Whether it lies in a plane."""
        return self.family == "flat"

    @property
    def local(self) -> bool:
        """Whether its functions work in the element's own frame, and know several faces."""
        return self.family in ("solid", "walls")

    @property
    def suffix(self) -> str:
        """Suffix of its functions."""
        port = "_ported" if self.ported else ""
        if self.axis is not None:
            return f"{self.kind}_{'xyz'[self.axis]}{port}"
        return (
            self.kind
            if self.family == "sphere" and not self.ported
            else f"{self.kind}_tilted{port}"
        )


@dataclass(frozen=True)
class SurfaceKind:
    """A surface kind in use, its number, and whether all its elements share one material."""

    kind: str
    number: int
    single: bool


@dataclass(frozen=True)
class SourceKind:
    """A source kind in use: stem of its kernel file, number, whether it draws a position."""

    stem: str
    number: int
    extended: bool


@dataclass(frozen=True)
class ProgramSpec:
    """Everything that the text of a program depends on."""

    classes: tuple[ElementClass, ...]
    surfaces: tuple[SurfaceKind, ...]
    sources: tuple[SourceKind, ...]
    effects: frozenset[str]
    n_elements: int
    """Number of elements where the ledger is kept in registers, else 0."""
    note_words: int = 0
    """Words in which a ray remembers the faces around where it started."""
    note_bits: int = 16
    """Bits of a face there: 16 for up to 2047 elements, else 32."""
    lanes: int = 1
    packets: int = 1
    """Packets of so many lanes that a work-item keeps at once."""
    cached_bytes: int = 0
    """With a tree: how much of the scene's tables stays in a core's cache."""
    interleaved: bool = False
    private_tallies: bool = False
    stages: tuple[str, ...] = ("wave",)

    def for_device(
        self,
        lanes: int,
        stages: tuple[str, ...],
        *,
        interleaved: bool = False,
        private_tallies: bool = False,
        cached_bytes: int = CACHED_BYTES,
    ) -> ProgramSpec:
        """Return the spec with what a device and a composition add.

        `lanes` is how many rays a work-item holds at once: in the lanes of one packet, or, where
        they go through a tree of boxes each by itself, in as many packets of one lane.
        """
        one_by_one = "acceleration" in self.effects
        return replace(
            self,
            lanes=1 if one_by_one else lanes,
            packets=lanes if one_by_one else 1,
            cached_bytes=cached_bytes if one_by_one and lanes > 1 else 0,
            stages=stages,
            interleaved=interleaved,
            private_tallies=private_tallies,
        )

    @property
    def records(self) -> bool:
        """Whether endings are recorded for the tally stage."""
        return bool(self.effects & {"far-field", "detector"})

    @property
    def queue_fields(self) -> dict[str, tuple[str, ...]]:
        """The packet's fields by type, as the queue stores them."""
        real = ["ox", "oy", "oz", "dx", "dy", "dz", "w"]
        if {"shares", "roulette"} <= self.effects:
            real.append("launched")
        long = ["left"]
        if "contact" in self.effects:
            real += ["came_x", "came_y", "came_z"]
            long += [f"note{n}" for n in range(self.note_words)]
        if "splitting" in self.effects:
            long.append("path")
        word = ("ray_lo", "ray_hi", "generation")
        return {"queue_real": tuple(real), "queue_word": word, "queue_long": tuple(long)}


def program_source(spec: ProgramSpec) -> str:
    """Return the OpenCL C text of a program.

    Raises
    ------
    KernelBuildError
        Where a template does not render.
    """
    context: dict[str, Any] = {
        "lanes": spec.lanes,
        "packets": spec.packets,
        # a row's first line and the two of a node; nodes stand level by level
        "warm_elements": spec.cached_bytes // CACHE_LINE,
        "warm_nodes": spec.cached_bytes // (4 * 8 * TREE_NODE),
        "lane": lambda value, number: lane(value, number, spec.lanes),
        "effects": spec.effects,
        "classes": spec.classes,
        "surfaces": spec.surfaces,
        "sources": spec.sources,
        "records": spec.records,
        "interleaved": spec.interleaved,
        "private_tallies": spec.private_tallies,
        "n_elements": spec.n_elements,
        "ledger_rows": spec.n_elements + 4 if spec.n_elements else 0,
        "row_stride": ROW_STRIDE,
        "row_frame": ROW_FRAME,
        "material_stride": MATERIAL_STRIDE,
        "source_stride": SOURCE_STRIDE,
        "note_words": spec.note_words,
        "note_bits": spec.note_bits,
        "tree_node": TREE_NODE,
        "tree_width": TREE_WIDTH,
        "tree_stack": TREE_STACK,
        "launch_struct": c_struct("launch_t", LAUNCH),
        "item_struct": c_struct("item_t", ITEM),
        **spec.queue_fields,
    }
    parts: list[tuple[str, dict[str, Any]]] = [("prelude.mako", {}), ("lib/philox.mako", {})]
    parts += [(f"lib/{stem}.mako", {}) for stem in ("elementary", "vectors", "limbs", "packets")]
    if any(cls.family == "solid" for cls in spec.classes):
        parts.append(("lib/cap.mako", {}))
    for cls in spec.classes:
        before = {"solid": ("lib/local", "lib/solid", "lib/cap_bound"), "walls": ("lib/local",)}
        after = {"flat": ("lib/flat",)}
        around = (*before.get(cls.family, ()), f"elements/{cls.kind}", *after.get(cls.family, ()))
        stems = (*around, "lib/meet")
        parts += [(f"{stem}.mako", {"cls": cls}) for stem in stems]
    if "acceleration" in spec.effects:
        parts.append(("effects/acceleration.mako", {}))
    parts += [(f"lib/{stem}.mako", {}) for stem in ("faces", "nearest", "locate", "ledger")]
    parts += [(f"surfaces/{surface.kind}.mako", {}) for surface in spec.surfaces]
    if "detector" in spec.effects or "far-field" in spec.effects:
        parts += [("lib/cells.mako", {}), ("detectors/bins.mako", {})]
    if "detector" in spec.effects:
        parts.append(("detectors/detector.mako", {}))
    if "far-field" in spec.effects:
        parts.append(("effects/far_field.mako", {}))
    if "roulette" in spec.effects:
        parts.append(("effects/roulette.mako", {}))
    parts += [("lib/shade.mako", {}), ("lib/survive.mako", {}), ("lib/sources.mako", {})]
    parts += [(f"sources/{source.stem}.mako", {}) for source in spec.sources]
    parts += [("lib/generate.mako", {}), ("lib/queue.mako", {}), ("lib/arguments.mako", {})]
    parts += [(f"stages/{stage}.mako", {}) for stage in spec.stages]
    if spec.records and not {"probe", "follow", "paths"} & set(spec.stages):
        parts.append(("stages/tally.mako", {}))
    return "".join(render(name, **context, **extra) for name, extra in parts)


@dataclass(frozen=True)
class Program:
    """A program built for one device."""

    spec: ProgramSpec
    source: str
    digest: str
    build_seconds: float
    built: cl.Program

    def kernel(self, name: str) -> cl.Kernel:
        """Return a new kernel object; keep it, each call makes another."""
        import pyopencl as cl

        return cl.Kernel(self.built, name)


_CACHE: dict[tuple[int, ProgramSpec], Program] = {}
_MESSAGE = re.compile(r'(?:^|\s)"?kernels/(?P<name>[\w/]+\.mako)"?:(?P<line>\d+):(?P<rest>.*)')


def _build_error(log: str) -> KernelBuildError:
    """Turn a compiler's log into an error that points into a template."""
    from hostcode.assets import kernels_dir

    matches = [m for m in map(_MESSAGE.search, log.splitlines()) if m]
    found = next((m for m in matches if "error" in m["rest"]), matches[0] if matches else None)
    if found is None:
        return KernelBuildError("(program)", None, "the compiler refused it", log)
    name, line = found["name"], int(found["line"])
    text = (kernels_dir() / name).read_text(encoding="utf-8").splitlines()
    near = range(max(line - 2, 1), min(line + 2, len(text)) + 1)
    excerpt = "\n".join(f"{'>' if n == line else ' '}{n:5d} | {text[n - 1]}" for n in near)
    return KernelBuildError(name, line, found["rest"].strip(), f"{excerpt}\n\n{log}")


def build(device: OpenDevice, spec: ProgramSpec) -> Program:
    """Build (or take from this process's cache) the program of a spec on a device.

    Parameters
    ----------
    device : OpenDevice
        An open device; programs are cached for each context.
    spec : ProgramSpec
        What the program must do.

    Raises
    ------
    KernelBuildError
        Where a template does not render or the compiler refuses the text, with its line.
    """
    import pyopencl as cl

    key = (device.context.int_ptr, spec)
    if key in _CACHE:
        return _CACHE[key]
    source = program_source(spec)
    digest = hashlib.sha256("\0".join((source, *OPTIONS)).encode()).hexdigest()
    started = time.perf_counter()
    program = cl.Program(device.context, source)
    try:
        built = program.build(options=list(OPTIONS))
    except cl.RuntimeError as error:
        raise _build_error(str(error)) from error
    made = Program(spec, source, digest, time.perf_counter() - started, built)
    _CACHE[key] = made
    return made
