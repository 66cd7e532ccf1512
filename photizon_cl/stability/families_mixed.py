"""Hard cases of several elements: touching, nearly coincident, sharing edges."""

from __future__ import annotations

import itertools
import math
import random
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.cpc import Cpc
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import AXES, frame
from photizon_cl.scene.surfaces.absorber import Absorber
from photizon_cl.stability.build import SCALES, TILT, aimed, black, turned
from photizon_cl.stability.case import Case, Left

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.surfaces import Surface

__all__ = ["nearly_coincident", "room", "shared_edges", "shared_rims", "touching"]

_GAP: Final = 1e-12


def room(
    low: Sequence[float],
    high: Sequence[float],
    tilt: tuple[float, float] = (0.0, 0.0),
    surface: Surface | None = None,
) -> tuple[Element, ...]:
    """Return the six walls of a closed box, normals inwards.

    Parameters
    ----------
    low, high : sequence of float
        Opposite corners in metres, in the tilted frame of ``+z``.
    tilt : tuple of float, optional
        Turn of the whole box about world x or about world y, in degrees.
    surface : Surface, optional
        Of all walls; default black.
    """
    if tilt[0] and tilt[1]:
        raise ValueError("a box is tilted about one axis")
    about = 0 if tilt[0] else 1
    angle = tilt[0] or tilt[1]
    rows = np.array(frame("+z", tilt))
    walls = []
    for n, axis in enumerate(AXES):
        along = "xyz".index(axis[1])
        middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
        middle[along] = low[along] if axis[0] == "+" else high[along]
        half = [(b - a) / 2 for a, b in zip(low, high, strict=True)]
        # for +a the frame's u is axis a + 1; for -a it is a + 2
        u, v = (along + 1) % 3, (along + 2) % 3
        if axis[0] == "-":
            u, v = v, u
        turn = (angle if u == about else 0.0, angle if v == about else 0.0)
        if angle and along == about:
            # It turns in its own plane: a frame of the next axis is laid down by a quarter turn,
            # then turned about its v, which is the axis of the turn.
            turn = (-90.0 if axis[0] == "+" else 90.0, angle)
            u, v = (along + 2) % 3, (along + 1) % 3
            axis = "+" + "xyz"[(along + 1) % 3]
        x, y, z = (np.array(middle) @ rows).tolist() if angle else middle
        walls.append(
            Rectangle(
                name=f"wall {n}",
                position=(x, y, z),
                axis=axis,
                tilt_deg=turn,
                half_width=half[u],
                half_height=half[v],
                surface=surface or Absorber(),
            )
        )
    return tuple(walls)


def nearly_coincident() -> Iterator[Case]:
    """Faces 1e-12 of their size apart, crossed from outside and from the gap."""
    r = random.Random(41)
    for scale in SCALES:
        for tilt in ((0.0, 0.0), TILT):
            w = frame("+z", tilt)[2]
            for order in (0, 1):
                low = black(Rectangle, scale, tilt=tilt, half_width=1, half_height=1, name="low")
                high = black(
                    Disk, scale, tilt=tilt, radius=1.4, at=[_GAP * x for x in w], name="high"
                )
                pair = (low, high) if order else (high, low)
                for side in (1, -1):
                    end = [scale * r.uniform(-0.6, 0.6) for _ in range(2)]
                    start = [scale * r.uniform(-1, 1) for _ in range(2)]
                    yield aimed("parallel faces", pair, (*start, side * scale), (*end, 0.0))
                inside = (0.1 * scale, 0.2 * scale, 0.0)
                yield turned(
                    "from one face to the other",
                    (low, high),
                    inside,
                    (0.3, 0.2, 0.9),
                    left=Left(0, 0, plus=True),
                )
        for factor in (1 + _GAP, 1 + 1e-9):
            inner = black(Sphere, scale, radius=0.7, name="inner")
            outer = black(Sphere, scale, radius=0.7 * factor, name="outer")
            for place in ((0.1, 0.2, 0.3), (2.0, 1.0, -3.0)):
                along = [r.gauss(0, 1) for _ in range(3)]
                if place[0] > 1:
                    along = [-x + 0.1 * y for x, y in zip(place, along, strict=True)]
                for pair in ((inner, outer), (outer, inner)):
                    yield turned(
                        f"shells R and R(1 {factor - 1:+g})",
                        pair,
                        [scale * x for x in place],
                        along,
                    )


