"""The list of runs that forecasts are scored by, and how."""

from __future__ import annotations

import photizon_cl as pz
from benchmarks import forecasts


def test_the_list_is_what_it_says():
    assert len(forecasts.RUNS) == 40
    assert len({(run.preset, run.target, run.seed, run.on) for run in forecasts.RUNS}) == 40
    assert {run.preset for run in forecasts.RUNS} <= set(pz.presets())
    assert all(0.01 <= run.target <= 0.05 for run in forecasts.RUNS)


def test_what_was_told_stands_beside_what_it_took():
    row = forecasts.traced(forecasts.Run("box-room", 0.05, 1))
    assert row["converged"]
    assert row["kept"] in [{k: t[k] for k in row["kept"]} for t in row["told"]]
    assert 0.0 < row["at"] < row["seconds"]
    after = row["kept"]["after_batches"]
    assert 8 <= after < row["batches"]
    cells = forecasts._line(row)
    assert len(cells) == len(forecasts.HEADER)
    assert cells[4] == str(after)
    assert cells[9] == f"{row['kept']['seconds'] / row['seconds']:.2f}"


def test_within_is_a_factor_to_either_side():
    for told, took, good in ((10.0, 8.01, True), (10.0, 7.9, False), (8.01, 10.0, True),
                             (7.9, 10.0, False)):  # fmt: skip
        assert forecasts.within({"seconds": told}, took) == good
    assert not forecasts.within(None, 10.0)


def test_what_a_run_told_at_its_end_is_no_forecast(monkeypatch):
    short = pz.trace("box-room", batches=8, rays_per_batch=64)
    monkeypatch.setattr(forecasts.pz, "trace", lambda *_, **__: short)
    row = forecasts.traced(forecasts.Run("box-room", 0.05, 1))
    assert row["kept"] is None
    assert row["at"] is None
