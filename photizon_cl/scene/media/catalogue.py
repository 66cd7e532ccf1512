"""Glasses by name, from the catalogues of their makers.

What is read are the files of refractiveindex.info (M. N. Polyanskiy, Scientific Data 11, 94, 2024;
in the public domain by CC0 1.0), which took them from the makers' own. They come with the Python
package ``refractiveindex`` (MIT), an optional extra: none of its code runs, as it would compute
powers by the platform's library, which differs between machines.
"""

from __future__ import annotations

import difflib
from decimal import Decimal
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import declare
from photizon_cl.scene.limits import MOST_CHARACTERS
from photizon_cl.scene.media.dispersion import Dispersion, IndexTable, Polynomial, Sellmeier
from photizon_cl.scene.parameters import Name, Parameter

__all__ = ["Glass", "glass_name", "glasses", "known_glass"]

_PACKAGE: Final = "refractiveindex"
_MOST_NAMED: Final = 6


class Glass(Name):
    """The name of a glass of a catalogue, with its maker before it where several have one."""

    needs_spectrum = True

    @property
    def expected(self) -> str:  # noqa: D102
        return 'the name of a glass, such as "N-BK7" or "SCHOTT N-BK7"'

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        # as it is copied from a list
        return super().read(value.strip() if isinstance(value, str) else value, path, problems)


def glass_name(meaning: str) -> dict[str, Parameter]:
    """Declare the name of a glass."""
    return declare(Glass(meaning))


@cache
def glasses() -> dict[str, tuple[tuple[str, Path], ...]]:
    """Return the makers that have a glass, and its file with each, by its name in capitals.

    Empty where the catalogue is not installed.
    """
    spec = find_spec(_PACKAGE)
    found: dict[str, list[tuple[str, Path]]] = {}
    for home in (spec.submodule_search_locations or ()) if spec else ():
        data = Path(home) / "database" / "data" / "specs"
        for file in sorted(data.glob("*/optical/*.yml")):
            maker = file.parent.parent.name.upper()
            found.setdefault(file.stem.upper(), []).append((maker, file))
    return {name: tuple(files) for name, files in found.items()}


def known_glass(name: str) -> Dispersion | Problem:
    """Return how the index of a glass depends on wavelength; else what is wrong with its name."""
    known = glasses()
    if not known:
        hint = "pip install 'photizon-cl[glass]' brings it; or give its dispersion"
        return Problem("glass", show(name), "a catalogue that is installed", hint=hint)
    asked = name.upper()
    maker, _, rest = asked.partition(" ")
    files = known.get(asked) or tuple(f for f in known.get(rest, ()) if f[0] == maker)
    if len(files) == 1:
        return _read(files[0][1])
    if files:
        some = " or ".join(show(f"{maker} {name}") for maker, _ in files)
        hint = "several makers have one of that name"
        return Problem("glass", show(name), some, hint=hint)
    near = []
    if len(asked) <= MOST_CHARACTERS:
        near = difflib.get_close_matches(rest or asked, list(known), _MOST_NAMED)
        # BK7 is N-BK7 sooner than K7
        near.sort(key=lambda name: not name.lower().endswith(f"-{(rest or asked).lower()}"))
    hint = f"did you mean {' or '.join(map(show, near))}?" if near else ""
    return Problem("glass", show(name), f"one of the {len(known)} glasses there are", hint=hint)


@cache
def _read(file: Path) -> Dispersion | Problem:
    """Return the dispersion in a file of the catalogue; a problem where it is none known here."""
    import yaml

    with file.open(encoding="utf-8") as text:
        entries = yaml.load(text, Loader=yaml.BaseLoader)["DATA"]
    for entry in entries:
        kind = entry["type"]
        if kind in ("formula 2", "formula 3"):
            first, *others = map(float, entry["coefficients"].split())
            pairs = tuple(zip(others[::2], others[1::2], strict=True))
            low, high = map(_nanometres, entry["wavelength_range"].split())
            values, places = ([pair[k] for pair in pairs] for k in (0, 1))
            if kind == "formula 2":  # 1 + first + Σ B λ²/(λ² − C)
                if first:
                    values, places = [first, *values], [0.0, *places]
                return Sellmeier(B=values, C_um2=places, range_nm=(low, high))
            powers = [0, *(int(place) for place in places)]
            return Polynomial(coefficients=[first, *values], powers=powers, range_nm=(low, high))
        if kind == "tabulated n":
            rows = [line.split() for line in entry["data"].splitlines() if line.strip()]
            nodes = sorted((_nanometres(um), float(index)) for um, index in rows)
            return IndexTable(
                wavelength_nm=[nm for nm, _ in nodes], index=[index for _, index in nodes]
            )
    expected = "a glass whose index is given by a formula known here"
    return Problem("glass", show(file.stem), expected)


def _nanometres(um: str) -> float:
    return float(Decimal(um) * 1000)
