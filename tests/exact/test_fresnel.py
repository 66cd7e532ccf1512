"""Fresnel's formulas against 50 digits: R, T, the refracted direction, at the awkward ends."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mpmath
import numpy as np
import pytest
from oracles.engine import compiled, scene_of, trace
from oracles.kernels import run_text
from oracles.scenes import BLACK, beam, glass, wall

if TYPE_CHECKING:
    from hostcode.run.tables import DeviceTables

KERNEL = """
__kernel void test(__global const double *d, __global const double *n, __global const double *m,
                   __global double *out, uint count) {
    const size_t i = get_global_id(0);
    packet_t p;
    contact_t c;
    p.w = splat(1.0);
    p.dx = LOAD(d, i); p.dy = LOAD(d + count, i); p.dz = LOAD(d + 2 * count, i);
    c.nx = LOAD(n, i); c.ny = LOAD(n + count, i); c.nz = LOAD(n + 2 * count, i);
    c.came_plus = LE(dot3(p.dx, p.dy, p.dz, c.nx, c.ny, c.nz), splat(0.0));
    const encounter_t event = {ALL_LANES, &p, &c, 0UL};
    // a row of each lane's own, behind one another
    uint all;
    const lint row = (rank_lanes(ALL_LANES, &all) + (long)(i * LANES)) * 4L;
    const material_t material = {m, row, -1L};
    outcome_t o = no_outcome(&p, &c);
    meet_fresnel(&event, &material, &o);
    STORE(o.dx, out, i); STORE(o.dy, out + count, i); STORE(o.dz, out + 2 * count, i);
    STORE(o.w, out + 3 * count, i);
    STORE(o.second_dx, out + 4 * count, i); STORE(o.second_dy, out + 5 * count, i);
    STORE(o.second_dz, out + 6 * count, i);
    STORE(o.second_w, out + 7 * count, i);
    STORE(SEL(o.splits, splat(1.0), splat(0.0)), out + 8 * count, i);
    STORE(SEL(o.went_plus, splat(1.0), splat(0.0)), out + 9 * count, i);
}
"""


def tables_of(index: float, outside: float) -> DeviceTables:
    """Return the compiled tables of a plate."""
    lamp = beam((0, 0, 1), "-z")
    return compiled(scene_of([lamp], [{**wall((0, 0, 0), "+z"), **glass(index, outside)}])).tables


def constants(index: float, outside: float) -> np.ndarray:
    """Return the material row that the host computes for a pair of indices."""
    return tables_of(index, outside).materials[:4]


class Met:
    """What the surface made of rays: shape (count, 3) directions and (count,) weights."""

    def __init__(self, d: np.ndarray, n: np.ndarray, m: np.ndarray, lanes: int = 1) -> None:
        count = len(d)
        arguments = [d.T.copy(), n.T.copy(), m.copy(), np.zeros((10, count)), np.uint32(count)]
        spec = tables_of(1.5, 1.0).spec
        out = run_text(KERNEL, arguments, count, lanes=lanes, spec=spec)[3]
        self.raw = out
        self.direction, self.weight = out[0:3].T, out[3]
        self.mirrored, self.reflected = out[4:7].T, out[7]
        self.splits, self.went_plus = out[8] == 1.0, out[9] == 1.0


class Truth:
    """The same with 50 digits, for a direction and a normal taken as they are."""

    def __init__(self, d: list[float], n: list[float], index: float, outside: float) -> None:
        d, n = ([mpmath.mpf(float(x)) for x in v] for v in (d, n))
        length = mpmath.sqrt(sum(x * x for x in n))
        n = [x / length for x in n]
        length = mpmath.sqrt(sum(x * x for x in d))
        d = [x / length for x in d]
        dn = sum(a * b for a, b in zip(d, n, strict=True))
        n1, n2 = (outside, index) if dn <= 0 else (index, outside)
        ratio = mpmath.mpf(n1) / mpmath.mpf(n2)
        ci = abs(dn)
        square = 1 - ratio**2 * (1 - ci**2)
        self.total = square <= 0
        self.ct = mpmath.sqrt(square) if square > 0 else mpmath.mpf(0)
        self.ci, self.ratio = ci, ratio
        rs = (ratio * ci - self.ct) / (ratio * ci + self.ct)
        rp = (ratio * self.ct - ci) / (ratio * self.ct + ci)
        self.reflectance = mpmath.mpf(1) if self.total else (rs**2 + rp**2) / 2
        self.mirrored = [x - 2 * dn * y for x, y in zip(d, n, strict=True)]
        g = self.ct if dn > 0 else -self.ct
        self.bent = [ratio * (x - dn * y) + g * y for x, y in zip(d, n, strict=True)]


def directions() -> np.ndarray:
    """Return directions across z = 0 from straight to grazing; a multiple of 16."""
    tilts = [0.0, 1e-12, 1e-8, 1e-4, 0.1, 0.3, 0.5, 0.588, 0.7, 0.78, 0.9, 0.983, 1.2, 1.4, 1.5]
    tilts += [math.pi / 2 - x for x in (1e-2, 1e-4, 1e-8, 1e-12, 1e-15)]
    rows = []
    for tilt in tilts:
        for phi in (0.0, 0.7, 2.0, 4.4):
            cosine = math.cos(tilt) if tilt < 1.5 else math.sin(math.pi / 2 - tilt)
            sine = math.sin(tilt)
            rows.append((sine * math.cos(phi), sine * math.sin(phi), -cosine))
            rows.append((sine * math.cos(phi), sine * math.sin(phi), cosine))
    assert len(rows) % 16 == 0
    return np.array(rows)


INDICES = [(1.5, 1.0), (1.0, 1.5), (2.4, 1.33), (1.0 + 1e-12, 1.0), (1.0, 1.0 + 1e-9), (4.0, 1.0)]
INDICES += [(1.5, 1.5), (1.5 + 2.0**-52, 1.5)]


@pytest.mark.parametrize(("index", "outside"), INDICES)
def test_weights_and_directions_against_fifty_digits(index: float, outside: float) -> None:
    d = directions()
    n = np.tile([0.0, 0.0, 1.0], (len(d), 1))
    met = Met(d, n, np.tile(constants(index, outside), (len(d), 1)))
    u = 2.0**-53
    with mpmath.workdps(50):
        for k in range(len(d)):
            truth = Truth(d[k], n[k], index, outside)
            # d is a unit vector to rounding only; near the critical angle and at grazing incidence
            # that moves cos θt by u/cos θt, which no computation from d can undo
            slack = 8 * u * (1 + 1 / max(float(truth.ct), 1e-9))
            if truth.total:
                assert not met.splits[k]
                assert met.weight[k] == 1.0
                want = truth.mirrored
                slack = 8 * u
            elif index == outside:
                assert not met.splits[k]
                assert met.reflected[k] == 0.0
                assert met.weight[k] == 1.0
                want = d[k]
                slack = 4 * u
            else:
                r = float(truth.reflectance)
                assert met.splits[k]
                assert met.weight[k] + met.reflected[k] == 1.0
                # dR/R: both amplitudes have zeros or ones only where ci or ct has one
                sensitive = 1 / max(float(truth.ct), 1e-12) ** 2 + 1 / max(float(truth.ci), 1e-12)
                assert abs(met.reflected[k] - r) <= 16 * u * max(r, min(sensitive * r, 1.0))
                want = truth.bent
                mirrored = [
                    abs(a - b) for a, b in zip(met.mirrored[k], truth.mirrored, strict=True)
                ]
                assert max(mirrored) < 8 * u
            error = max(abs(a - b) for a, b in zip(met.direction[k], want, strict=True))
            assert error < slack


@pytest.mark.parametrize(
    ("index", "outside"),
    [
        (4.0, 1.0),
        (1000.0, 1.0),
        (1000.0, 0.001),
    ],
)
def test_extreme_ratios_of_indices(index: float, outside: float) -> None:
    """From the denser side below the critical angle; d's rounding alone moves sin θt by m·u."""
    ratio, u = index / outside, 2.0**-53
    angles = math.asin(1.0 / ratio) * np.linspace(0.05, 0.95, 160)
    d = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)
    n = np.tile([0.0, 0.0, 1.0], (160, 1))
    met = Met(d, n, np.tile(constants(index, outside), (160, 1)))
    with mpmath.workdps(50):
        for k in range(160):
            truth = Truth(d[k], n[k], index, outside)
            slack = 16 * ratio * u / float(truth.ct)
            error = max(abs(a - b) for a, b in zip(met.direction[k], truth.bent, strict=True))
            assert error < slack


