"""Tallies of very many cells, of which only those that are not zero are held: the same bits."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from test_hostile_results import both, rewritten, setting

import photizon_cl as pz
from hostcode.program.plan import ExecutionPlan
from hostcode.run import readout, tally, wavefront
from hostcode.run.tally import BLOCK, CELL, SparseTally, canonical, is_sparse, merged
from photizon_cl.result.statistics import exact_sum
from photizon_cl.result.sums import DenseSums, SparseSums

pytestmark = pytest.mark.usefixtures("built_quickly")

SIDE = 300
HOW = {"batches": 3, "rays_per_batch": 4096, "seed": 5}


def scene():
    """Return a map and a far field of more cells than one block has."""
    tables = pz.load("cosine-fourth").to_dict()
    tables["element"][0]["detector"] = {"map": [SIDE, SIDE], "generations": 3}
    tables["far_field"] = {"n_mu": 30, "n_phi": 20}
    return pz.load(tables)


@pytest.fixture(scope="module")
def dense():
    return pz.trace(scene(), **HOW)


@pytest.fixture
def sparse(monkeypatch):
    """Have tallies of more than a thousand cells be sparse."""
    monkeypatch.setattr(tally, "_SPARSE_FROM", 1000)


def everything(result):
    """Return all that a result says."""
    d, far = result.detectors["target"], result.far_field
    said = {**result.summary(), "seconds": 0, "build_seconds": 0, "forecast": None}
    arrays = (d.map.irradiance, d.map.sigma, d.map.count, far.intensity, far.sigma, far.count)
    return said, [array.tobytes() for array in arrays]


def test_the_same_bits(dense, sparse):
    found = pz.trace(scene(), **HOW)
    assert isinstance(dense.tally._sums, DenseSums)
    assert isinstance(found.tally._sums, SparseSums)
    assert found.tally.n_cells > BLOCK
    assert everything(found) == everything(dense)
    whole, part = dense.tally.state(), found.tally.state()
    lit = np.flatnonzero(whole.count != 0)
    assert set(lit) <= set(part.cells.tolist())
    assert len(part.cells) < 0.5 * len(whole.count)
    n = len(whole.count)
    for name in ("limbs", "count", "mean", "m2"):
        all_cells, held = getattr(whole, name), getattr(part, name)
        assert all_cells[part.cells].tobytes() == held[: len(part.cells)].tobytes()
        rest = np.ones(n, bool)
        rest[part.cells] = False
        assert not all_cells[:n][rest].any()
        assert all_cells[n:].tobytes() == held[len(part.cells) :].tobytes()  # the balance
    again = found.tally.copy()
    assert again.state().limbs.tobytes() == part.limbs.tobytes()
    assert again.digest == found.tally_digest


def test_a_tally_that_is_read_in_mid_batch(dense, sparse, monkeypatch):
    reads = []

    def counted(*arguments):
        reads.append(arguments)
        return readout.read_sparse(*arguments)

    monkeypatch.setattr(wavefront, "_EVENTS_BEFORE_FLUSH", 300)
    monkeypatch.setattr(wavefront, "read_sparse", counted)
    plan = ExecutionPlan(lanes=8, items=8, wave_rays=1000)
    found = pz.trace(scene(), plan=plan, **HOW)
    assert len(reads) > 2 * HOW["batches"]
    assert everything(found) == everything(dense)


def test_saved_and_opened_and_gone_on_with(dense, sparse, tmp_path, monkeypatch):
    two = pz.trace(scene(), **{**HOW, "batches": 2}, checkpoint=tmp_path / "run")
    assert everything(pz.resume(tmp_path / "run", batches=3)) == everything(dense)
    two.save(tmp_path / "kept", figures=False)
    opened = pz.open_result(tmp_path / "kept")
    assert everything(opened) == everything(two)
    assert everything(opened.refine(batches=3)) == everything(dense)
    # and by a version, or a scene, that holds all cells
    monkeypatch.undo()
    opened = pz.open_result(tmp_path / "kept")
    assert isinstance(opened.tally._sums, DenseSums)
    assert everything(opened.refine(batches=3)) == everything(dense)


def test_a_file_with_all_cells_is_read(dense, sparse, tmp_path, monkeypatch):
    with monkeypatch.context() as plain:
        plain.setattr(tally, "_SPARSE_FROM", 1 << 40)
        dense.save(tmp_path, figures=False)
    opened = pz.open_result(tmp_path)
    assert isinstance(opened.tally._sums, SparseSums)
    assert everything(opened) == everything(dense)
    assert everything(opened.refine(batches=4)) == everything(dense.refine(batches=4))


def test_workers_send_what_is_not_zero(dense, sparse):
    with ThreadPoolExecutor(2) as pool:
        assert everything(pz.trace(scene(), executor=pool, **HOW)) == everything(dense)


def shorter(arrays, attrs, top):
    arrays["cells"] = arrays["cells"][:-1]


def as_doubles(arrays, attrs, top):
    arrays["cells"] = arrays["cells"] * 1.0


def moved(arrays, attrs, top):
    arrays["cells"] = arrays["cells"] + 1


@pytest.mark.parametrize(
    "change",
    [
        setting("cells", -1, 1 << 40),
        setting("cells", 0, -1),
        setting("cells", 3, 2),  # twice the same
        both(setting("cells", 3, 4), setting("cells", 4, 3)),
        setting("limbs", (9, 1), -1),
        setting("count", 9, -1),
        setting("mean", 9, 1.0),
        shorter,
        as_doubles,
        moved,
    ],
)
def test_a_file_that_is_made_up_is_not_believed(change, sparse, tmp_path):
    pz.trace(scene(), **HOW).save(tmp_path, figures=False)
    rewritten(tmp_path / "result.nc", change)
    with pytest.raises(pz.ResultError, match="damaged or not a photizon result"):
        pz.open_result(tmp_path)


# -- the form itself ------------------------------------------------------------------------------


def some(n_cells, lit, seed):
    """Return cells in canonical form, of which some are not zero."""
    draw = np.random.default_rng(seed)
    cells = np.zeros((n_cells, CELL), np.int64)
    at = draw.choice(n_cells, lit, replace=False)
    cells[at] = draw.integers(-(2**40), 2**40, (lit, CELL))
    return canonical(cells)


@pytest.mark.parametrize("lit", [0, 1, 1000, 3 * BLOCK // 2])
def test_a_sparse_tally_stands_for_all_cells(lit):
    cells = some(2 * BLOCK + 5, lit, 1)
    found = SparseTally.of(cells)
    assert len(found.numbers) == lit
    assert found.whole().tobytes() == cells.tobytes()
    parts = [part.whole() for _, part in found.blocks()]
    assert np.concatenate(parts).tobytes() == cells.tobytes()
    assert found.within(7, BLOCK).whole().tobytes() == cells[7 : 7 + BLOCK].tobytes()
    assert exact_sum(found.rows) == exact_sum(cells)
    other = some(2 * BLOCK + 5, 1000, 2)
    total = merged(found, SparseTally.of(other)).whole()
    assert total.tobytes() == canonical(cells + other).tobytes()
    changed = found.with_cells({3: np.arange(4), BLOCK: np.ones(4, np.int64)})
    cells[3], cells[BLOCK] = np.arange(4), 1
    assert changed.whole().tobytes() == cells.tobytes()


@pytest.mark.parametrize(
    ("numbers", "rows"),
    [
        (np.array([1, 1]), np.zeros((2, 4), np.int64)),
        (np.array([2, 1]), np.zeros((2, 4), np.int64)),
        (np.array([9]), np.zeros((1, 4), np.int64)),
        (np.array([-1]), np.zeros((1, 4), np.int64)),
        (np.array([1]), np.zeros((2, 4), np.int64)),
        (np.array([1.0]), np.zeros((1, 4), np.int64)),
        (np.array([1]), np.zeros((1, 4))),
    ],
)
def test_what_is_no_tally_is_refused(numbers, rows):
    with pytest.raises(ValueError, match="numbers"):
        SparseTally(9, numbers, rows)


def test_small_tallies_have_all_cells():
    assert not is_sparse(1 << 20)
    assert is_sparse(1 << 23)
