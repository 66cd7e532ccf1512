"""Gates on polarised light whose answers are closed forms."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

import photizon_cl as pz
from oracles.engine import scene_of, trace
from oracles.polarised import (
    CLOSE,
    ON,
    Step,
    arriving,
    bench,
    glass,
    launched,
    mirrored,
    reflected,
    sent,
    turned,
)
from oracles.scenes import BLACK

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

X, Y, Z = np.eye(3)


def reflectances(angle: float, index: float) -> tuple[float, float]:
    """Return R_s and R_p from outside, by Fresnel's sines and tangents."""
    one = math.radians(angle)
    two = math.asin(math.sin(one) / index)
    s = math.sin(one - two) / math.sin(one + two)
    p = math.tan(one - two) / math.tan(one + two)
    return s * s, p * p


# -- plates ----------------------------------------------------------------------------------------


def pile(
    plates: int, index: float, angle: float = 0.0, told: dict[str, Any] | None = None, **run: Any
) -> pz.Scene:
    """Return a beam through parallel plates; the plane of incidence has the source's u as its s."""
    n = np.array([0.0, math.sin(math.radians(angle)), math.cos(math.radians(angle))])
    lamp: dict[str, Any] = {
        "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, -5], "axis": "+z",
        "radius": 1e-9,
    }  # fmt: skip
    if told is not None:
        lamp["polarisation"] = told
    size = {"kind": "rectangle", "half_width": 4.0, "half_height": 4.0}
    tilt = {"axis": "+z", "tilt_deg": [-angle, 0.0]}
    faces = []  # met from behind their normals
    for k in range(plates):
        for depth, surface in ((0.0, glass(1.0, index)), (0.01, glass(index))):
            at = (0.02 * k + depth) * n
            faces.append({**size, **tilt, "position": at.tolist(), "surface": surface})
    end = {"kind": "rectangle", "name": "end", "position": [0, 0, 5], "axis": "-z", **BLACK}
    end |= {"half_width": 1.0, "half_height": 1.0, "detector": {}}
    settings = {"rays_per_batch": 1, "generation_cap": 400, **run}
    return scene_of([lamp], [*faces, end], run=settings)


def through_pile(r: float, plates: int) -> float:
    """Return the transmittance of a pile for one polarisation, after G. G. Stokes (1862)."""
    return (1.0 - r) / (1.0 + (2 * plates - 1) * r)


def plate_by_its_parts(angle: float = 60.0) -> None:
    """A plate lets through the mean of what it lets through of s and of p, and each by itself."""
    r_s, r_p = reflectances(angle, 1.52)
    s, p = through_pile(r_s, 1), through_pile(r_p, 1)
    for told, wanted in (
        (None, 0.5 * (s + p)),
        ({"angle_deg": 0.0}, s),
        ({"angle_deg": 90.0}, p),
        ({"degree": 0.25, "angle_deg": 90.0}, 0.375 * s + 0.625 * p),
        ({"angle_deg": 30.0}, 0.75 * s + 0.25 * p),
    ):
        assert abs(arriving(pile(1, 1.52, angle, told, **ON)) - wanted) < CLOSE, told


def of_two_sources(light: dict[str, Any], spectra: Sequence[Sequence[float]]) -> pz.Scene:
    """Return two beams, one polarised along s and one along p, that pass one face at 60°."""
    told = {"kind": "collimated-disk", "position": [0, 0, -5], "axis": "+z", "radius": 1e-9}
    lamps: list[dict[str, Any]] = [
        {**told, "flux": flux, "spectrum": list(spectrum), "polarisation": {"angle_deg": angle}}
        for flux, spectrum, angle in zip((1.0, 2.0), spectra, (0.0, 90.0), strict=True)
    ]
    size = {"kind": "rectangle", "half_width": 4.0, "half_height": 4.0}
    face = {"axis": "+z", "tilt_deg": [-60.0, 0.0], "position": [0, 0, 0], **size}
    end = {"name": "end", "position": [0, 0, 5], "axis": "-z", **size, **BLACK}
    faces = [{**face, "surface": glass(1.0, 1.5)}, {**end, "detector": {"wavelengths": True}}]
    return scene_of(lamps, faces, run={"rays_per_batch": 64, **ON}, spectrum=light)


