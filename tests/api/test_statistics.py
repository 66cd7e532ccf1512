"""Batch means: exact totals, Welford's recurrence, the digest, the stopping rule."""

from __future__ import annotations

import hashlib
import math
from fractions import Fraction

import numpy as np
import pytest

from hostcode.run.tally import canonical, exact, values
from photizon_cl.compile.layout import ROWS, DetectorCells, TallyCells, TallyLayout
from photizon_cl.errors import RunError
from photizon_cl.result.statistics import Accumulator, complete, exact_sum
from photizon_cl.result.stopping import LEAST_BATCHES, Goal, achieved_sigma
from photizon_cl.scene.filters.along import across
from photizon_cl.scene.filters.generation import Generation

UNIT = Fraction(1, 2**95)


def tallies(n_batches, n_cells, seed=1, largest=2**55):
    random = np.random.default_rng(seed)
    for _ in range(n_batches):
        cells = np.zeros((n_cells, 4), np.int64)
        cells[:, 0] = random.integers(0, largest, n_cells)
        cells[:, 1:3] = random.integers(0, 2**32, (n_cells, 2))
        cells[:, 3] = random.integers(0, 1000, n_cells)
        yield cells


def filled(batches, differences=()):
    batches = list(batches)
    tally = Accumulator(len(batches[0]), differences)
    for cells in batches:
        tally.add(cells)
    return tally


def test_totals_are_exact_beyond_64_bits():
    # 300 batches of 2^55 units of 2^-31: the first limb of a batch's cell would overflow.
    batches = list(tallies(300, 3, largest=2**62))
    tally = filled(batches)
    for cell in range(3):
        assert tally.exact(cell) == sum(exact(cells)[cell] for cells in batches)
        mean = Fraction(tally.exact(cell), 300) * UNIT
        assert abs(Fraction(float(tally.mean(cell, 1)[0])) - mean) <= mean * Fraction(1, 2**51)
    assert (tally.count == np.sum([cells[:, 3] for cells in batches], axis=0)).all()


def test_mean_and_standard_error_are_those_of_the_textbook():
    batches = list(tallies(25, 5))
    tally = filled(batches)
    x = np.array([values(cells) for cells in batches])
    np.testing.assert_allclose(tally.mean(), x.mean(axis=0), rtol=1e-14)
    expected = x.std(axis=0, ddof=1) / math.sqrt(25)
    np.testing.assert_allclose(tally.standard_error(), expected, rtol=1e-12)


def test_one_batch_has_no_error_and_equal_batches_have_none_at_all():
    (cells,) = tallies(1, 4)
    assert np.isnan(filled([cells]).standard_error()).all()
    equal = filled([cells] * 7)
    assert (equal.standard_error() == 0.0).all()
    np.testing.assert_allclose(equal.mean(), filled([cells]).mean(), rtol=2.0**-51)


def test_a_difference_has_the_error_of_its_batches():
    # Two cells that always move together: each is uncertain, their difference is not.
    batches = list(tallies(12, 2, largest=2**40))
    for cells in batches:
        cells[1] = cells[0]
        cells[0, 0] += 5
    tally = filled(batches, [(0, 1)])
    assert tally.standard_error()[0] > 0.0
    assert tally.standard_error()[2] == 0.0
    negative = filled([np.array([[0, 0, 1, 0], [0, 0, 3, 0]])] * 2, [(0, 1)])
    assert negative.state().mean[2] == -2.0 * 2.0**-95


def test_the_digest_is_a_chain_over_the_bytes():
    batches = list(tallies(3, 2))
    digest = bytes(32)
    for cells in batches:
        digest = hashlib.sha256(digest + cells.astype("<i8").tobytes()).digest()
    assert filled(batches).digest == f"sha256:{digest.hex()}"
    assert filled(batches[::-1]).digest != f"sha256:{digest.hex()}"


