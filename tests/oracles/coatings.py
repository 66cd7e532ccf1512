"""What coatings do to rays: the kernels themselves, and what they must give."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np

import photizon_cl as pz
from oracles.engine import TREE, scene_of, trace
from oracles.kernels import run_text
from oracles.scenes import beam, wall
from photizon_cl.compile.compiled import compile_scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene

    Array = NDArray[np.float64]

KERNEL = """
__kernel void test(__global const double *geometry, __global const double *materials,
                   __global const long *codes, __global const double *d,
                   __global const long *rows, __global const long *coatings,
                   ulong head, __global double *out, uint count) {
    const size_t i = get_global_id(0);
    const scene_t scene = {geometry, materials, materials, codes};
    packet_t p;
    contact_t c;
    p.w = weight_splat(1.0);
    p.dx = TO_REAL(LOAD(d, i)); p.dy = TO_REAL(LOAD(d + count, i));
    p.dz = TO_REAL(LOAD(d + 2 * count, i));
    c.nx = splat(0.0); c.ny = splat(0.0); c.nz = splat(1.0);
    c.came_plus = LE(p.dz, splat(0.0));
    const encounter_t event = {ALL_LANES, &p, &c, 0UL};
    const lint coating = LOAD(coatings, i);
    const lint place = SELI(IGE(coating, lsplat(0L)), coating >> 1, lsplat((long)head));
    const material_t material = {materials, LOAD(rows, i), -1L, &scene, coating, place};
    outcome_t o = no_outcome(&p, &c);
    meet_SURFACE(&event, &material, &o);
    const weight none = weight_splat(0.0);
    const weight second = SECOND;
    const mask crossed = c.came_plus ^ o.went_plus;
    STORE(TO_WIDE(SEL_WEIGHT(crossed, second, o.w)), out, i);
    STORE(TO_WIDE(SEL_WEIGHT(crossed, o.w, none)), out + count, i);
}
"""
"""Of each ray what is reflected and what passes."""


def plates(
    surfaces: Sequence[dict[str, Any]], precision: str = "fp64", **parts: Any
) -> CompiledScene:
    """Return a compiled scene with a plate for each surface."""
    walls = [
        {**wall((10.0 * n, 0, 0), "+z"), "surface": surface} for n, surface in enumerate(surfaces)
    ]
    scene = scene_of([beam((0, 0, 1), "-z")], walls, **parts)
    return compile_scene(scene, scene.run, without=TREE, precision=precision)


def glass(coating: dict[str, Any] | None, index: float = 1.5, outside: float = 1.0) -> Any:
    """Return a border of two media with a coating."""
    surface = {"kind": "fresnel", "index": index, "index_outside": outside}
    return surface if coating is None else {**surface, "coating": coating}


def met(
    made: CompiledScene, element: Any, line: Any, angle_deg: Any, inside: Any, lanes: int = 1
) -> tuple[Array, Array]:
    """Return what of rays is reflected and what passes, by the kernel of the surface.

    Parameters
    ----------
    made : CompiledScene
        Of `plates`.
    element, line, angle_deg, inside : array_like
        Which plate each ray meets, of which line it is, its angle of incidence, and whether it
        comes from behind the normal.
    lanes : int
        Width of the kernel.
    """
    element, line, angle, inside = np.broadcast_arrays(element, line, angle_deg, inside)
    count, shape = -(-element.size // 16) * 16, element.shape
    element, line, angle, inside = (
        np.resize(a.ravel(), count) for a in (element, line, angle, inside)
    )
    tables, spec = made.tables, made.tables.spec
    turn = np.radians(angle)
    cosine = np.where(angle == 90.0, 1e-300, np.cos(turn))  # on a side
    phi = 0.7 * np.arange(count)
    along = np.array(
        [np.sin(turn) * np.cos(phi), np.sin(turn) * np.sin(phi), np.where(inside, cosine, -cosine)]
    )
    places = tables.codes[int(tables.launch["material_of"]) :]
    rows = places[element] + line * spec.strides.material
    coatings = tables.codes[int(tables.launch["coatings"]) :][element]
    (kind,) = {surface.kind for surface in spec.surfaces}
    arguments = [
        tables.geometry, tables.materials, tables.codes, along.copy(), rows.astype(np.int64),
        coatings.astype(np.int64), np.uint64(tables.launch["coating_head"]), np.zeros((2, count)),
        np.uint32(count),
    ]  # fmt: skip
    real = spec.real
    second = "SEL_WEIGHT(o.splits, o.second_w, none)" if spec.pairs else "none"
    text = KERNEL.replace("SURFACE", kind).replace("SECOND", second)
    out = run_text(text, arguments, count, lanes=lanes, spec=spec, real=real)[-1]
    return tuple(row[: math.prod(shape)].reshape(shape) for row in out)


def in_digits(
    surface: pz.Fresnel, nm: float, sine: float, cosine: float, *, inside: bool, digits: int = 50
) -> tuple[float, float]:
    """Return reflectance and transmittance by the matrices of layers, in many digits.

    Of sine and cosine of the angle of incidence that is taken which is the smaller.
    """
    coating = surface.coating
    assert isinstance(coating, pz.StackCoating)
    layers = [(y.index, y.extinction, y.thickness_nm) for y in coating.layers]
    before, behind = surface.index_outside, surface.index
    if inside:
        layers, before, behind = layers[::-1], behind, before
    with mpmath.workdps(digits):
        square = mpmath.mpf(sine) ** 2 if sine < cosine else 1 - mpmath.mpf(cosine) ** 2
        along = mpmath.mpf(before) ** 2 * square
        near = mpmath.sqrt(mpmath.mpf(before) ** 2 - along)
        far = mpmath.sqrt(mpmath.mpc(mpmath.mpf(behind) ** 2 - along))
        r = t = mpmath.mpf(0)
        for power in (0, 2):  # s and p
            e, h = mpmath.mpc(1), far / mpmath.mpf(behind) ** power
            for n, kappa, d in reversed(layers):
                index = mpmath.mpc(n, kappa)
                q = mpmath.sqrt(index**2 - along)
                beta = 2 * mpmath.pi * mpmath.mpf(d) / mpmath.mpf(nm) * q
                eta = q / index**power
                over = 2 * mpmath.pi * d / nm * index**power if q == 0 else mpmath.sin(beta) / eta
                e, h = (
                    mpmath.cos(beta) * e - 1j * over * h,
                    mpmath.cos(beta) * h - 1j * eta * mpmath.sin(beta) * e,
                )
            eta = near / mpmath.mpf(before) ** power
            r += abs((eta * e - h) / (eta * e + h)) ** 2 / 2
            share = (far / mpmath.mpf(behind) ** power).real
            t += 4 * eta * share / abs(eta * e + h) ** 2 / 2
        return float(r), float(t)


# -- stacks ----------------------------------------------------------------------------------------


def stack(*layers: tuple[float, ...]) -> dict[str, Any]:
    """Return a stack of (index, thickness in nm) or (index, thickness, extinction)."""
    keys = ("index", "thickness_nm", "extinction")
    return {"kind": "stack", "layers": [dict(zip(keys, y, strict=False)) for y in layers]}


MGF2 = stack((1.38, 99.6))
MIRROR_OF_12 = stack(*[(2.35, 58.5), (1.46, 94.2)] * 6)
BAND = stack(*[(2.35, 58.5), (1.46, 94.2)] * 3, (2.35, 117.0), *[(1.46, 94.2), (2.35, 58.5)] * 3)


def stacks_in_digits() -> None:
    """Parts that are reflected and that pass, of layers that absorb, from both sides."""
    cases = [glass(stack((1.46, 80.0), (0.05, 15.0, 3.9), (2.3, 60.0, 0.02))), glass(MIRROR_OF_12)]
    lines = [450.0, 633.0]
    made = plates(cases, spectrum={"wavelengths_nm": lines})
    which = list(product(range(2), range(2), (0.0, 30.0, 41.0, 55.0, 80.0, 89.9), (False, True)))
    element, line, angle, inside = map(np.array, zip(*which, strict=True))
    found = met(made, element, line, angle, inside)
    for (n, k, a, within), r, t in zip(which, *found, strict=True):
        turn, surface = math.radians(a), made.scene.element[n].surface
        wanted = in_digits(surface, lines[k], math.sin(turn), math.cos(turn), inside=within)
        assert abs(r - wanted[0]) < 3e-14, (n, k, a, within)
        assert abs(t - wanted[1]) < 3e-14, (n, k, a, within)


def nothing_is_made_or_lost() -> None:
    """Parts of stacks without extinction add up to 1, to the rounding of the split."""
    cases = [glass(MIRROR_OF_12), glass(BAND, 1.7, 1.3)]
    made = plates(cases, spectrum={"wavelengths_nm": [450.0, 550.0, 650.0]})
    angles = np.linspace(0.0, 89.0, 40)
    which, lines = np.arange(2)[:, None, None], np.arange(3)[:, None]
    for inside in (False, True):
        r, t = met(made, which, lines, angles, inside)
        assert np.abs(r + t - 1.0).max() <= 2.0**-53


# -- tables ----------------------------------------------------------------------------------------


def table_from_both_sides() -> None:
    """A table over the angle outside, looked up by rays from outside and by those that leave."""
    nodes, r, t = [0.0, 30.0, 60.0, 90.0], [0.1, 0.3, 0.2, 1.0], [0.8, 0.6, 0.7, 0.0]
    table = {"kind": "table", "angle_deg": nodes, "reflectance": r, "transmittance": t}
    made = plates([glass(table, 1.5, 1.2)])
    outside = np.array([0.0, 1e-6, 12.0, 30.0, 45.0, 59.999, 60.0, 75.0, 89.9])
    within = np.degrees(np.arcsin(1.2 / 1.5 * np.sin(np.radians(outside))))
    for angle, inside in ((outside, False), (within, True)):
        found = met(made, 0, 0, angle, inside)
        for got, values in zip(found, (r, t), strict=True):
            # an angle inside is rounded, and counts the more outside the nearer that is to 90
            room = np.where(outside > 80.0, 1e-12, 1e-14)
            assert (np.abs(got - np.interp(outside, nodes, values)) < room).all()


def beyond_the_critical_angle() -> None:
    """All that would be reflected or pass is reflected."""
    made = plates([glass({"kind": "fixed", "reflectance": 0.25, "transmittance": 0.5})])
    r, t = met(made, 0, 0, np.array([41.0, 42.0, 60.0]), inside=True)
    assert (r.tolist(), t.tolist()) == ([0.25, 0.75, 0.75], [0.5, 0.0, 0.0])


# -- traces ----------------------------------------------------------------------------------------


def absorbed_to_the_last_bit() -> None:
    """A window takes what its coatings leave, and a lossless one nothing, in every batch."""
    lossy = {"kind": "fixed", "reflectance": 0.25, "transmittance": 0.5}
    whole = {"kind": "fixed", "reflectance": 0.25, "transmittance": 0.75}
    boards = [
        {**wall((10.0 * n, 0, 0), "+z"), "surface": surface}
        for n, surface in enumerate((glass(lossy), glass(whole), glass(None)))
    ]
    lamps = [{**beam((10.0 * n, 0, 1), "-z"), "tilt_deg": [20.0, 0.0]} for n in range(3)]
    for splitting in (True, False):
        run = {"rays_per_batch": 96, "splitting": splitting}
        found = trace(scene_of(lamps, boards, far_field={"n_mu": 2, "n_phi": 4}, run=run))
        third = found.emitted / 3
        assert found.absorbed("element 0") == third / 4
        assert found.absorbed("element 1") == 0
        assert found.absorbed("element 2") == 0
        assert max(map(abs, found.closures())) <= (1e-16 if splitting else 0)
