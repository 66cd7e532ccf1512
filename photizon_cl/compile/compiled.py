"""The compiled scene: flat tables for the device, the effects in use, the layout of the tally."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program.precision import FP64, PRECISIONS
from hostcode.program.spec import MAX_REGISTER_ELEMENTS, ProgramSpec
from hostcode.run.tables import DeviceTables
from hostcode.run.tally import image
from photizon_cl.compile.draft import Draft
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.compile.grid import Grid
from photizon_cl.compile.kinds import ALL_KINDS, Kinds
from photizon_cl.compile.layout import lay_out
from photizon_cl.compile.packing import (
    codes_by_class,
    columns,
    element_classes,
    element_codes,
    geometry_table,
    material_table,
    source_kinds,
    source_table,
    strides,
    surface_kinds,
)
from photizon_cl.compile.quantities import watched
from photizon_cl.compile.rays import (
    beams_of,
    check_weights,
    ray_weights,
    rays_of_sources,
    share_rays,
)
from photizon_cl.errors import ArgumentError, Problem, SceneError, show
from photizon_cl.geometry.placing import recentre, recentred

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hostcode.program.precision import Precision
    from photizon_cl.compile.common import Common
    from photizon_cl.compile.effects.base import Effect
    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

__all__ = ["MAX_RAY_NUMBER", "CompiledScene", "compile_scene"]

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
    reasons : mapping of str to str
        Why each effect and kind is in use, by its name in `EFFECT_ROWS`.
    rays_of_source : tuple of int
        Rays that each source launches in a batch.
    unit_power : float
        Watts of a ray of weight 1 in a batch.
    emitted : int
        Exact weight launched in a batch, in units of 2^-95.
    emitted_parts : tuple of int
        What of it each line of the spectrum has; all of it without one.
    shift : tuple of float
        Taken off every position so that a scene far from the origin loses nothing, in metres.
    precision : Precision
        What the kernels compute in.
    """

    scene: Scene
    settings: RunSettings
    tables: DeviceTables
    layout: TallyLayout
    reasons: Mapping[str, str]
    rays_of_source: tuple[int, ...]
    unit_power: float
    emitted: int
    emitted_parts: tuple[int, ...]
    shift: tuple[float, float, float]
    precision: Precision = FP64

    @property
    def heaviest(self) -> float:
        """Weight of a ray at most, that of the heaviest launched one being 1."""
        used = (effect for effect in EFFECTS if effect.name in self.reasons)
        return max((effect.heaviest(self.scene, self.settings) for effect in used), default=1.0)

    @property
    def effects(self) -> frozenset[str]:
        """Names of the effects and kinds in use."""
        return frozenset(self.reasons)


