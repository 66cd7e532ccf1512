"""What a report says in words: the summary, the key figures, how the run was made."""

from __future__ import annotations

import platform
from importlib import metadata
from typing import TYPE_CHECKING, Final

from markupsafe import Markup

from photizon_cl.compile.effects.table import EFFECT_ROWS
from photizon_cl.result.text import lit_percent
from photizon_cl.views.report.numbers import amount, brief, integer, number, percent, share
from photizon_cl.views.report.tables import Table

if TYPE_CHECKING:
    from photizon_cl.result.estimates import Estimates

__all__ = ["effects_tables", "judged_by", "key_figures", "run_table", "summary", "versions_table"]

_CODE: Final = Markup("<code>{}</code>")
_PACKAGES: Final = ("numpy", "pyopencl", "mako", "matplotlib", "xarray", "h5py")


def _count(number: int, one: str, many: str = "") -> str:
    return f"{integer(number)} {one if number == 1 else many or one + 's'}"


def judged_by(result: Estimates) -> str:
    """Return what the achieved σ is the median over, or the largest of."""
    if result.scene.run.target_on:
        return ", ".join(result.scene.run.target_on)
    if any(d.map is not None for d in result.detectors.values()):
        return "the map bins with at least 10 arrivals"
    if result.detectors:
        return "the totals of the detectors"
    return "the absorbed and escaped rows of the ledger"


def summary(result: Estimates) -> list[Markup]:
    """Return the paragraph that says in plain English what was done and what came out."""
    scene, run, ledger = result.scene, result.scene.run, result.ledger
    sources = _count(len(scene.source), "source")
    text = Markup(
        "This run traced {rays} from {sources} of {power} W{together} through a scene of "
        "{elements}, in {batches} with seed {seed}."
    ).format(
        rays=_count(result.rays, "ray"),
        sources=sources,
        power=amount(ledger.emitted.value, 6),
        together=" together" if len(scene.source) > 1 else "",
        elements=_count(len(scene.element), "element"),
        batches=_count(result.batches, "batch", "batches"),
        seed=run.seed,
    )
    return [text + _where(result), _how_well(result)]


def _where(result: Estimates) -> Markup:
    """Say where most of the power went."""
    ledger = result.ledger
    rows = [(f"was absorbed by {name}", row) for name, row in ledger.absorbed.items()]
    rows += [(f"was absorbed in {name}", row) for name, row in ledger.absorbed_in.items()]
    rows += [("escaped", ledger.escaped), ("reached the generation cap", ledger.depth_capped)]
    ranked = sorted(rows, key=lambda item: -item[1].value)
    said = [
        Markup("{} {}").format(share(row, ledger.emitted.value), what)
        for what, row in ranked[:3]
        if row.value > 0.0
    ]
    if not said:
        return Markup("")
    rest = sum(1 for _, row in ranked[3:] if row.value > 0.0)
    tail = f", and the rest went to {_count(rest, 'other row')}" if rest else ""
    return Markup(" Of the emitted power, {}{}.").format(_listed(said), tail)


def _listed(parts: list[Markup]) -> Markup:
    if len(parts) < 2:
        return Markup(", ").join(parts)
    return Markup(", ").join(parts[:-1]) + Markup(" and ") + parts[-1]


def _how_well(result: Estimates) -> Markup:
    achieved, target = result.achieved_sigma, result.target_sigma
    if achieved is None:
        if result.batches == 1:
            why = "it was a single batch, and errors come from the scatter between batches"
        else:
            why = "nothing that it measures received light"
        words = Markup("No relative standard error is known: {}. The target of {} is not met.")
        found = words.format(why, percent(target))
    else:
        verdict = "meets" if result.converged else "does not meet"
        words = Markup(
            "The {} relative standard error (σ) over {} is {}, which {} the target of {}."
        )
        found = words.format(
            result.sigma_is.split()[0],
            judged_by(result),
            percent(achieved),
            verdict,
            percent(target),
        )
    closure = result.ledger.closure
    if closure == 0.0:
        return found + Markup(" The energy ledger closes exactly.")
    part = number(f"{abs(closure) / result.ledger.emitted.value:.1e}")
    words = Markup(" The energy ledger closes to {} of the emitted power, which is rounding.")
    return found + words.format(part)


