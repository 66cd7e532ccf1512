"""Drives the engine directly: a scene, a plan, a device in; exact tallies out."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from hostcode.device import device as devices
from hostcode.program.plan import ExecutionPlan
from hostcode.run.probe import probe_rays
from hostcode.run.tally import canonical, exact
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import CompiledScene, compile_scene
from photizon_cl.result.statistics import complete
from photizon_cl.scene.files import load

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from photizon_cl.scene.model import Scene

PLAN = ExecutionPlan(lanes=4, items=8, wave_rays=1 << 16, refill=1, stack_rays=64)
"""How tests run unless they say otherwise: narrow lanes build fastest."""


@cache
def open_device(origin: str = "", compute_units: int | None = None) -> OpenDevice:
    """Return an open device: the chosen one, or that of ``debian``, ``pypi`` or ``intel``.

    Skips the calling test where there is none of that origin.
    """
    if not origin:
        return devices.open_device(devices.choose(), compute_units=compute_units)
    for record in devices.enumerate_devices():
        if record.origin == origin and not devices.qualify(record, self_test=True):
            return devices.open_device(record, compute_units=compute_units)
    pytest.skip(f"no usable OpenCL of {origin} on this machine")


@dataclass(frozen=True, eq=False)
class Traced:
    """Batches of a scene, with its rows by name; amounts are exact, in launched weights."""

    compiled: CompiledScene
    batches: tuple[NDArray[np.int64], ...]
    interactions: int
    first: int = 0

    @property
    def digest(self) -> str:
        """Hash over the batches' canonical tallies, as the device gave them."""
        return hashlib.sha256(b"".join(cells.tobytes() for cells in self.batches)).hexdigest()

    @property
    def cells(self) -> NDArray[np.int64]:
        """Sum of the batches, completed by the host, shape (n_cells, 4)."""
        layout = self.compiled.layout
        parts = [complete(layout, cells) for cells in self.batches]
        return canonical(np.sum(parts, axis=0))

    def amount(self, first: int, n: int = 1) -> Fraction:
        """Return the exact sum of cells, in launched weights."""
        return Fraction(sum(exact(self.cells[first : first + n])), 2**95)

    def count(self, first: int, n: int = 1) -> int:
        """Return the arrivals in cells."""
        return int(self.cells[first : first + n, 3].sum())

    @property
    def emitted(self) -> Fraction:
        """Weight launched."""
        return Fraction(self.compiled.emitted * len(self.batches), 2**95)

    def absorbed(self, name: str) -> Fraction:
        """Return what an element absorbed."""
        names = [element.name for element in self.compiled.scene.element]
        return self.amount(names.index(name))

    @property
    def escaped(self) -> Fraction:
        """What left the scene."""
        return self.amount(self.compiled.layout.escaped)

    @property
    def killed(self) -> Fraction:
        """What roulette ended."""
        return self.amount(self.compiled.layout.killed)

    @property
    def boosted(self) -> Fraction:
        """What roulette added."""
        return self.amount(self.compiled.layout.boosted)

    @property
    def depth_capped(self) -> Fraction:
        """What was alive at the generation cap."""
        return self.amount(self.compiled.layout.depth_capped)

    def detector(self, name: str) -> DetectorTally:
        """Return what the detector on an element counted."""
        for d in self.compiled.layout.detectors:
            if self.compiled.scene.element[d.element].name == name:
                return DetectorTally(self, d)
        raise KeyError(name)

    @property
    def far_field(self) -> list[Fraction]:
        """Escaped weight of each far-field bin, row-major (mu, phi)."""
        layout = self.compiled.layout
        n = layout.n_mu * layout.n_phi
        bins = self.cells[layout.far_field : layout.far_field + n]
        return [Fraction(v, 2**95) for v in exact(bins)]

    @property
    def far_field_counts(self) -> NDArray[np.int64]:
        """Escapes of each far-field bin, shape (n_mu, n_phi)."""
        layout = self.compiled.layout
        n = layout.n_mu * layout.n_phi
        counts = self.cells[layout.far_field : layout.far_field + n, 3]
        return counts.reshape(layout.n_mu, layout.n_phi)

    def closures(self) -> list[Fraction]:
        """Return each batch's closure as a fraction of what it emitted."""
        layout, found = self.compiled.layout, []
        for cells in self.batches:
            rows = exact(complete(layout, cells)[: layout.n_rows])
            named = zip(layout.rows, rows[layout.n_elements :], strict=True)
            taken = sum(rows[: layout.n_elements]) + sum(row.sign * n for row, n in named)
            found.append(Fraction(self.compiled.emitted - taken, self.compiled.emitted))
        return found


