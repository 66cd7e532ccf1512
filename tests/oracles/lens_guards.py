"""Rays at lenses for which one guard against rounding is all that keeps the answer right.

Each gate is a lens and rays whose answer is known; without the guard that the gate is for, some are
off by a hundred times the bound and more, or get lost.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.program.precision import PRECISIONS
from hostcode.run.probe import element_of, face_of, probe_faces
from oracles.corners import U
from oracles.curved import leaks_of, rays_in
from oracles.engine import open_device
from oracles.lens_regions import lens_made
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.general_lens import Lens
from photizon_cl.scene.surfaces.absorber import Absorber
from photizon_cl.scene.surfaces.mirror import Mirror
from photizon_cl.stability.case import Case, Left
from photizon_cl.stability.measure import compile_elements, measure, state_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

AWAY: dict[str, Any] = {"position": (0.3, -0.2, 0.1), "tilt_deg": (33.3, -71.7)}
CENTRED: dict[str, Any] = {"position": (0.0, 0.0, 0.0)}
FRONT, EDGE = 0, 2


def lens(where: dict[str, Any], front: float, back: float, thickness: float, **more: Any) -> Lens:
    """Return a black lens whose rims have the radius 1."""
    return Lens(
        name="lens", axis="+z", surface=Absorber(), front_radius=front, back_radius=back,
        thickness=thickness, aperture_radius=1.0, **where, **more,
    )  # fmt: skip


def hits_of(
    body: Lens, starts: Any, along: Any, left: Left | None = None
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Probe rays given in the lens's frame.

    Returns
    -------
    hits : ndarray, shape (n, 7), float64
        As `probe_faces` gives them, points in world coordinates.
    faces : ndarray, shape (n,), int64
        Number of the face, −1 on a miss.
    rays : ndarray, shape (n, 6), float64
        The rays in world coordinates.
    """
    rows = np.array(body.frame)
    along = np.asarray(along) @ rows
    along /= np.linalg.norm(along, axis=1)[:, None]
    made = compile_elements((body,))
    from_middle = np.asarray(starts) @ rows + (np.array(body.position) - made.shift)
    state = np.full(len(along), state_of(made, left), np.int64)
    rays = np.hstack([from_middle, along])
    hits, states = probe_faces(open_device(), made.tables, rays, 1, state)
    for found in (hits[:, 1:4], rays[:, :3]):
        found += made.shift
    return hits, np.where(states < 0, -1, face_of(states)), rays


def circle(n: int) -> NDArray[np.float64]:
    """Return n points of the unit circle in the plane of the rims, shape (n, 3)."""
    phi = 2.0 * math.pi * (np.arange(n) + 0.1) / n
    return np.stack([np.cos(phi), np.sin(phi), 0.0 * phi], axis=1)


def rims_belong_to_both() -> None:
    """What leaves the edge where it ends meets the front there, whichever side rounding put it."""
    out, up = circle(256), np.array([0.0, 0.0, 1.0])
    around = np.cross(up, out)
    # the sine at which they meet a bulging front is 0.8 sqrt(5)/3 − 0.6·2/3,
    # at a hollow one 0.6·2/3 − 0.3 sqrt(5)/3
    for front, along, sine in (
        (1.5, 0.8 * up - 0.6 * out, 0.19),
        (-1.5, math.sqrt(0.55) * around - 0.6 * out - 0.3 * up, 0.17),
    ):
        body = lens(AWAY, front, 2.5, 0.9)
        starts = out + 0.5 * body.edge_thickness * up
        hits, faces, _ = hits_of(body, starts, along, Left(0, EDGE))
        assert (faces == FRONT).all()
        assert hits[:, 0].max() <= 8.0 * U / sine


def glass_has_an_exit() -> None:
    """Where a half ball ends a rod, what goes along the edge at their rim gets out all the same."""
    body = lens(AWAY, 1.0, 1.0, 4.0)
    r = np.random.default_rng(7)
    out = circle(4096)
    around, up = np.cross([0.0, 0.0, 1.0], out), np.array([0.0, 0.0, 1.0])
    below, lean = 10.0 ** -r.uniform(8, 17, len(out)), 10.0 ** -r.uniform(8, 12, len(out))
    starts = out + 0.5 * body.edge_thickness * (1.0 - below)[:, None] * up
    turn = r.uniform(0.0, 1.4, len(out))[:, None]
    along = np.cos(turn) * around + np.sin(turn) * up - lean[:, None] * out
    hits, faces, _ = hits_of(body, starts, along, Left(0, EDGE))
    assert (faces >= 0).all()
    # as far as chords of a circle come at these angles to it, if they stay on the edge
    assert hits[:, 0].max() <= 2.0 * lean.max() / math.cos(1.4) ** 2


