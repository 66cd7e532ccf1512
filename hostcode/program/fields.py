"""One list each of what a ray carries, what a search finds and what an ending records.

The kernels' structures, the queue, the records and the buffers of the host are made from these
lists. Each list here is what every program has; effects add fields of their own, see
`photizon_cl.compile.effects`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

__all__ = [
    "BASE_ENDING",
    "BASE_HIT",
    "BASE_RAY",
    "ENDING_TYPES",
    "HIT_TYPES",
    "LAUNCHED",
    "RAY_TYPES",
    "REALS",
    "EndingField",
    "HitField",
    "RayField",
    "declare",
    "of_type",
]

_C_TYPES: Final = {
    "real": "real",
    "weight": "weight",
    "long": "lint",
    "ulong": "luint",
    "word": "word",
    "mask": "mask",
}

RAY_TYPES: Final = ("real", "weight", "long", "ulong", "word")
HIT_TYPES: Final = ("real", "long", "mask")
ENDING_TYPES: Final = ("real", "weight", "word")

REALS: Final = ("real", "weight")
"""Types that buffers hold as doubles, whatever they are on the device."""


@dataclass(frozen=True)
class RayField:
    """A number that a ray carries from one interaction to the next, and that the queue keeps.

    Parameters
    ----------
    name : str
        Member of ``packet_t``.
    type : str
        ``real``, ``weight``, ``long``, ``ulong`` or ``word``.
    start : str
        Its value in a launched ray: C, in the scope of ``generate`` (kernels/lib/generate.mako).
    meaning : str
        Unit and meaning.
    empty : str
        Its value in a lane without a ray; default `start`.
    onward, second : str
        Its value behind an interaction, in the ray that goes on in its lane and in the second one:
        C, in the scope of ``shade`` (kernels/lib/shade.mako), where ``p`` still is the ray before.
        Without them it stays what it was.
    beside : str
        The same for a scattered ray that goes on beside those; default `onward`.
    """

    name: str
    type: str
    start: str
    meaning: str
    empty: str = ""
    onward: str = ""
    second: str = ""
    beside: str = ""

    @property
    def cleared(self) -> str:
        """Its value in a lane without a ray."""
        return self.empty or self.start


@dataclass(frozen=True)
class HitField:
    """A number that the search for the nearest face gives.

    Parameters
    ----------
    name : str
        Member of ``hit_t``; dots lead into structures.
    type : str
        ``real``, ``long`` or ``mask``.
    meaning : str
        Unit and meaning.
    """

    name: str
    type: str
    meaning: str


@dataclass(frozen=True)
class EndingField:
    """A number that is recorded of a ray that arrives at a detector or leaves the scene.

    Parameters
    ----------
    name : str
        Member of ``ending_t``.
    type : str
        ``real``, ``weight`` or ``word``.
    value : str
        C, in the scope of ``shade`` (kernels/lib/shade.mako).
    meaning : str
        Unit and meaning.
    """

    name: str
    type: str
    value: str
    meaning: str


def _vector(names: str, starts: str, meaning: str) -> tuple[RayField, ...]:
    pairs = zip(names.split(), starts.split(), strict=True)
    return tuple(RayField(name, "real", start, meaning, "splat(0.0)") for name, start in pairs)


BASE_RAY: Final[tuple[RayField, ...]] = (
    *_vector("ox oy oz", "x y z", "origin in m, in the scene's recentred coordinates"),
    *_vector("dx dy dz", "dx dy dz", "unit direction"),
    RayField(
        "w", "weight", "w", "weight relative to the heaviest launched ray", "weight_splat(0.0)"
    ),
    RayField(
        "left",
        "long",
        "lsplat(NO_FACE)",
        "the face it left: code << 2 | now on the + side << 1 | came from the + side, or NO_FACE",
    ),
    RayField("ray_lo", "word", "lo", "number of the launched ray, low half", "wsplat(0u)"),
    RayField("ray_hi", "word", "hi", "number of the launched ray, high half", "wsplat(0u)"),
    RayField("generation", "word", "wsplat(0u)", "surface interactions so far"),
)
"""What every ray carries."""

LAUNCHED: Final = RayField("launched", "weight", "w", "weight as launched", "weight_splat(0.0)")
"""What a ray carries where its launched weight matters; several effects may bring it."""

BASE_HIT: Final[tuple[HitField, ...]] = (
    HitField("t", "real", "distance in m, infinite where nothing is met"),
    HitField("plane", "real", "coordinate in m of a flat face across an axis"),
    HitField("code", "long", "element, face and kinds, see CODE; LONG_MAX where nothing is met"),
    HitField("edge", "mask", "it was met within rounding of its edge"),
)
"""What every search finds."""

BASE_ENDING: Final[tuple[EndingField, ...]] = (
    EndingField("w", "weight", "p->w", "weight that arrives or leaves"),
    EndingField("x", "real", "SEL(found, c->x, p->dx)", "point of the arrival in m, or direction"),
    EndingField("y", "real", "SEL(found, c->y, p->dy)", "point of the arrival in m, or direction"),
    EndingField("z", "real", "SEL(found, c->z, p->dz)", "point of the arrival in m, or direction"),
    EndingField(
        "tag",
        "word",
        "TO_WORD(SELI(found, (element << 1) | (INT_MASK(c->came_plus & ~c->inner) & 1L), "
        "lsplat(-1L)))",
        "element << 1 | (arrives on the + side); all ones for what leaves the scene",
    ),
    EndingField("generation", "word", "p->generation", "surface interactions before"),
)
"""What every record holds."""


def of_type(fields: tuple[RayField | EndingField, ...], *types: str) -> tuple[str, ...]:
    """Return the names of the fields that have one of some types, in order."""
    return tuple(field.name for field in fields if field.type in types)


def declare(fields: tuple[RayField | HitField | EndingField, ...]) -> str:
    """Return the C members of a structure, one a line with its meaning."""
    return "".join(
        f"    {_C_TYPES[field.type]} {field.name};  // {field.meaning}\n" for field in fields
    )
