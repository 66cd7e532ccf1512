"""The compiled scene: flat tables for the device, the effects in use, the layout of the tally."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program import (
    MATERIAL_STRIDE,
    MAX_REGISTER_ELEMENTS,
    ROW_STRIDE,
    SOURCE_STRIDE,
    ElementClass,
    ProgramSpec,
    SourceKind,
    SurfaceKind,
)
from hostcode.tables import DeviceTables
from hostcode.tally import image
from photizon_cl.angles import azimuth_edges
from photizon_cl.elements import Disk, Rectangle, Sphere
from photizon_cl.errors import RunError
from photizon_cl.frames import axis_index
from photizon_cl.surfaces import Absorber, Fresnel, Lambertian, Mirror

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from photizon_cl.elements import Element
    from photizon_cl.scene import Scene
    from photizon_cl.settings import RunSettings
    from photizon_cl.sources import Source
    from photizon_cl.surfaces import Surface

__all__ = ["CompiledScene", "DetectorCells", "TallyLayout", "compile_scene"]

_ROUNDOFF: Final = 2.0**-53
MAX_RAY_NUMBER: Final = 2**48
"""Ray numbers have 48 bits of a draw's counter."""


@dataclass(frozen=True)
class DetectorCells:
    """Where a detector's cells stand in a batch's tally.

    Parameters
    ----------
    element : int
        Number of its element in the scene.
    power : int
        Its power cell.
    ladder, n_generations : int
        First cell of the ladder and its number of entries, 0 without one.
    map, nx, ny : int
        First cell of the map (row-major, v then u) and its bins, 0 without one.
    """

    element: int
    power: int
    ladder: int
    n_generations: int
    map: int
    nx: int
    ny: int


@dataclass(frozen=True)
class TallyLayout:
    """Meaning of the cells of a batch's tally.

    Cells ``0 … n_elements − 1`` are absorbed by the elements; then escaped, roulette killed,
    roulette boosted, depth-capped; then the detectors' cells and the far field's.
    """

    n_elements: int
    detectors: tuple[DetectorCells, ...]
    far_field: int
    n_mu: int
    n_phi: int
    n_cells: int

    @property
    def escaped(self) -> int:
        """Cell of what leaves the scene."""
        return self.n_elements

    @property
    def killed(self) -> int:
        """Cell of the weight that roulette ended."""
        return self.n_elements + 1

    @property
    def boosted(self) -> int:
        """Cell of the weight that roulette added."""
        return self.n_elements + 2

    @property
    def depth_capped(self) -> int:
        """Cell of the weight alive at the generation cap."""
        return self.n_elements + 3

    @property
    def n_rows(self) -> int:
        """Cells of the ledger."""
        return self.n_elements + 4


@dataclass(frozen=True, eq=False)
class CompiledScene:
    """A scene ready for a device. Pickles; holds nothing of a device.

    Parameters
    ----------
    scene : Scene
        What was compiled.
    settings : RunSettings
        Seed, rays per batch, generation cap and roulette floor that were compiled in.
    tables : DeviceTables
        What the device reads.
    layout : TallyLayout
        What the tally means.
    effects : frozenset of str
        Names in `photizon_cl.effects.EFFECTS` that the scene uses.
    rays_of_source : tuple of int
        Rays that each source launches in a batch.
    unit_power : float
        Watts of a ray of weight 1 in a batch.
    emitted : int
        Exact weight launched in a batch, in units of 2^-95.
    shift : tuple of float
        Taken off every position so that a scene far from the origin loses nothing, in metres.
    """

    scene: Scene
    settings: RunSettings
    tables: DeviceTables
    layout: TallyLayout
    effects: frozenset[str]
    rays_of_source: tuple[int, ...]
    unit_power: float
    emitted: int
    shift: tuple[float, float, float]


