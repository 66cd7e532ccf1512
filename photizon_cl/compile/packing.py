"""A scene's objects as the rows that the kernels read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.errors import HostError
from hostcode.program.codes import decode, encode
from hostcode.program.parts import ElementClass, SourceKind, Strides, SurfaceKind
from hostcode.program.spec import CACHE_LINE
from photizon_cl.compile.grid import Indices, numbers_of
from photizon_cl.errors import ArgumentError
from photizon_cl.geometry.placing import bounded, moved
from photizon_cl.scene.elements import Element
from photizon_cl.scene.frames import axis_index
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from hostcode.run.tables import DeviceTables
    from photizon_cl.compile.common import Common
    from photizon_cl.compile.draft import Draft
    from photizon_cl.compile.effects.base import Effect
    from photizon_cl.compile.grid import Grid
    from photizon_cl.compile.kinds import Kinds
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.surfaces.base import Surface

POSITION: Final = Row("ROW", ("x", "m", ""), ("y", "m", ""), ("z", "m", ""))
"""What every element's row begins with: its recentred position. Its frame ends it."""
SOURCE: Final = Row(
    "SOURCE",
    ("x", "m", "recentred position"),
    ("y", "m", ""),
    ("z", "m", ""),
    ("weight", "", "of its rays, relative to the heaviest"),
    ("first_ray", "", "number of its first ray in a batch"),
    ("end_ray", "", "behind its last ray"),
    ("kind", "", "number of its kind in the program"),
)
"""What every source's row begins with. Its frame ends it."""
_FRAME: Final = 9

# -- strides -------------------------------------------------------------------------------------


def _rows(things: Any) -> list[Row]:
    return list(dict.fromkeys(thing.row for thing in things))


