"""Random numbers on the device, bit for bit, at every lane width; counters; path positions."""

from __future__ import annotations

import random

import numpy as np
import pytest
from oracles import philox, random_gates
from oracles.kernels import run_text

from hostcode.program.plan import LANE_WIDTHS

BLOCKS = """
__kernel void test(__global const uint *c, __global const uint *k, __global uint *out, uint n) {
    const size_t i = get_global_id(0);
    word c0 = LOAD(c, i), c1 = LOAD(c + n, i), c2 = LOAD(c + 2 * n, i), c3 = LOAD(c + 3 * n, i);
    philox4x32_10(&c0, &c1, &c2, &c3, k[0], k[1]);
    STORE(c0, out, i); STORE(c1, out + n, i); STORE(c2, out + 2 * n, i); STORE(c3, out + 3 * n, i);
}
"""


def device_blocks(counters: np.ndarray, key: tuple[int, int], lanes: int) -> np.ndarray:
    """Return Philox blocks from the device, shape (n, 4)."""
    n = len(counters)
    arrays = [counters.T.copy(), np.array(key, np.uint32), np.zeros((4, n), np.uint32)]
    return run_text(BLOCKS, [*arrays, np.uint32(n)], n, lanes=lanes)[2].T


@pytest.mark.parametrize("lanes", LANE_WIDTHS)
def test_published_vectors_and_a_thousand_counters(lanes: int) -> None:
    r = random.Random(7)
    counters = [tuple(r.getrandbits(32) for _ in range(4)) for _ in range(1008)]
    keys = [tuple(r.getrandbits(32) for _ in range(2)) for _ in range(2)]
    for counter, key, published in philox.VECTORS:
        assert philox.block(counter, key) == published
        counters[3] = counter
        got = device_blocks(np.array(counters, np.uint32), key, lanes)
        assert tuple(got[3]) == published
    for key in keys:
        got = device_blocks(np.array(counters, np.uint32), key, lanes)
        assert [tuple(row) for row in got.tolist()] == [philox.block(c, key) for c in counters]


@pytest.mark.parametrize("lanes", LANE_WIDTHS)
def test_counter_has_the_documented_layout(lanes: int) -> None:
    random_gates.counter_layout(lanes)


def test_no_two_documented_counters_are_equal() -> None:
    r = random.Random(12)
    fields = [(2**48, 48), (2**56, 56), (2**20, 20), (16, 4)]
    cases = {tuple(r.getrandbits(bits) for _, bits in fields) for _ in range(5000)}
    base = (5, 1, 3, 2)
    for n, (_, bits) in enumerate(fields):  # and all that differ in one bit from each other
        for bit in range(bits):
            cases.add((*base[:n], base[n] ^ 1 << bit, *base[n + 1 :]))
    assert len({philox.counter_of(*case) for case in cases}) == len(cases)


@pytest.mark.parametrize("lanes", LANE_WIDTHS)
def test_children_are_as_documented(lanes: int) -> None:
    r = random.Random(9)
    paths = [1, 2, 2**53, 2**54 - 1, 2**54, 2**54 + 1, 2**55 - 1, 2**55, 2**56 - 1]
    paths += [r.getrandbits(56) | 1 for _ in range(503)]
    got = random_gates.device_children(np.array(paths, np.uint64), lanes)
    assert got.tolist() == [[philox.child(p, 0), philox.child(p, 1)] for p in paths]


def test_no_two_rays_of_a_full_tree_share_a_counter() -> None:
    random_gates.paths_are_unique()


@pytest.mark.parametrize("start", [2**54 - 1, 2**54, 2**55 + 12345])
def test_full_trees_beyond_54_splits_have_no_shared_counter(start: int) -> None:
    random_gates.paths_are_unique(start, 13)


CHAINS = {
    "all transmitted": lambda n, r: 0,
    "all reflected": lambda n, r: 1,
    "alternating": lambda n, r: n % 2,
    "random": lambda n, r: r.getrandbits(1),
}


@pytest.mark.parametrize("turn", CHAINS)
def test_chains_5000_splits_deep(turn: str) -> None:
    """Along a chain and to its sides no position is met twice, and siblings differ everywhere.

    Checked on the oracle, which the device equals (above).
    """
    r, path, seen = random.Random(10), 1, {1}
    for n in range(5000):
        children = philox.child(path, 0), philox.child(path, 1)
        assert children[0] != children[1]
        assert not seen & set(children)
        seen.update(children)
        path = children[CHAINS[turn](n, r)]
    assert max(seen) < 2**56


@pytest.mark.parametrize("lanes", LANE_WIDTHS)
def test_uniforms_are_in_the_half_open_interval(lanes: int) -> None:
    random_gates.unit_interval(lanes)