def two_sources(light: dict[str, Any]) -> None:
    """Every line or band of a source has the light of that source."""
    lines = ([1.0, 0.0, 2.0], [1.0, 2.0, 1.0])
    spectra = ([1.0, 3.0], [1.0, 1.0]) if "edges_nm" in light else lines
    found = pz.trace(of_two_sources(light, spectra), batches=1)
    told = found.detectors["end"].power.by_wavelength
    passed = [1.0 - r for r in reflectances(60.0, 1.5)]
    for k, line in enumerate(told):
        parts = (spectrum[k] / sum(spectrum) for spectrum in spectra)
        wanted = sum(
            flux * part * t for flux, part, t in zip((1.0, 2.0), parts, passed, strict=True)
        )
        assert abs(line.value - wanted) < CLOSE, k
    again = pz.trace(found.scene, batches=1)
    assert again.tally_digest == found.tally_digest


# -- reflections -----------------------------------------------------------------------------------


def fold(first: float, second: float, turn: float, told: dict[str, Any] | None = None) -> float:
    """Return what two reflections from glass leave, their planes at an angle."""
    d = mirrored(Z, np.array([math.sin(math.radians(first)), 0.0, -math.cos(math.radians(first))]))
    # s of the first is y; across d stand y and y x d
    side = np.cross(d, Y)
    plane = math.cos(math.radians(turn)) * side + math.sin(math.radians(turn)) * Y
    steps = [Step(first, X, glass(1.52)), Step(second, plane, glass(1.52))]
    return arriving(bench(steps, told))


def two_folds() -> None:
    """What the first reflection makes of unpolarised light the second one sees."""
    one, two = reflectances(50.0, 1.52), reflectances(65.0, 1.52)
    for turn in (0.0, 30.0, 45.0, 90.0, 121.0):
        c = math.cos(math.radians(turn)) ** 2
        along = c * two[0] + (1.0 - c) * two[1], c * two[1] + (1.0 - c) * two[0]
        wanted = 0.5 * (one[0] * along[0] + one[1] * along[1])
        assert abs(fold(50.0, 65.0, turn) - wanted) < CLOSE, turn


def brewster() -> None:
    """At Brewster's angle p is transmitted whole, and what is reflected is s alone."""
    angle = math.degrees(math.atan(1.52))
    r_s, _ = reflectances(angle, 1.52)
    assert abs(fold(angle, angle, 0.0) - 0.5 * r_s * r_s) < CLOSE
    assert fold(angle, angle, 90.0) < 1e-30
    for degrees, wanted in ((0.0, 0.0), (90.0, r_s), (45.0, 0.5 * r_s)):
        seen = arriving(bench([Step(angle, X, glass(1.52))], {"angle_deg": degrees}))
        assert abs(seen - wanted) < CLOSE
    whole = arriving(bench([Step(angle, X, glass(1.52), through=True)], {"angle_deg": 0.0}))
    assert whole == 1.0


def malus() -> None:
    """Two reflections at Brewster's angle, the second turned: cos² of the turn."""
    angle = math.degrees(math.atan(1.52))
    r_s, _ = reflectances(angle, 1.52)
    for turn in range(0, 180, 15):
        wanted = 0.5 * r_s * r_s * math.cos(math.radians(turn)) ** 2
        assert abs(fold(angle, angle, turn) - wanted) < CLOSE


# -- phases ----------------------------------------------------------------------------------------

_ANALYSER = math.degrees(math.atan(1.52))


def analysed(steps: list[Step], told: dict[str, Any], along: NDArray[Any]) -> list[float]:
    """Return what a reflection at Brewster's angle gives, of four turns by 45°, over R_s.

    `along` is the direction of the beam behind the steps; a turn of 0 passes what is across
    along × x, or along × y where the beam is along x.
    """
    r_s, _ = reflectances(_ANALYSER, 1.52)
    first = np.cross(along, X if abs(along[0]) < 0.9 else Y)
    first /= np.linalg.norm(first)
    second = np.cross(along, first)
    seen = []
    for turn in (0.0, 45.0, 90.0, 135.0):
        a = math.radians(turn)
        plane = math.cos(a) * first + math.sin(a) * second
        seen.append(arriving(bench([*steps, Step(_ANALYSER, plane, glass(1.52))], told)) / r_s)
    return seen


def rhomb_angle(index: float, phase: float) -> float:
    """Return the larger angle at which total reflection shifts s against p by a phase."""
    low, high = math.asin(math.sqrt(2.0 / (index * index + 1.0))), math.radians(89.9)

    def shift(angle: float) -> float:
        s = math.sin(angle)
        return 2.0 * math.atan(math.cos(angle) * math.sqrt(s * s - 1.0 / index**2) / (s * s))

    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if shift(middle) > phase else (low, middle)
    return math.degrees(low)


