"""Polarised light by coherency matrices in space, and gates on how the engine carries it.

A ray's light is J = <E E†>, a 3 × 3 matrix in world coordinates whose trace is the power: there is
no frame across the ray, and nothing of the engine's Stokes parameters. A face acts by
M = a_s s sᵀ + a_p p' pᵀ (M. Born and E. Wolf, Principles of Optics, 7th ed., 1.5.2, with
exp(−iωt)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

import photizon_cl as pz
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, cube

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

ON = {"polarisation": True}
CLOSE = 1e-12


# -- light -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Light:
    """A ray's direction and coherency matrix; the trace is its power."""

    along: NDArray[Any]
    field: NDArray[Any] = field(repr=False)

    @property
    def power(self) -> float:
        """Its power."""
        return float(np.trace(self.field).real)

    @property
    def degree(self) -> float:
        """Part of its power that is polarised."""
        square = float(np.trace(self.field @ self.field).real)
        return math.sqrt(max(2.0 * square / self.power**2 - 1.0, 0.0))


def unpolarised(along: NDArray[Any], power: float = 1.0) -> Light:
    """Return light without polarisation."""
    return Light(along, power * (np.eye(3) - np.outer(along, along)) / 2.0 + 0j)


def launched(source: Any, along: NDArray[Any], power: float = 1.0) -> Light:
    """Return the light of a source along a ray."""
    light = unpolarised(along, power)
    told = source.polarisation
    if told is None:
        return light
    u, v, w = np.array(source.frame)
    first = u - (u @ along) * along
    first /= np.linalg.norm(first)
    second = np.cross(along, first) * (1.0 if along @ w >= 0.0 else -1.0)
    assert second @ v >= -1e-15 or abs(along @ w) < 1e-12
    angle = math.radians(told.angle_deg)
    e = math.cos(angle) * first + math.sin(angle) * second
    whole = power * told.degree * np.outer(e, e)
    return Light(along, whole + (1.0 - told.degree) * light.field)


