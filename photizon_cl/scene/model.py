"""The scene: what is simulated, validated and immutable."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final

from photizon_cl.errors import Problem, printable, show
from photizon_cl.scene.declarations import declare, free_text, unique_name
from photizon_cl.scene.described import (
    REQUIRED,
    Accepts,
    Described,
    Known,
    Nested,
    NestedList,
    parameters_of,
)
from photizon_cl.scene.elements import Element
from photizon_cl.scene.far_field import FarField
from photizon_cl.scene.importance import Importance, targets_of
from photizon_cl.scene.media.medium import Medium
from photizon_cl.scene.media.names import VACUUM, media_of
from photizon_cl.scene.parameter_paths import put_values
from photizon_cl.scene.polarisation import unasked
from photizon_cl.scene.reader import SCHEMA, read_scene
from photizon_cl.scene.settings import RunSettings
from photizon_cl.scene.sources import Source
from photizon_cl.scene.spectral import spectral_problems
from photizon_cl.scene.spectrum import Spectrum
from photizon_cl.scene.writing import save_scene

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping, Sequence

    from photizon_cl.scene.names import ByName
    from photizon_cl.scene.surfaces import Surface

__all__ = ["SCHEMA", "FarField", "RunSettings", "Scene", "between_objects", "same_stream"]

_LABELS: Final = ("name", "title", "notes")
_FLOOR: Final = 1e-9
"""The automatic roulette floor where rays split."""
_WHEN_TO_STOP: Final = ("target_sigma", "target_on", "max_seconds")
_NO_ELEMENTS: Final[Any] = ()
_NO_MEDIA: Final[Any] = ()


@dataclass(frozen=True, repr=False)
class Scene(Described):
    """Sources, elements, and how to run them.

    Parameters
    ----------
    name : str
        Short name.
    source : sequence of Source
        At least one; names unique; a share in all of them or in none. Kept as a tuple whose items
        are found by name as well: ``scene.source["lamp"]``.
    element : sequence of Element, optional
        Names unique; found by name as well. Their order decides between faces of equal rank in one
        place.
    run : RunSettings, optional
        How the scene is run by default.
    far_field : FarField, optional
        Bins for what escapes; None bins nothing.
    importance : Importance, optional
        Where scattered rays are sent more often; None sends them as their surfaces do.
    title : str, optional
        One line for people.
    notes : str, optional
        Free text.
    medium : sequence of Medium, optional
        What bodies are made of, by names that surfaces and sources call; found by name as well.
    spectrum : Spectrum, optional
        The wavelengths of its light; None where nothing depends on wavelength.

    Raises
    ------
    SceneError
        With every problem found.
    """

    label: ClassVar[str] = ""

    name: str = field(metadata=unique_name("short name"))
    source: Accepts[Sequence[Source], ByName[Source]] = field(
        default=REQUIRED, metadata=declare(NestedList(Source, 1, meaning="where rays start"))
    )
    element: Accepts[Sequence[Element], ByName[Element]] = field(
        default=_NO_ELEMENTS, metadata=declare(NestedList(Element, 0, meaning="what they can hit"))
    )
    run: RunSettings = field(
        default_factory=RunSettings,
        metadata=declare(
            Nested(RunSettings, "the settings of a", meaning="how it is run by default")
        ),
    )
    far_field: FarField | None = field(
        default=None, metadata=declare(Nested(FarField, meaning="bins for what escapes"))
    )
    importance: Importance | None = field(
        default=None,
        metadata=declare(
            Nested(Importance, "the", meaning="where scattered rays are sent more often")
        ),
    )
    title: str = field(default="", metadata=free_text("one line for people"))
    notes: str = field(default="", metadata=free_text("free text"))
    medium: Accepts[Sequence[Medium], ByName[Medium]] = field(
        default=_NO_MEDIA,
        metadata=declare(NestedList(Medium, 0, meaning="what is in bodies and around them")),
    )
    spectrum: Spectrum | None = field(
        default=None,
        metadata=declare(Nested(Spectrum, meaning="the wavelengths of its light")),
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check names and shares across sources and elements, and what is named elsewhere."""
        elements = known.get("element") or ()
        sources, media = known.get("source") or (), known.get(Medium.label) or ()
        problems = between_objects(sources, elements)
        problems += _duplicates(Medium.label, media)
        problems += media_of(media, source=sources, element=elements)
        problems += spectral_problems(known, ("source", "element", Medium.label))
        problems += unasked(known.get(RunSettings.label), sources)
        return problems + targets_of(known.get(Importance.label), elements)

    @property
    def heading(self) -> str:
        """Title, or name without one, fit to be shown beside other text: see `printable`."""
        return printable(" ".join(self.title.split()) or self.name)

    def __repr__(self) -> str:
        n, m = len(self.source), len(self.element)
        return (
            f"<photizon_cl.Scene {self.name!r}: {n} source{'s' * (n != 1)}, "
            f"{m} element{'s' * (m != 1)}>"
        )

    def replace(self, changes: Mapping[str, object]) -> Scene:
        """Return the scene with other values; this one stays as it is.

        Parameters
        ----------
        changes : mapping of str to object
            Values by path: ``run.KEY``, ``far_field.KEY``, ``source.NAME.KEY``,
            ``element.NAME.KEY``, ``element.NAME.surface.KEY``, ``medium.NAME.KEY``, with ``[i]``
            for a component and quotes around a name that has other characters than letters,
            digits, ``-`` and ``_``:
            ``element."wall -x".surface.reflectance``. A value is what a scene file would hold
            there, or an object such as ``pz.Mirror(0.9)``; None takes away what may be absent.

        Raises
        ------
        ArgumentError
            Where a path leads nowhere.
        SceneError
            With every problem of the scene that it would be.
        """
        tables = self.to_dict()
        put_values(Scene, tables, changes)
        return read_scene(Scene, tables)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene file, in one step; a file of that name is replaced.

        Parameters
        ----------
        path : str or path
            A ``.toml`` or ``.json`` file. `photizon_cl.load` reads back an equal scene.

        Raises
        ------
        ArgumentError
            Where the path ends otherwise or cannot be written.
        """
        save_scene(self, path)

    def to_dict(self) -> dict[str, Any]:
        """Return the scene as the file format's tables, which `photizon_cl.load` reads back.

        Every default is written out; what is absent (far field, detector, share, zero tilt) stays
        absent.
        """
        out: dict[str, Any] = {"schema": SCHEMA, "name": self.name}
        for item in ("title", "notes"):
            if getattr(self, item):
                out[item] = getattr(self, item)
        out["run"] = self.run.to_table()
        for item, parameter in parameters_of(Scene).items():
            value = getattr(self, item)
            if type(parameter) is Nested and item not in out and value is not None:
                out[item] = value.to_table()
        if self.medium:
            out[Medium.label] = [medium.to_table() for medium in self.medium]
        out["source"] = [source.to_table() for source in self.source]
        if self.element:
            out["element"] = [element.to_table() for element in self.element]
        return out

    def roulette_floor(self, run: RunSettings | None = None) -> float:
        """Return the floor of these settings, default `self.run`, in this scene, as a number."""
        floor = (run or self.run).roulette_floor
        if floor != "auto":
            return floor
        return _FLOOR if self.splits(run) else 0.0

    @property
    def wavelengths(self) -> tuple[float | None, ...]:
        """Wavelengths in nm of lines, or middles of bands; a single None without a spectrum."""
        return (None,) if self.spectrum is None else self.spectrum.middles_nm

    @property
    def reference_nm(self) -> float | None:
        """The wavelength in nm at which a single number is told; None without a spectrum."""
        return None if self.spectrum is None else self.wavelengths[self.spectrum.reference]

    @property
    def fewest_rays(self) -> int:
        """Rays of a batch at least: one of each source, and of each line in which it has power."""
        n = len(self.wavelengths)
        return sum(n if s.spectrum is None else sum(map(bool, s.spectrum)) for s in self.source)

    @property
    def ray_needs(self) -> str:
        """What has one ray of a batch at least, for messages."""
        if self.spectrum is None:
            return "source"
        return f"{self.spectrum.word} of a source that has power"

    def index_of(self, nm: float | None) -> dict[str, float]:
        """Return refractive indices of the media by name, the vacuum's among them.

        Parameters
        ----------
        nm : float or None
            Wavelength in nanometres; None without a spectrum.
        """
        return {VACUUM: 1.0, **{medium.name: medium.index_at(nm) for medium in self.medium}}

    def optics_at(self, nm: float | None) -> dict[Surface, Surface]:
        """Return the elements' surfaces, each with numbers for media and tables over wavelength.

        Parameters
        ----------
        nm : float or None
            Wavelength in nanometres; None without a spectrum.
        """
        index_of = self.index_of(nm)
        return {s: s.among(index_of).at(nm) for element in self.element for s in element.surfaces}

    @cached_property
    def optics(self) -> dict[Surface, Surface]:
        """`optics_at` the one wavelength that stands for all."""
        return self.optics_at(self.reference_nm)

    @property
    def names_media(self) -> bool:
        """Whether there is any medium by name, other than the vacuum around it all."""
        return bool(self.medium) or any(
            s.media is not None for e in self.element for s in e.surfaces
        )

    @property
    def splitter(self) -> Element | None:
        """The first element whose surface makes two rays of one; None where there is none."""
        return next((e for e in self.element if any(s.branches for s in e.surfaces)), None)

    @property
    def scatters(self) -> bool:
        """Whether any surface sends a ray on in a direction drawn from a density."""
        return any(s.scatters or s.lobe is not None for e in self.element for s in e.surfaces)

    @property
    def polarises(self) -> bool:
        """Whether any surface sends on more or less of light for how that is polarised."""
        return any(s.polarises for e in self.element for s in e.surfaces)

    def splits(self, run: RunSettings | None = None) -> bool:
        """Say whether rays go on as two in this scene, run so; default `self.run`."""
        return (run or self.run).splitting and self.splitter is not None

    def digest(self) -> str:
        """Return ``sha256:…`` over what determines the stream and the rows of its results.

        Included: every source and element with its name, in file order, the far-field bins, and
        of ``[run]`` seed, rays_per_batch, generation_cap, roulette_floor, the effects that it
        asks for and, where a surface splits, that rays do not. Left out: name, title, notes, and
        target_sigma, target_on and max_seconds, which only decide when to stop. Defaults count as
        written out, an automatic floor as the number that it is; floats enter by their exact
        hexadecimal value.
        """
        table = {k: v for k, v in self.to_dict().items() if k not in _LABELS}
        table["run"] = {k: v for k, v in table["run"].items() if k not in _WHEN_TO_STOP}
        table["run"]["roulette_floor"] = self.roulette_floor()
        if self.splitter is None:  # then it decides nothing
            table["run"].pop("splitting", None)
        text = json.dumps(
            _canonical(table), sort_keys=True, separators=(",", ":"), ensure_ascii=True
        )
        return "sha256:" + hashlib.sha256(text.encode("ascii")).hexdigest()


def same_stream(a: Scene, b: Scene) -> bool:
    """Say whether two scenes as run launch the very same rays and tally them in the same rows.

    Their batches of the same number are then equal. When to stop may differ.
    """
    return a.digest() == b.digest()  # the seed is part of it


def between_objects(
    sources: Sequence[Known | None], elements: Sequence[Known | None]
) -> list[Problem]:
    """Return the problems between a scene's objects: names used twice, shares given by some.

    Parameters
    ----------
    sources, elements : sequence of Known or None
        In file order; None where an entry could not be read at all.
    """
    problems = _duplicates("source", sources) + _duplicates("element", elements)
    given = [i for i, known in enumerate(sources) if known and known.get("share") is not None]
    if given:
        for i, known in enumerate(sources):
            # A share that was refused is absent from the values: it has its own problem already.
            if known and "share" in known.values and known.get("share") is None:
                hint = f"source[{given[0]}] gives one: a share is given by all sources or by none"
                problems.append(Problem(f"source[{i}].share", "nothing", "a share", hint=hint))
    return problems


def _duplicates(label: str, objects: Sequence[Known | None]) -> list[Problem]:
    first: dict[str, int] = {}
    problems = []
    for i, known in enumerate(objects):
        used = known.get("name") if known else None
        if used is None:
            continue
        if used in first:
            expected = f"a name that no other {label} has"
            hint = f"{label}[{first[used]}] has it already"
            problems.append(Problem(f"{label}[{i}].name", show(used), expected, hint=hint))
        else:
            first[used] = i
    return problems


def _canonical(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _canonical(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_canonical(v) for v in value]
    return value.hex() if isinstance(value, float) else value
