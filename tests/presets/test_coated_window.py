"""The preset `coated-window` against the closed form of a single film, line by line."""

from __future__ import annotations

import mpmath
import pytest

import photizon_cl as pz

pytestmark = pytest.mark.usefixtures("one_lane")


def reflectance(nm: float) -> mpmath.mpf:
    """Return R of a face at normal incidence (Airy's formula of one film)."""
    with mpmath.workdps(30):
        glass, film = mpmath.mpf("1.5168"), mpmath.mpf("1.38")
        r, s = (1 - film) / (1 + film), (film - glass) / (film + glass)
        c = 2 * r * s * mpmath.cos(mpmath.pi * 550 / nm)
        return (r**2 + s**2 + c) / (1 + r**2 * s**2 + c)


def test_anchor_numbers():
    scene = pz.load("coated-window")
    lines = scene.spectrum.wavelengths_nm
    parts = [reflectance(nm) for nm in lines]
    for nm, r in zip(lines, parts, strict=True):
        assert f"{float(r):.11f} at {nm:.0f} nm" in scene.notes
    through = [float((1 - r) ** 2) for r in parts]
    ghosts = [float((1 - r) ** 2 * r**2) for r in parts]
    assert "{:.12f}, {:.12f} and {:.12f} W".format(*through) in scene.notes
    assert f"{sum(through):.12f} W together" in scene.notes
    shown = [f"{ghost:.8e}".replace("e-04", "e-4") for ghost in ghosts]
    assert "{}, {} and {} W".format(*shown) in scene.notes
    assert f"bare glass has {(0.5168 / 2.5168) ** 2:.10f}" in scene.notes
    for name in ("front", "back"):
        (film,) = scene.element[name].surface.coating.layers
        assert film.thickness_nm == pytest.approx(550.0 / 4.0 / 1.38, rel=1e-15)


def test_every_order_of_every_line_is_exact():
    result = pz.trace("coated-window", batches=1, rays_per_batch=96)
    ladder = result.detectors["transmitted"].ladder
    for line, nm in enumerate((450.0, 550.0, 650.0)):
        r = float(reflectance(nm))
        for order in range(3):
            part = ladder[2 + 2 * order].by_wavelength[line]
            wanted = (1.0 - r) ** 2 * r ** (2 * order)
            assert part.value == pytest.approx(wanted, rel=2e-12)
    for name in ("front", "back"):
        assert result.ledger.absorbed[name].value == 0.0
    assert abs(result.ledger.closure) <= 3e-15
