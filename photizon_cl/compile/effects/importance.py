"""Importance sampling: scattered rays are sent towards targets."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hostcode.program.fields import LAUNCHED, RayField
from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.compile.layout import LedgerRow
from photizon_cl.geometry.placing import moved
from photizon_cl.geometry.targets import BALL, RING, target_of
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

_TARGET = Row(
    "TARGET",
    ("x", "m", "recentred centre"),
    ("y", "m", ""),
    ("z", "m", ""),
    *((f"{row}{axis}", "", "its frame") for row in "uvn" for axis in "xyz"),
    ("a", "m", "half size along u, outer radius, or radius of the ball"),
    ("b", "m", "half size along v, or inner radius"),
    ("per_area", "1/m²", "1 over its area, of a flat one"),
    ("reach", "m", "radius of a ball around the centre that holds it"),
    ("side", "", "1 or −1 where only that side counts, else 0"),
    ("shape", "", "SQUARE, RING or BALL of photizon_cl/geometry/targets.py"),
    ("share", "", "part of what is sent towards targets"),
    ("per_share", "", "1 over that"),
    ("first", "", "sum of the shares before it"),
    ("end", "", "sum of the shares up to it, 1 of the last one"),
)
"""What the kernel reads of a target."""

_RATIO = RayField(
    "ratio",
    "weight",
    "weight_splat(1.0)",
    "weight over what it would be without importance",
    onward="p->ratio * SEL_WEIGHT(outcome.drawn_second, weight_splat(1.0), outcome.ratio)",
    second="p->ratio * SEL_WEIGHT(outcome.drawn_second, outcome.ratio, weight_splat(1.0))",
)
"""What a ray carries where roulette is played: its floor is one of the weight without importance,
or it would end just those rays that were sent where they matter."""


class Importance(Effect):
    """Scattered rays are drawn from the mixture of their surface's density and the targets'."""

    name: ClassVar[str] = "importance"
    what: ClassVar[str] = "scattered rays are sent towards chosen elements, and weighted for it"
    costs: ClassVar[str] = (
        "a random block a scattering, a direction and two densities a target; a ledger row"
    )

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where the scene asks for it, and something scatters."""
        asked = scene.importance
        if asked is None or not asked.fraction or not scene.scatters:
            return None
        first = asked.toward[0]
        more = f" and {len(asked.toward) - 1} more" if len(asked.toward) > 1 else ""
        return f'[importance] sends {asked.fraction:g} of what scatters toward "{first}"{more}'

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        if scene.importance is None:
            return "the scene has no [importance]"
        if not scene.importance.fraction:
            return "importance.fraction is 0"
        return "no surface scatters"

    def possible(self, scene: Scene) -> bool:
        """Not without targets."""
        return False

    def heaviest(self, scene: Scene, settings: RunSettings) -> float:
        """Return the weight beyond which no ray is made heavier (HEAVIEST in its kernel)."""
        return 2.0

    def rows(self, scene: Scene) -> tuple[LedgerRow, ...]:
        """Return what the weights lose; negative where they gain."""
        return (LedgerRow("importance.balance", 1, "importance balance", signed=True),)

    def parts(self, draft: Draft) -> EffectParts:
        """Return the draw."""
        call = "send_toward(launch, scene, p, h, c, ledger, row, &outcome);"
        floor = draft.scene.roulette_floor(draft.settings)
        return EffectParts(
            ray=(LAUNCHED,) * draft.weights_differ + (_RATIO,) * (floor > 0.0),
            templates=(("survive", "effects/importance"),),
            hooks=(("surface", call),),
            launch=(
                ("toward_fraction", "double", "part of the scattered rays that targets draw"),
                ("targets", "ulong", "where in the geometry table the targets stand"),
                ("n_targets", "ulong", "their number"),
            ),
            densities=True,
            parameters=(
                ("target_numbers", len(_TARGET)),
                ("target_ring", RING),
                ("target_ball", BALL),
                *_TARGET.constants(0).items(),
            ),
        )

    def assemble(self, draft: Draft) -> None:
        """Put the targets behind the elements' rows, and behind the tree where there is one."""
        asked = draft.scene.importance
        assert asked is not None
        assert draft.geometry is not None
        rows, first = [], 0.0
        for n, (name, share) in enumerate(asked.shares.items(), 1):
            end = 1.0 if n == len(asked.toward) else first + share
            target = target_of(draft.scene.element[name])
            x, y, z = moved(target.centre, draft.shift)
            (ux, uy, uz), (vx, vy, vz), (nx, ny, nz) = target.frame
            values = {
                "x": x, "y": y, "z": z, "ux": ux, "uy": uy, "uz": uz, "vx": vx, "vy": vy,
                "vz": vz, "nx": nx, "ny": ny, "nz": nz, "a": target.a, "b": target.b,
                "per_area": 1.0 / target.area if target.area else 0.0, "reach": target.reach,
                "side": float(target.side), "shape": float(target.shape), "share": share,
                "per_share": 1.0 / share,
                "first": first, "end": end,
            }  # fmt: skip
            rows.append(_TARGET.pack(values))
            first = end
        draft.launch["toward_fraction"] = asked.fraction
        draft.launch["targets"] = len(draft.geometry)
        draft.launch["n_targets"] = len(rows)
        draft.geometry = np.concatenate((draft.geometry, np.ravel(rows)))