def compile_scene(
    scene: Scene,
    settings: RunSettings,
    force: frozenset[str] = frozenset(),
    without: frozenset[str] = frozenset(),
    *,
    precision: str = FP64.name,
    general: bool = False,
    common: Common | None = None,
) -> CompiledScene:
    """Compile a scene.

    Parameters
    ----------
    scene : Scene
        A validated scene.
    settings : RunSettings
        How it is run; may differ from ``scene.run``.
    force : frozenset of str
        Effects compiled in although the scene does not need them, where that is possible, and kinds
        (``element.sphere``) although no object is one. They change no other number: one with cells
        or rows of its own adds those to the tally.
    without : frozenset of str
        Effects left out although the scene would have them. Only for one that changes no bit of the
        answer, as `acceleration`.
    precision : str
        What the kernels compute in, one of `hostcode.program.precision.PRECISIONS`.
    general : bool
        Whether to make no use of there being one of something, or few elements, as a program that
        is made for all scenes must not. It changes no number.
    common : Common, optional
        What other scenes need as well, with which it is to share a program. It changes no number
        either: an effect with cells or rows of its own is left out where only others need it.

    Raises
    ------
    SceneError
        Where the settings ask for an effect that there is not, or that the scene cannot have.
    ArgumentError
        Where a batch has fewer rays than the sources have lines, the rays of one source are so weak
        beside another's that the tally could not hold them, the scene has more elements or kinds
        than the kernels can tell apart, or something changes too fast with wavelength in a band.
    """
    mode = PRECISIONS[precision]
    rays = share_rays(scene, settings.rays_per_batch)
    unit_power, exact_weights = ray_weights(scene, rays)
    check_weights(scene, exact_weights, settings.rays_per_batch)
    weights = [mode.weighed(weight) for weight in exact_weights]
    shift = recentre(scene)
    forced = force | _asked_for(scene, settings)
    used = _effects_in_use(
        recentred(scene, shift, mode.roundoff), settings, forced, without, mode.roundoff, common
    )
    layout = lay_out(
        scene,
        [row for effect, _ in used for row in effect.rows(scene)],
        [
            (e.name, shape, e.labels(scene), e.unit, e.scale(scene), e.counted_as)
            for e, _ in used
            if (shape := e.cells(scene))
        ],
        max((e.divides(scene) for e, _ in used), default=0),
    )
    layout = replace(layout, watched=watched(scene, layout, settings.target_on))
    draft = Draft(scene, settings, layout, shift, precision=mode)
    draft.note_words = common.note_words if common else 0
    draft.beams = beams_of(scene)
    for effect, reason in used:
        effect.prepare(draft, forced=reason == _FORCED)

    effects = [effect for effect, _ in used]
    kinds = Kinds.of(scene, force, general=general)
    stride = draft.strides = strides(kinds, effects)
    axes = common.axes if common else [element.class_axis for element in scene.element]
    axes = [None] * len(axes) if draft.all_tilted else axes
    draft.classes, class_of = element_classes(scene, kinds, axes)
    draft.grid = Grid.of(scene)
    materials, draft.materials = material_table(scene, kinds, stride, draft.grid)
    draft.material_of = [draft.materials[element.surfaces[0]] for element in scene.element]
    surfaces = surface_kinds(kinds, draft.materials, common, divided=layout.parts > 0)
    draft.coatings = tuple(sorted(kinds.coatings, key=lambda cls: cls.kernel))
    draft.scatters = tuple(sorted(kinds.scatters, key=lambda cls: cls.kernel))
    draft.surface_numbers = {surface.kind: surface.number for surface in surfaces}
    sources = source_kinds(scene, kinds)
    draft.element_codes = element_codes(scene, class_of, surfaces, draft.coincident)
    draft.geometry = geometry_table(draft, class_of, stride, effects)
    parts = [replace(effect.parts(draft), effect=effect.name) for effect, _ in used]
    in_registers = kinds.few(MAX_REGISTER_ELEMENTS) and not layout.parts
    spec = ProgramSpec(
        classes=draft.classes,
        surfaces=surfaces,
        sources=sources,
        forms=draft.forms,
        effects=frozenset(effect.name for effect, _ in used if effect.in_text),
        parts=tuple(parts),
        columns=columns(kinds, effects, stride),
        strides=stride,
        ledger=tuple(row.macro or row.name for row in layout.rows),
        n_elements=len(scene.element) if in_registers else 0,
        real=mode.real,
        weight=mode.weight,
    )
    _fill(draft, used, spec)
    tables = DeviceTables(
        spec=spec,
        geometry=draft.geometry,
        materials=np.array(materials, np.float64),
        sources=source_table(draft, sources, rays, weights, stride),
        codes=np.array(draft.codes, np.int64),
        detector_numbers=np.array(draft.detector_numbers, np.float64),
        edges=np.array(draft.edges, np.float64),
        launch=draft.launch,
        n_cells=layout.n_cells,
    )
    emitted = [0] * len(scene.wavelengths)
    for beam, n, weight in zip(draft.beams, rays, weights, strict=True):
        emitted[beam.line] += n * image(weight)
    reasons = {name: _FORCED for name in ALL_KINDS if name in force}
    reasons |= _kinds_in_use(scene)
    reasons |= {effect.name: reason for effect, reason in used}
    return CompiledScene(
        scene,
        settings,
        tables,
        layout,
        reasons,
        rays_of_sources(scene, rays),
        unit_power,
        sum(emitted),
        tuple(emitted),
        shift,
        mode,
    )


