"""What the kernels make of a field by any two amplitudes, beside coherency matrices."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from oracles.engine import compiled
from oracles.kernels import run_text
from oracles.polarised import Light, chain, sent

BODY = """
__kernel void test(__global const double *in, __global double *out, uint count) {
    const size_t i = get_global_id(0);
#define IN(k) LOAD(in + (k) * count, i)
    packet_t p;
    clear_packet(&p);
    p.dx = IN(0); p.dy = IN(1); p.dz = IN(2);
    p.stokes_q = IN(12); p.stokes_u = IN(13); p.stokes_v = IN(14);
    contact_t c = no_contact(&p, splat(0.0));
    c.nx = IN(3); c.ny = IN(4); c.nz = IN(5);
    const encounter_t event = {ALL_LANES, &p, &c, 0UL};
    const incident_t light = incident_light(&event);
    const amplitudes_t a = complex_amplitudes(IN(8), IN(9), IN(10), IN(11));
    outcome_t o = no_outcome(&p, &c);
    send_on(&o, ALL_LANES, IN(15), IN(6), IN(7), splat(1.0), wsplat(REFLECTED));
    polarise(&o, ALL_LANES, &light, &a);
    STORE(o.stokes_q, out, i); STORE(o.stokes_u, out + count, i);
    STORE(o.stokes_v, out + 2 * count, i);
    STORE(part_of(&light, &a), out + 3 * count, i);
    const amplitudes_t same = alike(), metal = conductor();
    STORE(part_of(&light, &same), out + 4 * count, i);
    STORE(part_of(&light, &metal), out + 5 * count, i);
    STORE(part_sent(&light, IN(8), IN(10)), out + 6 * count, i);
}
"""


def basis(d):
    """Return e1 and e2 across a unit vector (Duff and others, JCGT 6(1), 2017)."""
    sign = 1.0 if d[2] >= 0.0 else -1.0
    k = -1.0 / (sign + d[2])
    m = d[0] * d[1] * k
    e1 = np.array([1.0 + sign * d[0] * d[0] * k, sign * m, -sign * d[0]])
    return e1, np.array([m, sign + d[1] * d[1] * k, -d[1]])


def field_of(d, stokes):
    """Return the coherency matrix of unit power."""
    q, u, v = stokes
    e1, e2 = basis(d)
    # U + iV = 2 <E1 E2*>
    inner = np.array([[1.0 + q, u + 1j * v], [u - 1j * v, 1.0 - q]]) / 2.0
    e = np.array([e1, e2])
    return e.T @ inner @ e


def stokes_of(light):
    e1, e2 = basis(light.along)
    inner = np.array([e1, e2]) @ light.field @ np.array([e1, e2]).T
    whole = (inner[0, 0] + inner[1, 1]).real
    parts = (inner[0, 0] - inner[1, 1]).real, 2 * inner[0, 1].real, 2 * inner[0, 1].imag
    return np.array(parts) / whole, whole


def unit(v):
    return v / np.linalg.norm(v)


def rays(count, seed, sine=None):
    """Return rays and faces: directions, normals, where the ray goes, amplitudes, Stokes."""
    g = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        d = unit(g.normal(size=3))
        side = unit(np.cross(d, g.normal(size=3)))
        size = g.uniform(0.01, 0.999) if sine is None else sine
        n = unit(size * side - np.sqrt(1.0 - size * size) * d) * g.choice([-1.0, 1.0])
        to = unit(d - 2.0 * (d @ n) * n)
        a = g.normal(size=4)
        if sine is None and g.integers(2):  # any direction in the plane of incidence
            to = unit(d + g.uniform(-0.5, 0.5) * n)
        elif sine is not None:
            a[2:] = -a[:2]  # alike, as all are that light meets squarely
        stokes = unit(g.normal(size=3)) * g.choice([1.0, g.uniform()])
        found.append((d, n, to, a, stokes))
    return found


def met(found, lanes):
    count = len(found)
    table = np.empty((16, count))
    for i, (d, n, to, a, stokes) in enumerate(found):
        table[:, i] = [*d, *n, *to[1:], *a, *stokes, to[0]]
    spec = compiled(chain(1, 3, None)).tables.spec
    given = [table, np.zeros((7, count)), np.uint32(count)]
    return run_text(BODY, given, count, lanes=lanes, spec=spec)[1]


@pytest.mark.parametrize("sine", [None, 1e-3, 1e-7, 1e-11, 1e-15, 1e-16, 0.0])
def test_any_amplitudes(sine):
    found = rays(256, 1, sine)
    out = met(found, 8)
    for i, (d, n, to, (s_re, s_im, p_re, p_im), stokes) in enumerate(found):
        light = sent(Light(d, field_of(d, stokes)), n, to, s_re + 1j * s_im, p_re + 1j * p_im)
        wanted, power = stokes_of(light)
        # what is taken out is right to the rounding of what came
        close = 4e-15 * max(s_re**2 + s_im**2, p_re**2 + p_im**2) / power
        assert np.abs(out[:3, i] - wanted).max() < close
        assert abs(out[3, i] / power - 1.0) < close
    assert np.abs(out[4:6] - 1.0).max() < 4e-16
    assert np.sqrt((out[:3] ** 2).sum(axis=0)).max() < 1.0 + 1e-15


def test_lanes_give_the_same_bits():
    found = rays(64, 2) + rays(64, 3, 1e-12)
    assert met(found, 1).tobytes() == met(found, 8).tobytes()


def test_unpolarised_light_has_the_mean_to_the_bit():
    found = [(d, n, to, a, np.zeros(3)) for d, n, to, a, _ in rays(512, 4)]
    out = met(found, 8)
    # fma of exact products: the mean of two squares, rounded as without polarisation
    for i, (_, _, _, a, _) in enumerate(found):
        s, p = float(a[0]), float(a[2])
        exact = Fraction(s) * Fraction(s) + Fraction(p * p)
        assert out[6, i] == float(exact) / 2.0


def test_light_is_never_more_than_polarised():
    """What a strong polariser leaves of light that it takes nearly all of."""
    g = np.random.default_rng(6)
    found = []
    for d, n, to, _, _ in rays(512, 5):
        a = np.array([10.0 ** g.uniform(-12, 0), 0.0, 10.0 ** g.uniform(-12, 0), 0.0])
        found.append((d, n, to, a, unit(g.normal(size=3))))
    out = met(found, 8)
    assert np.isfinite(out).all()
    assert np.sqrt((out[:3] ** 2).sum(axis=0)).max() < 1.0 + 1e-15
    assert (out[3] >= 0.0).all()
