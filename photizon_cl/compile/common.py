"""What scenes need that are to share one program, whatever their values are.

A program is made for exactly what a scene holds: a tilt of 0 turns nothing, and two walls of one
reflectance have one material. So scenes that differ in values alone may need different programs.
Where each is compiled for what any of them needs there is one, and no bit of any answer changes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from hostcode.program.spec import ProgramSpec
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.surfaces import Surface

__all__ = ["NOTE_WORDS", "Common", "kinds_of"]

NOTE_WORDS = "note_words"
"""The count by which the effect of elements that touch tells how much a ray remembers."""


@dataclass(frozen=True)
class Common:
    """What any of some scenes needs of a program; their objects are of the same kinds.

    Parameters
    ----------
    effects : frozenset of str
        Effects in use.
    axes : tuple of int or None
        World axis that each element's functions are specialised to; None for the general ones.
    several : frozenset of str
        Kernels of surfaces of which a scene has several materials.
    splitting : frozenset of str
        Kernels of surfaces of which one sends rays on as two.
    note_words : int
        Words of what a ray remembers of the faces around it.
    """

    effects: frozenset[str]
    axes: tuple[int | None, ...]
    several: frozenset[str] = frozenset()
    splitting: frozenset[str] = frozenset()
    note_words: int = 0

    @classmethod
    def of(cls, scene: Scene, spec: ProgramSpec, effects: frozenset[str]) -> Self:
        """Return what a scene needs by itself.

        Parameters
        ----------
        scene : Scene
            The scene.
        spec : ProgramSpec
            What its own program is.
        effects : frozenset of str
            Names of the effects in use.
        """
        return cls(
            effects,
            tuple(element.class_axis for element in scene.element),
            frozenset(surface.kind for surface in spec.surfaces if not surface.single),
            frozenset(surface.kind for surface in spec.surfaces if surface.splits),
            max(
                (n for part in spec.parts for k, n in part.parameters if k == NOTE_WORDS), default=0
            ),
        )

    def __or__(self, other: Self) -> Self:
        """Return what both need, of scenes whose objects are of the same kinds."""
        return type(self)(
            self.effects | other.effects,
            tuple(a if a == b else None for a, b in zip(self.axes, other.axes, strict=True)),
            self.several | other.several,
            self.splitting | other.splitting,
            max(self.note_words, other.note_words),
        )


def kinds_of(scene: Scene) -> tuple[str, ...]:
    """Return the kinds of a scene's objects in order: scenes of other kinds share no program."""
    return (
        *(source.kernel for source in scene.source),
        *("/".join((e.kernel, *map(_optics_of, e.surfaces))) for e in scene.element),
    )


def _optics_of(surface: Surface) -> str:
    lobe, coat = surface.lobe, surface.coat
    more = (f"+{lobe.kernel}" if lobe is not None else "", f"&{coat.kernel}" if coat else "")
    return surface.kernel + "".join(more)
