"""What is compiled for a scene, why, and what each piece costs in time."""

from __future__ import annotations

import statistics
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.scene.names import unknown_name

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

__all__ = ["EFFECTS_SCHEMA", "EffectUse", "Effects", "Price", "ProgramCost", "ProgramUse", "Ratio"]

EFFECTS_SCHEMA: Final = "photizon-effects/1"


@dataclass(frozen=True)
class Ratio:
    """How many times as long one of two programs takes as the other, of rounds in turn.

    Parameters
    ----------
    median, low, high : float
        Median and quartiles of the rounds' ratios.
    rounds : int
        How many there were.
    """

    median: float
    low: float
    high: float
    rounds: int

    @classmethod
    def of(cls, ratios: Sequence[float]) -> Ratio:
        """Return the spread of at least one ratio."""
        low = high = statistics.median(ratios)
        if len(ratios) > 1:
            low, _, high = statistics.quantiles(ratios, n=4, method="inclusive")
        return cls(statistics.median(ratios), low, high, len(ratios))

    def summary(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {"median": self.median, "low": self.low, "high": self.high, "rounds": self.rounds}


@dataclass(frozen=True)
class ProgramCost:
    """What a program takes on a device.

    Parameters
    ----------
    interactions_per_s : float
        Median over the rounds.
    build_seconds : float
        Of the compiler, nothing kept: from the text to kernels that have been launched. Median,
        where it was built several times.
    source_bytes : int
        Of its text.
    binary_bytes : int or None
        Of what the compiler made of it, where the device says.
    """

    interactions_per_s: float
    build_seconds: float
    source_bytes: int
    binary_bytes: int | None

    def summary(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "interactions_per_s": self.interactions_per_s,
            "build_seconds": self.build_seconds,
            "source_bytes": self.source_bytes,
            "binary_bytes": self.binary_bytes,
        }


@dataclass(frozen=True)
class Price:
    """Two programs of one scene beside each other, that with something and that without it.

    Parameters
    ----------
    more, less : ProgramCost
        The program with it, and without.
    slowdown : Ratio
        Time that the one with it takes for what the other takes 1.
    same_bits : bool
        Whether both gave the same bits in all cells that both have.
    """

    more: ProgramCost
    less: ProgramCost
    slowdown: Ratio
    same_bits: bool

    def summary(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "with": self.more.summary(),
            "without": self.less.summary(),
            "slowdown": self.slowdown.summary(),
            "same_bits": self.same_bits,
        }


@dataclass(frozen=True)
class EffectUse:
    """An effect, or a kind as one, in a scene.

    Parameters
    ----------
    name : str
        ``group.kind`` for a kind, a word for an effect.
    group : str
        ``source``, ``element``, ``surface`` or ``effect``.
    what, costs : str
        What it does, and what the device does more because of it.
    in_use : bool
        Whether it is compiled for the scene.
    because : str
        Why it is in use, or why it is left out; a clause behind "because".
    optional : bool
        Whether it may be the other way and change no number: compiled in although nothing needs it,
        or left out although the scene has it.
    price : Price or None
        Where it was measured.
    unmeasured : str
        Why there is no price; empty where there is one.
    """

    name: str
    group: str
    what: str
    costs: str
    in_use: bool
    because: str
    optional: bool
    price: Price | None = None
    unmeasured: str = ""

    def summary(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "name": self.name,
            "group": self.group,
            "what": self.what,
            "costs": self.costs,
            "in_use": self.in_use,
            "because": self.because,
            "optional": self.optional,
            "price": self.price.summary() if self.price else None,
            "unmeasured": self.unmeasured,
        }


@dataclass(frozen=True)
class ProgramUse:
    """A program with more in it than the scene needs, beside the one that is made for it.

    Parameters
    ----------
    name : str
        What is in it.
    adds : tuple of str
        Names of the effects and kinds that the scene's own program does without.
    price : Price or None
        Where it was measured.
    unmeasured : str
        Why there is no price; empty where there is one.
    """

    name: str
    adds: tuple[str, ...]
    price: Price | None = None
    unmeasured: str = ""

    def summary(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "name": self.name,
            "adds": list(self.adds),
            "price": self.price.summary() if self.price else None,
            "unmeasured": self.unmeasured,
        }


@dataclass(frozen=True)
class Effects:
    """Every effect and kind that there is, and what a scene makes of it.

    Iterating gives an `EffectUse` for each; ``effects["element.sphere"]`` gives one.

    Parameters
    ----------
    scene : str
        Its name.
    rows : tuple of EffectUse
        Kinds of sources, elements and surfaces, then effects.
    programs : tuple of ProgramUse
        Groups of what the scene does without; empty where nothing was measured.
    device : str or None
        Where prices were measured; None where nothing was.
    own : ProgramCost or None
        What the scene's own program takes there, over all rounds.
    seconds : float
        That the measurement took.
    """

    scene: str
    rows: tuple[EffectUse, ...]
    programs: tuple[ProgramUse, ...] = ()
    device: str | None = None
    own: ProgramCost | None = None
    seconds: float = 0.0

    def __iter__(self) -> Iterator[EffectUse]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> EffectUse:
        found = next((row for row in self.rows if row.name == name), None)
        if found is None:
            raise unknown_name("effects", name, [row.name for row in self.rows])
        return found

    @property
    def in_use(self) -> tuple[str, ...]:
        """Names of what is compiled for the scene."""
        return tuple(row.name for row in self.rows if row.in_use)

    @property
    def different(self) -> tuple[str, ...]:
        """Names of what changed a bit that it must not, of effects and of programs."""
        measured: list[EffectUse | ProgramUse] = [*self.rows, *self.programs]
        return tuple(x.name for x in measured if x.price is not None and not x.price.same_bits)

    @property
    def same_bits(self) -> bool | None:
        """Whether all that was measured gave the same bits; None where nothing was."""
        measured: list[EffectUse | ProgramUse] = [*self.rows, *self.programs]
        return not self.different if any(x.price is not None for x in measured) else None

    def summary(self) -> dict[str, Any]:
        """Return everything as plain values that JSON can hold."""
        return {
            "schema": EFFECTS_SCHEMA,
            "scene": self.scene,
            "device": self.device,
            "seconds": self.seconds,
            "own": self.own.summary() if self.own else None,
            "effects": [row.summary() for row in self.rows],
            "programs": [program.summary() for program in self.programs],
            "same_bits": self.same_bits,
        }
