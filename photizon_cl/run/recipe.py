"""A recipe that can be run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from photizon_cl.result.recipe import RecipeText

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.run.progress import Progress
    from photizon_cl.run.result import Result

__all__ = ["Recipe"]


@dataclass(frozen=True)
class Recipe(RecipeText):
    """How to make a result again.

    Parameters
    ----------
    scene : Scene
        As run.
    batches : int
        Batches in all.
    precision : str
        ``fp64``, ``mixed`` or ``fp32``.
    tally_digest : str
        What the run must give.
    version, engine : str
        The version of photizon_cl, and `engine_digest`, that made the result.
    """

    def trace(
        self,
        *,
        device: DeviceRecord | str | int | None = None,
        progress: Callable[[Progress], object] | None = None,
        executor: Executor | None = None,
        plan: ExecutionPlan | None = None,
        checkpoint: Any = None,
    ) -> Result:
        """Make the result again; every argument as in `photizon_cl.trace`.

        What comes out may still have other bits, or too few batches where Ctrl-C ended it: see
        `differs`.
        """
        from photizon_cl.run.simulation import trace  # a recipe is read without OpenCL

        return trace(
            self.scene, batches=self.batches, precision=self.precision, device=device,
            progress=progress, executor=executor, plan=plan, checkpoint=checkpoint,
        )  # fmt: skip
