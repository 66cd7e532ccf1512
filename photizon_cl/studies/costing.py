"""The study of what accuracy costs in time."""

from __future__ import annotations

import dataclasses
import time
from typing import TYPE_CHECKING, Any, Final

from hostcode.errors import Abandoned, HostError
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.quantities import quantity_of
from photizon_cl.errors import PhotizonError, RunError
from photizon_cl.result.cost import CostStudy
from photizon_cl.result.cost_advice import advice
from photizon_cl.result.pilot import NEGLIGIBLE, Pilot
from photizon_cl.run.batches import with_settings
from photizon_cl.run.interruption import interruptible
from photizon_cl.run.pilot import pilot
from photizon_cl.scene.files import load
from photizon_cl.scene.parameter_paths import quoted
from photizon_cl.studies.knobs import KNOBS, Knob, Option, as_it_stands, with_cap
from photizon_cl.studies.trial import Trial

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping, Sequence

    from hostcode.device.device import DeviceRecord
    from photizon_cl.scene.model import Scene

__all__ = ["Study", "cost"]

_SECONDS: Final = 120.0
_TURNS: Final = 12
"""Turns that each setting has: a moment in which the machine is slow meets all of them."""
_LEAST: Final = 256
"""Batches that each setting should have at least: σ² is known to 9 % by so many."""
_FEWEST_RAYS: Final = 2048
"""Rays of a batch that it is not made smaller than for their sake."""
_TRACING: Final = 0.25
"""Part of the time that is kept for tracing, should building programs take all of it."""
_PATIENCE: Final = 20.0
"""Times as long as the scene as it stands that a setting may take for a batch."""


def cost(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    quantity: str | None = None,
    max_seconds: float = _SECONDS,
    seed: int | None = None,
    device: DeviceRecord | str | int | None = None,
    progress: Callable[[str], object] | None = None,
) -> CostStudy:
    """Study what accuracy costs in time on a device: which settings trade how much of it.

    Traces the scene with its own settings and with others, one changed at a time, in turns; each
    has its σ, its bias against the most careful one by common random numbers, and its seconds.

    Parameters
    ----------
    scene : Scene, str, path or mapping
        A scene, or what `photizon_cl.load` makes one of.
    quantity : str, optional
        ``detectors.floor.power``, say; default the first of the scene's ``target_on``, else the
        power of its first detector, with a map where there is one, else what escapes. Of a map or
        the far field σ is the median relative one over the lit bins, as a run's target has it, and
        the bias that of their sum.
    max_seconds : float, optional
        For all of it, in (0, 1e9]; building programs may take longer.
    seed : int, optional
        The random stream; default the scene's.
    device : DeviceRecord, str or int, optional
        As in `photizon_cl.trace`.
    progress : callable, optional
        Given a line now and then.

    Returns
    -------
    CostStudy

    Raises
    ------
    SceneError, ArgumentError
        Where the scene or an argument is not valid.
    RunError
        Where there is no usable device, or the scene as it stands cannot be traced in the time.

    Examples
    --------
    >>> import photizon_cl as pz
    >>> study = pz.cost("integrating-sphere", max_seconds=20)  # doctest: +SKIP
    >>> study.advice  # doctest: +SKIP
    """
    as_run = with_settings(load(scene), seed=seed, max_seconds=max_seconds)
    return Study(as_run, quantity, device, progress or (lambda _: None)).run()


