"""A scene's objects as the rows that the kernels read."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from hostcode.program.program import (
    MATERIAL_STRIDE,
    ROW_FRAME,
    ROW_STRIDE,
    SOURCE_STRIDE,
    TREE_NODE,
    ElementClass,
    SourceKind,
    SurfaceKind,
)
from photizon_cl.compile.tree_nodes import pack_nodes
from photizon_cl.geometry.tree import build_tree, world_boxes
from photizon_cl.scene.elements.flat import Flat
from photizon_cl.scene.frames import axis_index

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hostcode.run.tables import DeviceTables
    from photizon_cl.compile.layout import DetectorCells
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.frames import Vec3
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.sources import Source

# -- sources -------------------------------------------------------------------------------------


def extended(source: Source) -> bool:
    """Say whether a source draws a position besides a direction."""
    return bool(source.packed())


def source_table(
    scene: Scene,
    kinds: tuple[SourceKind, ...],
    rays: tuple[int, ...],
    weights: list[float],
    shift: tuple[float, float, float],
) -> NDArray[np.float64]:
    """Return the rows of the source table, see ``kernels/lib/sources.mako``."""
    number = {kind.stem: kind.number for kind in kinds}
    table = np.zeros((len(scene.source), SOURCE_STRIDE))
    first = 0
    for row, source, n, weight in zip(table, scene.source, rays, weights, strict=True):
        row[0:3] = np.subtract(source.position, shift)
        row[3] = source.packed()[0] if source.packed() else 0.0
        row[4:8] = weight, first, first + n, number[source.kernel]
        row[8:17] = np.ravel(source.frame)
        first += n
    return table.ravel()


# -- elements ------------------------------------------------------------------------------------


def recentre(scene: Scene) -> tuple[float, float, float]:
    """Return the shift that brings a far scene near the origin, zero for one that is near.

    A whole multiple of four times the scene's size, rounded to a power of two: positions lose
    nothing by the subtraction, and a scene around the origin is not touched.
    """
    boxes = [(e.position, e.reach) for e in scene.element]
    boxes += [(s.position, s.packed()[0] if s.packed() else 0.0) for s in scene.source]
    low = np.min([np.subtract(p, r) for p, r in boxes], axis=0)
    high = np.max([np.add(p, r) for p, r in boxes], axis=0)
    size = float(np.max(high - low))
    if not size > 0.0:
        return (0.0, 0.0, 0.0)
    step = math.ldexp(4.0, math.frexp(size)[1])
    x, y, z = (float(np.rint(c / step)) * step for c in (low + high) / 2)
    return (x, y, z)


def element_classes(
    scene: Scene, force_tilt: bool
) -> tuple[tuple[ElementClass, ...], list[ElementClass]]:
    """Return the classes of a scene's elements in order, and the class of each element."""
    keys: list[tuple[str, str, int | None, bool]] = []
    for e in scene.element:
        keys.append((e.kernel, e.family, None if force_tilt else e.class_axis, e.ported))
    order = sorted(set(keys), key=lambda k: (k[0], -1 if k[2] is None else k[2], k[3]))
    classes = {
        key: ElementClass(*key, single=keys.count(key) == 1 and key[1] == "sphere", number=n)
        for n, key in enumerate(order)
    }
    return tuple(classes.values()), [classes[key] for key in keys]


def element_codes(
    scene: Scene, class_of: list[ElementClass], surface_number: dict[str, int]
) -> list[int]:
    """Return the elements' codes, see ``kernels/lib/packets.mako``."""
    codes = []
    for n, (element, cls) in enumerate(zip(scene.element, class_of, strict=True)):
        down = cls.axis is not None and axis_index(element.axis) % 2 == 1
        counted = element.detector is not None
        kind = surface_number[element.surface.kind]
        codes.append(n << 32 | counted << 12 | kind << 8 | down << 7 | cls.number)
    return codes


def codes_by_class(codes: list[int], n_classes: int) -> list[int]:
    """Return where each class's codes begin, where the last end, and the codes by class."""
    bounds, ordered = [n_classes + 1], []
    for number in range(n_classes):
        ordered += [code for code in codes if code & 127 == number]
        bounds.append(n_classes + 1 + len(ordered))
    return bounds + ordered


def codes_in_order(
    codes: list[int], material_of: list[int], n_classes: int, tree: int
) -> list[int]:
    """Return where each class's first code stands, where the tree begins, and the codes in order.

    `tree` is its place in the geometry table. These codes have the material's row in place of the
    element's number, which is their place.
    """
    first: dict[int, int] = {}
    for n, code in enumerate(codes):
        first.setdefault(code & 127, n_classes + 1 + n)
    with_material = [
        row << 32 | code & 0xFFFFFFFF for code, row in zip(codes, material_of, strict=True)
    ]
    return [first[number] for number in range(n_classes)] + [tree] + with_material


