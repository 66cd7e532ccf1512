from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

import photizon_cl as pz
from photizon_cl.scene.registry import CLASSES

MODULE_OF = pz._MODULE_OF | {name: cls.__module__ for name, cls in CLASSES.items()}


@pytest.mark.parametrize("name", sorted(MODULE_OF))
def test_every_public_name_resolves_to_its_module(name):
    value = getattr(pz, name)
    assert value.__name__ == name
    assert value.__module__ == MODULE_OF[name]
    assert inspect.getdoc(value)


@pytest.mark.parametrize("name", sorted(pz._MODULES))
def test_public_modules(name):
    assert getattr(pz, name).__name__ == pz._MODULES[name]


def test_tables_and_all_agree():
    assert pz.__all__ == sorted(["__version__", *MODULE_OF, *pz._MODULES])
    assert len(MODULE_OF) == len(pz._MODULE_OF) + len(CLASSES)  # no kind hides another name
    assert set(pz.__all__) <= set(dir(pz))


def test_a_kind_is_public_by_its_row_in_the_registry(run_python):
    code = """
from photizon_cl import *
from photizon_cl.scene.registry import ELEMENTS, SOURCES, SURFACES
import photizon_cl as pz
for group in (ELEMENTS, SOURCES, SURFACES):
    for cls in group.values():
        assert globals()[cls.__name__] is getattr(pz, cls.__name__) is cls
assert trace is pz.trace and figures is pz.figures
"""
    run_python(code)


def test_no_public_name_is_also_a_submodule():
    # Importing a submodule binds its name in the package, over whatever stood there.
    for module in [*MODULE_OF.values(), *pz._MODULES.values()]:
        assert module.split(".")[1] not in pz.__all__


@pytest.mark.parametrize("name", ["Prism", "prism", "_private", "__wrapped__"])
def test_unknown_names_are_attribute_errors(name):
    with pytest.raises(AttributeError, match=f"has no attribute '{name}'"):
        getattr(pz, name)


def test_importing_touches_no_opencl_and_little_else(run_python):
    code = """
import sys
import photizon_cl as pz
own = {name for name in sys.modules if name.startswith(("photizon_cl", "hostcode"))}
assert own == {"photizon_cl", "photizon_cl.version"}, own
heavy = {"pyopencl", "numpy", "mako", "matplotlib", "xarray", "rich"} & set(sys.modules)
assert not heavy, heavy
assert pz.__version__
assert not hasattr(pz, "prism")
assert "photizon_cl.scene.registry" not in sys.modules
pz.Scene, pz.load, pz.Rectangle, pz.Fresnel
assert "pyopencl" not in sys.modules
"""
    run_python(code)


TYPED = """
import photizon_cl as pz
from photizon_cl import Disk, Result

reveal_type(pz.Rectangle)
reveal_type(pz.trace("box-room").refine(batches=2))
reveal_type(pz.advisories)
reveal_type(Disk)
x: Result = pz.open_result("x")
pz.Rectangle(name=1)
pz.Prism
"""


@pytest.mark.slow
def test_type_checkers_see_every_class(tmp_path):
    file = tmp_path / "typed.py"
    file.write_text(TYPED)
    command = ["-m", "mypy", "--strict", "--ignore-missing-imports", "--cache-dir", tmp_path / "c"]
    done = subprocess.run(
        [sys.executable, *map(str, command), "--config-file=", str(file)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    said = [line.partition("typed.py:")[2] for line in done.stdout.splitlines() if "typed" in line]
    revealed = [line for line in said if "Revealed" in line]
    for line, wanted in zip(
        revealed,
        ["elements.rectangle.Rectangle", "run.result.Result", "-> list[str]", "elements.disk.Disk"],
        strict=True,
    ):
        assert wanted in line
    errors = [line for line in said if "error:" in line]
    assert all(line.startswith(("10:", "11:")) for line in errors), errors
    assert any('"name" to "Rectangle" has incompatible type "int"' in line for line in errors)
    assert any('Module has no attribute "Prism"' in line for line in errors)
