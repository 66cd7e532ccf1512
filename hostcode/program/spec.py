"""What the text of a program depends on.

`ProgramSpec` names everything: the lane width, the element classes, surfaces, sources, tallies and
effects in use, the fields of a ray, and a few counts. Two scenes with equal specs share a program;
parameters live in buffers and do not recompile anything.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from hostcode.program.fields import BASE_ENDING, BASE_HIT, BASE_RAY
from hostcode.program.parts import EffectParts, Strides

if TYPE_CHECKING:
    from hostcode.program.fields import EndingField, HitField, RayField
    from hostcode.program.parts import ElementClass, SourceKind, SurfaceKind, TallyForm

__all__ = [
    "CACHED_BYTES",
    "CACHE_LINE",
    "MAX_REGISTER_ELEMENTS",
    "PLAIN_PARTS",
    "PROBE_STAGES",
    "TALLY_STAGES",
    "ProgramSpec",
]

PROBE_STAGES: Final = ("probe",)
"""Stages of the program that searches for faces and does nothing else."""
TALLY_STAGES: Final = ("tally",)
"""Stages of the program that counts endings."""
_GIVEN_RAYS: Final = frozenset({"probe", "follow"})
"""Stages that are given their rays, and keep no ledger."""
MAX_REGISTER_ELEMENTS: Final = 8
"""Up to this many elements the ledger is kept in registers."""
PLAIN_PARTS: Final = ("geometry", "tally")
"""What kernels have a short way for: roots and Fresnel's forms without what is compensated, weights
that are counted to 2^-31 only."""
CACHE_LINE: Final = 64
"""Bytes of a cache line."""
CACHED_BYTES: Final = 1 << 20
"""How much of a scene's tables is taken to stay in a core's cache: its second level, measured."""


@dataclass(frozen=True)
class ProgramSpec:
    """Everything that the text of a program depends on."""

    classes: tuple[ElementClass, ...]
    surfaces: tuple[SurfaceKind, ...]
    sources: tuple[SourceKind, ...]
    forms: tuple[TallyForm, ...]
    """Forms of the detectors' tallies."""
    effects: frozenset[str]
    """Names that templates ask for."""
    parts: tuple[EffectParts, ...]
    """What the effects in use bring, in order."""
    columns: tuple[tuple[str, int], ...]
    """Names of the tables' columns as the kernels have them, and their places in a row."""
    strides: Strides
    ledger: tuple[str, ...]
    """Rows of the ledger behind the elements'."""
    n_elements: int
    """Number of elements where the ledger is kept in registers, else 0."""
    real: str = "double"
    """C type of lengths and directions: ``double`` or ``float``."""
    weight: str = "double"
    """C type of weights: that, or ``double``."""
    plain: frozenset[str] = frozenset()
    """Parts of the arithmetic that are done the short way, some of `PLAIN_PARTS`: for a study of
    what care costs, and never for an answer."""
    lanes: int = 1
    packets: int = 1
    """Packets of so many lanes that a work-item keeps at once."""
    cached_bytes: int = 0
    """With a tree: how much of the scene's tables stays in a core's cache."""
    interleaved: bool = False
    private_tallies: bool = False
    stages: tuple[str, ...] = ("wave",)
    books: bool = True
    """Whether a ledger is kept."""

    def for_device(
        self,
        lanes: int,
        stages: tuple[str, ...],
        *,
        interleaved: bool = False,
        private_tallies: bool = False,
        cached_bytes: int = CACHED_BYTES,
    ) -> ProgramSpec:
        """Return the spec with what a device and a composition add.

        What the stages make no use of is left out, so that more scenes share a program.

        `lanes` is how many rays a work-item holds at once: in the lanes of one packet, or, where
        each is searched for by itself, in as many packets of one lane.
        """
        one_by_one = self.one_by_one
        launches = books = bool(set(stages) - _GIVEN_RAYS)
        probes = stages == PROBE_STAGES
        return replace(
            self,
            sources=self.sources if launches else (),
            surfaces=() if probes and not self.orders else self.surfaces,
            forms=() if probes else self.forms,
            ledger=() if probes else self.ledger,
            n_elements=self.n_elements if books else 0,
            books=books,
            lanes=1 if one_by_one else lanes,
            packets=lanes if one_by_one else 1,
            cached_bytes=cached_bytes if one_by_one and lanes > 1 else 0,
            stages=stages,
            interleaved=interleaved,
            private_tallies=private_tallies,
        )

    def for_tally(self) -> ProgramSpec:
        """Return what the program that counts endings depends on, given a device's spec.

        Nothing of elements, surfaces or sources, so that scenes which count in the same way share
        it.
        """
        parts = tuple(part.for_tally() for part in self.parts)
        return replace(
            self,
            classes=(),
            surfaces=(),
            sources=(),
            effects=frozenset(),
            parts=tuple(part for part in parts if part != EffectParts()),
            columns=(),
            strides=Strides(),
            ledger=(),
            n_elements=0,
            lanes=1,
            packets=1,
            cached_bytes=0,
            interleaved=False,
            stages=TALLY_STAGES,
        )

    @property
    def launches(self) -> bool:
        """Whether rays come from sources."""
        return bool(self.sources)

    @property
    def splits(self) -> bool:
        """Whether rays go on as two."""
        return any(part.splits for part in self.parts)

    @property
    def extras(self) -> int:
        """Rays that may go on beside two."""
        return sum(part.extras for part in self.parts) if self.splits else 0

    @property
    def children(self) -> int:
        """Rays that may go on beside one."""
        return 1 + self.extras if self.splits else 0

    @property
    def pairs(self) -> bool:
        """Whether a surface may give two rays, whether or not both go on."""
        asked = self.splits or any(part.pairs for part in self.parts)
        return asked or any(surface.splits for surface in self.surfaces)

    @property
    def events(self) -> bool:
        """Whether it is asked what happened to the rays that surfaces send on."""
        return any(part.events for part in self.parts)

    @property
    def keyed(self) -> bool:
        """Whether cells are kept by key."""
        return any(part.keyed for part in self.parts)

    @property
    def passes(self) -> bool:
        """Whether there are surfaces that a ray passes as if nothing were there."""
        return any(not surface.counts for surface in self.surfaces)

    @property
    def one_by_one(self) -> bool:
        """Whether each ray is searched for by itself."""
        return any(part.one_by_one for part in self.parts)

    @property
    def orders(self) -> bool:
        """Whether a second search puts faces in one place in order."""
        return any(part.orders for part in self.parts)

    @property
    def ends(self) -> bool:
        """Whether a ray may end between two faces."""
        return any(part.ends for part in self.parts)

    @property
    def densities(self) -> bool:
        """Whether surfaces are asked for the density of what they scatter."""
        return any(part.densities for part in self.parts)

    @property
    def coats(self) -> bool:
        """Whether what surfaces reflect and let pass may be a coating's."""
        return any(part.coats for part in self.parts)

    @property
    def amplitudes(self) -> bool:
        """Whether surfaces are asked by what amplitudes they send on polarised light."""
        return any(part.amplitudes for part in self.parts)

    @property
    def recorded(self) -> frozenset[str]:
        """What is recorded for the tally stage."""
        return frozenset(what for part in self.parts for what in part.records)

    @property
    def records(self) -> bool:
        """Whether anything is recorded for the tally stage."""
        return bool(self.recorded)

    @property
    def ray_fields(self) -> tuple[RayField, ...]:
        """What a ray carries; what several effects bring, once."""
        return BASE_RAY + tuple(dict.fromkeys(field for part in self.parts for field in part.ray))

    @property
    def hit_fields(self) -> tuple[HitField, ...]:
        """What a search gives."""
        return BASE_HIT + tuple(field for part in self.parts for field in part.hit)

    @property
    def ending_fields(self) -> tuple[EndingField, ...]:
        """What a record holds."""
        return BASE_ENDING + tuple(field for part in self.parts for field in part.ending)

    @property
    def launch_members(self) -> tuple[tuple[str, str, str], ...]:
        """What effects add to the launch structure."""
        return tuple(member for part in self.parts for member in part.launch)