def rhomb() -> None:
    """Fresnel's rhomb: two total reflections by 45° each make linear light circular.

    What leaves it is alike to an analyser at every turn; two rhombs make it linear again, turned.
    """
    index = 1.51
    angle = rhomb_angle(index, math.pi / 4)
    assert abs(angle - 54.6) < 0.1
    inner = glass(index)
    enter, leave = Step(0.0, X, inner, through=True), Step(0.0, X, inner, True, behind=True)

    def total(plane: NDArray[Any]) -> Step:
        return Step(angle, plane, inner, behind=True)

    t = 1.0 - ((index - 1.0) / (index + 1.0)) ** 2
    # the second reflection turns the beam back into its first direction
    steps = [enter, total(X), total(-X), leave]
    told = {"angle_deg": 45.0}
    assert np.allclose(analysed(steps, told, Z), 0.5 * t * t, rtol=0.0, atol=CLOSE)
    twice = analysed([*steps, *steps], told, Z)
    # along z x x = y and its right-handed turns: -x at 90 deg; from 45 deg it is turned to -45 deg
    assert np.allclose(sorted(twice), np.array([0.0, 0.5, 0.5, 1.0]) * t**4, rtol=0.0, atol=CLOSE)
    before = analysed([], told, Z)
    assert np.allclose(sorted(before), [0.0, 0.5, 0.5, 1.0], rtol=0.0, atol=CLOSE)
    assert abs(before.index(min(before)) - twice.index(min(twice))) == 2
    # p in the plane of incidence stays what it was
    flat = analysed(steps, {"angle_deg": 0.0}, Z)
    assert np.allclose(sorted(flat), np.array([0.0, 0.5, 0.5, 1.0]) * t**2, rtol=0.0, atol=CLOSE)


def metal() -> None:
    """A metal turns a field about its plane of incidence, and a square one about nothing."""
    ideal = {"kind": "mirror", "reflectance": 0.75}
    for angle in (0.0, 1e-9, 1e-7, 1e-3, 30.0, 89.0):
        n = np.array([math.sin(math.radians(angle)), 0.0, -math.cos(math.radians(angle))])
        d = mirrored(Z, n)
        e = math.cos(0.5) * X + math.sin(0.5) * Y
        seen = analysed([Step(angle, X, ideal)], {"angle_deg": math.degrees(0.5)}, d)
        after = 2.0 * (e @ n) * n - e  # -r_s s s^T + r_p p' p^T of -1 and 1
        first = np.cross(d, X if abs(d[0]) < 0.9 else Y)
        first /= np.linalg.norm(first)
        for turn, part in zip((0.0, 45.0, 90.0, 135.0), seen, strict=True):
            a = math.radians(turn)
            s = np.cross(d, math.cos(a) * first + math.sin(a) * np.cross(d, first))
            assert abs(part - 0.75 * float(after @ s) ** 2) < CLOSE, (angle, turn)


def near_the_critical_angle() -> None:
    """The phase of total reflection, from where it begins to grazing incidence."""
    index = 1.5
    critical = math.degrees(math.asin(1.0 / index))
    t = 1.0 - ((index - 1.0) / (index + 1.0)) ** 2
    inner = glass(index)
    for angle in (critical + 1e-9, critical + 1e-5, critical + 0.1, 51.0, 75.0, 89.9):
        n = np.array([math.sin(math.radians(angle)), 0.0, -math.cos(math.radians(angle))])
        steps = [
            Step(0.0, X, inner, through=True),
            Step(angle, X, inner, behind=True),
            Step(0.0, Y, inner, through=True, behind=True),
        ]
        seen = analysed(steps, {"angle_deg": 45.0}, mirrored(Z, n))
        square = math.sin(math.radians(angle)) ** 2
        half = math.atan(
            math.cos(math.radians(angle)) * math.sqrt(square - 1.0 / index**2) / square
        )
        wanted = np.array([math.sin(half) ** 2, 0.5, 0.5, math.cos(half) ** 2]) * t * t
        assert np.allclose(sorted(seen), wanted, rtol=0.0, atol=CLOSE), angle


