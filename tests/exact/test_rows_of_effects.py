"""Rows and cells that an effect adds: booked, balanced, scaled, shown and kept."""

from __future__ import annotations

from typing import ClassVar

import pytest
from oracles.engine import scene_of
from oracles.scenes import beam, wall

import photizon_cl as pz
from hostcode.program.parts import EffectParts
from photizon_cl.cli.main import main
from photizon_cl.compile import compiled
from photizon_cl.compile.effects.base import Effect
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.compile.layout import LedgerRow

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


class Fog(Effect):
    """Takes half of what goes on from a surface."""

    name: ClassVar[str] = "fog"
    what: ClassVar[str] = "half of what goes on is lost"
    costs: ClassVar[str] = "nothing to speak of"

    def needed(self, scene, settings):
        return "it is foggy"

    def rows(self, scene):
        return (LedgerRow("fogged", 1, "lost in the fog"),)

    def parts(self, draft):
        half = "image_difference(image_of(outcome.w), image_of(outcome.w * R(0.5)))"
        booked = f"book_row(launch, ledger, ROW_FOGGED, met, {half});"
        return EffectParts(hooks=(("surface", booked), ("surface", "outcome.w *= R(0.5);")))


@pytest.fixture
def foggy(monkeypatch):
    monkeypatch.setattr(compiled, "EFFECTS", (*EFFECTS, Fog()))


@pytest.fixture
def result(foggy):
    return pz.trace("box-room", batches=2, rays_per_batch=512)


def test_it_is_a_part_of_the_balance(result):
    ledger = result.ledger
    fog = ledger.others["lost in the fog"]
    assert ledger.closure == ledger.worst_closure == 0.0
    assert 0.0 < fog.value < ledger.emitted.value
    shown = sum(row.value for _, row in ledger.rows())
    assert shown == pytest.approx(ledger.emitted.value, rel=1e-14)
    assert dict(ledger.labelled_rows())["lost in the fog"] == fog
    assert ledger.summary()["others"]["lost in the fog"]["value"] == fog.value


def test_it_is_in_files_and_comes_back(result, tmp_path):
    result.save(tmp_path / "run", figures=False)
    assert "lost in the fog" in (tmp_path / "run" / "ledger.csv").read_text("utf-8")
    again = pz.open_result(tmp_path / "run")
    assert again.ledger == result.ledger


def test_it_is_printed(foggy, capsys, tmp_path):
    words = ["run", "box-room", "--batches", "1", "--rays-per-batch", "64"]
    assert main([*words, "--out", str(tmp_path / "run")]) == 0
    assert "lost in the fog" in capsys.readouterr().out
    assert "lost in the fog" in (tmp_path / "run" / "summary.json").read_text("utf-8")


def test_a_scene_without_it_has_no_such_row():
    ledger = pz.trace("box-room", batches=1, rays_per_batch=64).ledger
    assert not ledger.others
    assert "others" not in ledger.summary()


class Way(Effect):
    """Counts weight times length of segments that end on an element, in units of `longest`."""

    name: ClassVar[str] = "way"
    what: ClassVar[str] = "weight times length of what ends on an element"
    costs: ClassVar[str] = "an addition an interaction"
    unit: ClassVar[str] = "W·m"
    longest: float = 1.0

    def needed(self, scene, settings):
        return "it is measured"

    def cells(self, scene):
        return (len(scene.element),)

    def labels(self, scene):
        return tuple(e.name for e in scene.element)

    def scale(self, scene):
        return self.longest

    def parts(self, draft):
        way = f"SEL(h->found, h->t * R({1.0 / self.longest!r}), splat(0.0))"
        count = f"count_weights(ledger, launch->way, element, met, p->w * {way});"
        member = ("way", "ulong", "first cell of the way")
        return EffectParts(hooks=(("surface", count),), launch=(member,))


def straight_down(height):
    """A beam that falls on a plate that half absorbs it, and from there on a black one."""
    lamp = {**beam((0, 0, height), "-z", 1e-3 * height)}
    plate = {**wall((0, 0, 0), "+z", height), "surface": {"kind": "mirror", "reflectance": 0.5}}
    lid = {**wall((0, 0, 3 * height), "-z", height), "surface": {"kind": "absorber"}}
    return scene_of([lamp], [plate, lid])


def test_cells_of_another_unit_are_scaled(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(Way, "longest", 2.0**12)
    monkeypatch.setattr(compiled, "EFFECTS", (*EFFECTS, Way()))
    result = pz.trace(straight_down(1024.0), batches=2, rays_per_batch=256)
    way = result.tallies["way"]
    assert way.unit == "W·m"
    assert [(c.value, c.count) for c in way.values()] == [(1024.0, 512), (1536.0, 512)]
    result.save(tmp_path / "run", figures=False)
    assert "value_W·m" in (tmp_path / "run" / "tally-way.csv").read_text("utf-8")
    assert result.summary()["tally_units"] == {"way": "W·m"}
    again = pz.open_result(tmp_path / "run").tallies["way"]
    assert (again, again.unit) == (way, "W·m")


@pytest.mark.parametrize(("height", "rays"), [(8.0, 1), (1e6, 4096), (1e12, 64)])
def test_numbers_that_are_too_large_end_the_run(monkeypatch, height, rays):
    monkeypatch.setattr(compiled, "EFFECTS", (*EFFECTS, Way()))
    with pytest.raises(pz.RunError, match="numbers beyond 4 at once"):
        pz.trace(straight_down(height), batches=1, rays_per_batch=rays)
