"""Where effects are named beside their own files: a list that may only become shorter.

What results are made of (maps, ladders, the far field, what roulette took) is called by its name
where it is shown. How faces are searched for (`contact`, `acceleration`) is woven into the kernels
of all elements. A new effect needs neither, and has no place here.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from contract import traced

from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.scene.registry import FILTERS

ROOT = Path(__file__).resolve().parents[2]
QUANTITIES = ("detector", "map", "ladder", "far-field")
"""Effects that are named as quantities are: in results, figures and the report."""
SHOWN_IN = (
    "photizon_cl/cli/", "photizon_cl/compile/layout.py", "photizon_cl/compile/quantities.py",
    "photizon_cl/result/",
    "photizon_cl/scene/detectors/", "photizon_cl/scene/elements/base.py", "photizon_cl/views/",
    # the bit of a code, and what asks for it
    "hostcode/program/codes.py", "kernels/lib/packets.mako",
)  # fmt: skip
KERNELS = {
    "contact": {
        "elements/baffled_tube", "elements/cpc", "elements/disk", "elements/lens",
        "elements/plano_convex",
        "elements/rectangle", "elements/sphere", "lib/cap_bound", "lib/faces", "lib/flat",
        "lib/nearest", "lib/packets", "lib/revolved", "lib/shade", "lib/solid",
    },
    "acceleration": {"lib/ledger", "lib/nearest", "lib/packets"},
}  # fmt: skip
LEFT = {
    "contact": {f"kernels/{stem}.mako" for stem in KERNELS["contact"]},
    "acceleration": {f"kernels/{stem}.mako" for stem in KERNELS["acceleration"]}
    | {"hostcode/device/opened.py"},
    "face-surfaces": {"kernels/lib/meet.mako", "kernels/lib/shade.mako"},
    # a setting has its name
    "splitting": {
        "photizon_cl/result/recipe.py", "photizon_cl/scene/model.py",
        "photizon_cl/studies/knobs.py",
    },
    "importance": {"photizon_cl/scene/importance.py"},
    # a key of sources has its name
    "spectrum": {"photizon_cl/run/pilot.py", "photizon_cl/scene/spectrum.py"},
    "polarisation": {"photizon_cl/result/recipe.py", "photizon_cl/scene/polarisation.py"},
    "roulette": {
        "photizon_cl/result/ledger.py", "photizon_cl/result/paths.py",
        "photizon_cl/views/report/claims.py", "photizon_cl/views/report/tables.py",
    },
}  # fmt: skip


def named_in(effect: str) -> set[str]:
    """Return the files that spell an effect's name as a string, but its own and the table."""
    found = set()
    for folder in ("photizon_cl", "hostcode", "kernels"):
        for path in (ROOT / folder).rglob("*"):
            name = path.relative_to(ROOT).as_posix()
            if path.suffix not in (".py", ".mako") or "/effects/" in name:
                continue
            if re.search(rf"[\"']{effect}[\"']", path.read_text(encoding="utf-8")):
                found.add(name)
    return found


@pytest.mark.parametrize("effect", [e.name for e in EFFECTS])
def test_an_effect_is_named_where_it_was_and_nowhere_else(effect):
    found = named_in(effect)
    if effect in QUANTITIES:
        assert [name for name in found if not name.startswith(SHOWN_IN)] == []
    else:
        assert found == LEFT.get(effect, set())


def test_a_name_is_found():
    assert "kernels/lib/flat.mako" in named_in("contact")
    assert not named_in("no effect at all")


def test_filters_in_use_are_those_of_the_registry():
    layout = traced("everything", 1).compiled.layout
    used = {type(f) for d in layout.detectors for tally in d.tallies for f in tally.filters}
    assert used == set(FILTERS.values())
