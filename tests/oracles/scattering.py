"""Gates on scatter, for the engine as it is and for broken ones."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

import photizon_cl as pz
from oracles.engine import scene_of, trace
from oracles.lobes import LOBES, NORMAL, drawn, way
from oracles.scenes import BLACK, beam, wall
from oracles.statistics import batch_values, batch_z, chi_square, sidak, z_limit
from photizon_cl.scene.scatters.total import total_at, within_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

ALPHA = 1e-6
"""False alarms of a gate."""
ANGLES = (0.0, 40.0, 75.0, 89.5)
RINGS, SECTORS, FINE = 16, 12, 64


def beta(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the parts of directions along the face, shape (n, 3)."""
    return directions - np.outer(directions @ NORMAL, NORMAL)


# -- directions ------------------------------------------------------------------------------------


def _shares(lobe: Any, middle: float, edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the integrals of the BSDF over rings and sectors, by the midpoint rule in φ."""
    phi = (np.arange(SECTORS * FINE) + 0.5) * (2.0 * math.pi / (SECTORS * FINE))
    far = -middle * np.cos(phi) + np.sqrt(1.0 - (middle * np.sin(phi)) ** 2)
    held = np.array([within_of(lobe, np.minimum(far, max(edge, 1e-12))) for edge in edges])
    rings = np.diff(held, axis=0) * (2.0 * math.pi / len(phi))
    return rings.reshape(len(edges) - 1, SECTORS, FINE).sum(axis=2)


def _ring_edges(lobe: Any, middle: float) -> NDArray[np.float64]:
    """Return Δ of rings that hold about as much each, before the horizon cuts them."""
    r = np.geomspace(1e-3 * min(lobe.width, 1.0), 1.0 + middle, 4096)
    held = within_of(lobe, r)
    inner = np.interp(np.arange(1, RINGS) / RINGS * held[-1], held, r)
    return np.array([0.0, *inner, 1.0 + middle + 1e-9])


def follows_the_bsdf(
    name: str, rays: int = 1 << 14, angles: tuple[float, ...] = ANGLES, level: float = ALPHA
) -> None:
    """Directions in rings of Δ and sectors about β₀, cut off by the horizon, by χ²."""
    lobe, level = LOBES[name], sidak(level, len(angles))
    for angle in angles:
        about = way(angle)
        directions = drawn(name, about[None], rays, lanes=8)[1:4].T
        middle = math.sin(math.radians(angle))
        assert np.abs(np.linalg.norm(directions, axis=1) - 1.0).max() < 4e-16
        assert (directions @ NORMAL).min() > 0.0
        off = beta(directions) - beta(about[None])
        edges = _ring_edges(lobe, middle)
        axis = beta(way(40.0)[None])[0] / np.linalg.norm(beta(way(40.0)[None])[0])
        turn = np.arctan2(np.cross(axis, off) @ NORMAL, off @ axis) % (2.0 * math.pi)
        counts, *_ = np.histogram2d(
            np.linalg.norm(off, axis=1),
            turn,
            bins=(edges, np.linspace(0.0, 2.0 * math.pi, SECTORS + 1)),
        )
        assert counts.sum() == rays
        parts = _shares(lobe, middle, edges)
        tis = float(total_at(lobe, np.array([1.0 - middle]))[0])
        assert abs(parts.sum() / tis - 1.0) < 2e-4  # the midpoint rule at the horizon
        chi_square(counts.astype(np.int64), parts / parts.sum(), level)


def says_its_density() -> None:
    """Densities of drawn directions, which the BSDF is made of."""
    for name in ("abg", "gaussian"):
        ways = np.array([way(angle, 77.0) for angle in (0.0, 30.0, 85.0)])
        found = drawn(name, ways, 96)
        delta = np.linalg.norm(beta(found[1:4].T - np.tile(ways, (32, 1))), axis=1)
        off = found[5] / LOBES[name].bsdf(delta) - 1.0
        assert np.abs(off).max() < 1e-7
        assert np.abs(found[4] * found[0] / (found[1:4].T @ NORMAL) / found[5] - 1.0).max() < 1e-9


# -- shares ----------------------------------------------------------------------------------------

_APART = 500.0


def plate(surface: dict[str, Any], angle: float = 40.0, **parts: Any) -> pz.Scene:
    """A slanting thin beam onto a wide plate."""
    return plates([surface], angle, **parts)


def plates(surfaces: list[dict[str, Any]], angle: float = 40.0, **parts: Any) -> pz.Scene:
    """The same for several surfaces, each with a beam and a plate of its own, in one program."""
    lamps, boards = [], []
    for n, surface in enumerate(surfaces):
        x = _APART * n
        lamps.append({**beam((x, 0.0, 0.5), "-z", 1e-9), "tilt_deg": [angle, 0.0]})
        boards.append({**wall((x, 0, 0), "+z", 50.0), "surface": surface})
    return scene_of(lamps, boards, **parts)


def weights_leaving(scene: pz.Scene, rays: int = 8) -> list[dict[tuple[str, str], set[float]]]:
    """Return the weights that leave each plate, by side and by whether all go that way."""
    out: list[dict[tuple[str, str], set[float]]] = [{} for _ in scene.element]
    found = pz.paths(scene, rays=rays * len(out))
    left = found.generation == 1
    along = (found.end - found.start)[left]
    along /= np.linalg.norm(along, axis=1)[:, None]
    _, number, times = np.unique(
        np.round(along, 9), axis=0, return_inverse=True, return_counts=True
    )
    same = times[np.ravel(number)] >= rays
    which = np.rint(found.start[left, 0] / _APART).astype(int)
    for n, z, kept, weight in zip(which, along[:, 2], same, found.weight[left], strict=True):
        side = ("up" if z > 0.0 else "down", "specular" if kept else "aside")
        out[n].setdefault(side, set()).add(float(weight))
    return out


def _reflectance(angle: float, n: float) -> float:
    """Return the unpolarised reflectance from outside, by Fresnel's formulas."""
    one = math.radians(angle)
    two = math.asin(math.sin(one) / n)
    s = math.sin(one - two) / math.sin(one + two)
    p = math.tan(one - two) / math.tan(one + two)
    return 0.5 * (s * s + p * p)


def both_parts_go_on() -> None:
    """Of a mirror TIS and the rest of ρ, of each child of glass TIS and the rest; of every ray."""
    lobe = LOBES["abg, flat"]
    table = lobe.to_table()
    tis = float(total_at(lobe, np.array([1.0 - math.sin(math.radians(40.0))]))[0])
    below = float(total_at(lobe, np.array([1.0 - math.sin(math.radians(40.0)) / 1.5]))[0])
    up = _reflectance(40.0, 1.5)
    wanted = [
        {("up", "specular"): 0.9 - tis, ("up", "aside"): tis},
        {("up", "aside"): tis},
        {
            ("up", "specular"): up * (1.0 - tis),
            ("up", "aside"): up * tis,
            ("down", "specular"): (1.0 - up) * (1.0 - below),
            ("down", "aside"): (1.0 - up) * below,
        },
    ]
    for found, parts in zip(weights_leaving(plates(_scattering(table, 0.9))), wanted, strict=True):
        assert found.keys() == parts.keys()
        for side, weight in parts.items():
            assert max(found[side]) - min(found[side]) <= 1e-15
            assert abs(max(found[side]) / weight - 1.0) <= 1e-7


def _scattering(table: dict[str, Any], reflectance: float) -> list[dict[str, Any]]:
    surfaces: tuple[dict[str, Any], ...] = (
        {"kind": "mirror", "reflectance": reflectance},
        {"kind": "absorber"},
        {"kind": "fresnel", "index": 1.5},
    )
    return [{**surface, "scatter": table} for surface in surfaces]


def closes() -> None:
    """in = out + absorbed, to the last bit; to rounding where glass splits rays."""
    tables = _scattering(LOBES["abg, flat"].to_table(), 0.8)
    found = trace(plates(tables), rays_per_batch=1536)
    assert max(map(abs, found.closures())) <= 1e-15
    found = trace(plates(tables), rays_per_batch=1536, splitting=False)
    assert found.closures() == [0]
    # without glass nothing rounds
    assert trace(plates(tables[:2]), rays_per_batch=1024).closures() == [0]


def one_of_two_goes_on(rays: int = 1 << 13) -> None:
    """``splitting = false``: each of the four rays of glass as often as both would have weighed."""
    lobe = pz.GaussianScatter(sigma=0.05, tis=0.6)
    tis = float(lobe.total(40.0))
    below = float(lobe.total(math.degrees(math.asin(math.sin(math.radians(40.0)) / 1.5))))
    scene = plate({"kind": "fresnel", "index": 1.5, "scatter": lobe.to_table()})
    scene = scene.replace({"run.splitting": False})
    found = pz.paths(scene, rays=rays)
    left = found.generation == 1
    assert set(found.weight[left].tolist()) == {1.0}
    along = np.round((found.end - found.start)[left], 9)
    _, number, times = np.unique(along, axis=0, return_inverse=True, return_counts=True)
    aside = times[np.ravel(number)] == 1
    up = along[:, 2] > 0.0
    r = _reflectance(40.0, 1.5)
    wanted = np.array([r * (1 - tis), r * tis, (1 - r) * (1 - below), (1 - r) * below])
    counts = np.array(
        [(up & ~aside).sum(), (up & aside).sum(), (~up & ~aside).sum(), (~up & aside).sum()]
    )
    chi_square(counts, wanted / wanted.sum(), ALPHA)


# -- importance, furnace ---------------------------------------------------------------------------

_HEIGHT, _OUTER, _INNER = 1.0, 0.5, 0.01


def rings_over_plates(
    cases: list[tuple[str, dict[str, Any], float]], *, aimed: bool = True, rays: int = 2048
) -> None:
    """Rings across the axes over plates in beams; what is specular goes through their holes.

    Of what arrives a ring gets the integral of the BSDF over its projection, a ring of Δ. A case is
    a lobe, a surface, and the part of the power that it scatters a share of. Each has a plate of
    its own, far from the others, and rays are sent towards all rings.
    """
    lamps, boards, rings = [], [], []
    for n, (name, surface, _) in enumerate(cases):
        x = _APART * n
        lamps.append(beam((x, 0, 0.01), "-z", 1e-9))
        optics = {**surface, "scatter": LOBES[name].to_table()}
        disk = {"kind": "disk", "axis": "+z", "position": [x, 0, 0], "radius": 0.1}
        boards.append({**disk, "surface": optics})
        hole = {"radius": _OUTER, "inner_radius": _INNER, "position": [x, 0, _HEIGHT]}
        ring = {**disk, **hole, "axis": "-z", "name": f"ring {n}"}
        rings.append({**ring, **BLACK, "detector": {}})
    more = {"importance": {"toward": [ring["name"] for ring in rings]}} if aimed else {}
    scene = scene_of(lamps, [*boards, *rings], **more)
    found = trace(scene, batches=32, rays_per_batch=rays * len(cases))
    sine = np.array([_INNER / math.hypot(_INNER, _HEIGHT), _OUTER / math.hypot(_OUTER, _HEIGHT)])
    limit = z_limit(sidak(ALPHA, len(cases) + 1), 31)
    for (name, _, part), detector in zip(cases, found.compiled.layout.detectors, strict=True):
        inner, outer = within_of(LOBES[name], sine)
        share = part * 2.0 * math.pi * float(outer - inner)
        z = batch_z(found, lambda x, cell=detector.power: x[cell], share * rays)
        assert abs(z) < limit, (name, z)
    assert max(map(abs, found.closures())) <= 1e-15
    if aimed:
        row = found.compiled.layout.row("importance.balance")
        assert abs(batch_z(found, lambda x: x[row], 0.0)) < limit


def aimed_ring() -> None:
    """What the gate of a broken engine runs."""
    rings_over_plates([("gaussian", {"kind": "absorber"}, 1.0)], rays=1024)


def white_furnace(name: str, rays: int = 1 << 12) -> None:
    """Of equal radiance from everywhere a white mirror that scatters makes equal radiance again.

    A lamp of cosine emission stands next to a wide plate. Its light leaves with a cosine again:
    what a direction loses to scatter it gets back from all others, since the BSDF is reciprocal and
    TIS + (ρ − TIS) = 1.
    """
    lamp = {"kind": "cosine-point", "flux": 1.0, "position": [0, 0, 1e-3], "axis": "-z"}
    surface = {"kind": "mirror", "reflectance": 1.0, "scatter": LOBES[name].to_table()}
    board = {**wall((0, 0, 0), "+z", 1e5), "surface": surface}
    n_mu, n_phi = 12, 4
    found = trace(
        scene_of([lamp], [board], far_field={"n_mu": n_mu, "n_phi": n_phi}),
        batches=32,
        rays_per_batch=rays,
    )
    first = found.compiled.layout.far_field
    bins = batch_values(found)[:, first : first + n_mu * n_phi].reshape(32, n_mu, n_phi)
    edges = np.linspace(-1.0, 1.0, n_mu + 1)
    wanted = np.where(edges[1:] > 1e-9, edges[1:] ** 2 - edges[:-1] ** 2, 0.0) / n_phi * rays
    limit = z_limit(sidak(ALPHA, n_mu // 2 * n_phi), 31)
    for row in range(n_mu // 2, n_mu):
        for column in range(n_phi):
            sample = bins[:, row, column]
            error = sample.std(ddof=1) / math.sqrt(32)
            assert abs(sample.mean() - wanted[row]) < limit * error, (row, column)