def compile_scene(
    scene: Scene, settings: RunSettings, force: frozenset[str] = frozenset()
) -> CompiledScene:
    """Compile a scene.

    Parameters
    ----------
    scene : Scene
        A validated scene.
    settings : RunSettings
        How it is run; may differ from ``scene.run``.
    force : frozenset of str
        Effects compiled in although the scene does not need them (``tilt``, ``roulette``,
        ``splitting``, ``shares``); they change no bit of the answer.

    Raises
    ------
    RunError
        Where a batch has fewer rays than the scene has sources.
    """
    rays = _share_rays(scene, settings.rays_per_batch)
    power = [s.flux / n for s, n in zip(scene.source, rays, strict=True)]
    unit_power = max(power)
    weights = [p / unit_power for p in power]
    shift = _recentre(scene)
    effects = _effects(scene, settings, weights) | force
    classes, class_of = _element_classes(scene, "tilt" in force)
    materials, material_of = _materials(scene)
    surfaces = _surface_kinds(scene, material_of)
    detectors, n_cells = _lay_out_detectors(scene)
    far_field = n_cells
    n_mu, n_phi = (scene.far_field.n_mu, scene.far_field.n_phi) if scene.far_field else (0, 0)
    n_cells += n_mu * n_phi
    layout = TallyLayout(len(scene.element), detectors, far_field, n_mu, n_phi, n_cells)

    number = {surface.kind: surface.number for surface in surfaces}
    codes = _codes(scene, classes, class_of, number)
    launch: dict[str, Any] = {
        "seed": settings.seed,
        "rays_per_batch": settings.rays_per_batch,
        "generation_cap": settings.generation_cap,
        "roulette_floor": settings.roulette_floor,
        "n_sources": len(scene.source),
        "n_elements": len(scene.element),
        "far_field": far_field,
        "n_mu": n_mu,
        "n_phi": n_phi,
    }
    edges: list[float] = []
    launch["material_of"] = len(codes)
    codes += material_of
    launch["material_of_kind"] = len(codes)
    first = {e.surface.kind: at for e, at in zip(scene.element, material_of, strict=True)}
    codes += [first[surface.kind] for surface in surfaces]
    launch["detector_of"] = len(codes)
    of_element = {d.element: n for n, d in enumerate(detectors)}
    codes += [of_element.get(n, -1) for n in range(len(scene.element))]
    launch["detectors"] = len(codes)
    numbers: list[float] = []
    for d in detectors:
        integers, row = _detector(scene.element[d.element], d, shift, edges)
        codes += integers
        numbers += row
    launch["mu_edges"] = len(edges)
    edges += _even_edges(Fraction(-1), Fraction(1), n_mu) if n_mu else []
    launch["phi_edges"] = len(edges)
    edges += azimuth_edges(n_phi) if n_phi else []

    kinds = sorted({(s.kernel, _extended(s)) for s in scene.source})
    sources = tuple(SourceKind(stem, n, extended) for n, (stem, extended) in enumerate(kinds))
    few = 0 < len(scene.element) <= MAX_REGISTER_ELEMENTS
    spec = ProgramSpec(
        classes=classes,
        surfaces=surfaces,
        sources=sources,
        effects=frozenset(effects & _COMPILED),
        n_elements=len(scene.element) if few else 0,
    )
    tables = DeviceTables(
        spec=spec,
        geometry=_geometry(scene, class_of, shift),
        materials=np.array(materials, np.float64),
        sources=_sources(scene, sources, rays, weights, shift),
        codes=np.array(codes, np.int64),
        detector_numbers=np.array(numbers, np.float64),
        edges=np.array(edges, np.float64),
        launch=launch,
        n_cells=n_cells,
    )
    emitted = sum(n * image(w) for n, w in zip(rays, weights, strict=True))
    return CompiledScene(
        scene, settings, tables, layout, frozenset(effects), rays, unit_power, emitted, shift
    )


# -- effects -------------------------------------------------------------------------------------

_COMPILED: Final = frozenset(
    {"splitting", "roulette", "shares", "detector", "map", "ladder", "far-field"}
)
"""Effects that the kernels' text asks for by name; the others show in classes and kinds."""


def _effects(scene: Scene, settings: RunSettings, weights: list[float]) -> set[str]:
    used = {f"source.{s.kind}" for s in scene.source}
    for element in scene.element:
        used |= {f"element.{element.kind}", f"surface.{element.surface.kind}"}
        if _tilted(element):
            used.add("tilt")
        if isinstance(element, Sphere) and element.port_fraction > 0.0:
            used.add("port")
        if isinstance(element.surface, Fresnel):
            used.add("splitting")
        if element.detector is not None:
            used.add("detector")
            if element.detector.map is not None:
                used.add("map")
            if element.detector.generations is not None:
                used.add("ladder")
    if any(getattr(s, "tilt_deg", (0.0, 0.0)) != (0.0, 0.0) for s in scene.source):
        used.add("tilt")
    if scene.far_field is not None:
        used.add("far-field")
    if settings.roulette_floor > 0.0:
        used.add("roulette")
    if any(w != 1.0 for w in weights):
        used.add("shares")
    return used


# -- sources -------------------------------------------------------------------------------------


