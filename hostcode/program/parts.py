"""What a program is made of: the kinds that a scene has, and what its effects bring.

Each is a value that compares by its content, so that two scenes which need the same text are known
to need the same program (`hostcode.program.spec.ProgramSpec`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hostcode.program.fields import EndingField, HitField, RayField

__all__ = ["EffectParts", "ElementClass", "SourceKind", "Strides", "SurfaceKind", "TallyForm"]


@dataclass(frozen=True)
class ElementClass:
    """Elements that one intersection function serves.

    Parameters
    ----------
    kind : str
        Stem of the kernel file in ``kernels/elements``.
    templates : tuple of str
        Kernel templates that are rendered for each class, in order, its own file among them.
    libraries : tuple of str
        Kernel templates that its own need before them, rendered once a program.
    flat : bool
        Whether it lies in a plane: then a hit near its edge is moved onto it.
    faced : bool
        Whether its functions work in the element's own frame, and know several faces.
    axis : int or None
        World axis (0, 1, 2) of the normal; None where it is tilted or has no meaning.
    opening : bool
        Whether a part of it is cut out.
    traits : frozenset of str
        What else its templates ask for.
    single : bool
        Whether the scene has just one element of the class, and its functions make use of that.
    number : int
        Its place in the class table.
    """

    kind: str
    templates: tuple[str, ...]
    libraries: tuple[str, ...]
    flat: bool
    faced: bool
    axis: int | None
    opening: bool = False
    traits: frozenset[str] = frozenset()
    single: bool = False
    number: int = 0

    @property
    def suffix(self) -> str:
        """Suffix of its functions."""
        turned = "_tilted" if self.axis is None else f"_{'xyz'[self.axis]}"
        return self.kind + (turned if self.flat else "") + ("_open" if self.opening else "")


@dataclass(frozen=True)
class SurfaceKind:
    """A surface kind in use.

    Parameters
    ----------
    kind : str
        Stem of its kernel file.
    number : int
        Its number in the codes.
    single : bool
        Whether all its elements have one row of the material table, of every line the same.
    absorbs : bool
        Whether what it does not send on is absorbed by the element; else it sends on everything.
    splits : bool
        Whether a ray may go on as two.
    counts : bool
        Whether meeting it is an interaction; else a ray passes as if nothing were there.
    refracts : bool
        Whether it is the border of two media.
    scatters : bool
        Whether a ray goes on in a direction drawn from a density that its file has.
    libraries : tuple of str
        Kernel templates that its file needs before it, rendered once a program.
    """

    kind: str
    number: int
    single: bool
    absorbs: bool = True
    splits: bool = False
    counts: bool = True
    refracts: bool = False
    scatters: bool = False
    libraries: tuple[str, ...] = ()


@dataclass(frozen=True)
class SourceKind:
    """A source kind in use.

    Parameters
    ----------
    stem : str
        Of its kernel file.
    option : str
        What its kernel is rendered with, a suffix of its function; empty where there is one.
    number : int
        Its number in the source table.
    draws_position : bool
        Whether it draws where rays start.
    libraries : tuple of str
        Kernel templates that its file needs before it, rendered once a program.
    """

    stem: str
    option: str
    number: int
    draws_position: bool
    libraries: tuple[str, ...] = ()

    @property
    def suffix(self) -> str:
        """Suffix of its function."""
        return f"{self.stem}_{self.option}" if self.option else self.stem


@dataclass(frozen=True)
class TallyForm:
    """What detectors count by: the filters of a tally in order, the first changing fastest.

    Parameters
    ----------
    filters : tuple of (str, str)
        Stem of each filter's kernel file, and the option that it is rendered with.
    """

    filters: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Strides:
    """Lengths of the tables' rows, and where in an element's and a source's its frame stands.

    They follow from the kinds in use. An element's row is a whole number of cache lines.
    """

    row: int = 24
    row_frame: int = 15
    material: int = 0
    source: int = 0
    source_frame: int = 0


@dataclass(frozen=True)
class EffectParts:
    """What an effect brings to a program.

    Parameters
    ----------
    effect : str
        Its name, for messages; `photizon_cl.compile.compiled.compile_scene` writes it.
    ray : tuple of RayField
        Numbers that a ray carries because of it.
    hit : tuple of HitField
        Numbers that a search gives because of it.
    ending : tuple of EndingField
        Numbers that are recorded because of it.
    templates : tuple of (str, str)
        Place in the program, one of `hostcode.program.source.PLACES`, and kernel template:
        its path below ``kernels/`` without the suffix.
    libraries : tuple of str
        Kernel templates that those need before them (``lib/powers``), rendered once a program.
    hooks : tuple of (str, str)
        Place in an interaction, one of `hostcode.program.source.HOOKS`, and the C statement there;
        kernels/lib/interaction.mako lists the variables in its scope.
    launch : tuple of (str, str, str)
        Members of the launch structure: name, C type, meaning.
    records : tuple of str
        What is recorded for the tally stage, some of `hostcode.program.source.RECORDS`.
    splits : bool
        Whether rays go on as two.
    extras : int
        Rays that it sends on beside those two, where they go on as two (``extra_t`` in
        kernels/lib/event.mako).
    pairs : bool
        Whether it looks at the second ray that a surface gives.
    events : bool
        Whether it asks what happened to the rays that a surface sends on (kernels/lib/event.mako).
    keyed : bool
        Whether it keeps cells by key (kernels/lib/keyed.mako).
    one_by_one : bool
        Whether each ray is searched for by itself, so that packets have one lane.
    orders : bool
        Whether a second search puts faces in one place in order (kernels/lib/nearest.mako).
    ends : bool
        Whether its statements at ``travel`` may end a ray on its way.
    densities : bool
        Whether it asks surfaces for the density of what they scatter.
    coats : bool
        Whether surfaces ask it what they reflect and let pass (``coat`` in
        kernels/effects/coatings.mako).
    amplitudes : bool
        Whether it asks surfaces by what amplitudes they send on light polarised along s and p.
    parameters : tuple of (str, int)
        Counts that the templates ask for.
    """

    effect: str = ""
    ray: tuple[RayField, ...] = ()
    hit: tuple[HitField, ...] = ()
    ending: tuple[EndingField, ...] = ()
    templates: tuple[tuple[str, str], ...] = ()
    libraries: tuple[str, ...] = ()
    hooks: tuple[tuple[str, str], ...] = ()
    launch: tuple[tuple[str, str, str], ...] = ()
    records: tuple[str, ...] = ()
    splits: bool = False
    extras: int = 0
    pairs: bool = False
    events: bool = False
    keyed: bool = False
    one_by_one: bool = False
    orders: bool = False
    ends: bool = False
    densities: bool = False
    coats: bool = False
    amplitudes: bool = False
    parameters: tuple[tuple[str, int], ...] = ()

    def for_tally(self) -> EffectParts:
        """Return what of it concerns the program that counts endings."""
        templates = tuple(entry for entry in self.templates if entry[0] == "tally")
        hooks = tuple(entry for entry in self.hooks if entry[0] == "arrival")
        mine = EffectParts(
            ending=self.ending, launch=self.launch, records=self.records, keyed=self.keyed
        )
        if not (templates or hooks):
            return mine
        return replace(
            mine,
            effect=self.effect,
            templates=templates,
            hooks=hooks,
            libraries=self.libraries,
            parameters=self.parameters,
        )
