"""Checks of random numbers and of the positions of rays in their tree, as those of `gates`."""

from __future__ import annotations

import random

import numpy as np

from oracles import philox
from oracles.kernels import run_text

DRAWS = """
__kernel void test(__global const ulong *ray, __global const ulong *path, __global const uint *gen,
                   __global double *out, ulong seed, uint n) {
    const size_t i = get_global_id(0);
    const luint number = LOAD(ray, i);
    real u, v;
    for (uint decision = 0; decision < 4; decision++) {
        draw_pair(seed, TO_WORD(number), TO_WORD(number >> 32), LOAD(path, i), LOAD(gen, i),
                  decision, &u, &v);
        STORE(u, out + 2 * decision * n, i);
        STORE(v, out + (2 * decision + 1) * n, i);
    }
}
"""
SPLITTING = frozenset({"splitting"})


def counter_layout(lanes: int = 4) -> None:
    """Every draw is Philox of the documented counter: each field in bits of its own."""
    r = random.Random(8)
    rays = [0, 1, 2**32 - 1, 2**32, 2**32 + 5, 2**47, 2**48 - 1]
    paths = [1, 2, 3, 2**32 - 1, 2**32, 2**44 - 1, 2**44, 2**54, 2**55, 2**56 - 1]
    generations = [0, 1, 2**16 - 1, 2**16, 2**16 + 1, 2**20 - 1]
    cases = [(ray, path, g) for ray in rays for path in paths for g in generations]
    cases += [
        (r.getrandbits(48), r.getrandbits(56), r.getrandbits(20)) for _ in range(512 - len(cases))
    ]
    seed = 0xFEDCBA9876543210
    n = len(cases)
    columns = [np.array(c, t) for c, t in zip(zip(*cases, strict=True), "QQI", strict=True)]
    arguments = [*columns, np.zeros((8, n)), np.uint64(seed), np.uint32(n)]
    out = run_text(DRAWS, arguments, n, lanes=lanes, effects=SPLITTING)[3]
    for k, (ray, path, generation) in enumerate(cases):
        for decision in range(4):
            want = philox.draw(seed, ray, path, generation, decision)
            assert tuple(out[2 * decision : 2 * decision + 2, k]) == want


CHILDREN = """
__kernel void test(__global const ulong *path, __global ulong *out, uint n) {
    const size_t i = get_global_id(0);
    const luint p = LOAD(path, i);
    STORE(child_path(p, 0), out, i);
    STORE(child_path(p, 1), out + n, i);
}
"""


def device_children(paths: np.ndarray, lanes: int = 8) -> np.ndarray:
    """Return both children of each path position, shape (n, 2)."""
    padded = np.resize(paths, -(-len(paths) // lanes) * lanes)
    n = len(padded)
    arguments = [padded, np.zeros((2, n), np.uint64), np.uint32(n)]
    out = run_text(CHILDREN, arguments, n, lanes=lanes, effects=SPLITTING)[1]
    return out.T[: len(paths)]


def paths_are_unique(start: int = 1, depth: int = 14) -> None:
    """No two rays of a full tree share a path position; beyond 54 splits none of a level do."""
    level, seen = np.array([start], np.uint64), [np.array([start], np.uint64)]
    for n in range(depth):
        level = device_children(level).ravel()
        assert len(np.unique(level)) == 2 ** (n + 1)
        seen.append(level)
    everything = np.concatenate(seen)
    assert everything.max() < 2**56
    if start == 1:
        assert len(np.unique(everything)) == 2 ** (depth + 1) - 1


UNITS = """
__kernel void test(__global const uint *high, __global const uint *low, __global double *out) {
    const size_t i = get_global_id(0);
    STORE(u01_closed_open(LOAD(high, i), LOAD(low, i)), out, i);
}
"""


def unit_interval(lanes: int = 4) -> None:
    """Uniforms are the first 53 bits, in [0, 1): 0 is reached, 1 is not."""
    ones, r = 2**32 - 1, random.Random(11)
    words = [(0, 0), (0, 2047), (0, 2048), (ones, ones), (ones, ones - 2047), (ones, ones - 2048)]
    words += [(1, 0), (2**31, 0), (ones, 0)]
    words += [(r.getrandbits(32), r.getrandbits(32)) for _ in range(1024 - len(words))]
    high, low = (np.array(c, np.uint32) for c in zip(*words, strict=True))
    got = run_text(UNITS, [high, low, np.zeros(1024)], 1024, lanes=lanes)[2]
    assert got.tolist() == [philox.to_unit(*pair) for pair in words]
    assert got[:6].tolist() == [0.0, 0.0, 2.0**-53, 1 - 2.0**-53, 1 - 2.0**-53, 1 - 2.0**-52]
