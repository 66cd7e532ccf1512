"""The kinds of the registry that a program is made for: those of a scene, or more."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.scene.registry import COATINGS, ELEMENTS, SCATTERS, SOURCES, SURFACES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.coatings import Coating
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.scatters import Scatter
    from photizon_cl.scene.sources import Source
    from photizon_cl.scene.surfaces import Surface

__all__ = ["ALL_KINDS", "Kinds"]

_GROUPS: Final[tuple[Mapping[str, type[Any]], ...]] = (
    SOURCES,
    ELEMENTS,
    SURFACES,
    SCATTERS,
    COATINGS,
)

ALL_KINDS: Final[Mapping[str, type[Any]]] = MappingProxyType(
    {f"{cls.label}.{kind}": cls for group in _GROUPS for kind, cls in group.items()}
)
"""Every kind of source, element, surface, scatter and coating, by ``group.kind``."""


@dataclass(frozen=True)
class Kinds:
    """What is compiled in of each group, each class once.

    Parameters
    ----------
    sources, elements, surfaces, scatters, coatings : tuple of type
        The classes.
    n_elements : int
        Elements of the scene.
    general : bool
        Whether no use is made of there being one of something, or few elements.
    """

    sources: tuple[type[Source], ...]
    elements: tuple[type[Element], ...]
    surfaces: tuple[type[Surface], ...]
    scatters: tuple[type[Scatter], ...]
    coatings: tuple[type[Coating], ...]
    n_elements: int
    general: bool = False

    @classmethod
    def of(cls, scene: Scene, force: frozenset[str] = frozenset(), *, general: bool) -> Kinds:
        """Return the kinds of a scene, and those that are forced on by ``group.kind``."""
        more = [kind for name, kind in ALL_KINDS.items() if name in force]

        def group(label: str, used: list[type[Any]]) -> tuple[type[Any], ...]:
            return tuple(dict.fromkeys([*used, *(kind for kind in more if kind.label == label)]))

        return cls(
            group("source", [type(s) for s in scene.source]),
            group("element", [type(e) for e in scene.element]),
            group("surface", [type(s) for e in scene.element for s in e.surfaces]),
            group(
                "scatter",
                [type(s.lobe) for e in scene.element for s in e.surfaces if s.lobe is not None],
            ),
            group(
                "coating",
                [type(c) for e in scene.element for s in e.surfaces if (c := s.coat) is not None],
            ),
            len(scene.element),
            general,
        )

    def few(self, most: int) -> bool:
        """Say whether a program may make use of there being at most so many elements."""
        return self.n_elements <= most and not self.general