def wrong_ways_along_the_edge(where: dict[str, Any], seed: int, n: int) -> list[str]:
    """Return what the 60-digit oracle calls wrong of rays that leave the edge along its ruling."""
    body = lens(where, 1.0, 1.0, 4.0)
    r = np.random.default_rng([7, seed])
    out, up = circle(n), np.array([0.0, 0.0, 1.0])
    around = np.cross(up, out)
    below, lean = 10.0 ** -r.uniform(1, 17, (n, 1)), 10.0 ** -r.uniform(8, 15, (n, 1))
    turn = 10.0 ** -r.uniform(0, 12, (n, 1))
    starts = out + 0.5 * body.edge_thickness * (1.0 - below) * up
    along = np.sin(turn) * around + np.cos(turn) * up - lean * out
    rows = np.array(body.frame)
    starts, along = starts @ rows + np.array(body.position), along @ rows
    along /= np.linalg.norm(along, axis=1)[:, None]
    cases = [
        Case(f"ray {k}", (body,), tuple(o), tuple(d), Left(0, EDGE), must_hit=True)
        for k, (o, d) in enumerate(zip(starts.tolist(), along.tolist(), strict=True))
    ]
    return [f"{m.label}: {m.note}" for m in measure(open_device(), cases) if not m.right]


def rims_hold() -> None:
    """No ray gets out at the rims of lenses that plates cut, tubes hold, and other lenses touch."""
    for number in range(3):
        for kind, shape in (
            ("on a plate", "knife"), ("glass in a barrel", "knife"), ("face to face", "biconcave"),
            ("in a cone", "hollow ball end"),
        ):  # fmt: skip
            _hold(kind, shape, number)


def grazing_roots_stay() -> None:
    """No ray gets out of half of an oblate ball on a rod, whose roots are polished.

    At places where it is none of the few of docs/guarantees.md: 1 in 4000, without the guard 1 in
    some hundreds at every place.
    """
    for number in (0, 2, 4, 5):
        _hold("halved", "oblate end", number)


def a_screen_hides_the_lens_behind_it(precision: str = "fp64") -> None:
    """What comes down along the edge's cylinder meets the screen between it and the lens."""
    for number, where in enumerate((CENTRED, AWAY, CENTRED | {"tilt_deg": (33.3, -71.7)})):
        body = lens(where, 1.5, 1.5, 1.0)
        rows, up = np.array(body.frame), np.array([0.0, 0.0, 1.0])
        height = 0.5 * body.edge_thickness
        for gap in (1.0, 1e-2, 1e-4):
            place = np.array(body.position) + (height + gap) * rows[2]
            screen = Disk(
                name="screen", axis="+z", surface=Absorber(), radius=3.0,
                **{**where, "position": tuple(place.tolist())},
            )  # fmt: skip
            made = compile_elements((body, screen), precision)
            out, r = circle(2048), np.random.default_rng([33, number])
            lean = 10.0 ** -r.uniform(4, 14, (len(out), 1))
            along = lean * np.cross(up, out) - up
            along /= np.linalg.norm(along, axis=1)[:, None]
            beside = r.integers(-6, 7, (len(out), 1)) * PRECISIONS[precision].roundoff
            starts = (1.0 + beside) * out + (height + 2.0 * gap) * up - 3.0 * along
            rays = np.hstack([starts @ rows + (np.array(body.position) - made.shift), along @ rows])
            state = np.full(len(out), state_of(made, None), np.int64)
            _, states = probe_faces(open_device(), made.tables, rays, 1, state)
            assert (element_of(states) == 1).all(), (where, gap)


