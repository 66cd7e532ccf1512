"""A scene written as the shortest text that gives it back: TOML for a file, Python for code."""

from __future__ import annotations

from typing import Any

from photizon_cl.scene.described import Described, parameters_of, shown_default
from photizon_cl.scene.model import SCHEMA, Scene

__all__ = ["as_python", "as_toml"]

_WIDTH = 88


def _given(item: Described) -> dict[str, Any]:
    """Return the parameters that differ from their defaults, objects after numbers."""
    given = {
        name: getattr(item, name)
        for name in parameters_of(type(item))
        if getattr(item, name) not in (None, shown_default(type(item), name))
    }
    return dict(sorted(given.items(), key=lambda entry: isinstance(entry[1], Described)))


def as_toml(scene: Scene) -> str:
    """Return a scene file without the defaults."""
    lines = [f'schema = "{SCHEMA}"', f"name = {_toml(scene.name)}"]
    lines += [f"{key} = {_toml(getattr(scene, key))}" for key in ("title",) if scene.title]
    for label in ("far_field", "importance", "spectrum"):
        if getattr(scene, label) is not None:
            lines += ["", f"[{label}]", *_entries(getattr(scene, label))]
    if _given(scene.run):
        lines += ["", "[run]", *_entries(scene.run)]
    groups = (("medium", scene.medium), ("source", scene.source), ("element", scene.element))
    for label, objects in groups:
        for item in objects:
            lines += ["", f"[[{label}]]", *_entries(item)]
    return "\n".join(lines) + "\n"


def _entries(item: Described) -> list[str]:
    given = _given(item)
    head = {"name": given.pop("name")} if "name" in given else {}
    if item.kind and item.kind != item.label:
        head["kind"] = item.kind
    return [f"{key} = {_toml(value)}" for key, value in {**head, **given}.items()]


def _toml(value: Any) -> str:
    if isinstance(value, Described):
        inner = ", ".join(_entries(value))
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(value)


def as_python(scene: Scene) -> str:
    """Return the call that builds a scene, with the package imported as ``pz``."""
    return "scene = " + _call(scene, 0) + "\n"


def _call(item: Described, depth: int) -> str:
    name = f"pz.{type(item).__name__}"
    arguments = [f"{key}={_python(value, depth + 1)}" for key, value in _given(item).items()]
    short = f"{name}({', '.join(arguments)})"
    if "\n" not in short and len(short) + 4 * depth < _WIDTH:
        return short
    inner = "    " * (depth + 1)
    return f"{name}(\n" + "".join(f"{inner}{a},\n" for a in arguments) + "    " * depth + ")"


def _python(value: Any, depth: int) -> str:
    if isinstance(value, Described):
        return _call(value, depth)
    if isinstance(value, tuple) and any(isinstance(item, Described) for item in value):
        inner = "    " * (depth + 1)
        items = "".join(f"{inner}{_call(item, depth + 1)},\n" for item in value)
        return f"[\n{items}" + "    " * depth + "]"
    if isinstance(value, tuple):
        return "[" + ", ".join(map(repr, value)) + "]"
    if isinstance(value, str):
        return f'"{value}"'
    return repr(value)
