"""The code of an element, and of a face of it: one 64-bit integer.

From its lowest bits: the element class, whether the normal points down its axis, the surface kind,
whether it has a detector, whether its faces may lie in those of others, the face, and the element's
number. Of two codes the smaller one belongs
to the element named first, and of one element to its first face.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from hostcode.errors import HostError

__all__ = ["CODE", "CodeField", "decode", "encode"]


@dataclass(frozen=True)
class CodeField:
    """Some bits of a code.

    Parameters
    ----------
    name : str
        What they say.
    shift, bits : int
        Where they begin, and how many they are.
    what : str
        What is counted, for the message where there are too many.
    """

    name: str
    shift: int
    bits: int
    what: str

    @property
    def limit(self) -> int:
        """How many values they tell apart."""
        return 1 << self.bits

    @property
    def mask(self) -> int:
        """The highest value."""
        return self.limit - 1


CODE: Final[dict[str, CodeField]] = {
    field.name: field
    for field in (
        CodeField("cls", 0, 7, "element classes (kinds by axis and opening) in one scene"),
        CodeField("down", 7, 1, "signs of an axis"),
        CodeField("surface", 8, 6, "surface kinds in one scene"),
        CodeField("detector", 14, 1, "detectors on an element"),
        CodeField("coincident", 15, 1, "elements whose faces may lie in others'"),
        CodeField("face", 16, 16, "faces of an element"),
        # a ray remembers element, face and side in 64 bits (kernels/lib/faces.mako)
        CodeField("element", 32, 27, "elements in one scene"),
    )
}
"""The fields of a code by name."""


def encode(**values: int) -> int:
    """Return a code; fields that are not named are 0.

    Raises
    ------
    HostError
        Where a value does not fit its bits.
    """
    code = 0
    for name, value in values.items():
        field = CODE[name]
        if not 0 <= value <= field.mask:
            raise HostError(
                f"more than {field.limit} {field.what}: the kernels cannot tell them apart; "
                "divide the scene"
            )
        code |= value << field.shift
    return code


def decode(code: int, name: str) -> int:
    """Return what a code says in one of its fields."""
    field = CODE[name]
    return code >> field.shift & field.mask