def chooses_one_child() -> None:
    """Of two children one goes on, as it is polarised: crossed glasses pass nothing."""
    angle = math.degrees(math.atan(1.52))
    r_s, _ = reflectances(angle, 1.52)
    steps = [Step(angle, X, glass(1.52))]
    d = mirrored(Z, np.array([math.sin(math.radians(angle)), 0.0, -math.cos(math.radians(angle))]))
    plane = 0.5 * np.cross(d, Y) + math.sqrt(0.75) * Y
    rays = 1 << 14
    run = {"splitting": False, "rays_per_batch": rays}
    crossed = trace(bench([*steps, Step(angle, Y, glass(1.52))], None, **run))
    assert crossed.detector("end").count == 0
    aslant = trace(bench([*steps, Step(angle, plane, glass(1.52))], None, **run))
    chance = 0.5 * r_s * r_s * 0.25
    # within 5 sigma of a binomial law: a false alarm in 10^6
    spread = math.sqrt(rays * chance * (1.0 - chance))
    assert abs(aslant.detector("end").count - rays * chance) < 5.0 * spread


# -- many reflections ------------------------------------------------------------------------------


def a_long_way(length: float = 4.0) -> int:
    """A skew ray in a polished tube, and an analyser outside; returns how often it is reflected.

    Its light is followed along the points that the engine met, so that what rounding does to them
    is not asked. Nothing is lost, and linear light stays linear.
    """
    lamp = {
        "kind": "collimated-disk", "flux": 1.0, "position": [0.3, 0, 0], "radius": 1e-30,
        **turned(np.array([0.2, 0.9, 1e-3]) / math.hypot(0.2, 0.9, 1e-3)),
        "polarisation": {"angle_deg": 25.0},
    }  # fmt: skip
    tube = {
        "kind": "cylinder", "position": [0, 0, -0.01], "axis": "+z", "radius": 1.0,
        "length": length, "surface": {"kind": "mirror", "reflectance": 1.0},
    }  # fmt: skip
    run = {"rays_per_batch": 1, "generation_cap": 1 << 16, **ON}
    alone = pz.paths(scene_of([lamp], [tube], run=run), rays=1, max_segments=1 << 16)
    bounces = len(alone) - 1
    ways = alone.end - alone.start
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    light = launched(alone.scene.source[0], ways[0])
    for at, along in zip(alone.end[:-1], ways[1:], strict=True):
        n = np.array([*at[:2], 0.0])
        light = sent(light, n / np.linalg.norm(n), along, -1.0, 1.0)
    assert abs(light.degree - 1.0) < CLOSE
    assert alone.weight[-1] == 1.0
    place, first = alone.start[-1] + 5.0 * light.along, np.cross(light.along, Z)
    first /= np.linalg.norm(first)
    second = np.cross(light.along, first)
    for turn in (0.0, 45.0, 90.0, 135.0):
        a, b = math.radians(turn), math.radians(_ANALYSER)
        n = math.sin(b) * (math.cos(a) * first + math.sin(a) * second) - math.cos(b) * light.along
        size = {"kind": "rectangle", "half_width": 0.1, "half_height": 0.1}
        plate = {**size, "position": place.tolist(), **turned(n), "surface": glass(1.52)}
        seen = reflected(light, n, 1.0 / 1.52)
        end = {**size, "position": (place + seen.along).tolist(), **turned(-seen.along), **BLACK}
        end |= {"name": "end", "detector": {}}
        assert abs(arriving(scene_of([lamp], [tube, plate, end], run=run)) - seen.power) < CLOSE
    return bounces


def scattered_light_is_unpolarised(rays: int = 1 << 13) -> None:
    """Of light that glass at Brewster's angle would not reflect at all, what was scattered."""
    angle = math.degrees(math.atan(1.52))
    r_s, _ = reflectances(angle, 1.52)
    lobe = {"kind": "gaussian", "sigma": 1e-3, "tis": 0.75}
    steps = [
        Step(45.0, X, {"kind": "mirror", "reflectance": 1.0, "scatter": lobe}),
        Step(angle, Y, glass(1.52)),
    ]
    told = {"angle_deg": 90.0}
    whole = trace(bench(steps, told, half=0.05, rays_per_batch=64)).detector("end")
    assert abs(float(whole.power) / 64 / (0.75 * 0.5 * r_s) - 1.0) < 2e-3
    chosen = trace(bench(steps, told, half=0.05, rays_per_batch=rays, splitting=False))
    chance = 0.75 * 0.5 * r_s
    # within 5 sigma of a binomial law: a false alarm in 10^6
    spread = math.sqrt(rays * chance * (1.0 - chance))
    assert abs(chosen.detector("end").count - rays * chance) < 5.0 * spread
