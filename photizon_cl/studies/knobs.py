"""What trades truth for time: the settings that a cost study tries."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING, Any, Final, Protocol

from hostcode.program.precision import PRECISIONS
from hostcode.program.spec import PLAIN_PARTS
from photizon_cl.checks.precision import DEFAULT
from photizon_cl.scene.settings import MAX_GENERATION_CAP, MAX_RAYS_PER_BATCH

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.model import Scene

__all__ = ["KNOBS", "Knob", "Option", "as_it_stands"]

_FLOORS: Final = (0.0, 1e-6, 1e-3, 0.1)
_SHARES: Final = (0.0, 0.25, 0.75)
"""Parts of the scattered rays that are sent towards a scene's targets."""
_ENDLESS: Final = 64
"""Generations beyond which splitting without roulette is not tried: it need not end."""


@dataclasses.dataclass(frozen=True)
class Option:
    """A setting to be tried.

    Parameters
    ----------
    name : str
        Short and different for each.
    knob : str
        What is changed.
    value : str, int, float or bool
        To what.
    written : str
        How a user asks for it; empty where only a study can.
    scene : Scene
        The scene with it in its ``[run]``.
    precision : str
        What the kernels compute in.
    plain : frozenset of str
        Parts of the arithmetic that are done the short way, see `hostcode.program.spec`.
    """

    name: str
    knob: str
    value: str | int | float | bool
    written: str
    scene: Scene
    precision: str = DEFAULT
    plain: frozenset[str] = frozenset()


class Knob(Protocol):
    """Gives the options of one knob, of a scene as it stands."""

    def __call__(self, scene: Scene, cap: int, /) -> Iterator[Option]:
        """Give them; `cap` is the generation cap of the reference."""
        ...


def as_it_stands(scene: Scene) -> Option:
    """Return the scene's own settings as an option."""
    return Option(DEFAULT, "precision", DEFAULT, "", scene)


def _with(scene: Scene, knob: str, value: Any, name: str) -> Option:
    """Return the option of a setting of the scene's ``[run]``."""
    changed = dataclasses.replace(scene, run=dataclasses.replace(scene.run, **{knob: value}))
    return Option(name, knob, value, f"{knob} = {json.dumps(value)}", changed)


def with_cap(scene: Scene, cap: int) -> Option:
    """Return a scene with another generation cap as an option."""
    return _with(scene, "generation_cap", cap, f"cap {cap}")


def _roulette(scene: Scene, cap: int) -> Iterator[Option]:
    own = scene.roulette_floor()
    for floor in _FLOORS:
        endless = floor == 0.0 and scene.splits() and scene.run.generation_cap > _ENDLESS
        if floor != own and not endless:
            yield _with(scene, "roulette_floor", floor, f"roulette {floor:g}")


def _cap(scene: Scene, cap: int) -> Iterator[Option]:
    own = scene.run.generation_cap
    for value in sorted({max(own // 4, 1), max(own // 2, 1), cap}):
        if value != own and value <= MAX_GENERATION_CAP:
            yield with_cap(scene, value)


def _splitting(scene: Scene, cap: int) -> Iterator[Option]:
    if scene.splitter is not None:
        other = not scene.run.splitting
        yield _with(scene, "splitting", other, "both children" if other else "one child")


def _batch(scene: Scene, cap: int) -> Iterator[Option]:
    own = scene.run.rays_per_batch
    for value in (own // 8, own * 8):
        if max(scene.fewest_rays, 1) <= value <= MAX_RAYS_PER_BATCH:
            yield _with(scene, "rays_per_batch", value, f"batch {value}")


def _precision(scene: Scene, cap: int) -> Iterator[Option]:
    for mode in PRECISIONS:
        if mode != DEFAULT:
            yield Option(mode, "precision", mode, f"--precision {mode}", scene, mode)


def _plain(scene: Scene, cap: int) -> Iterator[Option]:
    names = {"geometry": "plain geometry", "tally": "tally to 2^-31"}
    for part in PLAIN_PARTS:
        yield Option(names[part], part, "plain", "", scene, plain=frozenset({part}))


def _importance(scene: Scene, cap: int) -> Iterator[Option]:
    own = scene.importance
    if own is None or not scene.scatters:
        return
    for share in _SHARES:
        if share != own.fraction:
            sent = dataclasses.replace(own, fraction=share)
            changed = dataclasses.replace(scene, importance=sent)
            written = f"importance.fraction = {json.dumps(share)}"
            name = f"importance {share:g}" if share else "no importance"
            yield Option(name, "importance.fraction", share, written, changed)


KNOBS: Final[tuple[Knob, ...]] = (
    _importance,  # first where a scene has it: what is asked of it most, should time be short
    _precision,
    _roulette,
    _cap,
    _splitting,
    _batch,
    _plain,
)
"""What a study tries, in this order."""
