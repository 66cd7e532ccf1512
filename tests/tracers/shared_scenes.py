"""Scenes with media, spectra or scatter that other tracers know as well.

Each has one lamp and one element named ``sensor``; nothing stands behind them.
"""

from __future__ import annotations

from typing import Any

DOWN = {"position": [0.0, 0.0, 0.1], "axis": "-z"}
UP = {"position": [0.0, 0.0, 0.0], "axis": "+z"}
SQUARE = {**UP, "kind": "rectangle", "half_width": 0.015, "half_height": 0.015}
LEFT, RIGHT = ("left", -1.0, "+x"), ("right", 1.0, "-x")
WIDE, LONG = 0.05, 0.05
SPECTRUM = {"wavelengths_nm": [450.0, 550.0, 650.0]}
CROWN = {
    "kind": "sellmeier",
    "B": [1.03961212, 0.231792344, 1.01046945],
    "C_um2": [0.00600069867, 0.0200179144, 103.560653],
}
FLINT = {
    "kind": "sellmeier",
    "B": [1.62153902, 0.256287842, 1.64447552],
    "C_um2": [0.0122241457, 0.0595736775, 147.468793],
}
YELLOW = {"wavelength_nm": [400.0, 500.0, 700.0], "per_m": [40.0, 10.0, 2.0]}
RED = {"wavelength_nm": [400.0, 600.0, 700.0], "value": [0.2, 0.9, 0.7]}


def scene(
    name: str, lamp: dict[str, Any], sensor: dict[str, Any], *element: dict[str, Any], **more: Any
) -> dict[str, Any]:
    """Return one lamp, one sensor and what is between, as of a scene file."""
    shines = {"name": "lamp", "kind": "lambertian-disk", "flux": 1.0, "radius": 0.02}
    catches = {"name": "sensor", "surface": {"kind": "absorber"}, "detector": {}}
    shape = {} if "kind" in sensor else {"kind": "disk", "radius": 0.02}
    return {
        "schema": "photizon/1",
        "name": name,
        "source": [{**shines, **lamp}],
        "element": [*element, {**catches, **shape, **sensor}],
        **more,
    }


def coloured(
    name: str, dispersion: dict[str, Any], absorption: object, *element: dict[str, Any]
) -> dict[str, Any]:
    """Return one of glass with dispersion, told by wavelength."""
    glass = {"name": "glass", "dispersion": dispersion, "absorption_per_m": absorption}
    sensor = {**SQUARE, "detector": {"wavelengths": True}}
    return scene(name, DOWN, sensor, *element, medium=[glass], spectrum=SPECTRUM)


def body(name: str, kind: str, at: list[float], inside: str, outside: str, **shape: float) -> Any:
    surface = {"kind": "fresnel", "medium": inside, "medium_outside": outside}
    return {"name": name, "kind": kind, "position": at, "axis": "+z", "surface": surface, **shape}


def plate(name: str, at: list[float], axis: str, surface: dict[str, Any]) -> dict[str, Any]:
    half = {"half_width": WIDE, "half_height": LONG}
    return {
        "name": name, "kind": "rectangle", "position": at, "axis": axis, "surface": surface, **half,
    }  # fmt: skip


def walls(apart: float, height: float, surface: dict[str, Any]) -> list[dict[str, Any]]:
    """Return two plates that face each other."""
    return [plate(n, [side * apart, 0.0, height], axis, surface) for n, side, axis in (LEFT, RIGHT)]


BALL = {"kind": "sphere", "inside": "glass", "outside": "vacuum"}
BESIDE = {"position": [-0.04, 0.0, 0.05], "axis": "-z"}
ASIDE = {"position": [0.05, 0.01, 0.05], "axis": "-z"}

MITSUBA = [
    scene(
        "a ball of absorbing glass", DOWN, UP,
        body("ball", at=[0.0, 0.0, 0.05], radius=0.03, **BALL),
        medium=[{"name": "glass", "index": 1.5, "absorption_per_m": 20.0}],
    ),
    scene(
        "a bubble in glass in water", DOWN, UP,
        body("drop", "sphere", [0.002, 0.0, 0.05], "water", "vacuum", radius=0.04),
        body("glass", "sphere", [0.0, 0.003, 0.055], "glass", "water", radius=0.025),
        body("bubble", "sphere", [-0.004, 0.0, 0.05], "air", "glass", radius=0.01),
        run={"splitting": False},
        medium=[
            {"name": "water", "index": 1.33, "absorption_per_m": 8.0},
            {"name": "glass", "index": 1.55, "absorption_per_m": 30.0},
            {"name": "air", "index": 1.0},
        ],
    ),
    scene(
        "a mirror that scatters by ABg", BESIDE, ASIDE,
        plate(
            "mirror", [0.0, 0.0, 0.0], "+z",
            {
                "kind": "mirror", "reflectance": 0.9,
                "scatter": {"kind": "abg", "A": 0.03, "B": 0.05, "g": 1.7},
            },
        ),
    ),
    scene(
        "black paint with a Gaussian lobe", BESIDE, ASIDE,
        plate(
            "paint", [0.0, 0.0, 0.0], "+z",
            {"kind": "absorber", "scatter": {"kind": "gaussian", "sigma": 0.3, "tis": 0.1}},
        ),
    ),
    scene(
        "a channel of mirrors that scatter by Harvey and Shack",
        {"position": [0.0, 0.0, 0.08], "axis": "-z"}, UP,
        *walls(
            0.02, 0.04,
            {
                "kind": "mirror", "reflectance": 0.85,
                "scatter": {"kind": "harvey-shack", "b0": 0.5, "L": 0.2, "S": -2.5},
            },
        ),
        run={"splitting": False},
    ),
    scene(
        "a ball of absorbing glass between matt walls",
        DOWN, {**UP, "radius": 0.015, "kind": "disk"},
        body("ball", at=[0.0, 0.0, 0.04], radius=0.02, **BALL),
        *walls(0.03, 0.05, {"kind": "lambertian", "reflectance": 0.8}),
        medium=[{"name": "glass", "index": 1.7, "absorption_per_m": 15.0}],
    ),
]  # fmt: skip

RAYSECT = [
    coloured(
        "a yellow ball of flint", FLINT, YELLOW,
        body("ball", at=[0.0, 0.0, 0.05], radius=0.03, **BALL),
    ),
    coloured(
        "a lens of flint", FLINT, 5.0,
        body(
            "lens", "biconvex", [0.0, 0.0, 0.04], "glass", "vacuum",
            front_radius=0.03, back_radius=0.04, aperture_radius=0.02,
        ),
    ),
    coloured(
        "a yellow ball of crown between red walls", CROWN, YELLOW,
        body("ball", at=[0.0, 0.0, 0.04], radius=0.02, **BALL),
        *walls(0.03, 0.05, {"kind": "lambertian", "reflectance": RED}),
    ),
]  # fmt: skip