def _share_rays(scene: Scene, rays_per_batch: int) -> tuple[int, ...]:
    """Divide a batch among the sources: each gets a fixed number of rays, at least one.

    A fixed division launches exactly the sources' flux in every batch (stratification); the
    weight of a source's rays is its flux over their number, so every estimate stays unbiased.
    """
    n = len(scene.source)
    if rays_per_batch < n:
        raise RunError(
            f"rays_per_batch {rays_per_batch}: the scene {scene.name!r} has {n} sources and each "
            f"launches at least one ray in a batch; set rays_per_batch to {n} or more"
        )
    shares = [Fraction(s.flux if s.share is None else s.share) for s in scene.source]
    total = sum(shares)
    free = rays_per_batch - n
    exact = [free * share / total for share in shares]
    given = [1 + int(x) for x in exact]
    # largest remainders take what rounding down left, the source named first where they are equal
    order = sorted(range(n), key=lambda i: (-(exact[i] - int(exact[i])), i))
    for i in order[: rays_per_batch - sum(given)]:
        given[i] += 1
    return tuple(given)


def _extended(source: Source) -> bool:
    return bool(source.packed())


def _sources(
    scene: Scene,
    kinds: tuple[SourceKind, ...],
    rays: tuple[int, ...],
    weights: list[float],
    shift: tuple[float, float, float],
) -> NDArray[np.float64]:
    number = {kind.stem: kind.number for kind in kinds}
    table = np.zeros((len(scene.source), SOURCE_STRIDE))
    first = 0
    for row, source, n, weight in zip(table, scene.source, rays, weights, strict=True):
        row[0:3] = np.subtract(source.position, shift)
        row[3] = source.packed()[0] if source.packed() else 0.0
        row[4:8] = weight, first, first + n, number[source.kernel]
        row[8:17] = np.ravel(source.frame)
        first += n
    return table.ravel()


# -- elements ------------------------------------------------------------------------------------


def _tilted(element: Element) -> bool:
    return element.tilt_deg != (0.0, 0.0)


def _recentre(scene: Scene) -> tuple[float, float, float]:
    """Return the shift that brings a far scene near the origin, zero for one that is near.

    A whole multiple of four times the scene's size, rounded to a power of two: positions lose
    nothing by the subtraction, and a scene around the origin is not touched.
    """
    boxes = [(e.position, _extent(e)) for e in scene.element]
    boxes += [(s.position, s.packed()[0] if s.packed() else 0.0) for s in scene.source]
    low = np.min([np.subtract(p, r) for p, r in boxes], axis=0)
    high = np.max([np.add(p, r) for p, r in boxes], axis=0)
    size = float(np.max(high - low))
    if not size > 0.0:
        return (0.0, 0.0, 0.0)
    step = 2.0 ** (int(np.ceil(np.log2(size))) + 2)
    x, y, z = (float(np.rint(c / step)) * step for c in (low + high) / 2)
    return (x, y, z)


def _extent(element: Element) -> float:
    return float(max(abs(p) for p in element.packed()))


