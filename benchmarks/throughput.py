"""Surface interactions per second: every composition and lane width beside a scalar whole path.

All cells of a scene are measured in interleaved rounds, in an order that is shuffled anew (with a
fixed seed) in each, so that a slow minute of the machine hits all of them alike. Ratios are taken
round by round, and their median and quartiles are reported. The tallies of all cells of a scene
must be the same bits, or there is no result.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from benchmarks import cells
from benchmarks.report import Spread, table
from benchmarks.runner import Runner, Timing, compiled_preset, kernel_seconds
from hostcode.device.device import open_device, preferred_lanes
from hostcode.errors import DeviceError
from hostcode.program.plan import default_plan

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.cells import Cell
    from benchmarks.report import Report
    from hostcode.device.device import DeviceRecord, OpenDevice

WANTED_RATIO: Final = {"integrating-sphere": 3.5, "box-room": 4.0}
"""Times the scalar whole path that the default composition shall reach."""
WANTED_OVERHEAD: Final = 0.05
"""Part of the wall's time that may pass outside kernels."""
WANTED_SCALING: Final = 1.7
"""Two cores over one."""
_SHUFFLE: Final = 20250101


@dataclass(frozen=True)
class Settings:
    """How long and how much.

    Parameters
    ----------
    scenes : tuple of str
        Presets.
    rounds : int
        Rounds, each of which measures every cell once.
    seconds : float
        Time that a cell runs in a round, at least one wave.
    lanes, compositions
        Which cells.
    rays_per_batch, batches : int, optional
        A smaller problem than the preset's own, for a test of the harness.
    """

    scenes: tuple[str, ...] = cells.SCENES
    rounds: int = 7
    seconds: float = 0.25
    lanes: tuple[int, ...] = cells.LANES
    compositions: tuple[str, ...] = cells.COMPOSITIONS
    rays_per_batch: int | None = None
    batches: int | None = None


@dataclass
class Series:
    """A cell's timings, a round each."""

    cell: Cell
    timings: list[Timing] = field(default_factory=list)

    @property
    def rates(self) -> list[float]:
        """Millions of interactions per second, round by round."""
        return [timing.rate for timing in self.timings]

    def over(self, other: Series) -> Spread:
        """Return the spread of this series over another one, round by round."""
        return Spread.of(a / b for a, b in zip(self.rates, other.rates, strict=True))


def core_counts(record: DeviceRecord) -> tuple[int, ...]:
    """Return one compute unit and all of them, where a device can be divided and has several."""
    if record.type == "gpu" or record.compute_units == 1:
        return (record.compute_units,)
    try:
        open_device(record, compute_units=1)
    except DeviceError:
        return (record.compute_units,)
    return (1, record.compute_units)


def measure(record: DeviceRecord, settings: Settings, report: Report) -> dict[str, Any]:
    """Measure every scene, print its table and the verdicts, and return everything as data.

    Raises
    ------
    AssertionError
        If two cells of a scene gave other bits.
    """
    cores = core_counts(record)
    devices = {n: open_device(record, compute_units=n) for n in cores}
    profiled = open_device(record, profiling=True)
    scenes = {}
    for name in settings.scenes:
        scenes[name] = _measure_scene(name, record, devices, profiled, settings, report)
    data: dict[str, Any] = {
        "rounds": settings.rounds,
        "seconds_per_cell": settings.seconds,
        "scenes": scenes,
    }
    data["acceptance"] = _verdicts(scenes, cores)
    report.heading("Does it hold?")
    report.say(*(verdict["text"] for verdict in data["acceptance"]))
    return data


# -- one scene -----------------------------------------------------------------------------------