def touching() -> Iterator[Case]:
    """Bodies in contact: tangent spheres, a lens on a plate, a sphere on a plate."""
    r = random.Random(42)
    for scale in SCALES:
        plate = black(Rectangle, scale, half_width=2, half_height=2, name="plate")
        ball = black(Sphere, scale, radius=0.7, at=(0, 0, 0.7), name="ball")
        lens = black(PlanoConvex, scale, curvature_radius=1.5, aperture_radius=1, name="lens")
        double = black(
            Biconvex,
            scale,
            front_radius=2,
            back_radius=1.5,
            aperture_radius=1,
            name="double",
            at=(0, 0, 1.5 - math.sqrt(1.25)),
        )
        other = black(Sphere, scale, radius=0.35, at=(0, 0, 1.75), name="other")
        for body in (ball, lens, double):
            for beside in (0.0, 1e-12, 1e-6, 0.3):
                phi = r.uniform(0, 2 * math.pi)
                end = (scale * beside * math.cos(phi), scale * beside * math.sin(phi), 0.0)
                for side in (1, -1):
                    start = (scale * r.uniform(-2, 2), scale * r.uniform(-2, 2), scale * side)
                    yield aimed(
                        f"{body.kind} on a plate, {beside:g} from the contact",
                        (plate, body),
                        start,
                        end,
                    )
                start = (scale * r.uniform(-1, 1), scale * r.uniform(-1, 1), 0.0)
                yield aimed(
                    f"from the plate, {beside:g}",
                    (plate, body),
                    start,
                    (end[0], end[1], 0.1 * scale),
                    left=Left(0, 0, plus=True),
                )
        for beside in (0.0, 1e-9, 1e-3):
            point = (scale * beside, 0.0, 1.4 * scale)
            start = (2 * scale, 0.3 * scale, scale * r.uniform(1, 2))
            yield aimed(
                f"tangent spheres, {beside:g} from the contact", (plate, ball, other), start, point
            )


def shared_rims() -> Iterator[Case]:
    """Rays at the rims that a CPC shares with disks over its ends, from inside."""
    r = random.Random(43)
    for scale in SCALES:
        for tilt in ((0.0, 0.0), TILT):
            for angle in (20.0, 60.0):
                cpc = black(
                    Cpc, scale, tilt=tilt, exit_radius=0.7, acceptance_deg=angle, name="cpc"
                )
                assert isinstance(cpc, Cpc)
                wide, length = cpc.entrance_radius, cpc.length
                w = frame("+z", tilt)[2]
                exit_disk = black(Disk, tilt=tilt, radius=cpc.exit_radius, name="exit")
                lid = black(Disk, tilt=tilt, radius=wide, at=[length * x for x in w], name="lid")
                closed = (cpc, exit_disk, lid)
                for rim, z in ((cpc.exit_radius, 0.0), (wide, length)):
                    for beside in (0.0, 1e-16, -1e-16, 1e-12, -1e-12):
                        phi = r.uniform(0, 2 * math.pi)
                        k = rim * (1 + beside)
                        start = (
                            0.2 * cpc.exit_radius * r.uniform(-1, 1),
                            0.1 * cpc.exit_radius,
                            length * r.uniform(0.2, 0.8),
                        )
                        yield aimed(
                            f"rim at {z:.3g}, {beside:+g}",
                            closed,
                            start,
                            (k * math.cos(phi), k * math.sin(phi), z),
                            must_hit=abs(beside) < 1e-15,
                        )
                edge = cpc.exit_radius
                start = (edge * math.cos(1.0), edge * math.sin(1.0), 0.0)
                for lean in (-0.3, 0.0):
                    along = (lean * math.cos(1.1), lean * math.sin(1.1), 1.0)
                    yield turned(
                        "from the disk's rim",
                        closed,
                        start,
                        along,
                        left=Left(1, 0, plus=True),
                        must_hit=True,
                    )


def shared_edges() -> Iterator[Case]:
    """Rays at the edges and corners of closed rooms, from inside and from their walls."""
    r = random.Random(44)
    boxes = [
        ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)),
        ((0.1, 0.1, 0.1), (0.4, 0.5, 0.7)),
        ((1e3, -2e3, 0.3), (1e3 + 1, -2e3 + 1, 1.3)),
        ((0.0, 0.0, 0.0), (0.3, 1.1, 0.7)),
    ]
    tilts = [(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (33.3, 0.0), (0.0, -71.7)]
    for scale in (1e-9, 1.0, 1e9):
        for (low, high), tilt in zip([*boxes, boxes[3]], [*tilts[:3], *tilts[3:]], strict=True):
            a, b = [scale * x for x in low], [scale * x for x in high]
            walls, rows = room(a, b, tilt), np.array(frame("+z", tilt))
            for corner in itertools.product(*zip(a, b, strict=True)):
                start = [x + (y - x) * r.random() for x, y in zip(a, b, strict=True)]
                yield _towards("a corner", walls, start @ rows, corner @ rows)
                along = r.randrange(3)
                edge = list(corner)
                edge[along] = a[along] + (b[along] - a[along]) * r.random()
                yield _towards("an edge", walls, start @ rows, edge @ rows)
                if edge[2] != a[2]:
                    floor = [*start[:2], a[2]]
                    yield _towards(
                        "an edge, from the floor",
                        walls,
                        floor @ rows,
                        edge @ rows,
                        left=Left(4, 0, plus=True),
                    )


def _towards(
    label: str,
    scene: tuple[Element, ...],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    *,
    left: Left | None = None,
) -> Case:
    """Return the case of a ray between world points that must hit something."""
    d = np.subtract(end, start)
    d /= np.linalg.norm(d)
    x, y, z = map(float, start)
    dx, dy, dz = d.tolist()
    return Case(label, scene, (x, y, z), (dx, dy, dz), left, must_hit=True)