def key_figures(result: Estimates) -> list[tuple[str, str, str]]:
    """Return (name, value, remark) of the figures at the top of the page."""
    ledger, info = result.ledger, result.info
    achieved = result.achieved_sigma
    verdict = "met" if result.converged else "not met"
    closure = number(f"{ledger.closure:.1e}" if ledger.closure else "0")
    figures: list[tuple[str, str, str]] = [
        ("emitted", amount(ledger.emitted.value, 6) + " W", _launched(result)),
        ("rays", integer(result.rays), _count(result.batches, "batch", "batches")),
        (
            result.sigma_is,
            percent(achieved) if achieved is not None else "unknown",
            f"target {percent(result.target_sigma)}: {verdict}",
        ),
        ("escaped", brief(ledger.escaped.value, ledger.escaped.sigma, "W"), ""),
        ("ledger closure", closure + " W", "emitted − all other rows"),
    ]
    if result.least_lit is not None:
        name, lit, maps = result.least_lit
        remark = f"on {name}, the least of {maps} maps" if maps > 1 else "10 or more arrivals"
        figures.append(("lit map bins", lit_percent(lit), remark))
    rate = info.interactions / info.seconds if info.seconds > 0.0 else 0.0
    remark = f"{rate / 1e6:.3g} million a second" if rate else ""
    figures.append(("interactions", integer(info.interactions), remark))
    return figures


def _launched(result: Estimates) -> str:
    return "by " + _count(len(result.scene.source), "source")


# -- how it was run ------------------------------------------------------------------------------


def run_table(result: Estimates) -> Table:
    """Return how the run was made: stream, goal, device, time, digests."""
    scene, run, info = result.scene, result.scene.run, result.info
    goal = info.goal
    goals = [
        _count(goal.batches, "batch", "batches") + " in all" if goal.batches is not None else "",
        f"{result.sigma_is} of {percent(goal.target)}" if goal.target is not None else "",
        f"at most {goal.max_seconds:g} s" if goal.max_seconds is not None else "",
    ]
    rate = info.interactions / info.seconds if info.seconds > 0.0 else None
    floor = scene.roulette_floor()
    rows: list[tuple[str, str]] = [
        ("scene", scene.name),
        ("scene digest", _CODE.format(scene.digest())),
        ("tally digest", _CODE.format(result.tally_digest)),
        ("seed", str(run.seed)),
        ("batches", integer(result.batches)),
        ("rays per batch", integer(run.rays_per_batch)),
        ("rays", integer(result.rays)),
        ("goal", "; ".join(filter(None, goals)) or "none"),
        ("generation cap", integer(run.generation_cap)),
        ("roulette floor", amount(floor) if floor else "0 (off)"),
        ("interactions", integer(info.interactions)),
        ("time of the run", f"{info.seconds:.4g} s, without building programs"),
        ("time to build programs", f"{info.build_seconds:.3g} s"),
        ("interactions per second", "–" if rate is None else amount(rate)),
        ("device", info.device or "not recorded"),
        ("precision", info.precision),
    ]
    note = (
        "Two runs agree bit for bit exactly when their tally digests do; scene, seed and batches "
        "fix every number of the result, whatever the device."
    )
    caption = "How the run was made"
    return Table("table-run", caption, (("item", False), ("value", False)), rows, note)


def versions_table() -> Table:
    """Return the software that wrote the page."""
    from photizon_cl.version import __version__

    rows = [("photizon_cl", __version__), ("Python", platform.python_version())]
    for package in _PACKAGES:
        try:
            rows.append((package, metadata.version(package)))
        except metadata.PackageNotFoundError:
            rows.append((package, "not installed"))
    return Table(
        "table-versions",
        "Software that read the result and wrote this page",
        (("package", False), ("version", False)),
        rows,
    )


def _named(effect: str) -> Markup:
    """Return an effect's name, which may be broken behind its dot."""
    return Markup(".<wbr>").join(effect.split("."))


def effects_tables(result: Estimates) -> tuple[Table, Table]:
    """Return the effects that were compiled in, and those that were left out."""
    used = result.compiled.effects
    unlisted = sorted(used - set(EFFECT_ROWS))
    inside: list[tuple[str, ...]] = [
        (_named(name), effect.what, effect.costs)
        for name, effect in EFFECT_ROWS.items()
        if name in used
    ]
    inside += [(name, "–", "–") for name in unlisted]
    outside = [
        (_named(name), effect.what) for name, effect in EFFECT_ROWS.items() if name not in used
    ]
    heads = (("effect", False), ("what it does", False), ("what it costs on the device", False))
    return (
        Table("table-effects", "Effects in use: compiled in for this scene", heads, inside),
        Table(
            "table-left-out",
            "Left out: not compiled, since the scene has no use for it; it costs nothing",
            heads[:2],
            outside,
        ),
    )