def code_of(tables: DeviceTables, element: int) -> int:
    """Return an element's code from a table of either order."""
    codes, n_classes = tables.codes, len(tables.spec.classes)
    if "acceleration" in tables.spec.effects:
        return element << 32 | int(codes[n_classes + 1 + element]) & 0xFFFFFFFF
    return next(int(c) for c in codes[codes[0] : codes[n_classes]] if c >> 32 == element)


def add_tree(
    scene: Scene, shift: Vec3, factors: NDArray[np.float64], geometry: NDArray[np.float64]
) -> tuple[int, NDArray[np.float64]]:
    """Return the geometry table with a tree of boxes, and where in it that begins.

    See ``kernels/effects/acceleration.mako``.
    """
    boxes = world_boxes(scene.element, shift, factors.max(axis=1))
    rows = pack_nodes(*build_tree(boxes))
    # a node begins at a whole node from the table's beginning; the scene's size stands before the
    # first
    head = np.zeros(TREE_NODE - len(geometry) % TREE_NODE)
    head[-1] = np.max(np.abs(boxes))
    return len(geometry) + len(head), np.concatenate((geometry, head, rows.ravel()))


def geometry_table(
    scene: Scene,
    class_of: list[ElementClass],
    shift: tuple[float, float, float],
    factors: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the elements' rows: centre, what their class packs, frame."""
    table = np.zeros((len(scene.element), ROW_STRIDE))
    rows = zip(table, scene.element, class_of, factors.tolist(), strict=True)
    for row, element, cls, at_edges in rows:
        x, y, z = centre = _from_shift(element.position, shift)
        # Two elements that share an edge agree on it only to the rounding of the positions that
        # they were given: rounding bounds follow those, however near the recentred scene is.
        ax, ay, az = (max(abs(c), abs(q)) for c, q in zip(centre, element.position, strict=True))
        if isinstance(element, Flat):
            packed = element.packed((ax, ay, az), cls.axis, at_edges)
        else:
            packed = element.packed((ax, ay, az), cls.axis)
        row[0:3] = x, y, z
        row[3 : 3 + len(packed)] = packed
        row[ROW_FRAME : ROW_FRAME + 9] = np.ravel(element.frame)
    return table.ravel()


def _from_shift(position: Vec3, shift: Vec3) -> Vec3:
    return (position[0] - shift[0], position[1] - shift[1], position[2] - shift[2])


# -- surfaces ------------------------------------------------------------------------------------


def material_table(scene: Scene) -> tuple[list[float], list[int]]:
    """Rows of the distinct surfaces, and where in them each element's begins."""
    rows: dict[tuple[str, tuple[float, ...]], int] = {}
    of_element = []
    for element in scene.element:
        packed = element.surface.packed()
        padded = packed + (0.0,) * (MATERIAL_STRIDE - len(packed))
        key = (element.surface.kind, padded)
        of_element.append(rows.setdefault(key, len(rows) * MATERIAL_STRIDE))
    return [x for _, row in rows for x in row], of_element


def surface_kinds(scene: Scene, material_of: list[int]) -> tuple[SurfaceKind, ...]:
    """Return the surface kinds in use, by name."""
    rows: dict[str, set[int]] = {}
    for element, at in zip(scene.element, material_of, strict=True):
        rows.setdefault(element.surface.kind, set()).add(at)
    return tuple(
        SurfaceKind(kind, n, single=len(rows[kind]) == 1) for n, kind in enumerate(sorted(rows))
    )


# -- detectors -----------------------------------------------------------------------------------


def detector_row(
    element: Element, d: DetectorCells, shift: tuple[float, float, float], edges: list[float]
) -> tuple[list[int], list[float]]:
    """Return a detector's integers and numbers; its bins' edges go to the end of `edges`."""
    counts_plus = element.detector_side in ("front", "outside")
    x_edges = y_edges = 0
    if d.nx:
        along_x, along_y = element.map_edges(d.nx, d.ny)
        x_edges = len(edges)
        y_edges = x_edges + len(along_x)
        edges += along_x + along_y
    integers = [
        int(counts_plus), d.power, d.ladder, d.n_generations, d.map, d.nx, d.ny, x_edges, y_edges,
        int(not element.flat),
    ]  # fmt: skip
    row = [*np.subtract(element.position, shift).tolist(), *np.ravel(element.frame).tolist()]
    return integers, row