def test_a_restored_accumulator_goes_on_to_the_same_bits():
    batches = list(tallies(10, 6))
    whole = filled(batches, [(0, 1)])
    part = Accumulator.restore(filled(batches[:4], [(0, 1)]).state(), [(0, 1)])
    for cells in batches[4:]:
        part.add(cells)
    for name in ("limbs", "count", "mean", "m2"):
        assert (getattr(part.state(), name) == getattr(whole.state(), name)).all()
    assert part.digest == whole.digest
    with pytest.raises(ValueError, match="expected"):
        Accumulator.restore(whole.state(), [])
    with pytest.raises(ValueError, match="expected"):
        whole.add(np.zeros((5, 4), np.int64))


def test_a_copy_is_independent():
    batches = list(tallies(3, 2))
    tally = filled(batches[:2])
    before = tally.state()
    tally.copy().add(batches[2])
    assert (tally.state().limbs == before.limbs).all()
    assert tally.batches == 2


# -- detectors' power ------------------------------------------------------------------------------

# One element; a detector with a ladder of 3 and a map of 2 × 2; no far field.
LADDER = TallyCells("ladder", 6, (Generation(3),))
MAP = TallyCells("map", 9, (across("u", 1.0, 2), across("v", 1.0, 2)))
LAYOUT = TallyLayout(1, ROWS, (DetectorCells(0, 5, (LADDER, MAP)),), (), 14)


def arrivals():
    cells = np.zeros((14, 4), np.int64)
    cells[6:9] = [[1, 2**32 - 1, 7, 2], [0, 2**32 - 1, 2**32 - 1, 1], [2, 0, 0, 4]]
    cells[9] = cells[6:9].sum(axis=0)
    return canonical(cells)


def test_power_is_the_exact_sum_of_the_ladder():
    cells = arrivals()
    whole = complete(LAYOUT, cells)
    assert exact_sum(whole[5:6]) == exact_sum(whole[6:9])
    assert whole[5, 3] == 7
    assert (canonical(whole) == whole).all()
    assert not cells[5].any()


def test_ladder_and_map_that_disagree_are_a_defect():
    cells = arrivals()
    cells[9, 2] -= 1
    with pytest.raises(RunError, match="disagree"):
        complete(LAYOUT, cells)


# -- the stopping rule -----------------------------------------------------------------------------


def scattered(relative, n_batches):
    """Return alternating batches of one element's row whose relative error is known."""
    layout = TallyLayout(1, ROWS, (), (), 6)
    batches = []
    for n in range(n_batches):
        cells = np.zeros((6, 4), np.int64)
        cells[0, 0] = round(2**40 * (1.0 + (relative if n % 2 else -relative)))
        batches.append(cells)
    return layout, filled(batches)


def test_a_target_counts_from_the_eighth_batch_on():
    for n in range(1, 12):
        layout, tally = scattered(1e-6, n)
        assert Goal(None, 0.5).reached(layout, tally) == (n >= LEAST_BATCHES)
        assert Goal(3).reached(layout, tally) == (n >= 3)
        assert Goal(3, 0.5).reached(layout, tally) == (n >= 3)


def test_achieved_sigma_over_rows_leaves_zero_rows_out():
    layout, tally = scattered(0.1, 16)
    expected = 0.1 * math.sqrt(16 / 15) / math.sqrt(16)
    assert achieved_sigma(layout, tally) == pytest.approx(expected, rel=1e-6)
    assert achieved_sigma(*scattered(0.1, 1)) is None


def test_achieved_sigma_over_maps_takes_lit_bins_only():
    small = TallyCells("map", 6, (across("u", 1.0, 2), across("v", 1.0, 1)))
    layout = TallyLayout(1, ROWS, (DetectorCells(0, 5, (small,)),), (), 9)
    batches = []
    for n in range(4):
        cells = np.zeros((9, 4), np.int64)
        cells[6] = [2**30 + (2**20 if n % 2 else 0), 0, 0, 3]  # 12 arrivals: lit
        cells[7] = [2**30 * (n % 2), 0, 0, 2]  # 8 arrivals: noisy, and not lit
        batches.append(complete(layout, cells))
    tally = filled(batches)
    assert tally.count.tolist()[6:8] == [12, 8]
    assert achieved_sigma(layout, tally) < 1e-3
