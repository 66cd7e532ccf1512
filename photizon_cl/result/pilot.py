"""What a few hundred rays show of a scene: above all what its generation cap cuts, and why.

After m interactions a part A(m) of the power is still under way. Where light decays, by absorption
or by escape, A(m) falls by about the same factor an interaction and some cap leaves nothing worth a
word. Where it is trapped, by total reflection or between faces that take nothing, A(m) stops
falling and no cap helps. A pilot measures A at the scene's cap, at half of it, and at caps twice as
large each until little is left or its budget is spent; the same rays each time, so that what is
lost from one cap to the next is no accident of the draws. `photizon_cl.run.pilot` traces it.
"""

from __future__ import annotations

import json
import math
from dataclasses import astuple, dataclass
from typing import Final, Self

__all__ = ["NEGLIGIBLE", "Pilot"]

NEGLIGIBLE: Final = 1e-6
"""Part of the emitted power in the depth-capped row that is worth no word."""
_MOST: Final = 2**20 - 1
"""The largest generation cap that a scene may have."""
_MOST_RAYS: Final = 2**24
_LONGEST: Final = 4096
"""Characters of a pilot's text; it has a few hundred."""
_COUNTED: Final = 8.0
"""Rays that a decay is measured by, where there are so many: one that is lost by whole rays is
known to a third then."""
_STEADY: Final = 0.01
"""Part of the power under way that is lost while the cap doubles, below which it is not decaying in
any way that a cap could use."""
_LONG: Final = 1e8
"""Interactions of a batch that take many seconds on a few cores."""
_BY: Final = "by total reflection or by faces that take nothing"
_UNSEEN: Final = 3.0
"""Events of which none is seen with a probability of 5 %."""


