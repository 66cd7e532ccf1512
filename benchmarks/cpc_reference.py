"""A tracer for one thing only, the inside of a CPC with a perfect mirror, in plain numpy.

Nothing is shared with the engine. The wall is told by its definition: its meridian is a parabola
whose focus F is the opposite rim of the exit and whose axis e is tilted by the acceptance angle, so
that a point P at distance r from the axis is inside where

    g = |P − F| − (P − F)·e − 2a'(1 + sin θa) < 0,     F = (−a', 0),  e = (−sin θa, cos θa)

in the meridional plane (r, z). Along a ray g is convex (a sum of norms and a linear function), so a
ray that starts inside leaves once: at the wall where g > 0 on the plane of the aperture that it
runs towards, found by bisection, else through that aperture. Normals are the gradient of g.

R. Winston, J. C. Miñano, P. Benítez, Nonimaging Optics, Elsevier 2005, ch. 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Outcome", "beam_through_entrance", "follow", "transmission"]

_BISECTIONS = 64


@dataclass(frozen=True, eq=False)
class Outcome:
    """How rays ended.

    Parameters
    ----------
    transmitted : ndarray of bool
        Which ones left through the exit.
    reflections : ndarray of int
        How many each made.
    unfinished : int
        Rays still under way after the last step allowed.
    """

    transmitted: NDArray[np.bool_]
    reflections: NDArray[np.int64]
    unfinished: int


def sizes(exit_radius: float, acceptance_deg: float) -> tuple[float, float]:
    """Return entrance radius and length in metres."""
    theta = math.radians(acceptance_deg)
    entrance = exit_radius / math.sin(theta)
    return entrance, (entrance + exit_radius) / math.tan(theta)


def follow(
    points: NDArray[np.float64],
    directions: NDArray[np.float64],
    exit_radius: float = 0.025,
    acceptance_deg: float = 20.0,
    most: int = 2000,
) -> Outcome:
    """Follow rays that start inside, or on the entrance going in.

    Parameters
    ----------
    points, directions : ndarray, shape (n, 3)
        In metres with the exit's centre at the origin and the entrance up z; unit vectors.
    exit_radius, acceptance_deg : float
        The concentrator, in metres and degrees.
    most : int
        Reflections after which a ray is given up.
    """
    theta = math.radians(acceptance_deg)
    sine, cosine = math.sin(theta), math.cos(theta)
    _, length = sizes(exit_radius, acceptance_deg)
    twice_focal = 2.0 * exit_radius * (1.0 + sine)

    def outside(p: NDArray[np.float64]) -> NDArray[np.float64]:
        r = np.hypot(p[:, 0], p[:, 1]) + exit_radius
        return np.hypot(r, p[:, 2]) + r * sine - p[:, 2] * cosine - twice_focal

    o, d = np.array(points, float), np.array(directions, float)
    transmitted = np.zeros(len(o), bool)
    reflections = np.zeros(len(o), np.int64)
    alive = np.arange(len(o))
    for _ in range(most + 1):
        if not len(alive):
            break
        p, v = o[alive], d[alive]
        down = v[:, 2] < 0.0
        far = np.where(down, -p[:, 2], length - p[:, 2]) / v[:, 2]
        leaves = outside(p + far[:, None] * v) <= 0.0
        transmitted[alive[leaves]] = down[leaves]
        alive, p, v, far = alive[~leaves], p[~leaves], v[~leaves], far[~leaves]
        low, high = np.zeros(len(alive)), far
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            inside = outside(p + middle[:, None] * v) < 0.0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        p = p + high[:, None] * v
        r = np.hypot(p[:, 0], p[:, 1])
        from_focus = np.hypot(r + exit_radius, p[:, 2])
        slope_r = (r + exit_radius) / from_focus + sine
        slope_z = p[:, 2] / from_focus - cosine
        normal = np.stack([slope_r * p[:, 0] / r, slope_r * p[:, 1] / r, slope_z], axis=1)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        v = v - 2.0 * np.sum(v * normal, axis=1)[:, None] * normal
        o[alive], d[alive] = p, v / np.linalg.norm(v, axis=1)[:, None]
        reflections[alive] += 1
    return Outcome(transmitted, reflections, len(alive))


def beam_through_entrance(
    rng: np.random.Generator, angle_deg: float, side: int, entrance: float, length: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return side² parallel rays over the entrance, one in each cell of equal area."""
    j, i = np.meshgrid(np.arange(side), np.arange(side))
    r = entrance * np.sqrt((i + rng.random(i.shape)).ravel() / side)
    phi = 2.0 * np.pi * (j + rng.random(j.shape)).ravel() / side
    points = np.stack([r * np.cos(phi), r * np.sin(phi), np.full(side * side, length)], axis=1)
    angle = math.radians(angle_deg)
    along = np.array([-math.sin(angle), 0.0, -math.cos(angle)])
    return points, np.tile(along, (side * side, 1))


def transmission(
    angle_deg: float, side: int = 500, repeats: int = 8, seed: int = 1
) -> tuple[float, float, int]:
    """Return the transmission of the 25 mm, 20° CPC in parallel light, σ̂ and unfinished rays.

    Parameters
    ----------
    angle_deg : float
        Of the light against the axis.
    side, repeats : int
        `repeats` independent stratified samples of side² rays; σ̂ is from their scatter.
    seed : int
        Of numpy's generator.
    """
    entrance, length = sizes(0.025, 20.0)
    rng = np.random.default_rng([seed, round(1000.0 * angle_deg)])
    means, unfinished = [], 0
    for _ in range(repeats):
        outcome = follow(*beam_through_entrance(rng, angle_deg, side, entrance, length))
        means.append(float(outcome.transmitted.mean()))
        unfinished += outcome.unfinished
    return float(np.mean(means)), float(np.std(means, ddof=1) / math.sqrt(repeats)), unfinished