def _parts(d: NDArray[Any], n: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return s and p of a ray at a face."""
    s = np.cross(d, n)
    length = np.linalg.norm(s)
    if length < 1e-9:  # any plane does
        s = np.cross(d, [1.0, 0.0, 0.0] if abs(d[0]) < 0.9 else [0.0, 1.0, 0.0])
        length = np.linalg.norm(s)
    s = s / length
    return s, np.cross(d, s)


def mirrored(d: NDArray[Any], n: NDArray[Any]) -> NDArray[Any]:
    """Return the reflected direction."""
    return d - 2.0 * (d @ n) * n


def refracted(d: NDArray[Any], n: NDArray[Any], m: float) -> NDArray[Any] | None:
    """Return the refracted direction for m = n1/n2; None where all is reflected."""
    cosine = d @ n
    along = d - cosine * n
    square = 1.0 - m * m * (along @ along)
    if square <= 0.0:
        return None
    return m * along + math.copysign(math.sqrt(square), cosine) * n


def amplitudes(cosine: float, m: float) -> tuple[complex, complex, complex, complex]:
    """Return r_s, r_p, t_s and t_p for m = n1/n2, of which |t|² is a part of the power."""
    behind = np.sqrt(1.0 - m * m * (1.0 - cosine * cosine) + 0j)
    a, b = m * cosine + behind, cosine + m * behind
    root = np.sqrt(behind / (m * cosine))
    r_s = (m * cosine - behind) / a
    r_p = (cosine - m * behind) / b
    return r_s, r_p, 2.0 * m * cosine / a * root, 2.0 * m * cosine / b * root


def sent(light: Light, n: NDArray[Any], to: NDArray[Any], a_s: complex, a_p: complex) -> Light:
    """Return what goes on in a direction by two amplitudes."""
    s, p = _parts(light.along, n)
    matrix = a_s * np.outer(s, s) + a_p * np.outer(np.cross(to, s), p)
    return Light(to, matrix @ light.field @ matrix.conj().T)


def reflected(light: Light, n: NDArray[Any], m: float) -> Light:
    """Return what a border reflects."""
    r_s, r_p, *_ = amplitudes(abs(light.along @ n), m)
    return sent(light, n, mirrored(light.along, n), r_s, r_p)


def transmitted(light: Light, n: NDArray[Any], m: float) -> Light | None:
    """Return what a border lets through; None where all is reflected."""
    to = refracted(light.along, n, m)
    if to is None:
        return None
    *_, t_s, t_p = amplitudes(abs(light.along @ n), m)
    return sent(light, n, to, t_s, t_p)


def coated(
    light: Light, n: NDArray[Any], m: float, surface: Any, nm: float | None, to: NDArray[Any] | None
) -> Light:
    """Return what a coated border reflects, or lets through where it goes on `to`."""
    inside, outside = surface.indices
    from_inside = light.along @ n > 0.0
    angle = math.degrees(math.acos(min(abs(light.along @ n), 1.0)))
    if isinstance(surface.coating, pz.StackCoating):
        assert nm is not None
        found = surface.coating.amplitudes(angle, inside, outside, nm=nm, inside=from_inside)
        r_s, r_p, t_s, t_p = (complex(wave) for wave in found)
    else:
        powers = surface.coating.powers(angle, inside, outside, nm=nm, inside=from_inside)
        root, passed = (math.sqrt(float(part)) for part in powers)
        r_s, r_p, t_s, t_p = -root, root, passed, passed
    if to is not None:
        return sent(light, n, to, t_s, t_p)
    return sent(light, n, mirrored(light.along, n), r_s, r_p)


def conducted(light: Light, n: NDArray[Any], reflectance: float) -> Light:
    """Return what a metal reflects."""
    root = math.sqrt(reflectance)
    return sent(light, n, mirrored(light.along, n), -root, root)


# -- replaying what the engine traced --------------------------------------------------------------


def replay(scene: pz.Scene, rays: int, **options: Any) -> dict[str, float]:
    """Trace rays of a scene of flat elements, and follow each segment's light.

    Every weight behind a surface without scatter is compared. Returns the greatest difference,
    relative to the launched weight, and how many segments there were of each kind.
    """
    found = pz.paths(scene, rays=rays, **options)
    lights: list[Light] = []
    told = {"difference": 0.0, "r": 0, "t": 0, "i": 0, "s": 0, "launched": 0}
    first = np.cumsum([0, *_rays_of(scene, rays)])
    nm = None if scene.spectrum is None else scene.spectrum.wavelengths_nm[0]
    for n, parent in enumerate(found.parent):
        weight = float(found.weight[n])
        along = found.end[n] - found.start[n]
        along = along / np.linalg.norm(along)
        if parent < 0:
            number = int(np.searchsorted(first, found.ray[n], "right")) - 1
            lights.append(launched(scene.source[number], along, weight))
            told["launched"] += 1
            continue
        element = scene.element[int(found.element[parent])]
        light, what = _behind(lights[parent], element, along, weight, nm)
        told[what] += 1
        if what != "s" and element.surface.lobe is None:
            told["difference"] = max(told["difference"], abs(light.power - weight))
        lights.append(light)
    return told


def _rays_of(scene: pz.Scene, rays: int) -> Sequence[int]:
    from photizon_cl.compile.rays import share_rays

    return share_rays(scene, rays)


def _behind(
    light: Light, element: Any, along: NDArray[Any], weight: float, nm: float | None
) -> tuple[Light, str]:
    """Return the light of the ray that left an element in a direction, and what happened."""
    n, surface = np.array(element.frame[2]), element.surface
    back = mirrored(light.along, n)
    if not surface.counts:
        return light, "t"
    if surface.indices is not None:
        inside, outside = surface.indices
        m = outside / inside if light.along @ n < 0.0 else inside / outside
        through = refracted(light.along, n, m)
        if surface.coating is not None and (_same(back, along) or through is not None):
            to = None if _same(back, along) else through
            light = coated(light, n, m, surface, nm, to)
            return light, "t" if to is not None else "r" if through is not None else "i"
        if through is not None and _same(through, along):
            passed = transmitted(light, n, m)
            assert passed is not None
            return _weighed(passed, surface, weight), "t"
        if _same(back, along):
            return _weighed(
                reflected(light, n, m), surface, weight
            ), "r" if through is not None else "i"
    elif surface.reflects and _same(back, along):
        part = getattr(surface, "reflectance", None)
        part = surface.specular if part is None else part
        return _weighed(conducted(light, n, part), surface, weight), "r"
    return unpolarised(along, weight), "s"


def _weighed(light: Light, surface: Any, weight: float) -> Light:
    """Return the light with what scatter left of it."""
    if surface.lobe is None:
        return light
    return Light(light.along, light.field * (weight / light.power))


def _same(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return bool(np.linalg.norm(a - b) < 1e-9)


# -- scenes ----------------------------------------------------------------------------------------


def turned(n: NDArray[Any]) -> dict[str, Any]:
    """Return axis and tilt that give a normal."""
    a = -math.degrees(math.asin(min(max(n[1], -1.0), 1.0)))
    b = math.degrees(math.atan2(n[0], n[2]))
    return {"axis": "+z", "tilt_deg": [a, b]}


@dataclass(frozen=True)
class Step:
    """A face that a beam meets, and what it follows there.

    Parameters
    ----------
    angle : float
        Of incidence, in degrees.
    plane : ndarray, shape (3,)
        Any vector in the plane of incidence that is not along the ray.
    surface : mapping
        Its table.
    through : bool
        Whether the beam is followed through it; else to where it is reflected, as it is where all
        is.
    behind : bool
        Whether the beam comes from behind its normal.
    """

    angle: float
    plane: NDArray[Any]
    surface: dict[str, Any]
    through: bool = False
    behind: bool = False


def glass(index: float, outside: float = 1.0) -> dict[str, Any]:
    """Return the table of a border."""
    return {"kind": "fresnel", "index": index, "index_outside": outside}


def bench(
    steps: Sequence[Step],
    told: dict[str, Any] | None = None,
    *,
    half: float = 1e-3,
    more: dict[str, Any] | None = None,
    **run: Any,
) -> pz.Scene:
    """Return a beam of one ray along +z, the faces that it meets, and a detector at its end.

    The source's u is +x and its v is +y. What the steps do not follow leaves them.
    """
    d, at = np.array([0.0, 0.0, 1.0]), np.zeros(3)
    lamp: dict[str, Any] = {
        "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, 0], "axis": "+z", "radius": 1e-9,
    }  # fmt: skip
    if told is not None:
        lamp["polarisation"] = told
    elements: list[dict[str, Any]] = []
    for number, step in enumerate(steps):
        at = at + d * (1.0 + 0.3 * number)  # so that none stands where another one did
        side = step.plane - (step.plane @ d) * d
        side = side / np.linalg.norm(side)
        angle = math.radians(step.angle)
        n = (math.sin(angle) * side - math.cos(angle) * d) * (-1.0 if step.behind else 1.0)
        size = {"half_width": half, "half_height": half}
        face = {"kind": "rectangle", "position": at.tolist(), **size, **turned(n)}
        elements.append({**face, "surface": step.surface})
        to = None
        if step.through:
            m = step.surface["index_outside"] / step.surface["index"]
            to = refracted(d, n, 1.0 / m if step.behind else m)
        d = mirrored(d, n) if to is None else to
        d = d / np.linalg.norm(d)
    end = {"kind": "rectangle", "position": (at + d).tolist(), **turned(-d), **BLACK}
    end |= {"half_width": 0.1, "half_height": 0.1, "detector": {}, "name": "end"}
    # light that comes back to the same way has made more interactions
    settings = {"rays_per_batch": 1, "generation_cap": len(elements) + 1, **ON, **run}
    return scene_of([lamp], [*elements, end], run=settings, **(more or {}))


def arriving(scene: pz.Scene) -> float:
    """Return what a scene's end gets of 1 W."""
    return float(trace(scene).detector("end").power)


def chain(
    seed: int, faces: int, told: dict[str, Any] | None, coatings: Sequence[Any] = (), **more: Any
) -> pz.Scene:
    """Return a bench of faces at random angles: borders met from either side, and mirrors.

    Where there are `coatings` borders have them in turn, and every third has none.
    """
    g = np.random.default_rng(seed)
    steps: list[Step] = []
    for _ in range(faces):
        kind = g.choice(["mirror", "through", "back", "back"])
        surface = glass(*map(float, g.uniform(1.0, 2.5, 2)))
        if kind == "mirror":
            surface = {"kind": "mirror", "reflectance": float(g.uniform(0.5, 1.0))}
        elif coatings and len(steps) % 3:
            surface["coating"] = coatings[len(steps) % len(coatings)]
        behind, through = bool(g.integers(2)), kind == "through"
        steps.append(Step(g.uniform(0.0, 85.0), g.normal(size=3), surface, through, behind))
    return bench(steps, told, more=more)


GREEN = {"spectrum": {"wavelengths_nm": [550.0]}}
COATINGS: tuple[dict[str, Any], ...] = (
    {"kind": "stack", "layers": [{"index": 1.38, "thickness_nm": 99.6}]},
    {"kind": "fixed", "reflectance": 0.3, "transmittance": 0.6},
    {
        "kind": "stack",
        "layers": [
            {"index": 2.3, "thickness_nm": 130.0},
            {"index": 1.46, "thickness_nm": 210.0},
            {"index": 0.9, "extinction": 0.8, "thickness_nm": 20.0},
        ],
    },
    {
        "kind": "table", "angle_deg": [0.0, 50.0, 90.0], "reflectance": [0.1, 0.3, 0.9],
        "transmittance": [0.8, 0.6, 0.0],
    },
)  # fmt: skip


def coated_chain(seed: int = 0) -> None:
    """Every weight along a chain of coated faces is that of their own amplitudes."""
    told = ({"degree": 1.0, "angle_deg": 30.0}, {"degree": 0.4, "angle_deg": -70.0})
    found = replay(chain(seed, 9, told[seed % 2], COATINGS, **GREEN), 1)
    assert found["r"] + found["i"] >= 3
    assert found["difference"] < CLOSE


def room(**run: Any) -> pz.Scene:
    """Return a closed box of flat elements, every surface, and lamps that shine everywhere."""
    lobe = {"kind": "gaussian", "sigma": 0.2, "tis": 0.3}
    surfaces: list[dict[str, Any]] = [
        {"kind": "mirror", "reflectance": 0.9},
        {"kind": "mirror", "reflectance": 0.9, "scatter": lobe},
        {"kind": "mixed", "specular": 0.5, "diffuse": 0.3},
        {"kind": "lambertian", "reflectance": 0.7},
        {"kind": "mixed", "specular": 0.0, "diffuse": 0.6},
        {"kind": "mirror", "reflectance": 0.8},
    ]
    walls = [{**face, "surface": s} for face, s in zip(cube({}), surfaces, strict=True)]
    g = np.random.default_rng(5)
    panes = []
    for n, surface in enumerate(
        (
            glass(1.5),
            glass(1.0, 1.7),
            glass(1.6),
            {**glass(1.4), "scatter": lobe},
            {"kind": "clear"},
        )
    ):
        at = np.array([0.45 * math.cos(n), 0.45 * math.sin(n), 0.3 * math.sin(2.0 * n)])
        side = g.normal(size=3)
        size = {"half_width": 0.4, "half_height": 0.5}
        pane = {"kind": "rectangle", "position": at.tolist(), **size}
        panes.append({**pane, **turned(side / np.linalg.norm(side)), "surface": surface})
    lamps = [
        {"kind": "isotropic-point", "flux": 1.0, "position": [0.05, -0.1, 0.02]},
        {
            "kind": "isotropic-point", "flux": 2.0, "position": [0.0, 0.1, 0.0],
            "polarisation": {"angle_deg": 33.0},
        },
        {
            "kind": "cone-point", "flux": 1.0, "position": [-0.1, 0, 0], "axis": "-y",
            "tilt_deg": [20.0, -50.0], "half_angle_deg": 150.0,
            "polarisation": {"degree": 0.7, "angle_deg": 110.0},
        },
    ]  # fmt: skip
    settings = {"rays_per_batch": 64, "generation_cap": 5, **ON, **run}
    return scene_of(lamps, [*walls, *panes], run=settings)


def replays_a_room(rays: int = 60) -> None:
    """Every surface and what it makes of the light, and the light that lamps launch."""
    found = replay(room(), rays)
    assert min(found[what] for what in "rts") > 100
    assert found["i"] > 0
    assert found["difference"] < CLOSE
