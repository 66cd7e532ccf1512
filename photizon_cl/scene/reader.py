"""From the tables of a scene file to a `Scene`, reporting every problem in one pass."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final, TypeVar

from photizon_cl.errors import MOST_PROBLEMS, Problem, SceneError, join, key, show
from photizon_cl.scene.coatings import Coating
from photizon_cl.scene.described import (
    Described,
    Known,
    Nested,
    NestedList,
    is_required,
    parameters_of,
)
from photizon_cl.scene.elements import Element
from photizon_cl.scene.media.medium import Medium
from photizon_cl.scene.names import similar
from photizon_cl.scene.parameters import BAD
from photizon_cl.scene.registry import COATINGS, ELEMENTS, SCATTERS, SOURCES, SURFACES
from photizon_cl.scene.scatters import Scatter
from photizon_cl.scene.sources import Source
from photizon_cl.scene.surfaces import Surface

KINDS: Final[dict[type[Described], Mapping[str, type[Described]]]] = {
    Element: ELEMENTS,
    Source: SOURCES,
    Surface: SURFACES,
    Scatter: SCATTERS,
    Coating: COATINGS,
}
"""Classes by the kind that a table names, for each base that has kinds."""

SCHEMA: Final = "photizon/1"
"""The version of the format."""

_MISSING: Final = "nothing"
_NONE: Final[Mapping[str, str]] = MappingProxyType({})
_D = TypeVar("_D", bound=Described)


class RepeatedKeys(dict[str, Any]):
    """A JSON object in which a key stood more than once.

    Parameters
    ----------
    pairs : list of tuple
        The object's members as they stand in the file.
    """

    def __init__(self, pairs: Sequence[tuple[str, Any]]) -> None:
        super().__init__(pairs)
        times = Counter(name for name, _ in pairs)
        self.repeated = [name for name in self if times[name] > 1]


def read_scene(cls: type[_D], tables: object, file: str | None = None) -> _D:
    """Build a scene from the tables of a file.

    Parameters
    ----------
    cls : type
        The class of the scene.
    tables : mapping
        As parsed from TOML or JSON, or written by hand.
    file : str, optional
        Name for messages.

    Raises
    ------
    SceneError
        With every problem of the scene.
    """
    reader = _Reader()
    scene = reader.scene(cls, tables)
    if reader.problems or scene is None:
        raise SceneError(replace(problem, file=file) for problem in reader.problems)
    return scene


def _title(cls: type[Described]) -> str:
    """Name a class as the subject of a sentence."""
    if cls.kind in ("", cls.label):
        return f"every {cls.label}" if cls in KINDS else f"the {cls.label} table"
    return f"the {cls.label} {cls.kind}"


class _Reader:
    """Walks the tables and collects problems; what it cannot read it leaves out and goes on."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []

    def complain(self, path: str, found: str, expected: str, hint: str = "") -> None:
        self.problems.append(Problem(path, found, expected, hint=hint))

    @property
    def full(self) -> bool:
        """Whether so much is wrong that what follows is not looked at."""
        return len(self.problems) > MOST_PROBLEMS

    def scene(self, cls: type[_D], tables: object) -> _D | None:
        if not isinstance(tables, Mapping):
            self.complain("", show(tables), "a table with schema, name and source")
            return None
        self.repeats(tables, "")
        self.schema(tables)
        values: dict[str, Any] = {}
        built: dict[str, Any] = {}
        accepted = ("schema", *parameters_of(cls))
        absent = self.unknown(tables, "", accepted, "a scene file")
        for item, parameter in parameters_of(cls).items():
            if item not in tables:
                if is_required(cls, item) and item not in absent:
                    what = (
                        "at least one [[source]] table" if item == "source" else parameter.expected
                    )
                    self.complain(item, _MISSING, what, f"the key {item} is required")
                continue
            found = tables[item]
            if isinstance(parameter, NestedList):
                built[item], values[item] = self.array(parameter.base, found, item, parameter.least)
            elif isinstance(parameter, Nested):
                built[item], values[item] = self.table(parameter.base, found, item)
            else:
                built[item] = values[item] = parameter.read(found, item, self.problems)
        self.problems += cls.cross_check(Known(cls, values))
        return None if self.problems else cls(**built)

    def schema(self, tables: Mapping[str, Any]) -> None:
        found = tables.get("schema")
        if "schema" not in tables:
            self.complain("schema", _MISSING, show(SCHEMA), "the key schema is required")
        elif found != SCHEMA or not isinstance(found, str):
            self.complain(
                "schema", show(found), show(SCHEMA), "the version of the format that is read here"
            )

    def array(
        self, base: type[_D], found: object, path: str, least: int
    ) -> tuple[tuple[_D | None, ...], tuple[Known | None, ...]]:
        """Read an array of tables."""
        expected = f"an array of [[{path}]] tables"
        if isinstance(found, Mapping):
            self.complain(path, "a single table", expected, f"write [[{path}]] with two brackets")
            return (), ()
        if isinstance(found, str | bytes) or not isinstance(found, Sequence):
            self.complain(path, show(found), expected)
            return (), ()
        if len(found) < least:
            self.complain(path, "an empty array", f"at least one [[{path}]] table")
        pairs = []
        for i, item in enumerate(found):
            if self.full:
                break
            pairs.append(self.table(base, item, f"{path}[{i}]"))
        return tuple(pair[0] for pair in pairs), tuple(pair[1] for pair in pairs)

    def table(self, base: type[_D], found: object, path: str) -> tuple[_D | None, Known | None]:
        """Read one object; return it, or None, and what is known of it, or None."""
        if not isinstance(found, Mapping):
            hint = (
                f"write {{ kind = {show(found)} }}"
                if isinstance(found, str) and found in KINDS.get(base, ())
                else ""
            )
            self.complain(path, show(found), f"a table for the {base.label}", hint)
            return None, None
        self.repeats(found, path)
        before = len(self.problems)
        cls: type[Described] | None = base
        if base in KINDS:
            cls = self.kind(base, found, path)
        # Without a kind, the keys that all kinds share are still read; others cannot be judged.
        built, values = self.fields(cls or base, found, path, judge_unknown=cls is not None)
        known = Known(cls or base, values)
        if cls is not None:
            self.problems += [problem.under(path) for problem in cls.cross_check(known)]
        self.own(before, base, found)
        if len(self.problems) > before or cls is None:
            return None, known
        item = cls(**built)
        assert isinstance(item, base)  # the tables of kinds hold subclasses of base
        return item, known

    def kind(
        self, base: type[Described], found: Mapping[str, Any], path: str
    ) -> type[Described] | None:
        kinds, kind = KINDS[base], found.get("kind")
        if isinstance(kind, str) and kind in kinds:
            return kinds[kind]
        options = "one of " + " ".join(show(kind) for kind in kinds)
        where = join(path, "kind")
        if "kind" not in found:
            close = self.meant("kind", found, ())
            self.complain(where, _MISSING, options, f"the key kind is required{close}")
            return None
        hint = ""
        if isinstance(kind, str):
            near = similar(kind, kinds)
            hint = f"did you mean {show(near[0])}?" if near else ""
        self.complain(where, show(kind), options, hint)
        return None

    def fields(
        self, cls: type[Described], found: Mapping[str, Any], path: str, *, judge_unknown: bool
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Read the declared parameters; return the values to build with, and what is known."""
        kinded = any(issubclass(cls, base) for base in KINDS)
        accepted = (("kind",) if kinded else ()) + tuple(parameters_of(cls))
        title = _title(cls)
        absent = (
            self.unknown(found, path, accepted, title, cls.foreseen) if judge_unknown else set()
        )
        built: dict[str, Any] = {}
        known: dict[str, Any] = {}
        for item, parameter in parameters_of(cls).items():
            where = join(path, item)
            if item not in found:
                if not is_required(cls, item):
                    known[item] = None
                elif item not in absent:
                    self.complain(
                        where, _MISSING, parameter.expected, f"{title} requires the key {item}"
                    )
            elif isinstance(parameter, Nested):
                built[item], known[item] = self.table(parameter.base, found[item], where)
                if known[item] is None:
                    del known[item]
            else:
                value = parameter.read(found[item], where, self.problems)
                if value is not BAD:
                    built[item] = known[item] = value
        return built, known

    def unknown(
        self,
        found: Mapping[str, Any],
        path: str,
        accepted: Sequence[str],
        title: str,
        foreseen: Mapping[str, str] = _NONE,
    ) -> set[str]:
        """Report unknown keys; return the required keys that they were probably meant for."""
        meant: set[str] = set()
        for item in found:
            if item in accepted:
                continue
            if self.full:
                break
            near = [] if item in foreseen else similar(item, accepted)
            hint = f"did you mean {near[0]}?" if near else foreseen.get(item, "")
            meant.update(near)
            expected = f"no such key; {title} takes {', '.join(accepted)}"
            self.complain(join(path, key(item)), show(found[item]), expected, hint)
        return meant

    def meant(self, wanted: str, found: Mapping[str, Any], accepted: Sequence[str]) -> str:
        others = [str(k) for k in list(found)[:MOST_PROBLEMS] if k not in accepted]
        near = difflib.get_close_matches(wanted, others, 1)
        return f"; is {key(near[0])} meant for it?" if near else ""

    def repeats(self, found: Mapping[str, Any], path: str) -> None:
        if isinstance(found, RepeatedKeys):
            for item in found.repeated[: MOST_PROBLEMS + 1]:
                where = join(path, key(item))
                self.complain(where, "the key more than once", "every key once in its object")

    def own(self, before: int, base: type[Described], found: Mapping[str, Any]) -> None:
        """Put an object's name on its problems, as people count by names."""
        name = found.get("name")
        if base not in (Element, Source, Medium) or not isinstance(name, str):
            return
        self.problems[before:] = [
            replace(problem, owner=f"{base.label} {show(name)}")
            for problem in self.problems[before:]
        ]
