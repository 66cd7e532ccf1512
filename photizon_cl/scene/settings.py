"""How a scene is run by default."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Final, Literal

from photizon_cl.scene.declarations import flag, fraction_or, integer, number, words
from photizon_cl.scene.described import ABSENT, Accepts, Described

if TYPE_CHECKING:
    from collections.abc import Sequence

MAX_SEED: Final = 2**64 - 1
MAX_RAYS_PER_BATCH: Final = 2**24
MAX_GENERATION_CAP: Final = 2**20 - 1


@dataclass(frozen=True, kw_only=True)
class RunSettings(Described):
    """The ``[run]`` table: how the scene is run unless a call says otherwise.

    Parameters
    ----------
    seed : int
        Key of the random stream, 0 … 2^64 − 1.
    rays_per_batch : int
        Rays launched in a batch, 1 … 2^24.
    target_sigma : float
        Median relative standard error at which a run stops, in (0, 1].
    target_on : tuple of str, optional
        Quantities that must each meet the target, for example ``detectors.floor.power``; default
        the median over maps, detectors or rows, see the summary's ``achieved_sigma``.
    max_seconds : float
        Time at which a run stops, in (0, 1e9] seconds.
    generation_cap : int
        Interactions that are made of a ray and its descendants, 1 … 2^20 − 1.
    roulette_floor : float or "auto"
        Weight relative to the launched one below which roulette is played, in [0, 1]; 0 is off.
        ``"auto"``: 10⁻⁹ in a scene whose rays split, else 0. What splits between two faces again
        and again would else have no practical end.
    splitting : bool
        Whether a ray that meets a surface which splits goes on as both children; else as one of
        them with the weight of both, chosen by chance in proportion to their weights.
    polarisation : bool
        Whether rays carry the polarisation of their light, which decides how much glass reflects.
    effects : tuple of str, optional
        Effects that are compiled in although nothing else in the scene calls for them, by the names
        that ``photizon kinds`` lists.
    """

    label: ClassVar[str] = "run"

    seed: int = field(default=1, metadata=integer(0, MAX_SEED, "random stream", "2^64 - 1"))
    rays_per_batch: int = field(
        default=65536, metadata=integer(1, MAX_RAYS_PER_BATCH, "rays launched in a batch")
    )
    target_sigma: float = field(
        default=0.05,
        metadata=number(
            "a number in (0, 1]", 0.0, 1.0, "relative standard error to stop at", open_low=True
        ),
    )
    max_seconds: float = field(
        default=60.0,
        metadata=number(
            "a positive time in seconds, up to 1e9", 0.0, 1e9, "time to stop at", "s", open_low=True
        ),
    )
    generation_cap: int = field(
        default=32, metadata=integer(1, MAX_GENERATION_CAP, "interactions made of a ray")
    )
    roulette_floor: float | Literal["auto"] = field(
        default="auto",
        metadata=fraction_or(
            "auto", "relative weight below which roulette is played", "0 switches it off"
        ),
    )
    splitting: bool = field(
        default=True,
        metadata=flag("whether both children of a ray go on, or one that is chosen by chance"),
    )
    polarisation: bool = field(
        default=False, metadata=flag("whether rays carry the polarisation of their light")
    )
    target_on: Accepts[Sequence[str] | None, tuple[str, ...] | None] = field(
        default=ABSENT, metadata=words("quantities that must each meet the target")
    )
    effects: Accepts[Sequence[str] | None, tuple[str, ...] | None] = field(
        default=ABSENT, metadata=words("effects compiled in although nothing else calls for them")
    )