def _element_classes(
    scene: Scene, force_tilt: bool
) -> tuple[tuple[ElementClass, ...], list[ElementClass]]:
    keys: list[tuple[str, bool, int | None, bool]] = []
    for e in scene.element:
        ported = isinstance(e, Sphere) and e.port_fraction > 0.0
        matters = e.flat or ported
        straight = matters and not (force_tilt or _tilted(e))
        keys.append((e.kernel, e.flat, axis_index(e.axis) // 2 if straight else None, ported))
    order = sorted(set(keys), key=lambda k: (k[0], -1 if k[2] is None else k[2], k[3]))
    classes = {
        key: ElementClass(*key, single=keys.count(key) == 1 and not key[1], number=n)
        for n, key in enumerate(order)
    }
    return tuple(classes.values()), [classes[key] for key in keys]


def _codes(
    scene: Scene,
    classes: tuple[ElementClass, ...],
    class_of: list[ElementClass],
    surface_number: dict[str, int],
) -> list[int]:
    """Bounds of each class, then the elements' codes class by class."""
    bounds = [len(classes) + 1]
    codes: list[int] = []
    for cls in classes:
        for n, element in enumerate(scene.element):
            if class_of[n] is cls:
                down = cls.axis is not None and axis_index(element.axis) % 2 == 1
                counted = element.detector is not None
                kind = surface_number[element.surface.kind]
                codes.append(n << 16 | counted << 12 | kind << 8 | down << 7 | cls.number)
        bounds.append(len(classes) + 1 + len(codes))
    return bounds + codes


def _geometry(
    scene: Scene, class_of: list[ElementClass], shift: tuple[float, float, float]
) -> NDArray[np.float64]:
    table = np.zeros((len(scene.element), ROW_STRIDE))
    for row, element, cls in zip(table, scene.element, class_of, strict=True):
        centre = np.subtract(element.position, shift)
        row[0:3] = centre
        row[15:24] = np.ravel(element.frame)
        row[8] = -1.0 if axis_index(element.axis) % 2 else 1.0
        far = float(np.max(np.abs(centre)))
        if isinstance(element, Sphere):
            radius = element.radius
            rim = radius * element.cos_port + 4.0 * _ROUNDOFF * (radius + far)
            row[3:8] = (
                radius,
                1.0 / (radius * radius),
                1.0 / radius,
                rim,
                8.0 * _ROUNDOFF * radius * (radius + far),
            )
            continue
        half = _half_sizes(element, cls)
        row[3:5] = [h + 4.0 * _ROUNDOFF * (h + far) for h in half]
        row[5:7] = [h - 2.0 * _ROUNDOFF * (h + far) for h in half]
        if cls.axis is None:
            row[7] = 4.0 * _ROUNDOFF * far
            row[9] = 4.0 * _ROUNDOFF
        else:
            row[7] = 4.0 * _ROUNDOFF * abs(centre[cls.axis])
    return table.ravel()


def _half_sizes(element: Element, cls: ElementClass) -> tuple[float, float]:
    """Half sizes along the two in-plane axes of the class: world axes a+1, a+2, or u, v."""
    if isinstance(element, Disk):
        return (element.radius, element.radius)
    assert isinstance(element, Rectangle)
    u, v = element.half_width, element.half_height
    # for +a the frame's u is world axis a+1; for -a it is a+2
    swapped = cls.axis is not None and axis_index(element.axis) % 2 == 1
    return (v, u) if swapped else (u, v)


# -- surfaces ------------------------------------------------------------------------------------


def _materials(scene: Scene) -> tuple[list[float], list[int]]:
    """Rows of the distinct surfaces, and where in them each element's begins."""
    rows: dict[tuple[str, tuple[float, ...]], int] = {}
    of_element = []
    for element in scene.element:
        key = (element.surface.kind, _material(element.surface))
        of_element.append(rows.setdefault(key, len(rows) * MATERIAL_STRIDE))
    return [x for _, row in rows for x in row], of_element


def _surface_kinds(scene: Scene, material_of: list[int]) -> tuple[SurfaceKind, ...]:
    rows: dict[str, set[int]] = {}
    for element, at in zip(scene.element, material_of, strict=True):
        rows.setdefault(element.surface.kind, set()).add(at)
    return tuple(
        SurfaceKind(kind, n, single=len(rows[kind]) == 1) for n, kind in enumerate(sorted(rows))
    )


def _material(surface: Surface) -> tuple[float, float, float, float]:
    if isinstance(surface, Fresnel):
        inside, outside = surface.index, surface.index_outside
        return (
            outside / inside,
            (inside - outside) * (inside + outside) / (inside * inside),
            inside / outside,
            (outside - inside) * (outside + inside) / (outside * outside),
        )
    if isinstance(surface, Mirror | Lambertian):
        return (surface.reflectance, 0.0, 0.0, 0.0)
    assert isinstance(surface, Absorber)
    return (0.0, 0.0, 0.0, 0.0)


# -- detectors -----------------------------------------------------------------------------------


def _lay_out_detectors(scene: Scene) -> tuple[tuple[DetectorCells, ...], int]:
    cell = len(scene.element) + 4
    found = []
    for n, element in enumerate(scene.element):
        if element.detector is None:
            continue
        power = cell
        cell += 1
        generations = element.detector.generations or 0
        ladder = cell if generations else 0
        cell += generations
        nx, ny = element.detector.map or (0, 0)
        first = cell if nx else 0
        cell += nx * ny
        found.append(DetectorCells(n, power, ladder, generations, first, nx, ny))
    return tuple(found), cell


def _detector(
    element: Element, d: DetectorCells, shift: tuple[float, float, float], edges: list[float]
) -> tuple[list[int], list[float]]:
    counts_plus = element.detector_side in ("front", "outside")
    x_edges = y_edges = 0
    sphere = isinstance(element, Sphere)
    if d.nx:
        x_edges = len(edges)
        if isinstance(element, Sphere):
            edges += azimuth_edges(d.nx)
            half = (element.radius, element.radius)
        else:
            half = (
                (element.half_width, element.half_height)
                if isinstance(element, Rectangle)
                else (element.packed()[0], element.packed()[0])
            )
            edges += _even_edges(-Fraction(half[0]), Fraction(half[0]), d.nx)
        y_edges = len(edges)
        edges += _even_edges(-Fraction(half[1]), Fraction(half[1]), d.ny)
    integers = [
        int(counts_plus), d.power, d.ladder, d.n_generations, d.map, d.nx, d.ny, x_edges, y_edges,
        int(sphere),
    ]  # fmt: skip
    row = [*np.subtract(element.position, shift).tolist(), *np.ravel(element.frame).tolist()]
    return integers, row


def _even_edges(low: Fraction, high: Fraction, n: int) -> list[float]:
    """Edges of n equal bins, each rounded once."""
    return [float(low + (high - low) * k / n) for k in range(n + 1)]
