"""Sweep files read: every problem is told, none of them by a run."""

from __future__ import annotations

import difflib
import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from photizon_cl.errors import ArgumentError, Problem, SceneError, join, key, show
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.files import load, read_tables
from photizon_cl.scene.model import Scene
from photizon_cl.scene.parameter_paths import place_of
from photizon_cl.scene.parameters import Name
from photizon_cl.scene.presets import preset_names
from photizon_cl.scene.reader import SCHEMA, RepeatedKeys
from photizon_cl.scene.settings import RunSettings
from photizon_cl.scene.sweep_values import (
    MOST_POINTS,
    SPACINGS,
    is_numeric,
    read_spacing,
    value_text,
)
from photizon_cl.scene.sweeps import RUN_KEYS, SWEEP_SCHEMA, Axis, SweepPlan, grouped

__all__ = ["read_sweep"]

_KEYS: Final = ("schema", "scene", "vary", "run", "measure", "title", "notes")
_VARY_KEYS: Final = ("path", "values", *SPACINGS, "together", "name")
_TAKEN: Final = ("point", "digest", "batches", "rays", "seconds", "stopped")
"""Columns of a sweep's table that are always there."""
_COLUMNS: Final = tuple(
    f"{dot}{end}" for dot in "._" for end in ("sigma", "change", "change_sigma")
)
"""How the names end of what stands beside a measure's values."""


def read_sweep(
    source: str | os.PathLike[str] | Mapping[str, Any], run: Mapping[str, Any] | None = None
) -> SweepPlan:
    """Read a sweep file, or its tables; its points are not looked at.

    Parameters
    ----------
    source : str, path or mapping
        A scene's path in a file is relative to that file; in tables ``scene`` may be a `Scene`, or
        tables, as well.
    run : mapping, optional
        Settings that go before those of the file's ``[run]``.

    Raises
    ------
    SceneError
        With every problem of the file.
    """
    if isinstance(source, Mapping):
        return _Reader(None, Path()).read(_with(source, run))
    if not isinstance(source, str | os.PathLike):
        raise SceneError(
            [Problem("sweep", show(source), "the path of a sweep file, or its tables")]
        )
    path = Path(os.fsdecode(source))
    tables, file = read_tables(path, "a sweep file")
    return _Reader(file, path.parent).read(_with(tables, run))


def _with(tables: Any, run: Mapping[str, Any] | None) -> Any:
    """Return a file's tables with other settings."""
    if not run or not isinstance(tables, Mapping):
        return tables
    own = tables.get("run", {})
    return {**tables, "run": {**own, **run}} if isinstance(own, Mapping) else tables