def _measure_scene(
    name: str,
    record: DeviceRecord,
    devices: dict[int, OpenDevice],
    profiled: OpenDevice,
    settings: Settings,
    report: Report,
) -> dict[str, Any]:
    compiled = compiled_preset(name, settings.rays_per_batch)
    splitting = "splitting" in compiled.effects
    cores = tuple(devices)
    wanted = cells.cells(
        record, cores, splitting=splitting, lanes=settings.lanes, compositions=settings.compositions
    )
    plan = default_plan(record, preferred_lanes(record))
    default = Runner(profiled, compiled, plan, settings.batches)
    default.warm_up(settings.seconds)
    # Every cell traces the same batches: as many as the default has in flight at once.
    batches = default.batches
    runners = [Runner(devices[c.cores], compiled, c.plan, batches) for c in wanted]
    for runner in runners:
        runner.warm_up(settings.seconds)
    series = [Series(cell) for cell in wanted]
    overheads: list[dict[str, float]] = []
    turns: list[Callable[[], None]] = [
        *(
            lambda s=s, r=r: s.timings.append(r.time())
            for s, r in zip(series, runners, strict=True)
        ),
        lambda: overheads.append(_overhead(default)),
    ]
    generator = random.Random(_SHUFFLE)
    for _ in range(settings.rounds):
        generator.shuffle(turns)
        for turn in turns:
            turn()
    digest = _same_digest(name, series)
    rays = compiled.settings.rays_per_batch
    interactions = series[0].timings[0].interactions // runners[0].repeats
    report.heading(name)
    report.say(
        f"{batches} batches of {rays} rays, {interactions / 1e6:.2f} M interactions, traced again "
        f"and again; {settings.rounds} rounds of {len(wanted)} cells.",
        f"tally digest {digest[:23]}…, the same in every cell and round.",
        "M/s: millions of surface interactions per second, median [quartiles]; × whole path: its",
        "ratio to the scalar whole path on as many cores, round by round; * is the default.",
        "",
    )
    rows, data = _rows(series, cores)
    report.say(*table(*rows, left=2))
    overhead = {key: Spread.of(o[key] for o in overheads) for key in overheads[0]}
    report.say("", *_overhead_lines(overhead, plan.wave_rays))
    used = Spread.of(
        t.cpu_seconds / t.seconds
        for s in series
        if s.cell.default and s.cell.cores == cores[-1]
        for t in s.timings
    )
    busy = f"the default on {_cores(cores[-1])} kept {used.text(2)} of them busy"
    report.say(f"{busy}; fewer means that the machine had other work")
    return {
        "batches": batches,
        "rays_per_batch": rays,
        "interactions": interactions,
        "digest": digest,
        "cells": data,
        "overhead": {key: value.data() for key, value in overhead.items()},
        "cores_used": used.data(),
        "headline": _headline(series, cores),
    }


def _same_digest(name: str, series: list[Series]) -> str:
    found: dict[str, list[str]] = {}
    for s in series:
        for timing in s.timings:
            label = f"{s.cell.composition}, {s.cell.lanes} lanes, {s.cell.cores} cores"
            found.setdefault(timing.digest, []).append(label)
    if len(found) != 1:
        parts = "; ".join(f"{d[:23]}: {sorted(set(labels))}" for d, labels in found.items())
        raise AssertionError(f"{name}: compositions disagree about the tally: {parts}")
    return next(iter(found))


def _overhead(runner: Runner) -> dict[str, float]:
    """Run the default with profiling: what part of the wall's time no kernel ran in."""
    with kernel_seconds() as kernels:
        timing = runner.time()
    return {
        "enqueue": timing.enqueue_seconds / timing.seconds,
        "enqueue_cpu": kernels.enqueue_cpu / timing.seconds,
        "host": 1.0 - kernels.total / timing.seconds,
        "launches_per_second": kernels.launches / timing.seconds,
    }


def _overhead_lines(overhead: dict[str, Spread], wave_rays: int) -> list[str]:
    launches = overhead["launches_per_second"].median
    host, enqueue, cpu = (
        overhead[key].text(2, 100.0) for key in ("host", "enqueue", "enqueue_cpu")
    )
    default = f"default, waves of up to {wave_rays} rays, {launches:.0f} launches/s"
    calls = f"{cpu} % is processor time in enqueue calls; {enqueue} % passes while one is under way"
    return [
        f"{default}: {host} % of the wall's time outside kernels;",
        f"{calls} (kernels run meanwhile)",
    ]


