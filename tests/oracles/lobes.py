"""Lobes of every model, and what their kernels give: directions, shares and densities."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

import photizon_cl as pz
from oracles.engine import compiled
from oracles.kernels import run_text

if TYPE_CHECKING:
    from numpy.typing import NDArray

LOBES = {
    "abg": pz.AbgScatter(A=1e-3, B=1e-2, g=2.0),
    "abg, steep": pz.AbgScatter(A=1e-3, B=1e-4, g=3.3),
    "abg, flat": pz.AbgScatter(A=0.05, B=0.1, g=0.7),
    "abg, flatter than the disc": pz.AbgScatter(A=10.0, B=100.0, g=0.01),
    "abg, wider than the disc": pz.AbgScatter(A=0.9, B=8.0, g=1.5),
    "harvey-shack": pz.HarveyShackScatter(b0=2.0, L=0.01, S=-1.5),
    "harvey-shack, log": pz.HarveyShackScatter(b0=2.0, L=0.03, S=-2.0),
    "harvey-shack, steep": pz.HarveyShackScatter(b0=0.5, L=0.4, S=-9.0),
    "harvey-shack, wide": pz.HarveyShackScatter(b0=0.2, L=15.0, S=-100.0),
    "gaussian": pz.GaussianScatter(sigma=0.05, tis=0.2),
    "gaussian, wide": pz.GaussianScatter(sigma=1.5, tis=0.9),
    "gaussian, wider than the disc": pz.GaussianScatter(sigma=2.5, tis=0.9),
    "gaussian, narrow": pz.GaussianScatter(sigma=1e-5, tis=0.9),
    "lambertian": pz.LambertianScatter(tis=0.3),
    "table": pz.TableScatter(delta=(0.0, 0.01, 0.1, 1.0), bsdf_per_sr=(10.0, 5.0, 0.1, 0.005)),
    "table, one": pz.TableScatter(delta=(0.5,), bsdf_per_sr=(0.3,)),
    "table, hill": pz.TableScatter(delta=(0.05, 0.3, 0.6, 1.5), bsdf_per_sr=(0.1, 0.2, 0.1, 0.0)),
}

_BODY = """
__kernel void test(__global const double *geometry, __global const double *ways,
                   __global double *out, __global const long *codes, long where, ulong steps,
                   ulong n) {
    const size_t item = get_global_id(0);
    const scene_t scene = {geometry, geometry, geometry, codes};
    packet_t p;
    clear_packet(&p);
    uint lanes_set;
    const lint i = rank_lanes(ALL_LANES, &lanes_set) + (long)(item * LANES);
    p.alive = ALL_LANES;
    p.ray_lo = TO_WORD(i);
    contact_t c = no_contact(&p, splat(0.0));
    c.nx = splat(0.36); c.ny = splat(0.48); c.nz = splat(-0.8);
    const lint at = (i % (long)(n)) * 3L;
    const real x = gather(ways, at), y = gather(ways + 1, at), z = gather(ways + 2, at);
    const mask plus = GT(dot3(x, y, z, c.nx, c.ny, c.nz), splat(0.0));
    const lobe_t lobe = lobe_about(&scene, steps, where >> 1, ALL_LANES, lsplat(where), &c, plus,
                                   x, y, z);
    real dx, dy, dz;
    draw_lobe(7UL, &p, (luint)(1UL), &lobe, &dx, &dy, &dz);
    const real density = density_lobe(&lobe, dx, dy, dz);
    // the ray that came along -d, into where the first one came from
    const real up = dot3(dx, dy, dz, c.nx, c.ny, c.nz), cosine = dot3(x, y, z, c.nx, c.ny, c.nz);
    const lobe_t back = lobe_about(&scene, steps, where >> 1, ALL_LANES, lsplat(where), &c, plus,
                                   fma(2.0 * up, c.nx, -dx), fma(2.0 * up, c.ny, -dy),
                                   fma(2.0 * up, c.nz, -dz));
    const real reverse = density_lobe(&back, fma(2.0 * cosine, c.nx, -x),
                                      fma(2.0 * cosine, c.ny, -y), fma(2.0 * cosine, c.nz, -z));
    const ulong all = get_global_size(0) * LANES;
    STORE(density * lobe.tis / fabs(up), out + 5 * all, item);
    STORE(reverse * back.tis / fabs(cosine), out + 6 * all, item);
    STORE(lobe.tis, out, item);
    STORE(dx, out + all, item);
    STORE(dy, out + 2 * all, item);
    STORE(dz, out + 3 * all, item);
    STORE(density, out + 4 * all, item);
}
"""

NORMAL = np.array([0.36, 0.48, -0.8])


@cache
def tables() -> Any:
    """Return the compiled scene that has a plate for each lobe, and a target."""
    place = {"axis": "+z", "half_width": 1.0, "half_height": 1.0}
    plates = [
        pz.Rectangle(name=name, position=(0.0, 0.0, 3.0 * n), surface=pz.Absorber(lobe), **place)
        for n, (name, lobe) in enumerate(LOBES.items())
    ]
    black = pz.Rectangle(name="black", position=(9.0, 0.0, 0.0), surface=pz.Absorber(), **place)
    lamp = pz.IsotropicPoint(name="lamp", flux=1.0, position=(-9.0, 0.0, 0.0))
    toward = pz.Importance(toward=["black"])
    return compiled(
        pz.Scene(name="lobes", source=(lamp,), element=(*plates, black), importance=toward)
    ).tables


def drawn(name: str, ways: NDArray[np.float64], rays: int, lanes: int = 1) -> NDArray[np.float64]:
    """Return what the lobe's kernels give of rays, shape (7, rays).

    TIS, the three components of a direction, its density, the BSDF that this is made of, and the
    BSDF of the way back.

    Parameters
    ----------
    name : str
        One of `LOBES`.
    ways : ndarray, shape (n, 3)
        Unit directions that the lobes of rays 0, 1, … n − 1, 0, … are about.
    rays : int
        A multiple of the lanes.
    lanes : int
        Lane width.
    """
    made = tables()
    where = made.codes[made.launch["scatter"] + list(LOBES).index(name)]
    steps = np.uint64(made.launch["scatter_steps"])
    arguments = [
        made.geometry,
        np.ascontiguousarray(ways),
        np.zeros(7 * rays),
        made.codes,
        np.int64(where),
    ]
    given = [*arguments, steps, np.uint64(len(ways))]
    return run_text(_BODY, given, rays, lanes=lanes, spec=made.spec)[2].reshape(7, rays)


def way(angle_deg: float, turn_deg: float = 20.0) -> NDArray[np.float64]:
    """Return the direction at an angle from `NORMAL`, turned about it."""
    e1 = np.cross(NORMAL, (1.0, 0.0, 0.0))
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(NORMAL, e1)
    angle, turn = np.radians([angle_deg, turn_deg])
    along = np.cos(turn) * e1 + np.sin(turn) * e2
    return np.cos(angle) * NORMAL + np.sin(angle) * along
