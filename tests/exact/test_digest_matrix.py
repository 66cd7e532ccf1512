"""One scene, one seed, one set of bits, however it is computed.

The full product of the choices is thousands of runs. This is a covering set: for each of four
scenes a base run, and for every choice at least one run that differs from the base in that choice
(some differ in several), at the widths and compositions where the choice has code of its own:

=====================  ======================================================================
choice                 values
=====================  ======================================================================
lanes                  1, 2, 4, 8, 16 (packets); 1, 4, 16 (classical); 1 (whole path)
composition            packets, classical, whole path
max_bounces (K)        1, 3, 2^20
wave_rays              2^10 (half a batch), 2^12, 2^14, 2^16, 2^20 (every batch at once)
items                  1, 7, 64
refill                 1, 3, all lanes
local_size             1, 4, 64
stack_rays             1 (segments grow, losing nothing), 64, 256
queue layout           contiguous, interleaved
tally_copies, parts    atomics (parts 1, 4), 1 copy, 2 copies
compute units          1, 2
cached_bytes           1 (with a tree), 2^20
runtime                Debian's PoCL, PyPI's PoCL, Intel's CPU runtime, a GPU's
batches                12; 3 + 9; one by one in reverse order
=====================  ======================================================================

The scenes: the integrating sphere (curved, port, far field), the ghost ladder (splitting, ladders),
the box room (map and ladder, many elements) and `everything` (tilts, five sources with shares,
roulette, splitting, far field, detectors of every kind, 13 elements: the ledger by atomics).
"""

from __future__ import annotations

import hashlib
from functools import cache
from typing import TYPE_CHECKING, Any

import pytest
from oracles.engine import Traced, compiled, open_device, scene_of, trace_compiled
from oracles.scenes import everything

from hostcode.device.device import enumerate_devices, qualify
from hostcode.device.device import open_device as open_record
from hostcode.program import build
from hostcode.program.plan import ExecutionPlan
from photizon_cl.scene.files import load

if TYPE_CHECKING:
    from hostcode.device.device import OpenDevice
    from photizon_cl.compile.compiled import CompiledScene

BASE = ExecutionPlan(lanes=4, items=8, wave_rays=1 << 16, refill=1, stack_rays=64)
RAYS = 2048
BATCHES = 12
SCENES = ("integrating-sphere", "ghost-ladder", "box-room", "everything")


@cache
def scene(name: str, seed: int = 1) -> CompiledScene:
    """Return a compiled scene of the matrix."""
    if name == "everything":
        return compiled(load(everything()), seed=seed, rays_per_batch=RAYS)
    return compiled(name, seed=seed, rays_per_batch=RAYS)


@cache
def base(name: str) -> Traced:
    """Return the run that all others must equal."""
    return trace_compiled(scene(name), BATCHES, plan=BASE)


def same(
    name: str, *, batches: int = BATCHES, device: OpenDevice | None = None, **plan: Any
) -> None:
    """Assert that a run with other choices gives the same bytes."""
    run = trace_compiled(scene(name), batches, device=device, plan=BASE.with_(**plan))
    want = base(name)
    assert [c.tobytes() for c in run.batches] == [c.tobytes() for c in want.batches[:batches]]
    if batches == BATCHES:
        assert run.interactions == want.interactions


every_scene = pytest.mark.parametrize("name", SCENES)


def wholly(name: str, *values: Any) -> list[Any]:
    """Return pairs of every scene and value; those are slow which are of another scene than `name`.

    Each pair makes a program. What has code of its own at a width is in the named scene.
    """
    return [
        pytest.param(scene, value, marks=() if scene == name else pytest.mark.slow)
        for scene in SCENES
        for value in values
    ]


def of_everything(*others: str) -> list[Any]:
    """Return the scene of everything, and others as slow tests: each makes a program."""
    return ["everything", *(pytest.param(name, marks=pytest.mark.slow) for name in others)]


WIDE = [pytest.param(name, 16, marks=pytest.mark.slow) for name in SCENES]
NARROWEST = [pytest.param(name, 1, marks=pytest.mark.slow) for name in SCENES]
NARROW = [pytest.param(name, 2, marks=pytest.mark.slow) for name in SCENES]

# one run for each value of each choice; lanes 4 and 16 share these rows between them
CHOICES: dict[str, dict[str, Any]] = {
    "K = 1": {"max_bounces": 1, "batches": 1},
    "K = 3, 7 items, refill all": {"max_bounces": 3, "items": 7, "refill": 4},
    "wave of half a batch": {"wave_rays": 1 << 10},
    "wave of two batches": {"wave_rays": 1 << 12, "items": 64},
    "wave of eight batches": {"wave_rays": 1 << 14},
    "wave of all batches": {"wave_rays": 1 << 20, "items": 64},
    "one item": {"items": 1, "batches": 3},
    "tiny stacks that grow": {"stack_rays": 1, "items": 3},
    "one tally copy": {"tally_copies": 1},
    "two tally copies": {"tally_copies": 2, "wave_rays": 1 << 10},
    "one part a segment": {"tally_parts": 1},
    "groups of 4": {"local_size": 4, "items": 7},
    "interleaved queue": {"interleaved": True, "stack_rays": 2},
}