def _rows(
    series: list[Series], cores: tuple[int, ...]
) -> tuple[tuple[list[str], list[list[str]]], list[dict[str, Any]]]:
    by_key = {(s.cell.composition, s.cell.lanes, s.cell.cores): s for s in series}
    base = {n: by_key[cells.WHOLE_PATH, 1, n] for n in cores}
    header = ["composition", "lanes"]
    for n in cores:
        header += [f"{_cores(n)}: M/s", "× whole path"]
    if len(cores) > 1:
        header += ["M/s a core", f"{cores[-1]} cores / 1"]
    rows: list[list[str]] = []
    data: list[dict[str, Any]] = []
    for composition, lanes in dict.fromkeys((s.cell.composition, s.cell.lanes) for s in series):
        mark = ""
        row = []
        for n in cores:
            s = by_key[composition, lanes, n]
            mark = "*" if s.cell.default else mark
            rate, ratio = Spread.of(s.rates), s.over(base[n])
            row += [rate.text(), ratio.text(2)]
            data.append(
                {
                    "composition": composition,
                    "lanes": lanes,
                    "cores": n,
                    "default": s.cell.default,
                    "plan": _plan(s.cell),
                    "rate": rate.data(),
                    "over_whole_path": ratio.data(),
                    "rates": [float(f"{r:.5g}") for r in s.rates],
                }
            )
        if len(cores) > 1:
            one, every = (by_key[composition, lanes, n] for n in (cores[0], cores[-1]))
            row += [
                f"{Spread.of(every.rates).median / cores[-1]:.1f}",
                every.over(one).text(2),
            ]
        rows.append([composition, f"{lanes}{mark}", *row])
    return (header, rows), data


def _plan(cell: Cell) -> dict[str, Any]:
    return {name: getattr(cell.plan, name) for name in cell.plan.__dataclass_fields__}


def _cores(n: int) -> str:
    return "1 core" if n == 1 else f"{n} cores"


# -- the verdicts --------------------------------------------------------------------------------


def _headline(series: list[Series], cores: tuple[int, ...]) -> dict[str, Any]:
    """Return what the verdicts need: the default over the scalar cells, and two cores over one."""
    found: dict[str, Any] = {}
    default = {s.cell.cores: s for s in series if s.cell.default}
    for n in cores:
        scalar = [
            s for s in series if s.cell.cores == n and s.cell.lanes == 1 and s is not default[n]
        ]
        whole = next(s for s in scalar if s.cell.composition == cells.WHOLE_PATH)
        best = max(scalar, key=lambda s: Spread.of(s.rates).median)
        found[f"over_whole_path_{n}"] = default[n].over(whole).data()
        found[f"over_best_scalar_{n}"] = default[n].over(best).data()
        found[f"best_scalar_{n}"] = best.cell.composition
    if len(cores) > 1:
        found["scaling"] = default[cores[-1]].over(default[cores[0]]).data()
    return found


def _verdicts(scenes: dict[str, dict[str, Any]], cores: tuple[int, ...]) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = []

    def verdict(
        what: str, spread: dict[str, float], wanted: float, *, percent: bool = False
    ) -> None:
        scale, unit, digits = (100.0, " %", 2) if percent else (1.0, "", 2)
        holds = spread["median"] < wanted if percent else spread["median"] >= wanted
        sign = "<" if percent else "≥"
        middle, low, high = (scale * spread[k] for k in ("median", "low", "high"))
        text = (
            f"{'holds   ' if holds else 'FAILS   '} {what}: {middle:.{digits}f}{unit} "
            f"[{low:.{digits}f}–{high:.{digits}f}], wanted {sign} {scale * wanted:g}{unit}"
        )
        out.append({"text": text, "holds": holds, "value": spread["median"], "wanted": wanted})

    for name, wanted in WANTED_RATIO.items():
        if name in scenes:
            headline = scenes[name]["headline"]
            for n in cores:
                what = f"{name}, {_cores(n)}: default over the scalar whole path"
                verdict(what, headline[f"over_whole_path_{n}"], wanted)
    for name, scene in scenes.items():
        for key, what in (
            ("host", "overhead, all of the wall's time outside kernels"),
            ("enqueue_cpu", "overhead, processor time in enqueue calls alone"),
        ):
            verdict(f"{name}: {what}", scene["overhead"][key], WANTED_OVERHEAD, percent=True)
    if len(cores) > 1 and cores[-1] == 2:
        for name, scene in scenes.items():
            verdict(f"{name}: two cores over one", scene["headline"]["scaling"], WANTED_SCALING)
    for name, scene in scenes.items():
        for n in cores:
            best = scene["headline"][f"over_best_scalar_{n}"]
            text = (
                f"for the record: {name}, {_cores(n)}: default over the best scalar cell "
                f"({scene['headline'][f'best_scalar_{n}']}): {best['median']:.2f} "
                f"[{best['low']:.2f}–{best['high']:.2f}]"
            )
            out.append({"text": text, "holds": None, "value": best["median"], "wanted": None})
    return out