class Study:
    """A study under way.

    Parameters
    ----------
    scene : Scene
        With the study's seed, and its seconds as ``max_seconds``.
    quantity, device, progress
        As `cost` takes them.
    knobs : sequence of callable, optional
        What is tried, see `photizon_cl.studies.knobs`.
    """

    def __init__(
        self,
        scene: Scene,
        quantity: str | None,
        device: DeviceRecord | str | int | None,
        progress: Callable[[str], object],
        knobs: Sequence[Knob] = KNOBS,
    ) -> None:
        self.given, self.knobs = scene, knobs
        self.digest = scene.digest()
        self.device = str(device) if isinstance(device, int) else device
        self.progress = progress
        self.start = time.perf_counter()
        self.seconds = self.until = scene.run.max_seconds
        self.quantity = _checked(scene, quantity)
        self.asked = quantity is not None or bool(scene.run.target_on)
        self.left_out: list[tuple[str, str]] = []
        self.interrupted: Callable[[], bool] = lambda: False

    def run(self) -> CostStudy:
        """Make the study."""
        with interruptible() as self.interrupted:
            return self._run()

    def _run(self) -> CostStudy:
        scene, first = self._begun()
        cap, known = self._reference_cap()
        scene, first = self._smaller(scene, first, cap)
        reference, trials = first, [first]
        if cap != scene.run.generation_cap:
            reference = self._tried(with_cap(scene, cap), first, first) or first
            trials += [reference] if reference is not first else []
        # what each setting does by itself shows beside a cap that cuts nothing
        beside = reference.option.scene
        for option in (o for knob in self.knobs for o in knob(beside, cap)):
            if option.scene.run == scene.run and beside is not scene:
                continue  # the scene as it stands again
            if self._over(0.5):
                self.left_out.append((option.name, "no time was left to build its program"))
                continue
            trial = self._tried(option, first, reference)
            trials += [] if trial is None else [trial]
        self._take_turns(trials, reference)
        return self._told(trials, first, reference, known)

    def _tried(self, option: Option, first: Trial, reference: Trial) -> Trial | None:
        """Return a setting's trial with its first batch; None, and why is kept, where it has none.

        Parameters
        ----------
        option : Option
            The setting.
        first, reference : Trial
            The scene as it stands, and what the setting is one change of.
        """
        try:
            trial = self._opened(option)
            if trial.is_same(reference):
                self.left_out.append((option.name, "no program of the scene has that part"))
                return None
            self._advance(trial, 1, within=_PATIENCE * first.pace)
        except (PhotizonError, HostError, MemoryError) as error:
            self.left_out.append((option.name, str(error) or "no memory is left for it"))
            return None
        if trial.batches:
            return trial
        why = f"a batch takes more than {_PATIENCE:g} times as long as with fp64"
        self.left_out.append((option.name, "no time was left to trace it" if self._over() else why))
        return None

    def elapsed(self) -> float:
        """Return the seconds so far."""
        return time.perf_counter() - self.start

    def _over(self, part: float = 1.0) -> bool:
        return self.interrupted() or self.elapsed() > part * self.until

    def _opened(self, option: Option) -> Trial:
        self.progress(f"{option.name}: building its program")
        return Trial(option, self.quantity, self.device)

    def _advance(self, trial: Trial, n: int, within: float | None = None) -> None:
        """Trace batches, unless time is over on the way."""
        until = None if within is None else time.perf_counter() + within
        try:
            trial.advance(
                n, lambda: self._over() or (until is not None and time.perf_counter() > until)
            )
        except Abandoned:
            return

    def _reference_cap(self) -> tuple[int, Pilot | None]:
        """Return the generation cap that leaves next to nothing, by a pilot."""
        own = self.given.run.generation_cap
        self.progress("following a pilot's rays, for the generation cap")
        try:
            found = pilot(self.given, self.device, stop=self.interrupted)
        except (PhotizonError, HostError, MemoryError):
            return own, None
        for cap, left in found.left:
            if cap >= own and left <= NEGLIGIBLE:
                return cap, found
        needed = found.needed_cap
        return (max(found.left[-1][0], own) if needed is None else max(needed, own)), found

    def _begun(self) -> tuple[Scene, Trial]:
        """Trace a batch of the scene as it stands, of fewer rays where all would take too long.

        Raises
        ------
        RunError
            Where none ended in a quarter of the time.
        """
        usual = self.given.run.rays_per_batch
        few = max(_FEWEST_RAYS, self.given.fewest_rays)
        for rays in dict.fromkeys((usual, min(usual, few))):
            run = dataclasses.replace(self.given.run, rays_per_batch=rays)
            scene = dataclasses.replace(self.given, run=run)
            first = self._opened(as_it_stands(scene))
            self._advance(first, 1, within=0.25 * self.seconds)
            if first.batches:
                return scene, self._of_something(first)
            if self.interrupted():
                raise KeyboardInterrupt
        raise RunError(
            f"not one batch of {rays} rays ended within {0.25 * self.seconds:.0f} s, a quarter of "
            "the time: raise --max-seconds (max_seconds), or have the scene end its rays sooner, "
            "by --set run.roulette_floor=0.1 or a lower generation cap"
        )

    def _of_something(self, first: Trial) -> Trial:
        """Return the trial, or one of a quantity that is not 0 where nobody asked for this one."""
        if first.totals[0] or self.asked:
            return first
        name = first.strongest()
        if name is None:
            return first
        self.quantity = name
        trial = self._opened(first.option)
        self._advance(trial, 1)
        return trial if trial.batches else first

    def _smaller(self, scene: Scene, first: Trial, cap: int) -> tuple[Scene, Trial]:
        """Take fewer rays a batch where the time would not do for enough batches."""
        options = 2 + sum(1 for knob in self.knobs for _ in knob(scene, cap))
        share = 0.7 * (self.seconds - self.elapsed()) / options
        rays = least = scene.run.rays_per_batch
        pace = first.pace
        while pace * rays / least * _LEAST > share and rays // 2 >= max(
            _FEWEST_RAYS, scene.fewest_rays
        ):
            rays //= 2
        if rays == scene.run.rays_per_batch:
            return scene, first
        fewer = dataclasses.replace(scene, run=dataclasses.replace(scene.run, rays_per_batch=rays))
        trial = self._opened(as_it_stands(fewer))
        self._advance(trial, 1)
        return (fewer, trial) if trial.batches else (scene, first)

    def _take_turns(self, trials: list[Trial], reference: Trial) -> None:
        """Trace all settings in turn until the time is over."""
        # programs that took long to build leave some time all the same
        self.until = max(self.seconds, self.elapsed() + _TRACING * self.seconds)
        left = self.until - self.elapsed()
        turn = left / (_TURNS * (len(trials) + 1))
        number = 0
        while not self._over():
            number += 1
            self.progress(f"turn {number}, {self.elapsed():.0f} of {self.until:.0f} s")
            # every other turn goes backwards, so that none is always the first
            order = trials if number % 2 else trials[::-1]
            for trial in order:
                # a bias is known by the batches that both have
                times = 2.0 if trial is reference else 1.0
                n = trial.batches_in(times * turn)
                if self.elapsed() + 0.5 * n * trial.pace > self.until and trial.batches > 1:
                    continue
                self._advance(trial, n)
                if self._over():
                    return
            if self.elapsed() + 0.5 * turn > self.until:
                return

    def _told(
        self, trials: list[Trial], first: Trial, reference: Trial, known: Pilot | None
    ) -> CostStudy:
        if first.bins is not None:  # σ of the same bins everywhere, or nothing could be compared
            lit = first.bins.lit
            for trial in trials:
                if trial.bins is not None:
                    trial.bins.judge(lit)
        rows = tuple(trial.row(reference) for trial in trials)
        study = CostStudy(
            scene=self.given.name,
            scene_digest=self.digest,
            device=first.engine.device.record.label,
            quantity=self.quantity,
            given=first.option.name,
            reference=reference.option.name,
            rays_per_batch=first.compiled.settings.rays_per_batch,
            seed=first.compiled.settings.seed,
            seconds=self.elapsed(),
            settings=rows,
            left_out=tuple(self.left_out),
        )
        more = []
        cap = reference.compiled.settings.generation_cap
        if known is not None and (left := dict(known.left).get(cap, 0.0)) > NEGLIGIBLE:
            more.append(
                f"the reference's own cap of {cap} still cuts {100.0 * left:.2g} % of the emitted "
                f"power: {known.remedy()}"
            )
        if self.interrupted():
            more.append("the study was interrupted: fewer batches than there was time for")
        return dataclasses.replace(study, advice=(*advice(study), *more))


def _checked(scene: Scene, name: str | None) -> str:
    """Return the quantity of a study, by the name that it has everywhere.

    Raises
    ------
    ArgumentError
        Where it is none.
    """
    layout = compile_scene(scene, scene.run).layout
    if name is not None:
        return quantity_of(name, scene, layout).name
    for asked in scene.run.target_on or ():
        return quantity_of(asked, scene, layout).name
    for d in sorted(layout.detectors, key=lambda d: not d.nx):
        return f"detectors.{quoted(scene.element[d.element].name)}.power"
    return "ledger.escaped"
