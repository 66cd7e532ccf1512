"""Listing what is compiled for a scene, and measuring what each piece costs."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.effects.table import EFFECT_ROWS, EFFECTS
from photizon_cl.errors import ArgumentError, show
from photizon_cl.result.effects import Effects, EffectUse, ProgramUse
from photizon_cl.run.batches import with_settings
from photizon_cl.scene.files import load
from photizon_cl.studies.pricing import Pair, Pricing

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping, Sequence

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.scene.model import Scene

__all__ = ["EVERYTHING", "EVERY_EFFECT", "SECONDS", "Larger", "effects", "larger_programs"]

SECONDS: Final = 120.0
"""That measuring may take where nobody says."""
EVERY_EFFECT: Final = "every effect"
EVERYTHING: Final = "every effect and kind"

_BY_NAME: Final = {effect.name: effect for effect in EFFECTS}


class Larger(NamedTuple):
    """A program with more in it than a scene needs.

    Parameters
    ----------
    name : str
        What is in it.
    adds : tuple of str
        Effects and kinds that the scene's own program does without.
    compiled : CompiledScene
        It.
    """

    name: str
    adds: tuple[str, ...]
    compiled: CompiledScene


def larger_programs(
    scene: Scene, names: Sequence[str] | None = None, leave_out: frozenset[str] = frozenset()
) -> list[Larger]:
    """Return the programs that have more in them than a scene needs.

    Every effect that can be compiled into the program of the scene; the program that a tracer which
    does not specialise would run, with every kind as well, and no use made of there being one of
    something, or few elements; every kind of a group.

    Parameters
    ----------
    scene : Scene
        A scene.
    names : sequence of str, optional
        Only the programs of these names.
    leave_out : frozenset of str
        Effects and kinds that are left out where the scene does without them; the programs' names
        say so.
    """
    own = compile_scene(scene, scene.run)
    force: dict[str, frozenset[str]] = {EVERY_EFFECT: frozenset(), EVERYTHING: frozenset()}
    for row in EFFECT_ROWS.values():
        group = EVERY_EFFECT if row.group == "effect" else f"every kind of {row.group}"
        for title in (group, EVERYTHING):
            force[title] = force.get(title, frozenset()) | {row.name}
    found = []
    for title in force if names is None else names:
        general = title == EVERYTHING
        more = force[title] - leave_out
        made = compile_scene(scene, scene.run, force=more, general=general)
        adds = tuple(name for name in EFFECT_ROWS if name in made.effects - own.effects)
        if adds:
            spared = [name for name in EFFECT_ROWS if name in leave_out - made.effects]
            but = f" but {', '.join(spared)}" if spared else ""
            found.append(Larger(title + but, adds, made))
    return found


def effects(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    measure: bool = False,
    device: DeviceRecord | str | int | None = None,
    *,
    max_seconds: float | None = None,
    plan: ExecutionPlan | None = None,
) -> Effects:
    """Say what is compiled for a scene and why, what is left out and why, and what each costs.

    Measuring compiles the scene's own program and, one after another, programs that differ from it
    in one effect which changes no number: compiled in although the scene does not need it, or left
    out although the scene has it. Each is run in turn with the scene's own, on the same batches of
    the scene's stream, and its numbers are compared bit by bit. Kept kernels are neither used nor
    changed.

    Parameters
    ----------
    scene : Scene, str, path or mapping
        A scene, or what `photizon_cl.load` makes one of.
    measure : bool
        Whether to measure; without, no device is needed.
    device : str, int or DeviceRecord, optional
        As in `photizon_cl.trace`; like what follows, for measuring.
    max_seconds : float, optional
        Seconds that measuring may take, but for a program that is being compiled when they end;
        default 120.
    plan : ExecutionPlan, optional
        How a device runs a wave; changes no bit.

    Returns
    -------
    Effects
        An `EffectUse` for each effect and kind, by iteration and by name.

    Raises
    ------
    SceneError, ArgumentError
        Where the scene or an argument is not valid.
    RunError
        Where there is no usable device, it fails, or the time is too short for anything.

    Examples
    --------
    >>> import photizon_cl as pz
    >>> found = pz.effects("integrating-sphere")
    >>> found["element.sphere"].because, found["surface.mirror"].because
    ('"wall" is one', 'no element has one')
    """
    for name, given in (("device", device), ("max_seconds", max_seconds), ("plan", plan)):
        if given is not None and not measure:
            raise ArgumentError(
                f"{name}: found {show(given)}, expected none without measure=True, since nothing "
                "else makes use of it"
            )
    seconds = SECONDS if max_seconds is None else max_seconds
    scene = with_settings(load(scene), max_seconds=seconds)
    own = compile_scene(scene, scene.run)
    rows = [_row(name, own) for name in EFFECT_ROWS]
    if not measure:
        return Effects(scene.name, tuple(rows))
    # when to stop a run is of no matter here, and may name what is left out below
    scene = dataclasses.replace(scene, run=dataclasses.replace(scene.run, target_on=None))
    larger = larger_programs(scene)
    optional = [row.name for row in rows if row.optional]
    where = str(device) if isinstance(device, int) else device
    pricing = Pricing(own, len(optional) + len(larger), where, plan, max_seconds=seconds)
    measured: dict[str, Pair | str] = {}
    for program in larger[:1]:  # that which the time should not be too short for
        measured[program.name] = pricing.measure(program.compiled)
    for row in rows:
        if row.optional:
            change, none = frozenset({row.name}), frozenset[str]()
            force, without = (none, change) if row.in_use else (change, none)
            other = compile_scene(scene, scene.run, force, without)
            measured[row.name] = pricing.measure(other, more=not row.in_use)
    for program in larger[1:]:
        measured[program.name] = pricing.measure(program.compiled)
    pricing.build_again()
    priced = [_with_price(row, measured[row.name]) if row.optional else row for row in rows]
    programs = [ProgramUse(p.name, p.adds) for p in larger]
    return Effects(
        scene.name,
        tuple(priced),
        tuple(_with_price(program, measured[program.name]) for program in programs),
        pricing.label,
        pricing.cost(),
        pricing.seconds,
    )


def _row(name: str, own: CompiledScene) -> EffectUse:
    """Return what is to be said of an effect or kind without measuring."""
    told, reason = EFFECT_ROWS[name], own.reasons.get(name)
    scene, settings = own.scene, own.settings
    effect = _BY_NAME.get(name)
    if effect is None:
        has = "has one" if told.group in ("surface", "scatter") else "is one"
        holder = {"source": "source", "scatter": "surface"}.get(told.group, "element")
        because = reason or f"no {holder} {has}"
        optional = False
        why = (
            "kinds are measured by groups, as programs"
            if reason is None
            else "the scene is made of it"
        )
    else:
        because = reason or effect.absent(scene, settings)
        if reason is None:
            optional = effect.possible(scene)
            why = "" if optional else "the scene has nothing that it could work on"
        else:
            optional = effect.removable or effect.needed(scene, settings) is None
            why = "" if optional else "the scene's numbers depend on it"
    return EffectUse(
        name, told.group, told.what, told.costs, reason is not None, because, optional,
        unmeasured=why or "nothing was measured",
    )  # fmt: skip


_Told = TypeVar("_Told", EffectUse, ProgramUse)


def _with_price(row: _Told, measured: Pair | str) -> _Told:
    if isinstance(measured, str):
        return dataclasses.replace(row, unmeasured=measured)
    return dataclasses.replace(row, price=measured.price(), unmeasured="")