class _Reader:
    """Reads the tables of a sweep file and collects what is wrong."""

    def __init__(self, file: str | None, folder: Path) -> None:
        self.file, self.folder = file, folder
        self.problems: list[Problem] = []

    def complain(self, path: str, found: str, expected: str, hint: str = "") -> None:
        self.problems.append(Problem(path, found, expected, self.file, hint))

    def done(self) -> None:
        """Raise what was found."""
        if self.problems:
            raise SceneError(replace(p, file=p.file or self.file) for p in self.problems)

    def read(self, tables: object) -> SweepPlan:
        if not isinstance(tables, Mapping):
            self.complain("", show(tables), "a table with schema, scene and vary")
            self.done()
            raise AssertionError
        self.keys(tables, "", _KEYS, "a sweep file")
        self.schema(tables)
        scene = self.scene(tables)
        run = self.run(tables.get("run", {}), scene)
        axes = self.axes(tables.get("vary"))
        measures = self.measures(tables.get("measure", {}), axes)
        texts = {}
        for item in ("title", "notes"):
            texts[item] = tables.get(item, "")
            if not isinstance(texts[item], str):
                self.complain(item, show(texts[item]), "text")
        self.done()
        assert scene is not None
        scene = self.with_run(scene, run)
        axes = self.placed(scene, axes, run)
        self.done()
        return SweepPlan(scene, axes, run, measures, **texts, file=self.file)

    def keys(self, found: Mapping[str, Any], path: str, known: tuple[str, ...], what: str) -> None:
        """Refuse unknown keys, and those that stand twice."""
        if isinstance(found, RepeatedKeys):
            for item in found.repeated:
                self.complain(
                    join(path, key(item)), "the key more than once", "every key once in its object"
                )
        for item in found:
            if item not in known:
                near = difflib.get_close_matches(str(item), known, 1)
                hint = f"did you mean {near[0]}?" if near else ""
                expected = f"no such key; {what} takes {', '.join(known)}"
                self.complain(join(path, key(item)), show(found[item]), expected, hint)

    def schema(self, tables: Mapping[str, Any]) -> None:
        found = tables.get("schema")
        if found != SWEEP_SCHEMA:
            hint = "the key schema is required" if found is None else ""
            if found == SCHEMA:
                hint = "that is a scene: a sweep file names one by its key scene"
            shown = "nothing" if found is None else show(found)
            self.complain("schema", shown, show(SWEEP_SCHEMA), hint)

    def scene(self, tables: Mapping[str, Any]) -> Scene | None:
        given = tables.get("scene")
        expected = "a preset's name, or the path of a scene file beside this one"
        if given is None:
            self.complain("scene", "nothing", expected, "the key scene is required")
            return None
        try:
            if isinstance(given, Scene | Mapping):
                return load(given)
            if not isinstance(given, str) or not given:
                self.complain("scene", show(given), expected)
                return None
            if given in preset_names():
                return load(given)
            path = self.folder / given
            # without an ending and no file it can only be a preset's name that is none
            return load(given if not path.suffix and not os.path.lexists(path) else path)
        except SceneError as error:
            self.problems += [
                p
                if p.file
                else replace(p, path=p.path if p.path == "scene" else join("scene", p.path))
                for p in error.problems
            ]
            return None

    def run(self, given: object, scene: Scene | None) -> dict[str, Any]:
        if not isinstance(given, Mapping):
            self.complain("run", show(given), "a table of settings")
            return {}
        known = (*parameters_of(RunSettings), *RUN_KEYS)
        self.keys(given, "run", known, "the run table of a sweep")
        return {str(k): v for k, v in given.items() if k in known}

    def with_run(self, scene: Scene, run: dict[str, Any]) -> Scene:
        """Return the scene with the sweep's settings; those of `RUN_KEYS` are not a scene's."""
        try:
            return scene.replace({f"run.{k}": v for k, v in run.items() if k not in RUN_KEYS})
        except SceneError as error:
            self.problems += error.problems
            return scene

    # -- what is varied ------------------------------------------------------------------------

    def axes(self, given: object) -> tuple[Axis, ...]:
        if given is None:
            self.complain(
                "vary", "nothing", "at least one [[vary]] table", "the key vary is required"
            )
            return ()
        if isinstance(given, Mapping):
            hint = "write [[vary]] with two brackets"
            self.complain("vary", "a single table", "an array of [[vary]] tables", hint)
            return ()
        if not isinstance(given, list | tuple):
            self.complain("vary", show(given), "an array of [[vary]] tables")
            return ()
        if not given:
            self.complain("vary", "an empty array", "at least one [[vary]] table")
        found = [self.axis(table, f"vary[{n}]", n) for n, table in enumerate(given)]
        axes = tuple(axis for axis in found if axis is not None)
        if len(axes) == len(found) and axes:
            self.lengths(axes)
        return axes

    def axis(self, table: object, where: str, number: int) -> Axis | None:
        before = len(self.problems)
        if not isinstance(table, Mapping):
            self.complain(where, show(table), "a table with path and values")
            return None
        self.keys(table, where, _VARY_KEYS, "a vary table")
        path = table.get("path")
        if not isinstance(path, str) or not path.strip():
            shown = "nothing" if path is None else show(path)
            self.complain(f"{where}.path", shown, 'a parameter\'s path, "source.NAME.KEY" say')
        together = table.get("together", False)
        if not isinstance(together, bool):
            self.complain(f"{where}.together", show(together), "true or false")
        elif together and number == 0:
            hint = "it would step with the vary before, and there is none"
            self.complain(f"{where}.together", "true", "false in the first vary", hint)
        name = path
        if "name" in table:
            name = Name().read(table["name"], f"{where}.name", self.problems)
        ways = [k for k in ("values", *SPACINGS) if k in table]
        values: list[Any] | None = None
        if len(ways) != 1:
            hint = "one of them says what the parameter is set to"
            shown = " and ".join(ways) or "nothing"
            self.complain(where, shown, "values, linspace or logspace", hint)
        elif ways[0] == "values":
            values = self.listed(table["values"], f"{where}.values")
        else:
            values = read_spacing(ways[0], table[ways[0]], f"{where}.{ways[0]}", self.problems)
        if len(self.problems) > before or values is None:
            return None
        assert isinstance(path, str)
        return Axis(path, str(name), tuple(values), together)

    def listed(self, found: object, where: str) -> list[Any] | None:
        to_list = getattr(found, "tolist", None)  # a numpy array
        listed = to_list() if callable(to_list) else found
        if not isinstance(listed, list | tuple):
            self.complain(where, show(found), "a list of values")
            return None
        if not listed:
            self.complain(where, "an empty list", "at least one value")
            return None
        return list(listed)

    def lengths(self, axes: tuple[Axis, ...]) -> None:
        """Check how many points there are, and that none is there twice."""
        groups = grouped(axes)
        number = 0
        for group in groups:
            first = group[0]
            for offset, axis in enumerate(group[1:], 1):
                if len(axis.values) != len(first.values):
                    self.complain(
                        f"vary[{number + offset}]",
                        f"{len(axis.values)} values",
                        f"{len(first.values)}, as {first.path} has, with which it steps together",
                    )
                    return
            if len(first.values) <= MOST_POINTS:
                self.different(group, number)
            number += len(group)
        n = math.prod(len(group[0].values) for group in groups)
        if n > MOST_POINTS:
            parts = " × ".join(str(len(group[0].values)) for group in groups)
            shown = f"{n} points" + (f" ({parts})" if len(groups) > 1 else "")
            hint = "each is a run of its own"
            self.complain("vary", shown, f"at most {MOST_POINTS} points", hint)

    def different(self, group: tuple[Axis, ...], number: int) -> None:
        seen: dict[tuple[Any, ...], int] = {}
        for at, values in enumerate(zip(*(axis.values for axis in group), strict=True)):
            told = tuple(v if is_numeric([v]) else value_text(v) for v in values)
            if told in seen:
                shown = ", ".join(show(value) for value in values)
                self.complain(
                    f"vary[{number}].values[{at}]",
                    f"{shown} twice",
                    "every value once",
                    f"values[{seen[told]}] is the same, and so would be its points",
                )
                return
            seen[told] = at

    def placed(
        self, scene: Scene, axes: tuple[Axis, ...], run: Mapping[str, Any]
    ) -> tuple[Axis, ...]:
        """Return the axes with their units; refuse paths that lead nowhere, or to one place."""
        tables = scene.to_dict()
        places: list[tuple[str | int, ...] | None] = []
        found = []
        for n, axis in enumerate(axes):
            where = f"vary[{n}].path"
            try:
                place, unit = place_of(Scene, tables, axis.path)
            except ArgumentError as error:
                what, _, expected = str(error).partition(", expected ")
                shown = what.rpartition("found ")[2]
                told = (
                    show(axis.path) if shown == show(axis.path) else f"{show(axis.path)}: {shown}"
                )
                self.complain(where, told, expected)
                places.append(None)
                found.append(axis)
                continue
            for other, before in enumerate(places):
                if before is not None and (place[: len(before)] == before or
                                           before[: len(place)] == place):  # fmt: skip
                    self.complain(
                        where, show(axis.path), "a parameter that no other vary changes",
                        f"vary[{other}] changes {axes[other].path}",
                    )  # fmt: skip
                    break
            if place[0] == "run" and run and (len(place) == 1 or place[1] in run):
                some = "some of it" if len(place) == 1 else place[1]
                hint = f"the sweep's [run] sets {some} for all points"
                self.complain(where, show(axis.path), "a parameter that [run] does not set", hint)
            places.append(place)
            found.append(replace(axis, unit=unit))
        return tuple(found)

    # -- what is measured ----------------------------------------------------------------------

    def measures(self, given: object, axes: tuple[Axis, ...]) -> dict[str, Any]:
        if not isinstance(given, Mapping):
            self.complain("measure", show(given), "a table of measures by name")
            return {}
        self.keys(given, "measure", tuple(given), "")
        taken: dict[str, str] = {name: "a column of every sweep" for name in _TAKEN}
        for n, axis in enumerate(axes):
            if axis.name in taken:
                hint = f"{taken[axis.name]} is called so"
                self.complain(f"vary[{n}].name", show(axis.name), "a name of its own", hint)
            taken[axis.name] = f"vary[{n}]"
        found: dict[str, Any] = {}
        for given_name, value in given.items():
            where = join("measure", key(given_name))
            name = Name().read(given_name, where, self.problems)
            if not isinstance(name, str):
                continue
            for column in (name, *(f"{name}{end}" for end in _COLUMNS)):
                if column in taken:
                    what = "a name of its own"
                    if column != name:
                        what = f"a name beside which {show(column)} is free"
                    hint = f"{taken[column]} is called so"
                    self.complain(where, show(given_name), what, hint)
                    break
            found[name] = value
            taken |= {f"{name}{end}": f"a column of {where}" for end in _COLUMNS}
            taken[name] = where
        return found
