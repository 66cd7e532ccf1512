"""The page: everything that a report says, put into its template."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mako.lookup import TemplateLookup
from markupsafe import Markup

from photizon_cl.views.report import story, tables
from photizon_cl.views.report.claims import claims
from photizon_cl.views.report.cost import cost_table
from photizon_cl.views.report.far_field import far_field_tables
from photizon_cl.views.report.numbers import integer
from photizon_cl.views.report.paths import paths_table
from photizon_cl.views.report.spectrum import spectrum_table

if TYPE_CHECKING:
    from photizon_cl.result.cost import CostStudy
    from photizon_cl.result.estimates import Estimates
    from photizon_cl.views.report.figures import Drawing, Figures

__all__ = ["GENERATOR", "lookup", "render"]

GENERATOR: Final = "photizon_cl report"
"""What marks a page as ours: a file without it is not replaced."""

MOST_SCENE: Final = 200_000
"""Characters of the scene that a page shows."""
MOST_DETECTORS: Final = 50
"""Detectors with a section of their own; the table has more of them."""
# The writer gives every item of a list a line; a position is easier to read on one.
_SHORT_LIST: Final = re.compile(r"^(\w+ = )\[\n((?:\s+[-+.\w]+,\n){1,4})\]", re.MULTILINE)
_PLACED: Final = frozenset(
    {
        "layout",
        "ledger",
        "by-wavelength",
        "convergence",
        "cost",
        "map",
        "sigma",
        "ladder",
        "paths",
        "ghosts",
        "far-field",
        "far-field-cuts",
        "far-field-theta",
    }
)
_HERE: Final = Path(__file__).resolve().parent


@cache
def lookup() -> TemplateLookup:
    """Return the templates of this package; every value in them is escaped unless it is markup."""
    return TemplateLookup(
        [str(_HERE)], default_filters=["h"], strict_undefined=True, input_encoding="utf-8"
    )


@dataclass(frozen=True)
class _Section:
    """A detector on the page."""

    name: str
    anchor: str
    map: tables.Table | None
    ladder: tables.Table | None
    paths: tables.Table | None
    figures: list[Drawing]


def render(
    result: Estimates, figures: Figures, recipe: str | None, study: CostStudy | None = None
) -> str:
    """Return the page as text.

    Parameters
    ----------
    result : Estimates
        The result.
    figures : Figures
        Its figures.
    recipe : str or None
        The token that reproduces the run, where the directory holds one.
    study : CostStudy, optional
        What accuracy costs, where it was studied.
    """
    from photizon_cl.scene.writing import to_toml
    from photizon_cl.version import __version__

    scene = _SHORT_LIST.sub(_on_one_line, to_toml(result.scene))
    left = max(len(scene) - MOST_SCENE, 0)
    inside, outside = story.effects_tables(result)
    far = result.far_field
    text: str = (
        lookup()
        .get_template("page.mako")
        .render_unicode(
            generator=f"{GENERATOR} {__version__}",
            style=Markup((_HERE / "style.css").read_text(encoding="utf-8")),
            title=result.scene.heading,
            scene_name=result.scene.name,
            notes=result.scene.notes.strip(),
            converged=result.converged,
            summary=story.summary(result),
            key_figures=story.key_figures(result),
            advisories=[_sentence(text) for text in result.advisories],
            figures=figures,
            ledger=tables.ledger_table(result),
            by_wavelength=spectrum_table(result),
            detectors=tables.detector_table(result) if result.detectors else None,
            sections=_sections(result, figures),
            more_detectors=integer(max(len(result.detectors) - MOST_DETECTORS, 0)),
            far_field=[] if far is None else far_field_tables(far, result.ledger.escaped),
            checks=tables.checks_table(result),
            tallies=tables.tally_tables(result),
            others=[f for f in figures.drawn if f.kind not in _PLACED],
            run=story.run_table(result),
            versions=story.versions_table(),
            recipe=recipe,
            study=study,
            cost=None if study is None else cost_table(study, result.scene.digest()),
            effects=inside,
            left_out=outside,
            claims=claims(result),
            scene=scene[: MOST_SCENE or None],
            scene_left=integer(left) if left else "",
        )
    )
    return text.lstrip()


def _sentence(text: str) -> str:
    """Return text with a capital, unless it begins with a symbol, and a full stop."""
    start = text[:1].upper() if text[:1].isascii() else text[:1]
    return start + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")


def _on_one_line(found: re.Match[str]) -> str:
    return f"{found[1]}[{' '.join(found[2].split()).rstrip(',')}]"


def _sections(result: Estimates, figures: Figures) -> list[_Section]:
    emitted = result.ledger.emitted.value
    found = []
    for n, (name, detector) in enumerate(result.detectors.items()):
        if n == MOST_DETECTORS:
            break
        drawn = figures.of("map", "sigma", "ladder", "paths", "ghosts", element=name)
        m = detector.map
        summed = m and tables.map_table(f"table-map-{n}", name, m, detector.power)
        ladder = tables.ladder_table(f"table-ladder-{n}", name, detector, emitted)
        paths = paths_table(f"table-paths-{n}", name, detector, emitted)
        if summed or ladder or paths or drawn:
            anchor = f"detector-{n}"
            found.append(_Section(name, anchor, summed or None, ladder, paths, drawn))
    return found
