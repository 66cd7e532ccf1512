"""The figure of a page: its scene with the paths of a few rays, by ``photizon show``."""

from __future__ import annotations

import contextlib
import io
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from photizon_cl.cli.main import main
from photizon_docs.emit import as_toml

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

__all__ = ["draw"]

RAYS = 24


def draw(scene: Scene, path: Path) -> None:
    """Draw a scene into a PNG file."""
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.redirect_stdout(io.StringIO()) as printed,
    ):
        file = Path(folder) / "scene.toml"
        file.write_text(as_toml(scene), encoding="utf-8")
        status = main(["show", str(file), "--rays", str(RAYS), "--out", str(path)])
    if status:
        raise RuntimeError(f"photizon show: exit status {status}: {printed.getvalue()}")
