"""Every point of a sweep looked at before any is run."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from photizon_cl.checks.precision import DEFAULT, fitting_mode, mode_of
from photizon_cl.compile.common import Common, kinds_of
from photizon_cl.compile.compiled import CompiledScene, compile_scene
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.errors import MOST_PROBLEMS, ArgumentError, Problem, SceneError, join, key
from photizon_cl.result.measures import Measure, measures_of
from photizon_cl.run.batches import goal_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from photizon_cl.result.stopping import Goal
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.sweeps import SweepPlan

__all__ = ["Checked", "checked", "measures_at"]

_OWN = frozenset(effect.name for effect in EFFECTS)


@dataclass(frozen=True)
class Checked:
    """A sweep whose points can all be run.

    Parameters
    ----------
    plan : SweepPlan
        The sweep.
    measured : tuple of Measure
        What each point is asked for.
    common : dict
        What all points need of a program, by the kinds of their objects.
    precision : str
        What the kernels compute in.
    """

    plan: SweepPlan
    measured: tuple[Measure, ...]
    common: dict[tuple[str, ...], Common]
    precision: str

    def goal(self, scene: Scene) -> Goal:
        """Return what a point is to reach."""
        return _goal(self.plan, scene)

    def compiled(self, scene: Scene) -> CompiledScene:
        """Return a point's scene, for the program that all points share."""
        shared = self.common.get(kinds_of(scene))
        return compile_scene(scene, scene.run, precision=self.precision, common=shared)


def _goal(plan: SweepPlan, scene: Scene) -> Goal:
    """Return what a point is to reach: a number of batches only where the sweep gives one."""
    varied = {axis.path for axis in plan.axes}

    def given(name: str) -> Any:
        return getattr(scene.run, name) if name in plan.run or f"run.{name}" in varied else None

    return goal_of(scene, plan.given("batches"), given("target_sigma"), given("max_seconds"))


def checked(plan: SweepPlan, tell: Callable[[str], object] = lambda _: None) -> Checked:
    """Look at every point of a sweep, and make a program's needs of all of them.

    Parameters
    ----------
    plan : SweepPlan
        The sweep.
    tell : callable, optional
        Told what is being looked at.

    Raises
    ------
    SceneError
        With everything that is wrong, once each, with the first point where it is.
    """
    return _Check(plan, tell).run()


def measures_at(plan: SweepPlan) -> tuple[Measure, ...]:
    """Return what a sweep measures, of a sweep whose points were looked at before."""
    scene = plan.scene_at(0)
    return tuple(measures_of(plan.measures, scene, compile_scene(scene, scene.run).layout, []))


class _Check:
    """Collects what is wrong, and what the points need."""

    def __init__(self, plan: SweepPlan, tell: Callable[[str], object]) -> None:
        self.plan, self.tell = plan, tell
        self.found: dict[tuple[str, str, str], tuple[Problem, int, int]] = {}
        self.common: dict[tuple[str, ...], Common] = {}
        self.measured: list[Measure] | None = None
        self.scenes = 0
        """Points that are scenes."""

    def run(self) -> Checked:
        plan = self.plan
        precision = DEFAULT if plan.given("precision") is None else plan.given("precision")
        self.settings(precision)
        for number in range(len(plan)):
            if number % 100 == 0:
                self.tell(f"looking at point {number} of {len(plan)}")
            self.point(number, precision)
            if len(self.found) > MOST_PROBLEMS:
                break
        self.done()
        assert self.measured is not None
        return Checked(plan, tuple(self.measured), self.common, precision)

    def settings(self, precision: str) -> None:
        """Look at what the sweep's [run] has beside a scene's."""
        problems = []
        try:
            mode_of(precision)
        except ArgumentError as error:
            problems.append(_problem("run", str(error)))
        if not any(axis.path == "run.rays_per_batch" for axis in self.plan.axes):
            try:
                goal_of(self.plan.scene, self.plan.given("batches"), None, None)
            except ArgumentError as error:
                problems.append(_problem("run", str(error)))
        self.fail(problems)

    def fail(self, problems: list[Problem]) -> None:
        if problems:
            raise SceneError(dataclasses.replace(p, file=self.plan.file) for p in problems)

    def point(self, number: int, precision: str) -> None:
        try:
            scene = self.plan.scene_at(number)
            fitting_mode(precision, scene)
            _goal(self.plan, scene)
            if scene.run.rays_per_batch < scene.fewest_rays:
                raise ArgumentError(
                    f"rays_per_batch: found {scene.run.rays_per_batch}, expected at least "
                    f"{scene.fewest_rays}, one for each {scene.ray_needs}"
                )
            compiled = compile_scene(scene, scene.run, precision=precision)
        except SceneError as error:
            for problem in error.problems:
                self.note(number, problem)
        except ArgumentError as error:
            for line in str(error).split("\n"):
                self.note(number, _problem("", line))
        else:
            self.scenes += 1
            self.measures(number, compiled)
            needs = Common.of(scene, compiled.tables.spec, compiled.effects & _OWN)
            before = self.common.get(kinds_of(scene))
            self.common[kinds_of(scene)] = before | needs if before else needs

    def measures(self, number: int, compiled: CompiledScene) -> None:
        """See that a point has what is measured."""
        scene, layout = compiled.scene, compiled.layout
        if self.measured is None:
            problems: list[Problem] = []
            self.measured = measures_of(self.plan.measures, scene, layout, problems)
            self.fail(problems)
        for measure in self.measured:
            try:
                measure.check(scene, layout)
            except ArgumentError as error:
                self.note(number, _problem(join("measure", key(measure.name)), str(error)))

    def note(self, number: int, problem: Problem) -> None:
        """Keep a problem of a point; the same one of others is counted."""
        what = problem.path, problem.expected, problem.hint
        kept, first, times = self.found.get(what, (problem, number, 0))
        self.found[what] = kept, first, times + 1

    def done(self) -> None:
        """Raise what was found."""
        problems = []
        n = len(self.plan)
        for kept, first, times in self.found.values():
            path = f"point {first}: {kept.path}" if kept.path else f"point {first}"
            where = f"at {self.plan.said(first)}"
            if kept.path.startswith("measure.") and times == self.scenes:
                path, where = kept.path, ""  # the measure is wrong, and no point
            elif times == n and n > 1:
                where = "at every point"
            elif times > 1:
                where += f" and {times - 1} more point{'s' * (times > 2)}"
            hint = "; ".join(text for text in (kept.hint, where) if text)
            problems.append(dataclasses.replace(kept, path=path, hint=hint))
        self.fail(problems)


def _problem(path: str, text: str) -> Problem:
    """Return a message about an argument as a problem."""
    before, _, expected = text.partition(", expected ")
    where, sep, found = before.partition("found ")
    where = where.rstrip(": ")
    if not expected or not sep:
        return Problem(path, "what cannot be run", f"a scene that can: {text}")
    return Problem(f"{path}: {where}" if path and where else path or where, found, expected)
