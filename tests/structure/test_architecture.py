"""What docs/architecture.md and CONTRIBUTING.md name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("docs/architecture.md", "CONTRIBUTING.md", "docs/add-a-kind.md", "CHANGELOG.md")
MADE_BY_THE_PAGE = {"phong", "retroreflector", "bounces"}


@pytest.mark.parametrize("page", PAGES)
def test_every_path_exists(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    named = set(
        re.findall(r"\b(?:photizon_cl|hostcode|kernels|tests|benchmarks|docs)/[\w/.-]*\w", text)
    )
    assert named
    named = {p for p in named if Path(p).stem not in MADE_BY_THE_PAGE}
    missing = [p for p in named if not (ROOT / p).exists()]
    assert not missing


def test_every_function_of_the_walks_exists():
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    walks = text[text.index("## A ray's weight") : text.index("## Where a contract")]
    code = "".join(
        path.read_text(encoding="utf-8")
        for folder in ("photizon_cl", "hostcode", "kernels")
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".py", ".mako")
    )
    names = set(re.findall(r"`([A-Za-z_]+)`", walks)) - {"reflectance"}
    assert {"share_rays", "shade", "survive", "interact", "Accumulator"} <= names
    made = {"MIRROR_REFLECTANCE"}  # by `Row.constants`
    missing = {
        n for n in names - made if not re.search(rf"(def|class|FN \w+|\b){n}\b\s*[(:=]", code)
    }
    assert not missing
