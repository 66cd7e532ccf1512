"""A scene as the text of a file."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import reason, replacing
from photizon_cl.errors import ArgumentError, show
from photizon_cl.scene.sweep_values import plain_value

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

__all__ = ["SUFFIXES", "save_scene", "to_json", "to_toml"]

SUFFIXES: Final = (".toml", ".json")
"""How the names of scene files end."""


def to_toml(scene: Scene) -> str:
    """Return the scene as the text of a TOML file; `load` reads back an equal scene."""
    import tomli_w

    # Multi-line strings would turn carriage returns into line feeds.
    multiline = "\r" not in scene.notes + scene.title
    return tomli_w.dumps(scene.to_dict(), multiline_strings=multiline)


def to_json(scene: Scene) -> str:
    """Return the scene as the text of a JSON file; `load` reads back an equal scene."""
    tables = plain_value(scene.to_dict())
    return json.dumps(tables, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def save_scene(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write a scene file, see `photizon_cl.Scene.save`."""
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise ArgumentError(f"path: found {show(path)}, expected the path of a file") from None
    shown = show(str(file))
    if file.suffix.lower() not in SUFFIXES:
        raise ArgumentError(
            f"path: found {shown}, expected a file that ends in {' or '.join(SUFFIXES)} (the "
            "ending says which of the two it is)"
        )
    text = to_toml(scene) if file.suffix.lower() == ".toml" else to_json(scene)
    try:
        if file.is_dir():
            raise ArgumentError(f"path: found {shown}, expected a file (it is a directory)")
        # through a link, so that the file that it leads to is the one that changes
        with replacing(file.resolve()) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")
    except (OSError, ValueError) as error:
        if isinstance(error, ArgumentError):
            raise
        raise ArgumentError(f"path: {shown} cannot be written ({reason(error)})") from None
