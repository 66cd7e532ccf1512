"""Path tables in result files that are made up: refused in one line, before any work."""

from __future__ import annotations

import numpy as np
import pytest
from test_hostile_results import both, many, refused, rewritten, setting, without

import photizon_cl as pz

pytestmark = pytest.mark.usefixtures("built_quickly")


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("saved")
    scene = pz.load("ghost-ladder").to_dict()
    for element in scene["element"]:
        if "detector" in element:
            element["detector"]["paths"] = 5
    pz.trace(scene, batches=3, rays_per_batch=64).save(folder, figures=False)
    return (folder / "result.nc").read_bytes()


def raised(name, place, amount):
    def change(arrays, attrs, top):
        arrays[name] = arrays[name].copy()
        arrays[name][place] += amount

    return change


def moved(arrays, attrs, top):
    """A path more, and another as much less: the sum fits."""
    limbs = arrays["path_limbs"] = arrays["path_limbs"].copy()
    limbs[0, 1] += 1
    limbs[1, 1] -= 1


def wrapping(arrays, attrs, top):
    """Four counts whose sum is 0 in 64 bits."""
    arrays["path_count"] = arrays["path_count"].copy()
    arrays["path_count"][:4] += 1 << 62


MADE_UP = {
    "very many paths": many("path_keys", "path_about", "path_first", "path_count"),
    "very many limbs": many("path_limbs"),
    "very many steps": many("trail_steps"),
    "very many trails": many("trail_keys", "trail_ends"),
    "no keys": without("path_keys"),
    "no table": without(
        "path_keys", "path_about", "path_first", "path_limbs", "path_count", "path_mean", "path_m2",
        "path_values", "trail_keys", "trail_ends", "trail_steps",
    ),
    "one key twice": lambda a, t, s: a.update(path_keys=np.full_like(a["path_keys"], 7)),
    "another detector": setting("path_about", 0, 9 << 32),
    "interactions without end": setting("path_about", 0, (1 << 32) - 1),
    "a ray that was not launched": setting("path_first", 0, 1 << 40),
    "a negative ray": setting("path_first", 0, -1),
    "a watt too many": raised("path_limbs", (0, 0), 1),
    "counts that wrap around": wrapping,
    "no counts": setting("path_count", 0, 0),
    "power of another path": moved,
    "no scatter": lambda a, t, s: a.update(path_m2=np.ones_like(a["path_m2"])),
    "squares that are no numbers": setting("path_m2", 0, np.nan),
    "negative squares": setting("path_m2", 0, -1.0),
    "values of batches without end": setting("path_values", (0, 0), 1e300),
    "values of other batches": raised("path_values", (0, 0), 1e-3),
    "keys as doubles": lambda a, t, s: a.update(path_keys=a["path_keys"] * 1.0),
    "steps of another path": raised("trail_steps", 0, 1 << 20),
    "an element that is not there": setting("trail_steps", 0, 1 << 40),
    "a negative step": setting("trail_steps", 0, -1),
    "ends that turn back": lambda a, t, s: a.update(trail_ends=a["trail_ends"][::-1].copy()),
    "steps of a path that is not there": raised("trail_keys", 0, 1),
    "ends beyond the steps": raised("trail_ends", -1, 1),
    "everything at once": both(moved, wrapping),
}  # fmt: skip


QUICK = {
    "very many paths", "very many steps", "interactions without end", "counts that wrap around",
    "power of another path", "values of batches without end", "steps of another path",
    "ends beyond the steps",
}  # fmt: skip
"""One of each kind; the others are slow only because they are many."""


@pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in MADE_UP]
)
def test_what_is_made_up_is_not_believed(name, saved, tmp_path, capsys):
    path = tmp_path / "result.nc"
    path.write_bytes(saved)
    rewritten(path, MADE_UP[name])
    line = refused(path, capsys)
    assert "damaged or not a photizon result" in line
    assert "checksum does not fit" not in line


def test_what_is_not_changed_opens(saved, tmp_path):
    path = tmp_path / "result.nc"
    path.write_bytes(saved)
    before = pz.open_result(path).summary()
    rewritten(path, lambda *_: None)
    assert pz.open_result(path).summary() == before
