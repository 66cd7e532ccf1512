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
from typing import TYPE_CHECKING, Final, Self

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["NEGLIGIBLE", "UNTOLD", "Pilot"]

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
_ENDLESS: Final = 1e3
"""Interactions of a ray that had not ended: it splits again and again, or cannot get away."""
_BY: Final = "by total reflection or by faces that take nothing"
UNTOLD: Final = (
    f"raise generation_cap; where a higher one cuts as much, the light is trapped, {_BY}, and no "
    "cap helps"
)
"""What to do where no pilot told."""
_SAME: Final = 1e-9
"""Part by which power that is under way may change and count as the same."""
_RAISED: Final = 2.0**20
"""Times the emitted power that may be under way: roulette adds to some rays what it takes of
others, and evens that out only on average."""
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
    def needed_cap(self) -> int | None:
        """Cap that leaves about `NEGLIGIBLE`, to two digits; None where no cap seems to.

        By the slope of ln A between the last two caps at which enough is left to measure it. Where
        A went down to `NEGLIGIBLE` at a cap that was tried, at least where it went through; and at
        most there where the slope says nothing of that, as with light that all ends at once.
        """
        points, through = self._points, self._through
        if through is None and (len(points) < 2 or self._lost < _STEADY):
            return None
        solid = [point for point in points if point[1] * self.rays >= _COUNTED]
        found, there = math.inf, math.inf
        for some in (solid, points):
            if len(some) > 1 and found > _MOST:
                one, other = some[-2:]
                found = _crossing(one, other)
                if through is not None and found <= _MOST:
                    there = _along(one, other, through[0])
        if through is not None:
            # so many rays would still be under way there by the slope, and none is
            refuted = there * self.rays > _UNSEEN
            if through[1] > 0.0 and points:
                passed = _crossing(points[-1], through)
                found = passed if refuted else max(found, passed)
            elif refuted:
                return through[0]
        found = max(found, points[-1][0] + 1.0) if points else found
        return _rounded_up(found) if found <= _MOST else None

    @property
    def _through(self) -> tuple[int, float] | None:
        """The first cap beyond the scene's that leaves no more than `NEGLIGIBLE`."""
        return next((p for p in self.left if p[0] > self.cap and p[1] <= NEGLIGIBLE), None)

    @property
    def _points(self) -> list[tuple[int, float]]:
        """Caps before that one at which more is left."""
        through = self._through
        end = math.inf if through is None else through[0]
        return [(m, part) for m, part in self.left if m < end and part > NEGLIGIBLE]

    @property
    def _lost(self) -> float:
        """Part that the last of those caps took of what was under way at the one before.

        Not negative: roulette may add a little.
        """
        (_, before), (_, after) = self._points[-2:]
        return max(1.0 - after / before, 0.0)

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
        if not self.complete and (batch > _LONG or self.interactions > _ENDLESS):
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
        if not self.complete:
            return UNTOLD
        if self.capped <= NEGLIGIBLE:
            return "raise generation_cap"
        needed, last = self.needed_cap, self.left[-1][0]
        if needed is None:
            return self._held() if len(self._points) > 1 else UNTOLD
        if (needed, 0.0) == self._through:
            return f"raise generation_cap to {needed}, where all rays of the pilot had ended"
        by = "" if needed <= last else f", by the decay up to a cap of {last}"
        return f"raise generation_cap to about {needed}, which leaves about 1e-6{by}"

    def _held(self) -> str:
        """Say what is known of light of which little or nothing is lost any more."""
        points = self._points
        cap, left = points[-1]
        start = cap
        for m, part in reversed(points):  # back to where it was more
            if part > left * (1.0 + _SAME):
                break
            start = m
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
            f"last doubling of the cap took {_percent(self._lost)} of it. Either most of it is "
            f"trapped, {_BY}, or it decays so slowly that it would take a cap of "
            f"about {_crossing(*points[-2:]):.0e}: a higher cap hardly helps; let something "
            "absorb it or open a way out"
        )

    # -- files ---------------------------------------------------------------------------------

    def text(self) -> str:
        """Return it as text for `read`."""
        return json.dumps(astuple(self), allow_nan=False)

    @classmethod
    def read(cls, text: object, generation_cap: int) -> Self:
        """Return what `text` wrote.

        Parameters
        ----------
        text : object
            What a file has for one.
        generation_cap : int
            Of the file's scene.

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
                _whole(rays), _whole(cap), float(interactions), float(missed), points, complete
            )  # fmt: skip
        except (TypeError, ValueError, OverflowError, RecursionError) as error:
            raise ValueError(f"its pilot is none: {error}") from None
        caps = [m for m, _ in points]
        tried = list(made._tried(len(caps)))
        fits = (
            1 <= made.rays <= _MOST_RAYS
            and 1 <= made.cap == generation_cap <= _MOST
            and 0.0 <= made.interactions < math.inf
            and all(0.0 <= part <= _RAISED for _, part in points)
            and 0.0 <= made.missed <= 1.0
            and caps == tried
            and made.complete is (made.cap in caps)
        )
        if not fits:
            raise ValueError("its pilot has numbers that cannot be")
        return made

    def _tried(self, most: int) -> Iterator[int]:
        """Give the first of the caps that a pilot tries, see `left`."""
        cap = self.cap
        caps = [*([cap // 2] if cap > 1 else []), cap]
        while len(caps) < most and caps[-1] < _MOST:
            caps.append(min(2 * caps[-1], _MOST))
        yield from caps[:most]


def _whole(value: object) -> int:
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    raise TypeError("a number in it is not whole")


def _slope(one: tuple[int, float], other: tuple[int, float]) -> float:
    """Return by how much ln A falls an interaction between two points."""
    return math.log(one[1] / other[1]) / (other[0] - one[0])


def _crossing(one: tuple[int, float], other: tuple[int, float]) -> float:
    """Return where the line through two points of ln A meets `NEGLIGIBLE`."""
    slope = _slope(one, other)
    if slope <= 0.0:
        return math.inf
    return other[0] + math.log(other[1] / NEGLIGIBLE) / slope


def _along(one: tuple[int, float], other: tuple[int, float], cap: int) -> float:
    """Return A at a later cap by the line through two points of ln A."""
    return other[1] * math.exp(_slope(one, other) * (other[0] - cap))


def _rounded_up(value: float) -> int:
    step = int(10.0 ** max(math.floor(math.log10(value)) - 1, 0))
    return min(math.ceil(value / step) * step, _MOST)


def _percent(part: float) -> str:
    return f"{100.0 * part:.3g} %" if part >= 1e-4 else f"{part:.1e}"
