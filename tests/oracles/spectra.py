"""Scenes by wavelength, and what each line must give: prisms, tables, layers that absorb."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np

import photizon_cl as pz
from oracles import philox
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, wall

if TYPE_CHECKING:
    from oracles.engine import Traced

LINES = [486.1, 587.6, 656.3]
N_BK7 = {
    "kind": "sellmeier",
    "B": [1.03961212, 0.231792344, 1.01046945],
    "C_um2": [0.00600069867, 0.0200179144, 103.560653],
}
"""Schott's, from its data sheet."""


def index_of_bk7(nm: float) -> mpmath.mpf:
    """Return the index in 40 digits."""
    with mpmath.workdps(40):
        square = (mpmath.mpf(nm) / 1000) ** 2
        terms = zip(N_BK7["B"], N_BK7["C_um2"], strict=True)
        return mpmath.sqrt(1 + sum(mpmath.mpf(b) * square / (square - c) for b, c in terms))


def prism_scene(apex_deg: float = 40.0, lines: list[float] = LINES) -> pz.Scene:
    """Return a prism of N-BK7 on the axis of a thin beam, and a screen behind it."""
    half = apex_deg / 2
    glass = {"surface": {"kind": "fresnel", "medium": "bk7"}}
    faces = [
        {**wall((0, 0, side * 0.02), axis, 0.02), **glass, "tilt_deg": turn}
        for side, axis, turn in ((-1, "-z", [half, 0.0]), (1, "+z", [0.0, -half]))
    ]
    screen = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0, **BLACK}
    return scene_of(
        [beam((0, 0, -0.5), "+z", 1e-9)],
        [*faces, screen],
        medium=[{"name": "bk7", "dispersion": N_BK7}],
        spectrum={"wavelengths_nm": lines},
    )


def deviations(scene: pz.Scene) -> list[float]:
    """Return by how much the ray of each line is turned that goes straight through, in radians."""
    n = scene.spectrum.n
    found = pz.paths(scene, rays=n, seed=1, generation_cap=4)
    angles = [math.nan] * n
    for line in found:
        if line.parent < 0 and len(line.points) == 4:
            way = np.diff(line.points, axis=0)
            first, last = (d / math.hypot(*d) for d in (way[0], way[2]))
            angles[line.ray % n] = math.atan2(math.hypot(*np.cross(first, last)), first @ last)
    return angles


def deviation_of(nm: float, apex_deg: float = 40.0) -> float:
    """Return it by Snell's law at both faces, in 40 digits."""
    with mpmath.workdps(40):
        apex = mpmath.radians(apex_deg)
        n, first = index_of_bk7(nm), apex / 2
        inside = apex - mpmath.asin(mpmath.sin(first) / n)
        return float(first + mpmath.asin(n * mpmath.sin(inside)) - apex)


def prism() -> None:
    """The ray of each line is turned as its index says."""
    for nm, found in zip(LINES, deviations(prism_scene()), strict=True):
        assert abs(found - deviation_of(nm)) < 1e-12


def tables_scene(**spectrum: Any) -> pz.Scene:
    """Return a mirror behind an absorbing plate, which all light passes twice, and a target."""
    mirror = {"wavelength_nm": [400.0, 500.0, 600.0], "value": [0.5, 0.9, 0.25]}
    dye = {"wavelength_nm": [450.0, 650.0], "per_m": [0.0, 40.0]}
    plate = {"surface": {"kind": "fresnel", "medium": "dye"}}
    return scene_of(
        [
            {**beam((0, 0, -0.5), "+z", 0.01), "flux": 3.0, **spectrum},
            {**beam((0, 0, -0.4), "+z", 0.01), "flux": 0.5, "spectrum": [0.0, 1.0, 0.0, 2.0]},
        ],
        [
            {**wall((0, 0, 0), "-z", 1.0), **plate},
            {**wall((0, 0, 0.01), "+z", 1.0), **plate},
            {**wall((0, 0, 0.1), "-z", 1.0), "surface": {"kind": "mirror", "reflectance": mirror}},
            {**wall((0, 0, -1.0), "+z", 1.0), **BLACK,
             "detector": {"map": [2, 3], "generations": 6, "wavelengths": True}},
        ],
        medium=[{"name": "dye", "index": 1.0, "absorption_per_m": dye}],
        spectrum={"wavelengths_nm": [425.0, 500.0, 550.0, 650.0]},
    )  # fmt: skip


