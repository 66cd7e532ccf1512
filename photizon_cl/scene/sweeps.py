"""Sweeps: a scene, and values for some of its parameters.

::

    schema = "photizon-sweep/1"
    scene = "tube.toml"

    [[vary]]
    path = "source.sun.tilt_deg[0]"
    linspace = [0, 60, 61]

    [measure]
    PST = { pst = "sensor", source = "sun" }

Several ``[[vary]]`` make a grid, the last one changing fastest; one with ``together = true`` steps
with the one before. `photizon_cl.scene.sweep_reader` checks the file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import show
from photizon_cl.scene.sweep_values import is_numeric, plain_value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.model import Scene

__all__ = ["RUN_KEYS", "SWEEP_SCHEMA", "Axis", "SweepPlan", "grouped"]

SWEEP_SCHEMA: Final = "photizon-sweep/1"
RUN_KEYS: Final = ("batches", "precision")
"""What a sweep's ``[run]`` takes beside the keys of a scene's."""


@dataclass(frozen=True)
class Axis:
    """A parameter that a sweep varies.

    Parameters
    ----------
    path : str
        Of the parameter, see `photizon_cl.Scene.replace`.
    name : str
        What its column and its dimension are called; by default the path.
    values : tuple
        What it is set to, in order.
    together : bool
        Whether it steps with the axis before.
    unit : str
        Of the parameter, empty for a pure number.
    """

    path: str
    name: str
    values: tuple[Any, ...]
    together: bool = False
    unit: str = ""

    @property
    def numeric(self) -> bool:
        """Whether all values are numbers."""
        return is_numeric(list(self.values))

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{self.name}, {self.unit}" if self.unit else self.name


@dataclass(frozen=True)
class SweepPlan:
    """What a sweep is to run: a scene, axes, overrides and measures, all checked but the points.

    Parameters
    ----------
    scene : Scene
        With the sweep's ``[run]``.
    axes : tuple of Axis
        In the order of the file.
    run : mapping
        The overrides as given, by key.
    measures : mapping
        What is measured, by name, as the file has it; empty for every scalar.
    title, notes : str
        For people.
    file : str or None
        Name for messages.
    """

    scene: Scene
    axes: tuple[Axis, ...]
    run: Mapping[str, Any] = field(default_factory=dict)
    measures: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""
    notes: str = ""
    file: str | None = None

    @property
    def groups(self) -> tuple[tuple[Axis, ...], ...]:
        """Axes that step together; each group is a dimension, the last one changes fastest."""
        return grouped(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Values along each dimension."""
        return tuple(len(group[0].values) for group in self.groups)

    @property
    def heading(self) -> str:
        """Title, or that of the scene."""
        return self.title or self.scene.heading

    def __len__(self) -> int:
        return math.prod(self.shape)

    def index(self, point: int) -> tuple[int, ...]:
        """Return the place of a point along each dimension."""
        found = []
        for n in reversed(self.shape):
            point, at = divmod(point, n)
            found.append(at)
        return tuple(reversed(found))

    def values(self, point: int) -> tuple[Any, ...]:
        """Return a point's values in the order of the axes."""
        pairs = zip(self.groups, self.index(point), strict=True)
        return tuple(axis.values[at] for group, at in pairs for axis in group)

    def said(self, point: int) -> str:
        """Return a point's values in words."""
        pairs = zip(self.axes, self.values(point), strict=True)
        return ", ".join(f"{axis.name} = {show(value)}" for axis, value in pairs)

    def scene_at(self, point: int) -> Scene:
        """Return the scene of a point.

        Raises
        ------
        ArgumentError, SceneError
            Where it is none.
        """
        pairs = zip(self.axes, self.values(point), strict=True)
        return self.scene.replace({axis.path: value for axis, value in pairs})

    def given(self, setting: str) -> Any:
        """Return a setting of ``[run]`` that the sweep gives, None where it leaves it."""
        return self.run.get(setting)

    def to_dict(self) -> dict[str, Any]:
        """Return the sweep as a file that holds its scene, which `read_sweep` reads back."""
        vary = []
        for axis in self.axes:
            table = {"path": axis.path, "values": plain_value(list(axis.values))}
            table |= {"name": axis.name} if axis.name != axis.path else {}
            vary.append(table | ({"together": True} if axis.together else {}))
        out: dict[str, Any] = {"schema": SWEEP_SCHEMA}
        out |= {k: v for k, v in (("title", self.title), ("notes", self.notes)) if v}
        out |= {"scene": plain_value(self.scene.to_dict()), "vary": vary}
        out |= {"run": plain_value(dict(self.run))} if self.run else {}
        return out | ({"measure": plain_value(dict(self.measures))} if self.measures else {})


def grouped(axes: tuple[Axis, ...]) -> tuple[tuple[Axis, ...], ...]:
    """Return the axes that step together."""
    found: list[list[Axis]] = []
    for axis in axes:
        if axis.together:
            found[-1].append(axis)
        else:
            found.append([axis])
    return tuple(map(tuple, found))