def grazing_rays_leave_by_a_smooth_rim() -> None:
    """What runs along the edge of a lens in a tube leaves by the front that goes on from it."""
    region = lens_made("glass in a barrel", "oblate end", Mirror(1.0), (0.0, 0.0), 1.0, (0, 0, 0))
    body = region.elements[0]
    out, r = circle(4096), np.random.default_rng(32)
    below = 10.0 ** -r.uniform(11, 14, (len(out), 1))
    aside = 10.0 ** -r.uniform(6, 9, (len(out), 1))
    middle = 0.5 * body.edge_thickness * np.array([0.0, 0.0, 1.0])
    ends = body.aperture_radius * out + middle
    starts = body.aperture_radius * (1.0 - below) * out - 0.9 * middle
    starts += aside * np.cross(middle, out)
    along = (ends - starts) / np.linalg.norm(ends - starts, axis=1)[:, None]
    assert leaks_of(region, starts, along, steps=1) == (0, 0)


def _hold(kind: str, shape: str, number: int) -> None:
    r = np.random.default_rng([31, number])
    scale, away = ((1.0, 0.0), (1e-6, 0.0), (1e6, 1.3), (1e-6, 37.0))[number % 4]
    at = away * scale * r.uniform(-1, 1, 3)
    region = lens_made(kind, shape, Mirror(1.0), (0.0, 0.0), scale, at)
    assert leaks_of(region, *rays_in(r, region, 2000)) == (0, 0), (kind, shape, scale)


def heights_are_rounded() -> None:
    """What starts in the middle, where coordinates are 0, meets the vertex of a hollow face."""
    body = lens(CENTRED | {"tilt_deg": (33.3, -71.7)}, -1.5, -2.5, 0.2)
    beside = circle(512) * 10.0 ** -np.linspace(8.0, 17.0, 512)[:, None]
    for up, face in ((1.0, 0), (-1.0, 1)):
        starts, along = np.zeros_like(beside), beside + np.array([0.0, 0.0, up])
        hits, faces, _ = hits_of(body, starts, along)
        height = abs(body.vertices[face])
        assert (faces == face).all()
        assert np.abs(hits[:, 0] - height).max() <= 8.0 * U * height


def points_are_on_their_face() -> None:
    """What comes from 10¹⁰ lenses away ends on the face, though distances are good to 10⁻⁶."""
    body = lens(CENTRED, 1.5, 2.5, 0.9)
    out = circle(64)
    ends = out * np.linspace(0.02, 0.9, 64)[:, None]
    along = 0.2 * circle(64)[::-1] - np.array([0.0, 0.0, 1.0])
    starts = ends - 1e10 * along / np.linalg.norm(along, axis=1)[:, None]
    hits, faces, _ = hits_of(body, starts, along)
    assert (faces == FRONT).all()
    for point in hits[:, 1:4]:
        assert abs(_height(body, [Fraction(x) for x in point])) <= 4.0 * U


def grazing_chords_end_on_their_face() -> None:
    """What crosses the hollow of a needle along its side comes back to it there."""
    body = lens(CENTRED, -4e-12, math.inf, 0.1, front_conic=-1.1)
    side, height = body.sides[FRONT], body.vertices[FRONT]
    across = 10.0 ** -np.linspace(7.0, 12.0, 64)

    def place(r: float, phi: float) -> list[float]:
        return [r * math.cos(phi), r * math.sin(phi), float(Fraction(height) - side.sag_at(r))]

    starts = np.array([place(0.99, 0.1 * n) for n in range(64)])
    ends = np.array([place(across[n], 0.1 * n + 1e-3) for n in range(64)])
    hits, faces, rays = hits_of(body, starts, ends - starts, Left(0, FRONT, plus=True))
    assert (faces == FRONT).all()
    for ray, hit in zip(rays, hits, strict=True):
        t = Fraction(hit[0])
        reached = [Fraction(o) + t * Fraction(d) for o, d in zip(ray[:3], ray[3:], strict=True)]
        assert abs(_height(body, reached)) <= 8.0 * U


def _height(body: Lens, point: list[Fraction]) -> float:
    """Return the distance of a point from the surface of the front face, to first order."""
    x, y, z = point
    c, kappa = 1 / Fraction(body.front_radius), 1 + Fraction(body.front_conic)
    w = z - Fraction(body.vertices[FRONT])
    g = float(c * (x * x + y * y + kappa * w * w) + 2 * w)
    return 0.5 * g / math.hypot(float(c * x), float(c * y), float(1 + c * kappa * w))