@pytest.mark.parametrize(("index", "outside"), [(1.5, 1.0), (1.0 + 1e-12, 1.0), (1.0, 2.0)])
def test_reflectance_is_accurate_to_its_own_last_digits(index: float, outside: float) -> None:
    """Away from the critical angle and from grazing incidence: relative to R, however small."""
    d = directions()
    d = d[np.abs(d[:, 2]) > 0.6]
    d = d[: len(d) // 16 * 16]
    n = np.tile([0.0, 0.0, 1.0], (len(d), 1))
    met = Met(d, n, np.tile(constants(index, outside), (len(d), 1)))
    with mpmath.workdps(50):
        for k in range(len(d)):
            truth = Truth(d[k], n[k], index, outside)
            if not truth.total and truth.ct > 0.3:
                error = abs(met.reflected[k] - truth.reflectance) / truth.reflectance
                assert error < 64 * 2.0**-53


def test_transmittance_at_grazing_incidence_is_what_reflection_leaves() -> None:
    """T is small and linear in cos θ there; its absolute error is that of 1 − R."""
    cosines = np.array([10.0**-k for k in range(1, 17)])
    d = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, -cosines], axis=1)
    met = Met(d, np.tile([0.0, 0.0, 1.0], (16, 1)), np.tile(constants(1.5, 1.0), (16, 1)))
    with mpmath.workdps(50):
        for k in range(16):
            truth = Truth(d[k], [0.0, 0.0, 1.0], 1.5, 1.0)
            transmitted = 1 - truth.reflectance
            got = met.weight[k] if met.splits[k] else 1.0 - met.weight[k]
            assert abs(got - transmitted) < 1e-15
            assert met.weight[k] + met.reflected[k] * met.splits[k] == 1.0