def _fill(draft: Draft, used: list[tuple[Effect, str]], spec: ProgramSpec) -> None:
    """Fill codes and launch, then have the effects add theirs."""
    scene, settings, layout = draft.scene, draft.settings, draft.layout
    draft.launch = {
        "seed": settings.seed,
        "rays_per_batch": settings.rays_per_batch,
        "generation_cap": settings.generation_cap,
        "n_sources": len(draft.beams),
        "n_elements": len(scene.element),
    }
    draft.codes = codes_by_class(draft.element_codes, len(draft.classes))
    if spec.one_by_one:  # its codes have the materials' rows in them
        draft.launch["material_of"] = 0
    else:
        draft.launch["material_of"] = draft.add_codes(draft.material_of)
    first: dict[str, int] = {}
    for surface, at in draft.materials.items():
        first.setdefault(surface.kernel, at)
    for effect, _ in used:
        effect.assemble(draft)
    # of a kind that no element has, nothing is ever read
    draft.launch["material_of_kind"] = draft.add_codes(first.get(s.kind, 0) for s in spec.surfaces)
    for group in layout.groups:
        draft.launch[group.effect.replace("-", "_")] = group.first


# -- effects -------------------------------------------------------------------------------------

_FORCED: Final = "it was asked for"
_COMMON: Final = "scenes that share the program need it"


def _effects_in_use(
    scene: Scene,
    settings: RunSettings,
    force: frozenset[str],
    without: frozenset[str],
    roundoff: float,
    common: Common | None,
) -> list[tuple[Effect, str]]:
    """Ask every effect whether the scene needs it; return those in use, and why."""
    kinds = [kind for name, kind in ALL_KINDS.items() if name in force]
    force |= {effect.name for effect in EFFECTS if any(map(effect.serves, kinds))}
    unknown = (force - ALL_KINDS.keys() | without) - {effect.name for effect in EFFECTS}
    if unknown:
        raise ArgumentError(
            f"no effect {', '.join(sorted(unknown))}: expected some of "
            f"{', '.join(effect.name for effect in EFFECTS)}"
        )
    used: list[tuple[Effect, str]] = []
    for effect in EFFECTS:
        if effect.name in without:
            continue
        reason = effect.needed_within(scene, settings, roundoff)
        if reason is None and effect.name in force and effect.possible(scene):
            reason = _FORCED
        if reason is None and common and effect.name in common.effects and effect.possible(scene):
            adds = effect.rows(scene) or effect.cells(scene) or effect.divides(scene)
            reason = None if adds else _COMMON
        if reason is not None:
            used.append((effect, reason))
    return used


def _asked_for(scene: Scene, settings: RunSettings) -> frozenset[str]:
    """Return the effects that the settings name."""
    known = {effect.name: effect for effect in EFFECTS}
    problems = []
    for name in settings.effects or ():
        if name not in known:
            expected = f"some of {', '.join(known)}"
            problems.append(Problem("run.effects", show(name), expected))
        elif known[name].needed(scene, settings) is None and not known[name].possible(scene):
            hint = f"nothing in it has what this one works on: {known[name].what}"
            problems.append(
                Problem("run.effects", show(name), "effects that the scene can have", hint=hint)
            )
    if problems:
        raise SceneError(problems)
    return frozenset(settings.effects or ())


def _kinds_in_use(scene: Scene) -> dict[str, str]:
    """Return which object uses each kind first."""
    found: dict[str, str] = {}
    things: list[tuple[str, Any, str]] = [("source", s, s.name) for s in scene.source]
    for e in scene.element:
        things += [("element", e, e.name), *(("surface", s, e.name) for s in e.surfaces)]
        things += [("scatter", s.lobe, e.name) for s in e.surfaces if s.lobe is not None]
        things += [("coating", c, e.name) for s in e.surfaces if (c := s.coat) is not None]
    for group, thing, name in things:
        found.setdefault(
            f"{group}.{thing.kind}",
            f'"{name}" has one'
            if group in ("surface", "scatter", "coating")
            else f'"{name}" is one',
        )
    return found
