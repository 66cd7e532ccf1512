"""A row that an effect adds to the ledger: booked, balanced, shown and kept."""

from __future__ import annotations

from typing import ClassVar

import pytest

import photizon_cl as pz
from hostcode.program.spec import EffectParts
from photizon_cl.cli.main import main
from photizon_cl.compile import compiled
from photizon_cl.compile.effects.base import Effect
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.compile.layout import LedgerRow


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
    result.save(tmp_path / "run")
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