@pytest.mark.parametrize("offset", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, -1e-15, -1e-12, -1e-9, -1e-6])
def test_around_the_critical_angle(offset: float) -> None:
    """Inside 1.5, within an offset of the critical angle: all of it beyond, R near 1 before."""
    sine = (1.0 / 1.5) * (1.0 + offset)
    rows = [(sine * math.cos(p), sine * math.sin(p), math.sqrt(1 - sine * sine)) for p in range(16)]
    d = np.array(rows)
    met = Met(d, np.tile([0.0, 0.0, 1.0], (16, 1)), np.tile(constants(1.5, 1.0), (16, 1)))
    assert np.isfinite(met.raw).all()
    lengths = np.linalg.norm(met.direction, axis=1)
    assert np.abs(lengths - 1.0).max() < 4e-16
    if offset >= 1e-12:
        assert not met.splits.any()
        assert (met.weight == 1.0).all()
        assert not met.went_plus.any()
    elif offset <= -1e-12:
        assert met.splits.all()
        assert met.went_plus.all()
        # 1 − R grows as the root of the distance: about 4.1 sqrt(2 |offset|) / ...
        assert (1.0 - met.reflected < 20.0 * math.sqrt(-offset)).all()
        assert (met.direction[:, 2] > 0.0).all()
    total = np.where(met.splits, met.weight + met.reflected, met.weight)
    assert (total == 1.0).all()


@pytest.mark.parametrize("lanes", [2, 4, 16])
def test_every_lane_width_gives_the_same_bits(lanes: int) -> None:
    d = directions()
    n = np.tile([0.6, 0.0, 0.8], (len(d), 1))
    m = np.tile(constants(1.5, 1.0), (len(d), 1))
    assert Met(d, n, m, lanes).raw.tobytes() == Met(d, n, m).raw.tobytes()


def test_energy_and_reciprocity_over_random_incidence() -> None:
    """R + T = 1 exactly, and the light that goes back along the bent ray has the same R."""
    r = np.random.default_rng(5)
    d, n = (r.normal(size=(1024, 3)) for _ in range(2))
    d /= np.linalg.norm(d, axis=1)[:, np.newaxis]
    n /= np.linalg.norm(n, axis=1)[:, np.newaxis]
    m = np.tile(constants(1.7, 1.2), (1024, 1))
    met = Met(d, n, m)
    assert (np.where(met.splits, met.weight + met.reflected, met.weight) == 1.0).all()
    back = Met(-met.direction, n, m)
    easy = met.splits & (np.abs((met.direction * n).sum(axis=1)) > 0.05)
    easy &= np.abs((d * n).sum(axis=1)) > 0.05
    assert easy.sum() > 500
    assert np.abs(back.reflected - met.reflected)[easy].max() < 1e-13
    assert np.abs(back.direction + d)[easy].max() < 1e-14


def test_equal_indices_are_not_there() -> None:
    """n = n': no reflected child, no bend, one interaction; the light goes straight on."""
    elements = [
        {**wall((0, 0, 0), "+z"), "tilt_deg": [30.0, 20.0], **glass(1.4, 1.4)},
        {**wall((0.25, 0.125, -1), "+z", 0.3), **BLACK, "detector": {"map": [16, 16]}},
    ]
    lamp = beam((0.25, 0.125, 1.0), "-z", 0.2)
    with_plate = trace(scene_of([lamp], elements), rays_per_batch=512)
    without = trace(scene_of([lamp], elements[1:]), rays_per_batch=512)
    assert with_plate.interactions == 1024
    one, two = with_plate.detector("element 1"), without.detector("element 0")
    assert one.power == two.power == 512
    assert (one.map_counts == two.map_counts).all()
