"""Scatter and nested media by wavelength: what each ray must do, given its own."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np

import photizon_cl as pz
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, wall
from oracles.spectra import LINES, N_BK7, index_of_bk7, wavelength
from oracles.statistics import batch_values, batch_z, sidak, z_limit

if TYPE_CHECKING:
    from collections.abc import Callable

    from oracles.engine import Traced

ALPHA = 1e-6
"""False alarms of a statistical gate."""
EDGES = [400.0, 480.0, 500.0, 700.0]
REFLECTANCE = {"wavelength_nm": [380.0, 450.0, 560.0, 720.0], "value": [0.9, 0.3, 0.85, 0.4]}
_PER_PART = 8
_SEED = 5
_NARROW = 1e-9
_ASIDE, _DIFFUSE = 0.2, 0.1
_TURN = 40.0

Spectrum = dict[str, Any]
BY: dict[str, Spectrum] = {"lines": {"wavelengths_nm": LINES}, "bands": {"edges_nm": EDGES}}


def wavelengths(spectrum: Spectrum) -> tuple[int, Callable[[int], float]]:
    """Return how many rays there are, and the wavelength of each in nanometres."""
    if "wavelengths_nm" in spectrum:
        lines = spectrum["wavelengths_nm"]
        return len(lines) * _PER_PART, lambda ray: lines[ray // _PER_PART]
    edges = spectrum["edges_nm"]

    def in_band(ray: int) -> float:
        band = ray // _PER_PART
        return wavelength(_SEED, ray, edges[band], edges[band + 1])

    return (len(edges) - 1) * _PER_PART, in_band


def fresnel(sine: Any, n1: Any, n2: Any) -> Any:
    """Return the unpolarised reflectance, given the sine of the angle in the first medium."""
    c1, c2 = mpmath.sqrt(1 - sine**2), mpmath.sqrt(1 - (n1 * sine / n2) ** 2)
    s = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2)
    p = (n1 * c2 - n2 * c1) / (n1 * c2 + n2 * c1)
    return (s**2 + p**2) / 2


# -- scatter ---------------------------------------------------------------------------------------


def scattering_scene(spectrum: Spectrum) -> pz.Scene:
    """Return a slanting beam on glass that scatters narrowly, and a mirror of a table behind it."""
    narrow = {"kind": "gaussian", "sigma": _NARROW, "tis": _ASIDE}
    coloured = {"kind": "mirror", "reflectance": REFLECTANCE}
    return scene_of(
        [{**beam((0, 0, 0.5), "-z", 1e-9), "tilt_deg": [_TURN, 0.0]}],
        [
            {**wall((0, 0, 0), "+z", 50.0),
             "surface": {"kind": "fresnel", "medium": "bk7", "scatter": narrow}},
            {**wall((0, 0, -1.0), "+z", 50.0),
             "surface": {**coloured, "scatter": {"kind": "lambertian", "tis": _DIFFUSE}}},
        ],
        medium=[{"name": "bk7", "dispersion": N_BK7}],
        spectrum=spectrum,
    )  # fmt: skip


def scattering(by: str) -> None:
    """Glass scatters about the ray that its index gives, a mirror a part of its own reflectance.

    Of the border each of two children is 1 − TIS and TIS of Fresnel's R or T at the ray's
    wavelength, both in Snell's direction there; of the mirror ρ − TIS and TIS of what arrives.
    """
    rays, nm_of = wavelengths(BY[by])
    scene = scattering_scene(BY[by])
    found = pz.paths(scene, rays=rays, seed=_SEED, generation_cap=3)
    along = found.end - found.start
    along /= np.linalg.norm(along, axis=1)[:, None]
    table = pz.Curve(**REFLECTANCE)
    told = 0
    for ray in range(rays):
        mine = found.ray == ray
        nm = nm_of(ray)
        (first,) = np.flatnonzero(mine & (found.generation == 0))
        with mpmath.workdps(30):
            n = index_of_bk7(nm)
            into = [mpmath.mpf(x) for x in along[first].tolist()]
            r = float(fresnel(mpmath.sqrt(into[0] ** 2 + into[1] ** 2), 1, n))
            beta = [float(x / n) for x in into[:2]]
        for up, part in ((True, r), (False, 1.0 - r)):
            side = mine & (found.generation == 1) & ((along[:, 2] > 0.0) == up)
            weights = sorted(found.weight[side].tolist())
            assert len(weights) == 2
            assert abs(sum(weights) - part) < 1e-12
            assert abs(weights[0] / part - _ASIDE) < 1e-7
            wanted = along[first, :2] if up else np.array(beta)
            off = np.abs(along[side, :2] - wanted).max(axis=1)
            straight = np.argmax(found.weight[side])
            assert off[straight] < 1e-12
            assert 0.0 < off[1 - straight] < 7.0 * _NARROW
        rho = table.at(nm)
        for parent in np.flatnonzero(mine & (found.generation == 1) & (found.end[:, 2] == -1.0)):
            children = np.flatnonzero(mine & (found.parent == parent))
            parts = sorted((found.weight[children] / found.weight[parent]).tolist())
            wanted = sorted((rho - _DIFFUSE, _DIFFUSE))
            assert np.abs(np.subtract(parts, wanted)).max() < 1e-12
            told += 1
    assert told == 2 * rays


def scattering_of_lines() -> None:
    """What the gate of a broken engine runs, for lines."""
    scattering("lines")


def scattering_of_bands() -> None:
    """And for bands."""
    scattering("bands")


def everything(spectrum: Spectrum, **run: Any) -> pz.Scene:
    """Return all that reads a number over wavelength: a furnace of glass, mirrors, matt, paint."""
    lobe = {"kind": "gaussian", "sigma": 0.1, "tis": 0.2}
    dye = {"wavelength_nm": [450.0, 650.0], "per_m": [0.0, 4.0]}
    matt = {"wavelength_nm": [400.0, 700.0], "value": [0.7, 0.2]}
    target = {**wall((0.6, 0, 0.9), "-z", 0.2), **BLACK, "name": "target"}
    return scene_of(
        [
            {**beam((0, 0, 0.5), "-z", 0.02), "spectrum": [1.0, 2.0, 0.5]},
            {"kind": "cosine-point", "flux": 1.0, "position": [0.1, 0, 0.6], "axis": "-z"},
        ],
        [
            {"kind": "biconvex", "position": [0, 0, 0.2], "axis": "+z", "front_radius": 0.3,
             "back_radius": 0.4, "aperture_radius": 0.15,
             "surface": {"kind": "fresnel", "medium": "bk7", "scatter": lobe}},
            {**wall((0, 0, 0), "+z", 1.0),
             "surface": {"kind": "mirror", "reflectance": REFLECTANCE, "scatter": lobe}},
            {**wall((-1.0, 0, 0.5), "+x", 1.0), "surface": {"kind": "lambertian",
                                                           "reflectance": matt}},
            {**wall((0, 0, 1.0), "-z", 1.0), "surface": {"kind": "absorber", "scatter": lobe}},
            {**wall((1.0, 0, 0.5), "-x", 1.0), "surface": {"kind": "mixed", "specular": matt,
                                                          "diffuse": 0.25}},
            {**target, "detector": {"map": [2, 2], "generations": 4, "paths": 20,
                                    "wavelengths": True}},
        ],
        medium=[{"name": "bk7", "dispersion": N_BK7, "absorption_per_m": dye}],
        importance={"toward": ["target"]},
        spectrum=spectrum,
        run={"roulette_floor": 0.01, "generation_cap": 6, **run},
    )  # fmt: skip


def narrow_band(tables: dict[str, Any], rays: int, **how: Any) -> None:
    """A band so narrow that it is a line gives what that line gives, in every cell.

    The draw of a wavelength has a key of its own, so that all others are the same in both; what
    differs are polynomials in place of numbers, and where they stand.
    """
    lights: list[Spectrum] = [
        {"wavelengths_nm": [550.0]}, {"edges_nm": [550.0 * (1.0 - 2.0**-46), 550.0]}
    ]  # fmt: skip
    line, band = (trace(pz.load({**tables, "spectrum": x}), rays_per_batch=rays, **how)
                  for x in lights)  # fmt: skip
    assert band.compiled.tables.spec.real == line.compiled.tables.spec.real
    assert line.interactions == band.interactions > 4 * rays
    assert (line.cells[:, 3] == band.cells[:, 3]).all()
    one, other = (np.array(batch_values(found)).sum(axis=0) for found in (line, band))
    assert np.abs(one - other).max() <= 1e-9
    assert (one != 0.0).sum() > 20


def aimed_by_line() -> None:
    """Rays that are sent towards targets weigh what reflectance and index of their lines say.

    A matt wall of a table, and glass of a strong dispersion that scatters a half evenly, each under
    a disk that gets r²/(r² + d²) of what is scattered.
    """
    table = {"wavelength_nm": [400.0, 700.0], "value": [0.9, 0.2]}
    lobe = {"kind": "lambertian", "tis": 0.5}
    optics = [
        {"kind": "lambertian", "reflectance": table},
        {"kind": "fresnel", "medium": "steep", "scatter": lobe},
    ]
    lamps, boards, disks = [], [], []
    apart, radius, above = 30.0, 0.3, 1.0
    for n, surface in enumerate(optics):
        lamps.append({**beam((apart * n, 0, 0.2), "-z", 1e-9), "tilt_deg": [70.0, 0.0]})
        boards.append({**wall((apart * n, 0, 0), "+z", 5.0), "surface": surface})
        x = apart * n - 0.2 * math.tan(math.radians(70.0))  # where the beam lands
        disks.append(
            {"kind": "disk", "radius": radius, "position": [x, 0, above], "axis": "-z",
             "name": f"disk {n}", **BLACK, "detector": {"wavelengths": True}}
        )  # fmt: skip
    scene = scene_of(
        lamps,
        [*boards, *disks],
        medium=[{"name": "steep", "dispersion": {"kind": "cauchy", "A": 1.1, "B_um2": 0.3}}],
        spectrum={"wavelengths_nm": LINES},
        importance={"toward": ["disk 0", "disk 1"]},
        run={"generation_cap": 3},
    )
    rays = 3 * 512
    found = trace(scene, batches=32, rays_per_batch=2 * rays)
    limit = z_limit(sidak(ALPHA, 6), 31)
    seen = radius**2 / (radius**2 + above**2)
    sine = math.sin(math.radians(70.0))
    for k, nm in enumerate(LINES):
        n = 1.1 + 0.3e6 / nm**2
        parts = (pz.Curve(**table).at(nm), 0.5 * float(fresnel(mpmath.mpf(sine), 1, n)))
        for part, detector in zip(parts, found.compiled.layout.detectors, strict=True):
            cell = detector.by_wavelength("power", k)
            z = batch_z(found, lambda x, cell=cell: x[cell], part * seen * rays / 3)
            assert abs(z) < limit, (k, z)


# -- nested media ----------------------------------------------------------------------------------

_RADII = (0.3, 0.2, 0.1)
_DYE = {"wavelength_nm": [400.0, 550.0, 700.0], "per_m": [0.5, 0.0, 3.0]}
_GLASS_TAKES = 2.0
_WATER = (1.32, 0.0035)
_BESIDE = 0.05


def nested_scene(spectrum: Spectrum) -> pz.Scene:
    """Return a bubble in a ball of glass in a ball of water, and a thin beam beside the middle."""
    pairs = (("water", "vacuum"), ("bk7", "water"), ("vacuum", "bk7"))
    a, b = _WATER
    return scene_of(
        [beam((0, _BESIDE, -1.0), "+z", 1e-9)],
        [
            {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": radius,
             "surface": {"kind": "fresnel", "medium": inside, "medium_outside": outside}}
            for radius, (inside, outside) in zip(_RADII, pairs, strict=True)
        ],
        medium=[
            {"name": "water", "dispersion": {"kind": "cauchy", "A": a, "B_um2": b},
             "absorption_per_m": _DYE},
            {"name": "bk7", "dispersion": N_BK7, "absorption_per_m": _GLASS_TAKES},
        ],
        spectrum=spectrum,
    )  # fmt: skip


def _through(nm: float, beside: float) -> tuple[float, float]:
    """Return by how much a ray is turned by all balls, and what comes through, by Bouguer's law."""
    with mpmath.workdps(30):
        um = mpmath.mpf(nm) / 1000
        h = mpmath.mpf(beside)
        n = [mpmath.mpf(1), _WATER[0] + mpmath.mpf(_WATER[1]) / um**2, index_of_bk7(nm), 1]
        alpha = [0, pz.AbsorptionCurve(**_DYE).at(nm), _GLASS_TAKES, 0]
        turned, depth, part = mpmath.mpf(0), mpmath.mpf(0), mpmath.mpf(1)
        for k, radius in enumerate(map(mpmath.mpf, _RADII)):
            before, behind = h / (n[k] * radius), h / (n[k + 1] * radius)
            turned += 2 * (mpmath.asin(before) - mpmath.asin(behind))
            part *= (1 - fresnel(before, n[k], n[k + 1])) ** 2
            # the ways to a ball's rim add to what is before it, and take from what is in it
            depth -= 2 * alpha[k] * radius * mpmath.sqrt(1 - before**2)
            depth += 2 * alpha[k + 1] * radius * mpmath.sqrt(1 - behind**2)
        return float(turned), float(part * mpmath.exp(-depth))


def nested(by: str) -> None:
    """What goes straight through all three balls is turned and weakened as each wavelength is."""
    rays, nm_of = wavelengths(BY[by])
    told = 0
    for line in pz.paths(nested_scene(BY[by]), rays=rays, seed=_SEED, generation_cap=7):
        if line.parent >= 0:
            continue
        assert len(line.points) == 8
        way = np.diff(line.points, axis=0)[-1]
        turned, part = _through(nm_of(line.ray), math.hypot(*line.points[0][:2]))
        assert abs(math.atan2(-way[1], way[2]) - turned) < 1e-12
        assert abs(line.weight[-1] / part - 1.0) < 1e-12
        told += 1
    assert told == rays


def nested_of_bands() -> None:
    """What the gate of a broken engine runs."""
    nested("bands")


def nested_rows() -> Traced:
    """Return what such a scene books by line."""
    return trace(nested_scene(BY["lines"]), rays_per_batch=12, generation_cap=12)