WANTED = ((425.0, 0.6, 0.0), (500.0, 0.9, 10.0), (550.0, 0.575, 20.0), (650.0, 0.25, 40.0))
"""Wavelength, reflectance, absorption in 1/m of that scene's lines; the last reflectance is that of
the table's end."""
POWERS = {None: (0.75, 0.75, 0.75, 0.75), (1.0, 0.0, 3.0, 1.0): (0.6, 0.0, 1.8, 0.6)}


def tables(powers: tuple[float, ...] | None = None) -> Traced:
    """Every row of every line is what its reflectance and its absorption leave."""
    scene = tables_scene(**({} if powers is None else {"spectrum": list(powers)}))
    found = trace(scene, rays_per_batch=64, batches=2)
    layout, unit = found.compiled.layout, found.compiled.unit_power / 2
    second = (0.0, 0.5 / 3, 0.0, 1.0 / 3)
    row = {"mirror": 2, "target": 3, "dye": layout.row("absorbed_in.dye")}
    for k, (_, rho, alpha) in enumerate(WANTED):
        power = POWERS[powers][k] + second[k]
        once = math.exp(-alpha * 0.01)
        wanted = {
            "mirror": power * once * (1.0 - rho),
            "target": power * once * once * rho,
            "dye": power * (1.0 - once) * (1.0 + once * rho),
        }
        for name, cell in row.items():
            watts = float(found.amount(layout.part(cell, k))) * unit
            assert abs(watts - wanted[name]) < 1e-14, (k, name)
        (d,) = layout.detectors
        watts = float(found.amount(d.by_wavelength("power", k))) * unit
        assert abs(watts - wanted["target"]) < 1e-14, k
    sums(found)
    return found


def sums(found: Traced) -> None:
    """The parts of every row, ladder entry and bin are the whole to the last bit."""
    layout = found.compiled.layout
    for row in range(layout.n_rows):
        parts = [found.amount(layout.part(row, k)) for k in range(layout.parts)]
        assert sum(parts, Fraction(0)) == found.amount(row)
    for d in layout.detectors:
        for name, n in (("power", 1), ("ladder", d.n_generations), ("map", d.nx * d.ny)):
            first = {"power": d.power, "ladder": d.ladder, "map": d.map}[name]
            for k in range(n):
                cells = [d.by_wavelength(name, line) + k for line in range(d.wavelengths)]
                assert sum(map(found.amount, cells), Fraction(0)) == found.amount(first + k)
                assert sum(map(found.count, cells)) == found.count(first + k)


_IN_BAND = 7
"""The decision of a ray's wavelength in its band."""


def wavelength(seed: int, ray: int, low: float, high: float) -> float:
    """Return the wavelength of a ray in its band, from the draw that is documented."""
    u, _ = philox.draw(seed, ray, philox.ROOT, 0, _IN_BAND)
    return low + u * (high - low)


def prism_of_bands() -> None:
    """Rays in bands are turned as the index at their own wavelengths says."""
    edges = [400.0, 480.0, 500.0, 700.0]
    tables = prism_scene().to_dict()
    tables["spectrum"] = {"edges_nm": edges}
    scene = pz.load(tables)
    rays = 30
    found = pz.paths(scene, rays=rays, seed=5, generation_cap=4)
    told = 0
    for line in found:
        if line.parent >= 0 or len(line.points) != 4:
            continue
        way = np.diff(line.points, axis=0)
        first, last = (d / math.hypot(*d) for d in (way[0], way[2]))
        angle = math.atan2(math.hypot(*np.cross(first, last)), first @ last)
        band = line.ray // 10
        nm = wavelength(5, line.ray, edges[band], edges[band + 1])
        assert abs(angle - deviation_of(nm)) < 1e-12
        told += 1
    assert told == rays
