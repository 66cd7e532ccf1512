from __future__ import annotations

import pickle

import pytest

from hostcode import assets
from hostcode.errors import DeviceError, HostError, KernelBuildError


def test_kernels_are_found_with_their_stages():
    assert (assets.kernels_dir() / "stages" / "selftest.mako").is_file()
    assert (assets.kernels_dir() / "prelude.mako").is_file()
    assert assets.kernels_dir().is_absolute()


def test_missing_kernels_say_where_was_looked(monkeypatch, tmp_path):
    monkeypatch.setattr(assets, "__file__", str(tmp_path / "hostcode" / "assets.py"))
    with pytest.raises(HostError, match=r"looked for stages/ in .*install photizon-cl again"):
        assets.kernels_dir.__wrapped__()


def test_the_package_comes_before_the_checkout(monkeypatch, tmp_path):
    for place in (tmp_path / "hostcode" / "kernels", tmp_path / "kernels"):
        (place / "stages").mkdir(parents=True)
    monkeypatch.setattr(assets, "__file__", str(tmp_path / "hostcode" / "assets.py"))
    assert assets.kernels_dir.__wrapped__() == tmp_path / "hostcode" / "kernels"


def test_build_error_names_template_and_line():
    error = KernelBuildError("surfaces/mirror.mako", 12, "use of undeclared 'rho'", "12: w *= rho;")
    assert str(error) == "kernel surfaces/mirror.mako:12: use of undeclared 'rho'\n12: w *= rho;"
    assert str(KernelBuildError("a.mako", None, "no")) == "kernel a.mako: no"


@pytest.mark.parametrize(
    "error",
    [
        KernelBuildError("a.mako", 3, "no", "3: x"),
        KernelBuildError("a.mako", None, "no"),
        DeviceError("the device is refused: no fp64", "no fp64"),
        DeviceError("no device"),
        HostError("x"),
    ],
)
def test_errors_survive_the_way_back_from_a_worker(error):
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)
    assert isinstance(copy, HostError)
