from __future__ import annotations

import inspect

import pytest

import photizon_cl as pz

NAMES = sorted(pz._MODULE_OF)


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_resolves_to_its_module(name):
    value = getattr(pz, name)
    if inspect.ismodule(value):
        assert value.__name__ == pz._MODULE_OF[name] == f"photizon_cl.{name}"
        return
    assert value.__name__ == name
    assert value.__module__ == pz._MODULE_OF[name]
    assert inspect.getdoc(value)


def test_table_and_all_agree():
    assert sorted(pz.__all__) == sorted(["__version__", *pz._MODULE_OF])
    assert set(pz.__all__) <= set(dir(pz))


def test_no_public_name_is_also_a_submodule():
    # Importing a submodule binds its name in the package, over whatever stood there.
    for name, module in pz._MODULE_OF.items():
        assert not module.startswith(f"photizon_cl.{name}") or inspect.ismodule(getattr(pz, name))


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="has no attribute 'Prism'"):
        pz.Prism  # noqa: B018


def test_importing_touches_no_opencl_and_little_else(run_python):
    code = """
import sys
import photizon_cl as pz
heavy = {"pyopencl", "numpy", "mako", "matplotlib", "xarray", "rich"} & set(sys.modules)
assert not heavy, heavy
assert pz.__version__
pz.Scene, pz.load, pz.Rectangle, pz.Fresnel
assert "pyopencl" not in sys.modules
"""
    run_python(code)
