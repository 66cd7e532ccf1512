"""Walls of revolution and annuli: one scene, one seed, one set of bits, however it is computed."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import pytest
from oracles.engine import PLAN, Traced, compiled, open_device, scene_of, trace_compiled
from oracles.scenes import AXES, BLACK, glass, matt, mirror

from photizon_cl.stability.build import TILT

if TYPE_CHECKING:
    from photizon_cl.compile.compiled import CompiledScene

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

RAYS = 1024
BATCHES = 4


def tables() -> list[dict[str, Any]]:
    """Every kind with every surface it may have, touching, crossing and apart; two are tilted."""
    rows: list[dict[str, Any]] = [
        {"kind": "cylinder", "radius": 0.8, "length": 1.5, "position": [0, 0, -0.5], **mirror(0.9)},
        {"kind": "disk", "radius": 0.8, "inner_radius": 0.2, "position": [0, 0, -0.5], **matt(0.8)},
        {"kind": "conic", "curvature_radius": 1.0, "conic_constant": -1.0, "aperture_radius": 0.8,
         "inner_radius": 0.1, "position": [0, 0, 1.32], "axis": "-z", **mirror(0.95)},
        {"kind": "conic", "curvature_radius": 0.5, "conic_constant": 0.4, "aperture_radius": 0.4,
         "position": [0.1, 0, 0.1], "tilt_deg": [20.0, -10.0], **glass(1.5)},
        {"kind": "conic", "curvature_radius": 0.2, "conic_constant": -3.0, "aperture_radius": 0.3,
         "position": [-0.3, 0.2, 0.6], "axis": "+x", **matt(0.7)},
        {"kind": "cone", "entrance_radius": 0.2, "exit_radius": 0.0, "length": 0.4,
         "position": [0.4, -0.3, -0.2], "axis": "-y", **BLACK, "detector": {"side": "outside"}},
        {"kind": "cylinder", "radius": 0.1, "length": 0.5, "position": [-0.4, -0.3, 0.0],
         "tilt_deg": list(TILT), **BLACK,
         "detector": {"side": "outside", "map": [6, 4], "generations": 4}},
        {"kind": "disk", "radius": 0.3, "inner_radius": 0.15, "position": [0.3, 0.3, 0.5], **BLACK,
         "axis": "-x", "detector": {"map": [5, 6]}},
        {"kind": "cone", "entrance_radius": 0.3, "exit_radius": 0.5, "length": 0.2,
         "position": [0, 0, -0.45], **mirror(0.9)},
    ]  # fmt: skip
    return [{"axis": "+z", **row} for row in rows]


@cache
def scene(force: frozenset[str] = frozenset()) -> CompiledScene:
    """Return the scene compiled, with effects forced on."""
    lamps = [
        {"kind": "isotropic-point", "flux": 1.0, "position": [0.0, -0.1, 0.4]},
        {"kind": "cosine-point", "flux": 0.5, "position": [0.2, 0.1, -0.2], "axis": "+z"},
    ]
    run = {"rays_per_batch": RAYS, "generation_cap": 60, "roulette_floor": 1e-3}
    return compiled(scene_of(lamps, tables(), far_field={"n_mu": 4, "n_phi": 4}), force, **run)


@cache
def base() -> Traced:
    """Return the run that all others must equal."""
    return trace_compiled(scene(), BATCHES, plan=PLAN)


def same(made: CompiledScene, **plan: Any) -> None:
    """Assert that a run gives the same bytes."""
    run = trace_compiled(made, BATCHES, plan=PLAN.with_(**plan))
    assert [c.tobytes() for c in run.batches] == [c.tobytes() for c in base().batches]
    assert run.interactions == base().interactions


def test_much_happens_in_the_scene() -> None:
    found = base()
    assert found.interactions > 4 * BATCHES * RAYS
    assert 0 < found.escaped < found.emitted
    for name in ("element 5", "element 6", "element 7"):
        assert found.detector(name).count > 50


# 8 are those of the classical wavefront, below; one, of every kind, in test_digest_matrix.py
@pytest.mark.slow
@pytest.mark.parametrize("lanes", [1, 8, 16])
def test_lane_widths(lanes: int) -> None:
    same(scene(), lanes=lanes, refill=max(lanes // 4, 1))


def test_classical_wavefront() -> None:
    same(scene(), composition="classical", lanes=8, stack_rays=2)


@pytest.mark.slow  # of every kind in test_digest_matrix.py
def test_whole_paths() -> None:
    same(scene(), composition="whole-path", lanes=1)


@pytest.mark.parametrize(
    "effect",
    ["acceleration", *(pytest.param(e, marks=pytest.mark.slow) for e in ("tilt", "shares"))],
)
def test_forced_effects(effect: str) -> None:
    same(scene(frozenset({effect})))


@cache
def apart(force: frozenset[str] = frozenset()) -> Traced:
    """Trace one of each kind, where nothing touches: with contact forced, the same bits."""
    kinds = {row["kind"]: row for row in reversed(tables()) if row["surface"]["kind"] != "absorber"}
    rows = [
        {**row, "position": [1.9 * k - 2.5, 0.9 * k - 1.0, 1.5 - 1.1 * k], "axis": axis}
        for k, (row, axis) in enumerate(zip(kinds.values(), AXES[1:], strict=False))
    ]
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, 0.1, -0.3]}
    room = {"kind": "sphere", "radius": 9.0, "position": [0, 0, 0], "axis": "+z", **matt(0.6)}
    made = compiled(scene_of([lamp], [room, *rows]), force, rays_per_batch=RAYS, generation_cap=30)
    return trace_compiled(made, 2, plan=PLAN)


@pytest.mark.parametrize(
    "effect",
    ["contact", *(pytest.param(e, marks=pytest.mark.slow) for e in ("tilt", "acceleration"))],
)
def test_forced_effects_where_nothing_touches(effect: str) -> None:
    assert "contact" not in apart().compiled.effects
    assert all(apart().absorbed(f"element {n}") > 0.1 for n in range(1, 5))
    assert apart(frozenset({effect})).digest == apart().digest


@pytest.mark.slow  # the scene of everything in test_digest_matrix.py has the kinds as well
@pytest.mark.parametrize("origin", ["debian", "pypi"])
def test_both_pocls(origin: str) -> None:
    run = trace_compiled(scene(), 2, device=open_device(origin), plan=PLAN.with_(lanes=8))
    assert [c.tobytes() for c in run.batches] == [c.tobytes() for c in base().batches[:2]]
