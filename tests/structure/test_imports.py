"""Data goes one way: a folder imports only what is named for it here, and nothing goes in circles.

Imports in functions count, and so do those for type checkers, which say who knows whose types.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from import_graph import PACKAGES, cycle, folder, imports, violations

ROOT = Path(__file__).resolve().parents[2]

BASE = "errors atomic version"
"""Modules of photizon_cl that all of it may use."""
HOST_BASE = "errors assets templates"
"""The same of hostcode."""

# In the order in which a scene goes through them: each imports only from those above it.
PRODUCT = {
    "scene": "",
    "geometry": "scene",
    "checks": "scene geometry",
    "compile": "scene geometry checks",
    "result": "scene geometry checks compile",
    "views": "scene geometry checks compile result",
    "run": "scene geometry checks compile result views",
    "studies": "scene geometry checks compile result views run",
    "stability": "scene geometry checks compile result views run",
    "cli": "scene geometry checks compile result views run studies stability",
}

# hostcode never imports photizon_cl.
HOST = {
    "device": "",
    "program": "device",
    "run": "device program",
}

# What of the device's side is known outside it; where nothing stands, nothing is.
ACROSS = {
    "checks": "program",
    "compile": "errors program run",
    "result": "assets program run",
    "run": "errors device program run",
    "studies": "errors device program run",
    "stability": "device program run",
    "cli": "errors device",
}


def table():
    allowed = {"photizon_cl.errors": set(), "photizon_cl.atomic": set()}
    allowed["photizon_cl"] = {f"photizon_cl.{name}" for name in (*BASE.split(), *PRODUCT)}
    allowed["photizon_cl.__main__"] = {"photizon_cl.cli"}
    for name, others in PRODUCT.items():
        allowed[f"photizon_cl.{name}"] = {
            *(f"photizon_cl.{other}" for other in (*BASE.split(), *others.split())),
            *(f"hostcode.{other}" for other in ACROSS.get(name, "").split()),
        }
    allowed["hostcode.assets"] = {"hostcode.errors"}
    allowed["hostcode.templates"] = {"hostcode.errors", "hostcode.assets"}
    for name, others in HOST.items():
        allowed[f"hostcode.{name}"] = {
            f"hostcode.{other}" for other in (*HOST_BASE.split(), *others.split())
        }
    return allowed


@pytest.fixture(scope="module")
def found():
    return imports(ROOT)


def test_each_folder_imports_only_what_is_named_for_it(found):
    wrong = violations(found, table())
    assert not wrong, "\n".join(["", *wrong])


def test_no_module_imports_itself_in_a_circle(found):
    assert not cycle(found), " imports ".join(reversed(cycle(found)))


def test_the_table_names_what_there_is_and_what_is_used(found):
    there = {folder(item.source) for item in found} | {folder(item.target) for item in found}
    folders = {
        f"{package}.{path.name}"
        for package in PACKAGES
        for path in (ROOT / package).iterdir()
        if any(path.glob("*.py"))
    }
    assert folders == {name for name in table() if name.count(".") and name in folders}
    assert there <= {*table(), *(f"photizon_cl.{n}" for n in BASE.split()), "hostcode.errors"}
    used = {(folder(item.source), folder(item.target)) for item in found}
    across = {(f"photizon_cl.{a}", f"hostcode.{b}") for a in ACROSS for b in ACROSS[a].split()}
    assert across <= used


# -- the test itself -------------------------------------------------------------------------------


@pytest.fixture
def made_up(tmp_path):
    """Return a function that writes a small product and gives its imports."""

    def write(**files):
        for name, text in files.items():
            path = tmp_path / name.replace("__", "/")
            path = path.with_suffix(".py")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return imports(tmp_path)

    return write


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("from photizon_cl.run.result import Result\n", 1),
        ("import os\nimport photizon_cl.run.result\n", 2),
        ("def late():\n    from photizon_cl.run import result\n", 2),
        ("class A:\n    def late(self):\n        if 1:\n            import photizon_cl.run\n", 4),
        ("if TYPE_CHECKING:\n    from photizon_cl.run.result import Result\n", 2),
        ("try:\n    from ..run import result\nexcept ImportError:\n    pass\n", 2),
        ("import photizon_cl as pz\n", 1),
        ("import hostcode.run.tally\n", 1),
    ],
)
def test_a_violation_is_told_with_its_place(text, line, made_up):
    found = made_up(photizon_cl__scene__model=text, photizon_cl__run__result="class Result: ...\n")
    (said,) = violations(found, table())
    assert said.startswith(f"photizon_cl/scene/model.py:{line}: photizon_cl.scene may not import")


def test_what_is_allowed_is_not_told(made_up):
    found = made_up(
        photizon_cl__run__result="from photizon_cl.scene.model import Scene\nimport os\n",
        photizon_cl__scene__model="from photizon_cl.scene import frames\n",
        photizon_cl__scene__frames="import hostcodes.other\n",
    )
    assert len(found) == 2
    assert not violations(found, table())
    assert not cycle(found)


def test_a_new_folder_is_told(made_up):
    (said,) = violations(made_up(photizon_cl__new__a="import photizon_cl.scene\n"), table())
    assert "photizon_cl.new is not in the table" in said


@pytest.mark.parametrize(
    ("first", "second", "circle"),
    [
        ("from photizon_cl.scene.b import x\n", "def f():\n    import photizon_cl.scene.a\n", True),
        ("from photizon_cl.scene import b\n", "from photizon_cl.scene import a\n", True),
        (
            "from photizon_cl.scene import b\n",
            "if TYPE_CHECKING:\n    from photizon_cl.scene import a\n",
            False,
        ),
        (
            "from photizon_cl.scene import b\n",
            "if not TYPE_CHECKING:\n    from photizon_cl.scene import a\n",
            True,
        ),
    ],
)
def test_circles_are_found(first, second, circle, made_up):
    found = made_up(photizon_cl__scene__a=first, photizon_cl__scene__b=second)
    assert bool(cycle(found)) == circle
    assert not circle or set(cycle(found)) == {"photizon_cl.scene.a", "photizon_cl.scene.b"}