@dataclass(frozen=True, eq=False)
class DetectorTally:
    """What one detector counted."""

    traced: Traced
    cells: Any

    @property
    def power(self) -> Fraction:
        """Its total."""
        return self.traced.amount(self.cells.power)

    @property
    def count(self) -> int:
        """Its arrivals."""
        return self.traced.count(self.cells.power)

    @property
    def ladder(self) -> list[Fraction]:
        """Its power by generation."""
        first = self.cells.ladder
        return [self.traced.amount(first + g) for g in range(self.cells.n_generations)]

    @property
    def ladder_counts(self) -> list[int]:
        """Its arrivals by generation."""
        first = self.cells.ladder
        return [self.traced.count(first + g) for g in range(self.cells.n_generations)]

    @property
    def map_cells(self) -> NDArray[np.int64]:
        """Cells of the map, shape (ny, nx, 4)."""
        c = self.cells
        return self.traced.cells[c.map : c.map + c.nx * c.ny].reshape(c.ny, c.nx, 4)

    @property
    def map_counts(self) -> NDArray[np.int64]:
        """Arrivals of each bin, shape (ny, nx)."""
        return self.map_cells[:, :, 3]

    @property
    def map_total(self) -> Fraction:
        """Sum over the map."""
        return self.traced.amount(self.cells.map, self.cells.nx * self.cells.ny)


def scene_of(sources: Any, elements: Any, **parts: Any) -> Scene:
    """Return a scene from tables such as a file holds; names are given where they are left out.

    Without roulette, unless it is asked for: exact answers are those of every child.
    """
    parts["run"] = {"roulette_floor": 0.0, **parts.get("run", {})}
    named = lambda rows, stem: [{"name": f"{stem} {n}", **row} for n, row in enumerate(rows)]  # noqa: E731
    return load(
        {
            "schema": "photizon/1",
            "name": "test",
            "source": named(sources, "source"),
            "element": named(elements, "element"),
            **parts,
        }
    )


TREE = frozenset({"acceleration"})


def with_tree(tree: bool, force: frozenset[str] = frozenset()) -> dict[str, frozenset[str]]:
    """Return what `compile_scene` is told so that it builds a tree of boxes, or none."""
    return {"force": force | TREE} if tree else {"force": force, "without": TREE}


def compiled(
    scene: Scene | str,
    force: frozenset[str] = frozenset(),
    precision: str = "fp64",
    **run: Any,
) -> CompiledScene:
    """Compile a scene or preset with some run settings changed."""
    found = load(scene) if isinstance(scene, str) else scene
    return compile_scene(found, replace(found.run, **run), force, precision=precision)


def trace(
    scene: Scene | str,
    *,
    batches: int = 1,
    first: int = 0,
    force: frozenset[str] = frozenset(),
    device: OpenDevice | None = None,
    plan: ExecutionPlan = PLAN,
    precision: str = "fp64",
    **run: Any,
) -> Traced:
    """Trace batches of a scene; keywords override its run settings."""
    made = compiled(scene, force, precision, **run)
    return trace_compiled(made, batches, first, device, plan)


def trace_compiled(
    made: CompiledScene,
    batches: int = 1,
    first: int = 0,
    device: OpenDevice | None = None,
    plan: ExecutionPlan = PLAN,
) -> Traced:
    """Trace batches of a compiled scene."""
    if plan is PLAN:  # room for more batches than there are costs more than to trace a few rays
        rays = batches * made.settings.rays_per_batch
        plan = plan.with_(wave_rays=min(plan.wave_rays, rays))
    engine = Engine(device or open_device(), made.tables, plan)
    done = tuple(tally.cells for tally in engine.run(first, batches))
    return Traced(made, done, engine.statistics.interactions, first)


@dataclass(frozen=True, eq=False)
class Hits:
    """What `probe` found: distance (inf on a miss), element (-1), point and outward normal."""

    distance: NDArray[np.float64]
    element: NDArray[np.int64]
    point: NDArray[np.float64]
    normal: NDArray[np.float64]


def probe(
    scene: Scene,
    origins: Sequence[Sequence[float]] | NDArray[np.float64],
    directions: Sequence[Sequence[float]] | NDArray[np.float64],
    *,
    lanes: int = 1,
    device: OpenDevice | None = None,
) -> Hits:
    """Intersect rays with a scene through the production kernels, directions as they are given."""
    made = compiled(scene)
    rays = np.hstack([np.subtract(origins, made.shift), np.asarray(directions, np.float64)])
    hits, elements = probe_rays(device or open_device(), made.tables, rays, lanes)
    return Hits(hits[:, 0], elements, hits[:, 1:4] + made.shift, hits[:, 4:7])
