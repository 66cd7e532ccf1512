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
_COUNTED: Final = 8.0
"""Rays that a decay is measured by, where there are so many: one that is lost by whole rays is
known to a third then."""
_STEADY: Final = 0.01
"""Part of the power under way that is lost while the cap doubles, below which it is not decaying in
any way that a cap could use."""
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
    def decays(self) -> bool:
        """Whether some cap may leave little: what is under way falls as the cap rises."""
        return self.needed_cap is not None

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

    def advice(self, measured: float | None = None) -> str:
        """Return a sentence on what the cap cuts, empty where that is not worth a word.

        Parameters
        ----------
        measured : float, optional
            That part of the emitted power as a run found it; default as the pilot found it.
        """
        part = self.capped if measured is None else measured
        if measured is None and not self.complete:
            return (
                f"{self.rays} rays of a pilot made over {self.interactions:.3g} interactions each "
                f"and had not ended at the generation cap of {self.cap}: a batch of many rays will "
                "take long; raise roulette_floor (1e-6, say) or lower generation_cap"
            )
        if part <= NEGLIGIBLE:
            return ""
        who = f"by a pilot of {self.rays} rays, about " if measured is None else ""
        goes = "would go" if measured is None else "went"
        told = (
            f"{who}{_percent(part)} of the emitted power is still under way at the generation cap "
            f"of {self.cap} and {goes} to the depth-capped row; "
        )
        if not self.complete or self.capped <= NEGLIGIBLE:
            return told + "raise generation_cap"
        needed = self.needed_cap
        if needed is not None:
            by = "" if needed <= self.left[-1][0] else ", by the decay up to a cap of "
            by += f"{self.left[-1][0]}" if by else ""
            return told + f"a generation_cap of about {needed} leaves 1e-6 of it{by}"
        return told + self._held()

    def _held(self) -> str:
        """Say what is known of light of which little or nothing is lost any more."""
        cap, left = self.left[-1]
        start = next((m for m, part in self.left if 1.0 - left / part < 1e-9), cap)
        if start < cap:
            # that each had this chance of being lost, and none was, has a probability of 5 %
            most = _UNSEEN / (left * self.rays * (cap - start))
            return (
                f"of that nothing is lost from {start} to {cap} interactions. It is trapped, by "
                "total reflection or by faces that take nothing, or it loses less than "
                f"{most:.0e} of its power an interaction: raising the cap does not help; let "
                "something absorb it or open a way out"
            )
        return (
            f"at a cap of {cap} there are still {_percent(left)}, and the last doubling of the cap "
            f"took {_percent(self.lost)} of that. Either most of it is trapped, by total "
            "reflection or by faces that take nothing, or it decays so slowly that it would take a "
            f"cap above {_most_wanted(self.left)}: raising the cap hardly helps; let something "
            "absorb it or open a way out"
        )

    # -- files ---------------------------------------------------------------------------------

    def text(self) -> str:
        """Return it as text for `read`."""
        return json.dumps(astuple(self), allow_nan=False)

    @classmethod
    def read(cls, text: str) -> Self:
        """Return what `text` wrote.

        Raises
        ------
        ValueError
            Where it is none, or a number in it cannot be.
        """
        try:
            rays, cap, interactions, missed, left, complete = json.loads(text)
            left = tuple((int(m), float(part)) for m, part in left)
            made = cls(int(rays), int(cap), float(interactions), float(missed), left, bool(complete))
        except (TypeError, OverflowError) as error:
            raise ValueError(f"its pilot is none: {error}") from None
        caps = [m for m, _ in left]
        parts = [made.missed, *(part for _, part in left)]
        fits = (
            1 <= made.rays <= 2**24
            and 1 <= made.cap <= _MOST
            and 0.0 <= made.interactions < math.inf
            and all(0.0 <= part <= 2.0 for part in parts)
            and caps == sorted(set(caps))
            and len(caps) <= 64
            and all(1 <= m <= _MOST for m in caps)
        )
        if not fits:
            raise ValueError("its pilot has numbers that cannot be")
        return made


def _crossing(one: tuple[int, float], other: tuple[int, float]) -> float:
    """Return where the line through two points of ln A meets `NEGLIGIBLE`."""
    slope = math.log(one[1] / other[1]) / (other[0] - one[0])
    if slope <= 0.0:
        return math.inf
    return other[0] + math.log(other[1] / NEGLIGIBLE) / slope


def _most_wanted(left: tuple[tuple[int, float], ...]) -> str:
    """Return the cap that the last slope asks for, as text."""
    wanted = _crossing(*left[-2:])
    return f"{wanted:.0e}" if wanted < math.inf else "any"


def _rounded_up(value: float) -> int:
    step = 10 ** max(math.floor(math.log10(value)) - 1, 0)
    return min(math.ceil(value / step) * step, _MOST)


def _percent(part: float) -> str:
    return f"{100.0 * part:.3g} %" if part >= 1e-4 else f"{part:.1e}"
