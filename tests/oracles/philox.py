"""Philox4x32-10 from the paper, and the counter of a draw as it is documented.

J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy as 1, 2, 3",
SC'11. The vectors are those of Random123's ``kat_vectors``.
"""

from __future__ import annotations

from fractions import Fraction

VECTORS = (
    ((0x00000000,) * 4, (0x00000000,) * 2, (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
)

DIRECTION, POSITION, SCATTER, ROULETTE = range(4)
"""Decisions that a draw can be for."""

ROOT = 1
"""Path position of a launched ray."""


def block(counter: tuple[int, ...], key: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return one block of four 32-bit words."""
    c, k = list(counter), list(key)
    for round_number in range(10):
        if round_number:
            k = [(k[0] + 0x9E3779B9) % 2**32, (k[1] + 0xBB67AE85) % 2**32]
        high0, low0 = divmod(0xD2511F53 * c[0], 2**32)
        high1, low1 = divmod(0xCD9E8D57 * c[2], 2**32)
        c = [high1 ^ c[1] ^ k[0], low1, high0 ^ c[3] ^ k[1], low0]
    return c[0], c[1], c[2], c[3]


def counter_of(ray: int, path: int, generation: int, decision: int) -> tuple[int, int, int, int]:
    """Return the counter of a draw: 48 bits of ray, 56 of path, 20 of generation, 4 of decision."""
    assert ray < 2**48
    assert path < 2**56
    assert generation < 2**20
    assert decision < 2**4
    return (
        ray & 0xFFFFFFFF,
        (ray >> 32) | decision << 16 | (path >> 44) << 20,
        path & 0xFFFFFFFF,
        generation | ((path >> 32) & 0xFFF) << 20,
    )


def to_unit(high: int, low: int) -> float:
    """Return the double in [0, 1) of two words: their first 53 bits."""
    return float(Fraction((high << 21) | (low >> 11), 2**53))


def draw(seed: int, ray: int, path: int, generation: int, decision: int) -> tuple[float, float]:
    """Return the two uniforms of one decision."""
    words = block(counter_of(ray, path, generation, decision), (seed & 0xFFFFFFFF, seed >> 32))
    return to_unit(words[0], words[1]), to_unit(words[2], words[3])


def child(path: int, side: int) -> int:
    """Return the path position of a child (0 transmitted, 1 reflected) as it is documented."""
    if path < 2**54:
        return 2 * path + side
    wrap = 2**64
    h = path * 0x9E3779B97F4A7C15 % wrap
    h = (h ^ h >> 32) * 0xD6E8FEB86659FD93 % wrap
    h = (h ^ h >> 29) * 0xD6E8FEB86659FD93 % wrap
    h ^= h >> 32
    return 2**55 | (2 * h) % 2**55 | side