@dataclass(frozen=True)
class Pilot:
    """What the rays of a pilot did.

    Parameters
    ----------
    rays : int
        Launched.
    cap : int
        The scene's generation cap.
    interactions : float
        Made of a launched ray, on average, up to that cap; up to where it was given up in a pilot
        that is not complete.
    missed : float
        Part of the emitted power that escapes without an interaction, in [0, 1].
    left : tuple of (int, float)
        Caps, ascending, half the scene's and the scene's first, and the part of the emitted power
        that is still under way at each.
    complete : bool
        Whether the rays could be followed to the scene's cap; else `left` may lack it.
    """

    rays: int
    cap: int
    interactions: float
    missed: float
    left: tuple[tuple[int, float], ...]
    complete: bool = True

    # -- what follows --------------------------------------------------------------------------

    @property
    def capped(self) -> float:
        """Part of the emitted power that is still under way at the scene's cap."""
        return dict(self.left).get(self.cap, 0.0)

    @property
    def lost(self) -> float:
        """Part of what was under way at half the largest cap that was gone at that cap."""
        (_, before), (_, after) = self.left[-2:] if len(self.left) > 1 else ((0, 0.0),) * 2
        return 1.0 - after / before if before > 0.0 else 1.0

    @property
    def needed_cap(self) -> int | None:
        """Cap that leaves about `NEGLIGIBLE`, to two digits; None where no cap seems to.

        By the slope of ln A between the last two caps at which enough is left to measure it; where
        A itself was followed down to `NEGLIGIBLE`, at least where it went through.
        """
        points = [point for point in self.left if point[1] > NEGLIGIBLE]
        beyond = next((point for point in self.left if 0.0 < point[1] <= NEGLIGIBLE), None)
        reached = len(points) < len(self.left)
        if len(points) < 2:
            # one cap alone gives no slope; the next one, where there is, had nothing left
            return self.left[-1][0] if reached else None
        if not reached and self.lost < _STEADY:
            return None
        solid = [point for point in points if point[1] * self.rays >= _COUNTED]
        found = _crossing(*(solid if len(solid) > 1 else points)[-2:])
        if beyond is not None:
            found = max(found, _crossing(points[-1], beyond))
        return _rounded_up(found) if found <= _MOST else None

    def __str__(self) -> str:
        more = "" if self.complete else "more than "
        parts = [f"{self.rays} rays", f"{more}{self.interactions:.3g} interactions a ray"]
        if self.missed > 0.0:
            parts.append(f"{_percent(self.missed)} of the power escapes without one")
        if self.complete and self.capped > 0.0:
            parts.append(f"{_percent(self.capped)} is left at the cap of {self.cap}")
        return ", ".join(parts)

    def before(self, rays_per_batch: int) -> str:
        """Return a sentence for before a run, empty where nothing is worth a word.

        Parameters
        ----------
        rays_per_batch : int
            Of that run.
        """
        batch = self.interactions * rays_per_batch
        if not self.complete and batch > _LONG:
            return (
                f"{self.rays} rays of a pilot made {self.interactions:.3g} interactions each and "
                f"had not ended at the generation cap of {self.cap}: a batch of {rays_per_batch} "
                f"makes more than {batch:.1g}; raise roulette_floor (1e-6, say), or lower "
                "generation_cap or rays_per_batch"
            )
        if self.capped <= NEGLIGIBLE:
            return ""
        return (
            f"by a pilot of {self.rays} rays, about {_percent(self.capped)} of the emitted power "
            f"will still be under way at the generation cap of {self.cap} and go to the "
            f"depth-capped row; {self.remedy()}"
        )

    def remedy(self) -> str:
        """Return what to do about power in the depth-capped row."""
        if not self.complete or self.capped <= NEGLIGIBLE:
            return "raise generation_cap"
        needed, last = self.needed_cap, self.left[-1][0]
        if needed is None:
            return self._held()
        by = "" if needed <= last else f", by the decay up to a cap of {last}"
        return f"raise generation_cap to about {needed}, which leaves about 1e-6{by}"

    def _held(self) -> str:
        """Say what is known of light of which little or nothing is lost any more."""
        cap, left = self.left[-1]
        start = next((m for m, part in self.left if 1.0 - left / part < 1e-9), cap)
        if start < cap:
            # that each had this chance of being lost, and none was, has a probability of 5 %
            most = _UNSEEN / (left * self.rays * (cap - start))
            return (
                f"at a cap of {cap} {self.rays} rays of a pilot have {_percent(left)} left, and "
                f"nothing of that is lost from {start} interactions on. It is trapped, {_BY}, or "
                f"it loses less than {most:.0e} of its power an interaction: a higher cap does not "
                "help; let something absorb it or open a way out"
            )
        return (
            f"at a cap of {cap} {self.rays} rays of a pilot have {_percent(left)} left, and the "
            f"last doubling of the cap took {_percent(self.lost)} of it. Either most of it is "
            f"trapped, {_BY}, or it decays so slowly that it would take a cap of "
            f"about {_crossing(*self.left[-2:]):.0e}: a higher cap hardly helps; let something "
            "absorb it or open a way out"
        )

    # -- files ---------------------------------------------------------------------------------

    def text(self) -> str:
        """Return it as text for `read`."""
        return json.dumps(astuple(self), allow_nan=False)

    @classmethod
    def read(cls, text: object) -> Self:
        """Return what `text` wrote.

        Raises
        ------
        ValueError
            Where it is none, or a number in it cannot be.
        """
        if not isinstance(text, str) or len(text) > _LONGEST:
            raise ValueError("its pilot is no line of text")
        try:
            rays, cap, interactions, missed, left, complete = json.loads(text)
            points = tuple((_whole(m), float(part)) for m, part in left)
            made = cls(
                _whole(rays), _whole(cap), float(interactions), float(missed), points,
                complete is True,
            )  # fmt: skip
        except (TypeError, ValueError, OverflowError, RecursionError) as error:
            raise ValueError(f"its pilot is none: {error}") from None
        caps = [m for m, _ in points]
        fits = (
            1 <= made.rays <= _MOST_RAYS
            and 0.0 <= made.interactions < math.inf
            and all(0.0 <= part <= 1.0 for part in (made.missed, *(part for _, part in points)))
            and caps == sorted(set(caps))
            and all(1 <= m <= _MOST for m in (made.cap, *caps))
        )
        if not fits:
            raise ValueError("its pilot has numbers that cannot be")
        return made


def _whole(value: object) -> int:
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    raise TypeError("a number in it is not whole")


def _crossing(one: tuple[int, float], other: tuple[int, float]) -> float:
    """Return where the line through two points of ln A meets `NEGLIGIBLE`."""
    slope = math.log(one[1] / other[1]) / (other[0] - one[0])
    if slope <= 0.0:
        return math.inf
    return other[0] + math.log(other[1] / NEGLIGIBLE) / slope


def _rounded_up(value: float) -> int:
    step = int(10.0 ** max(math.floor(math.log10(value)) - 1, 0))
    return min(math.ceil(value / step) * step, _MOST)


def _percent(part: float) -> str:
    return f"{100.0 * part:.3g} %" if part >= 1e-4 else f"{part:.1e}"
