"""The scenes that come with the package, each with the analytic anchor that it pins."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Final

_NAMES: Final = (
    "cosine-fourth",
    "lambertian-sphere",
    "integrating-sphere",
    "ghost-ladder",
    "cpc-concentrator",
    "box-room",
    "plano-convex-condenser",
    "baffled-tube",
    "square-lightpipe",
    "cassegrain",
    "baffled-telescope",
    "absorbing-cuvette",
    "aspheric-condenser",
    "scattering-mirror",
    "dispersing-prism",
    "coated-window",
    "polariscope",
)

_ANCHOR: Final = "Anchor:"


@dataclass(frozen=True)
class Preset:
    """A scene that comes with the package.

    Parameters
    ----------
    name : str
        Name by which `photizon_cl.load` and the command line know it.
    title : str
        One line.
    anchor : str
        The analytic result that it pins: the paragraph of its notes that begins "Anchor:".
    """

    name: str
    title: str
    anchor: str


def preset_names() -> tuple[str, ...]:
    """Return the names of the presets, in the order in which they are listed."""
    return _NAMES


def preset_path(name: str) -> Path:
    """Return the scene file of a preset.

    An installed package holds the files itself; a checkout keeps them in its top-level
    ``presets``.

    Raises
    ------
    KeyError
        If there is no such preset.
    FileNotFoundError
        If the installation lacks its file.
    """
    if name not in _NAMES:
        raise KeyError(name)
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "presets", package.parent / "presets"):
        path = folder / f"{name}.toml"
        if path.is_file():
            return path
    raise FileNotFoundError(f"the file of preset {name} is missing; install photizon-cl again")


def preset(name: str) -> Preset:
    """Return a preset's title and anchor, read from its file."""
    table = tomllib.loads(preset_path(name).read_text(encoding="utf-8"))
    paragraphs = str(table["notes"]).split("\n\n")
    anchor = next(text for text in paragraphs if text.startswith(_ANCHOR))
    return Preset(name, str(table["title"]), " ".join(anchor[len(_ANCHOR) :].split()))


def presets() -> dict[str, Preset]:
    """Return the presets by name, each with its title and the known answer that it pins.

    ``for name in pz.presets(): scene = pz.load(name)``.

    Returns
    -------
    dict of str to Preset
        In the order in which ``photizon presets`` lists them.
    """
    return {name: preset(name) for name in _NAMES}