def strides(kinds: Kinds, effects: Sequence[Effect]) -> Strides:
    """Return the lengths of the tables' rows: those of the longest kind that is compiled in.

    Behind the columns of an element's kind come those of the effects in use, then its frame.
    """
    element = max((len(e.row) for e in kinds.elements), default=0) + len(POSITION)
    element += sum(len(effect.row) for effect in effects)
    source = max(len(s.row) for s in kinds.sources) + len(SOURCE)
    line = CACHE_LINE // 8
    return Strides(
        row=-(-(element + _FRAME) // line) * line,
        row_frame=element,
        material=_own_columns(kinds) + max((len(c.row) for c in kinds.coatings), default=0),
        source=source + _FRAME,
        source_frame=source,
    )


def _own_columns(kinds: Kinds) -> int:
    """Return the columns of a material's row that are its surface's; behind are its coating's."""
    return max((len(s.row) for s in kinds.surfaces), default=0)


def columns(
    kinds: Kinds, effects: Sequence[Effect], stride: Strides
) -> tuple[tuple[str, int], ...]:
    """Return the kernels' names of the columns in use, and their places in a row."""
    found = {**POSITION.constants(0), **SOURCE.constants(0)}
    groups: tuple[tuple[Sequence[Any], int], ...] = (
        *_places(effects, stride),
        (kinds.elements, len(POSITION)),
        (kinds.surfaces, 0),
        (kinds.coatings, _own_columns(kinds)),
        (kinds.sources, len(SOURCE)),
    )
    for things, first in groups:
        for row in _rows(things):
            for name, place in row.constants(first).items():
                if found.setdefault(name, place) != place:
                    raise ValueError(
                        f"two rows have a column {name}, in two places: give each class's Row a "
                        "prefix of its own"
                    )
    return tuple(sorted(found.items()))


def _places(effects: Sequence[Effect], stride: Strides) -> Iterator[tuple[list[Effect], int]]:
    """Give each effect and where its columns begin in an element's row."""
    place = stride.row_frame - sum(len(effect.row) for effect in effects)
    for effect in effects:
        yield [effect], place
        place += len(effect.row)


# -- sources -------------------------------------------------------------------------------------


def source_kinds(scene: Scene, kinds: Kinds) -> tuple[SourceKind, ...]:
    """Return the source kinds that are compiled in, by name."""
    found = {(s.kernel, s.option, s.draws_position, s.libraries) for s in scene.source}
    used = {kernel for kernel, *_ in found}
    found |= {
        (s.kernel, "", s.draws_position, s.libraries) for s in kinds.sources if s.kernel not in used
    }
    return tuple(
        SourceKind(stem, option, n, draws, libraries)
        for n, (stem, option, draws, libraries) in enumerate(sorted(found))
    )


def source_table(
    draft: Draft,
    kinds: tuple[SourceKind, ...],
    rays: tuple[int, ...],
    weights: list[float],
    stride: Strides,
) -> NDArray[np.float64]:
    """Return the rows of the source table: one for each beam."""
    number = {(kind.stem, kind.option): kind.number for kind in kinds}
    scene = draft.scene
    table = np.zeros((len(draft.beams), stride.source))
    first = 0
    for row, beam, n, weight in zip(table, draft.beams, rays, weights, strict=True):
        source = scene.source[beam.source]
        x, y, z = moved(source.position, draft.shift)
        values = SOURCE.pack(
            {
                "x": x,
                "y": y,
                "z": z,
                "weight": weight,
                "first_ray": first,
                "end_ray": first + n,
                "kind": number[source.kernel, source.option],
            }
        )
        values += source.row.pack(source.packed())
        row[: len(values)] = values
        row[stride.source_frame : stride.source_frame + _FRAME] = np.ravel(source.frame)
        first += n
    return table.ravel()


# -- elements ------------------------------------------------------------------------------------


def element_classes(
    scene: Scene, kinds: Kinds, axes: Sequence[int | None]
) -> tuple[tuple[ElementClass, ...], list[ElementClass]]:
    """Return the classes that are compiled in, in order, and the class of each element.

    `axes` are the world axes that the elements' functions are specialised to; None for the general.
    """
    keys: list[tuple[str, int | None, bool]] = []
    example: dict[tuple[str, int | None, bool], type[Element]] = {}
    for e, axis in zip(scene.element, axes, strict=True):
        key = (e.kernel, axis, e.opening)
        keys.append(key)
        example.setdefault(key, type(e))
    used = {kernel for kernel, *_ in keys}
    for kind in kinds.elements:
        if kind.kernel not in used:  # in its most general form
            example[kind.kernel, None, kind.opening is not Element.opening] = kind
    order = sorted(example, key=lambda k: (k[0], -1 if k[1] is None else k[1], k[2]))
    classes = {}
    for n, key in enumerate(order):
        cls, (kernel, axis, opening) = example[key], key
        classes[key] = ElementClass(
            kind=kernel,
            templates=cls.templates,
            libraries=cls.libraries,
            flat=cls.flat,
            faced=cls.faced,
            axis=axis,
            opening=opening,
            traits=cls.traits,
            single=cls.alone and keys.count(key) == 1 and not kinds.general,
            number=n,
        )
    return tuple(classes.values()), [classes[key] for key in keys]


def element_codes(
    scene: Scene,
    class_of: list[ElementClass],
    surfaces: tuple[SurfaceKind, ...],
    coincident: frozenset[int],
) -> list[int]:
    """Return the elements' codes, see `hostcode.program.codes`.

    `coincident` are the numbers of the elements whose faces may lie in those of others.

    Raises
    ------
    ArgumentError
        Where the scene has more of something than the kernels can tell apart.
    """
    number = {surface.kind: surface.number for surface in surfaces}
    codes = []
    try:
        for n, (element, cls) in enumerate(zip(scene.element, class_of, strict=True)):
            codes.append(
                encode(
                    element=n,
                    detector=int(element.detector is not None),
                    coincident=int(n in coincident),
                    surface=number[element.surfaces[0].kernel],
                    down=int(cls.axis is not None and axis_index(element.axis) % 2 == 1),
                    cls=cls.number,
                )
            )
    except HostError as error:
        raise ArgumentError(f"scene {scene.name!r}: {error}") from None
    return codes


def codes_by_class(codes: list[int], n_classes: int) -> list[int]:
    """Return where each class's codes begin, where the last end, and the codes by class."""
    bounds, ordered = [n_classes + 1], []
    for number in range(n_classes):
        ordered += [code for code in codes if decode(code, "cls") == number]
        bounds.append(n_classes + 1 + len(ordered))
    return bounds + ordered


def codes_in_order(
    codes: list[int], material_of: list[int], classes: tuple[ElementClass, ...], tree: int
) -> list[int]:
    """Return where each class's first code stands, where the tree begins, and the codes in order.

    `tree` is its place in the geometry table. These codes have the material's row in place of the
    element's number, which is their place.
    """
    first: dict[int, int] = {}
    for n, code in enumerate(codes):
        first.setdefault(decode(code, "cls"), len(classes) + 1 + n)
    with_material = [
        row << 32 | code & 0xFFFFFFFF for code, row in zip(codes, material_of, strict=True)
    ]
    # of a class without elements nothing is ever read
    return [first.get(cls.number, 0) for cls in classes] + [tree] + with_material


def code_of(tables: DeviceTables, element: int) -> int:
    """Return an element's code from a table of either order."""
    codes, n_classes = tables.codes, len(tables.spec.classes)
    if tables.spec.one_by_one:
        return element << 32 | int(codes[n_classes + 1 + element]) & 0xFFFFFFFF
    return next(int(c) for c in codes[codes[0] : codes[n_classes]] if c >> 32 == element)


def geometry_table(
    draft: Draft, class_of: list[ElementClass], stride: Strides, effects: Sequence[Effect]
) -> NDArray[np.float64]:
    """Return the elements' rows: position, what their class packs, what effects add, frame."""
    elements, first = draft.scene.element, len(POSITION)
    table = np.zeros((len(elements), stride.row))
    for (effect,), place in _places(effects, stride):
        if len(effect.row):
            added = [effect.row.pack(effect.packed(draft, n)) for n in range(len(elements))]
            table[:, place : place + len(effect.row)] = added
    rows = zip(table, elements, class_of, draft.at_edges.tolist(), strict=True)
    for row, element, cls, at_edges in rows:
        x, y, z = moved(element.position, draft.shift)
        centre = bounded(element.position, draft.shift, draft.precision.roundoff)
        packed = element.row.pack(
            element.packed(centre, cls.axis, at_edges, draft.precision.roundoff)
        )
        row[0:first] = x, y, z
        row[first : first + len(packed)] = packed
        row[stride.row_frame : stride.row_frame + _FRAME] = np.ravel(element.frame)
    return table.ravel()


# -- surfaces ------------------------------------------------------------------------------------


def material_table(
    scene: Scene, kinds: Kinds, stride: Strides, grid: Grid
) -> tuple[list[float], dict[Surface, int]]:
    """Rows of the distinct surfaces in order, and where in them that of each begins.

    A surface has a row for each line of the grid, or for each coefficient in each of its pieces.
    """
    rows: dict[tuple[str, tuple[float, ...]], int] = {}
    own = _own_columns(kinds)
    length = stride.material * grid.n * (grid.degree + 1)
    places: dict[Surface, int] = {}
    indices = Indices(scene)
    for element in scene.element:
        for surface in element.surfaces:
            if surface in places:
                continue
            values: list[float] = []
            for row in grid.rows(numbers_of(scene, surface, own, indices=indices)):
                values += [*row, *(0.0,) * (stride.material - len(row))]
            places[surface] = rows.setdefault((surface.kind, tuple(values)), len(rows) * length)
    return [x for _, row in rows for x in row], places


def surface_kinds(
    kinds: Kinds,
    materials: dict[Surface, int],
    common: Common | None = None,
    *,
    divided: bool = False,
) -> tuple[SurfaceKind, ...]:
    """Return the surface kinds that are compiled in, by name.

    `divided`: whether a material has several rows.
    """
    several = common.several if common else frozenset()
    splitting = common.splitting if common else frozenset()
    rows: dict[str, set[int]] = {cls.kernel: set() for cls in kinds.surfaces}
    made: dict[str, Surface | type[Surface]] = {}
    takes = {cls.kernel: cls.absorbs is True for cls in kinds.surfaces}
    for surface, at in materials.items():
        takes[surface.kernel] = takes.get(surface.kernel, False) or surface.absorbs
        rows.setdefault(surface.kernel, set()).add(at)
        kept = made.get(surface.kernel, surface)
        made[surface.kernel] = surface if surface.splits else kept
    for cls in kinds.surfaces:
        made.setdefault(cls.kernel, cls)
    return tuple(
        SurfaceKind(
            kind,
            n,
            single=not (len(rows[kind]) > 1 or kind in several or kinds.general or divided),
            # of a class whose objects each say it, what the most that they say is
            absorbs=takes[kind],
            splits=made[kind].splits is not False or kind in splitting,
            counts=made[kind].counts,
            refracts=made[kind].refracts,
            scatters=made[kind].scatters,
            libraries=made[kind].libraries,
        )
        for n, kind in enumerate(sorted(rows))
    )