# each of these makes a program, and one scene's is enough
BUILDS = {"K = 1": "ghost-ladder", "groups of 4": "box-room", "interleaved queue": "ghost-ladder"}


LONG = ("K = 1",)
"""A launch for every bounce; all of the classical composition's are of one as well."""


@pytest.mark.parametrize(
    ("choice", "name"),
    [
        pytest.param(
            choice,
            name,
            marks=pytest.mark.slow if BUILDS.get(choice, name) != name or choice in LONG else (),
        )
        for choice in CHOICES
        for name in SCENES
    ],
)
def test_choices_at_4_lanes(name: str, choice: str) -> None:
    same(name, **CHOICES[choice])


@pytest.mark.parametrize(("name", "lanes"), wholly("everything", 1, 8) + WIDE + NARROW)
def test_lane_widths(name: str, lanes: int) -> None:
    same(name, lanes=lanes, refill=max(lanes // 4, 1), batches=3 if lanes == 1 else BATCHES)


@pytest.mark.parametrize(("name", "lanes"), wholly("everything", 1) + WIDE)
def test_widest_and_scalar_with_other_choices(name: str, lanes: int) -> None:
    """K = 3 and stacks that grow at the widths with packets of their own kind."""
    plan = {"max_bounces": 3, "stack_rays": 1, "items": 7, "tally_parts": 1}
    same(name, lanes=lanes, refill=3, batches=2, **plan)


@pytest.mark.parametrize(("name", "lanes"), wholly("everything", 4) + NARROWEST + WIDE)
def test_classical_wavefront(name: str, lanes: int) -> None:
    same(name, composition="classical", lanes=lanes, batches=3)


@pytest.mark.parametrize("name", of_everything("ghost-ladder"))
def test_classical_wavefront_with_other_choices(name: str) -> None:
    same(name, composition="classical", wave_rays=1 << 10, items=7, batches=3)
    same(name, composition="classical", tally_copies=2, items=64, batches=3)


@pytest.mark.parametrize("name", of_everything(*SCENES[:3]))
def test_whole_paths(name: str) -> None:
    same(name, composition="whole-path", lanes=1, stack_rays=2, wave_rays=1 << 12, batches=3)


@pytest.mark.slow  # groups of 4: above
@pytest.mark.parametrize("name", of_everything("integrating-sphere"))
def test_groups_of_64(name: str) -> None:
    same(name, local_size=64, items=64, lanes=1, batches=2)


@every_scene
def test_one_and_two_threads(name: str) -> None:
    device = open_device()
    if device.record.compute_units < 2:
        pytest.skip("this device has one compute unit")
    for units in (1, 2):
        same(name, device=open_device("", units), tally_copies=units, wave_rays=1 << 20)


@pytest.mark.parametrize(
    ("name", "lanes"),
    [*wholly("everything", 8), *(pytest.param(s, 1, marks=pytest.mark.slow) for s in SCENES)],
)
@pytest.mark.parametrize("origin", ["debian", "pypi"])
def test_both_pocls(name: str, origin: str, lanes: int) -> None:
    same(name, device=open_device(origin), lanes=lanes, refill=1, batches=3)


def test_without_the_compilers_optimiser(monkeypatch: pytest.MonkeyPatch) -> None:
    """As `built_quickly` has many tests run what is optimised here."""
    optimised = base("everything")
    monkeypatch.setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-opt-disable")
    for programs in ("_CACHE", "_BUILT"):
        monkeypatch.setattr(build, programs, {})
    run = trace_compiled(scene("everything"), 2, plan=BASE)
    assert [c.tobytes() for c in run.batches] == [c.tobytes() for c in optimised.batches[:2]]
    assert build._BUILT


@pytest.mark.parametrize("name", ["integrating-sphere", "ghost-ladder"])
def test_intels_runtime(name: str) -> None:
    same(name, device=open_device("intel"), lanes=8, refill=1, batches=3)


@pytest.mark.slow
@every_scene
@pytest.mark.parametrize("lanes", [1, 2, 4, 8, 16])
def test_every_other_device_at_every_width(name: str, lanes: int) -> None:
    """Whatever is here beside PoCL; `python -m benchmarks.digests --all` does the presets."""
    others = [record for record in enumerate_devices() if not record.is_pocl]
    usable = [record for record in others if not qualify(record, self_test=True)]
    if not usable:
        pytest.skip("no device here but PoCL's: pip install 'photizon-cl[intel]', or a GPU")
    for record in usable:
        same(name, device=open_record(record), lanes=lanes, refill=1, batches=3)


@pytest.mark.parametrize(
    ("name", "composition"),
    [
        pytest.param("ghost-ladder", "packets", marks=pytest.mark.slow),
        ("ghost-ladder", "classical"),
        ("everything", "packets"),
        pytest.param("everything", "classical", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("widest", [8, pytest.param(16, marks=pytest.mark.slow)])
def test_rays_in_turn_through_a_tree(name: str, composition: str, widest: int) -> None:
    """Splitting, roulette, records, small segments: rays change places wherever they can."""
    tables = everything() if name == "everything" else name
    made = compiled(
        load(tables) if isinstance(tables, dict) else tables,
        frozenset({"acceleration"}),
        rays_per_batch=RAYS,
    )
    crowded = {"lanes": widest, "max_bounces": 3, "stack_rays": 1}
    for choices in ({"lanes": 8, "refill": 2}, crowded):
        plan = BASE.with_(composition=composition, cached_bytes=1, items=7, **choices)
        run = trace_compiled(made, 3, plan=plan)
        assert [c.tobytes() for c in run.batches] == [c.tobytes() for c in base(name).batches[:3]]


@every_scene
def test_batches_are_pure_functions(name: str) -> None:
    """12 = 3 + 9 = one by one in reverse order, whatever is in flight beside a batch."""
    want = [cells.tobytes() for cells in base(name).batches]
    made = scene(name)
    parts = [trace_compiled(made, 3, plan=BASE), trace_compiled(made, 9, first=3, plan=BASE)]
    assert [c.tobytes() for part in parts for c in part.batches] == want
    narrow = BASE.with_(wave_rays=RAYS)
    singles = [trace_compiled(made, 1, first=n, plan=narrow) for n in (11, 5, 0)]
    assert [t.batches[0].tobytes() for t in singles] == [want[n] for n in (11, 5, 0)]


def test_forty_batches_are_ten_and_thirty() -> None:
    made = compiled("box-room", rays_per_batch=256)
    forty = trace_compiled(made, 40, plan=BASE)
    parts = [trace_compiled(made, 10, plan=BASE), trace_compiled(made, 30, first=10, plan=BASE)]
    joined = b"".join(c.tobytes() for part in parts for c in part.batches)
    assert hashlib.sha256(joined).hexdigest() == forty.digest


@pytest.mark.parametrize("name", ["integrating-sphere", "box-room", "everything"])
def test_another_seed_gives_another_digest(name: str) -> None:
    digests = {trace_compiled(scene(name, seed), 1, plan=BASE).digest for seed in (1, 2, 2**64 - 1)}
    assert len(digests) == 3
    batches = [cells.tobytes() for cells in base(name).batches]
    assert len(set(batches)) == BATCHES


def test_batches_far_down_the_stream() -> None:
    """Ray numbers beyond 2^32 keep their upper bits."""
    made = scene("box-room")
    far = trace_compiled(made, 2, first=2**36, plan=BASE)
    near = trace_compiled(made, 2, plan=BASE)
    assert far.digest != near.digest
    again = trace_compiled(made, 2, first=2**36, plan=BASE.with_(wave_rays=1 << 10, lanes=1))
    assert far.digest == again.digest


# each a program: 8 is the last in registers
@pytest.mark.parametrize("n", [8, 9, *(pytest.param(n, marks=pytest.mark.slow) for n in (7, 10))])
def test_registers_and_atomics_keep_the_same_ledger(n: int) -> None:
    """Elements beyond the register limit, never hit, change no row of the others."""
    black = {"kind": "rectangle", "axis": "+z", "half_width": 0.1, "half_height": 0.1}
    box = [e for e in load("box-room").to_dict()["element"]]
    extra = [
        {**black, "position": [9.0, 9.0, 9.0 + k], "surface": {"kind": "absorber"}}
        for k in range(n - 6)
    ]
    room = load("box-room").to_dict()
    more = trace_compiled(
        compiled(
            scene_of(room["source"], box + extra, run=room["run"]),
            rays_per_batch=RAYS,
            generation_cap=64,
        ),
        plan=BASE,
    )
    want = base("box-room")
    rows = [*range(6), *range(n, n + 4)]
    got = [more.batches[0][row].tobytes() for row in rows]
    assert got == [want.batches[0][row].tobytes() for row in range(10)]


# the scene of everything, and each effect on the box room: tests/structure/test_contract_effects.py
@pytest.mark.parametrize(
    ("name", "effect"),
    # a tree for the ghost ladder is above
    wholly("ghost-ladder", "tilt", "contact")
    + [
        pytest.param(name, effect, marks=pytest.mark.slow)
        for name in SCENES
        for effect in ("acceleration", "roulette", "splitting", "shares")
    ],
)
def test_forcing_an_effect_changes_no_bit(name: str, effect: str) -> None:
    tables = everything() if name == "everything" else name
    made = compiled(
        load(tables) if isinstance(tables, dict) else tables,
        frozenset({effect}),
        rays_per_batch=RAYS,
    )
    run = trace_compiled(made, 2, plan=BASE)
    assert [c.tobytes() for c in run.batches] == [c.tobytes() for c in base(name).batches[:2]]
