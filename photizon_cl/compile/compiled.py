"""The compiled scene: flat tables for the device, the effects in use, the layout of the tally."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program.program import MAX_REGISTER_ELEMENTS, ProgramSpec, SourceKind
from hostcode.run.tables import DeviceTables
from hostcode.run.tally import image
from photizon_cl.compile.layout import DetectorCells, TallyLayout, lay_out
from photizon_cl.compile.packing import (
    add_tree,
    codes_by_class,
    codes_in_order,
    detector_row,
    element_classes,
    element_codes,
    extended,
    geometry_table,
    material_table,
    recentre,
    source_table,
    surface_kinds,
)
from photizon_cl.errors import ArgumentError
from photizon_cl.geometry.contact import in_contact, note_size
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.tree import BREAK_EVEN
from photizon_cl.geometry.wedges import edge_factors
from photizon_cl.scene.edges import azimuth_edges, even_edges

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

__all__ = ["CompiledScene", "DetectorCells", "TallyLayout", "compile_scene"]

LEAST_WEIGHT: Final = 1e-14
"""Least weight of a launched ray beside the heaviest; then good to 1e-15 in the tally."""
MAX_RAY_NUMBER: Final = 2**48
"""Ray numbers have 48 bits of a draw's counter."""


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
        Names in `photizon_cl.compile.effects.EFFECTS` that the scene uses.
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
    scene: Scene,
    settings: RunSettings,
    force: frozenset[str] = frozenset(),
    accelerate: bool | None = None,
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
        ``splitting``, ``shares``, ``contact``); they change no bit of the answer.
    accelerate : bool, optional
        Whether the nearest hit is sought through a tree of boxes; None decides by the number of
        elements. It changes no bit of the answer.

    Raises
    ------
    ArgumentError
        Where a batch has fewer rays than the scene has sources, or the rays of one source are so
        weak beside another's that the tally could not hold them.
    """
    rays = _share_rays(scene, settings.rays_per_batch)
    power = [s.flux / n for s, n in zip(scene.source, rays, strict=True)]
    unit_power = max(power)
    weights = [p / unit_power for p in power]
    _check_weights(scene, weights)
    shift = recentre(scene)
    near = Neighbours(scene.element)
    effects = _effects(scene, settings, weights) | force
    if in_contact(near, scene.source):
        effects |= {"contact"}
    classes, class_of = element_classes(scene, "tilt" in force)
    materials, material_of = material_table(scene)
    surfaces = surface_kinds(scene, material_of)
    layout = lay_out(scene)

    number = {surface.kind: surface.number for surface in surfaces}
    one_by_one = element_codes(scene, class_of, number)
    factors = edge_factors(near)
    geometry = geometry_table(scene, class_of, shift, factors)
    few = len(scene.element) < BREAK_EVEN and "acceleration" not in effects
    if few if accelerate is None else not (accelerate and scene.element):
        effects -= {"acceleration"}
        codes = codes_by_class(one_by_one, len(classes))
        first_material = len(codes)
        codes += material_of
    else:
        effects |= {"acceleration"}
        tree, geometry = add_tree(scene, shift, factors, geometry)
        codes = codes_in_order(one_by_one, material_of, len(classes), tree)
        first_material = len(classes) + 1
    launch: dict[str, Any] = {
        "seed": settings.seed,
        "rays_per_batch": settings.rays_per_batch,
        "generation_cap": settings.generation_cap,
        "roulette_floor": settings.roulette_floor,
        "n_sources": len(scene.source),
        "n_elements": len(scene.element),
        "far_field": layout.far_field,
        "n_mu": layout.n_mu,
        "n_phi": layout.n_phi,
    }
    edges: list[float] = []
    launch["material_of"] = first_material
    launch["material_of_kind"] = len(codes)
    first = {e.surface.kind: at for e, at in zip(scene.element, material_of, strict=True)}
    codes += [first[surface.kind] for surface in surfaces]
    launch["detector_of"] = len(codes)
    of_element = {d.element: n for n, d in enumerate(layout.detectors)}
    codes += [of_element.get(n, -1) for n in range(len(scene.element))]
    launch["detectors"] = len(codes)
    numbers: list[float] = []
    for d in layout.detectors:
        integers, row = detector_row(scene.element[d.element], d, shift, edges)
        codes += integers
        numbers += row
    launch["mu_edges"] = len(edges)
    edges += even_edges(-1.0, 1.0, layout.n_mu) if layout.n_mu else []
    launch["phi_edges"] = len(edges)
    edges += azimuth_edges(layout.n_phi) if layout.n_phi else []

    kinds = sorted({(s.kernel, extended(s)) for s in scene.source})
    sources = tuple(SourceKind(stem, n, extended) for n, (stem, extended) in enumerate(kinds))
    in_registers = 0 < len(scene.element) <= MAX_REGISTER_ELEMENTS
    words, bits = note_size(near) if "contact" in effects else (0, 16)
    spec = ProgramSpec(
        classes=classes,
        surfaces=surfaces,
        sources=sources,
        effects=frozenset(effects & _COMPILED),
        note_words=words,
        note_bits=bits,
        n_elements=len(scene.element) if in_registers else 0,
    )
    tables = DeviceTables(
        spec=spec,
        geometry=geometry,
        materials=np.array(materials, np.float64),
        sources=source_table(scene, sources, rays, weights, shift),
        codes=np.array(codes, np.int64),
        detector_numbers=np.array(numbers, np.float64),
        edges=np.array(edges, np.float64),
        launch=launch,
        n_cells=layout.n_cells,
    )
    emitted = sum(n * image(w) for n, w in zip(rays, weights, strict=True))
    return CompiledScene(
        scene, settings, tables, layout, frozenset(effects), rays, unit_power, emitted, shift
    )


# -- effects -------------------------------------------------------------------------------------

_COMPILED: Final = frozenset(
    {
        "splitting",
        "roulette",
        "shares",
        "detector",
        "map",
        "ladder",
        "far-field",
        "contact",
        "acceleration",
    }
)
"""Effects that the kernels' text asks for by name; the others show in classes and kinds."""


def _effects(scene: Scene, settings: RunSettings, weights: list[float]) -> set[str]:
    used = {f"source.{s.kind}" for s in scene.source}
    for element in scene.element:
        used |= {f"element.{element.kind}", f"surface.{element.surface.kind}"}
        if element.tilt_deg != (0.0, 0.0):
            used.add("tilt")
        if element.ported:
            used.add("port")
        if element.surface.splits:
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


def _share_rays(scene: Scene, rays_per_batch: int) -> tuple[int, ...]:
    """Divide a batch among the sources: each gets a fixed number of rays, at least one.

    A fixed division launches exactly the sources' flux in every batch (stratification); the
    weight of a source's rays is its flux over their number, so every estimate stays unbiased.
    """
    n = len(scene.source)
    if rays_per_batch < n:
        raise ArgumentError(
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


def _check_weights(scene: Scene, weights: list[float]) -> None:
    """Refuse rays so weak beside others that the tally's unit, 2^-95, would round them."""
    for source, weight in zip(scene.source, weights, strict=True):
        if weight < LEAST_WEIGHT:
            raise ArgumentError(
                f"source {source.name!r}: its rays carry {weight:.3g} of the power of the heaviest "
                f"ones, and the tally counts in units of 2^-95 of those (at least {LEAST_WEIGHT:g} "
                "is needed): give the sources shares that even this out, or trace them apart"
            )
