"""The GPU's command, as far as a machine without a GPU can tell."""

from __future__ import annotations

import json

import pytest

from benchmarks import gpu, icd
from benchmarks.gpu_checks import matrix_plans
from hostcode.device.device import preferred_lanes
from hostcode.program.plan import ExecutionPlan, default_plan

BARE = """
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {names!r}:
            raise ImportError(name + " is not on a bare machine")

sys.meta_path.insert(0, Refuse())
"""
NOT_THERE = ("rich", "matplotlib", "xarray", "h5netcdf", "tomli_w", "scipy", "pytest", "hypothesis")


def test_it_needs_nothing_but_numpy_mako_and_pyopencl(run_python):
    code = BARE.format(names=NOT_THERE) + "from benchmarks import gpu_run, icd; print('here')"
    assert run_python(code).split() == ["here"]


def test_a_device_that_is_not_there_is_status_2(capsys):
    assert gpu.main(["--device", "no such device"]) == 2
    assert "NO RESULT" in capsys.readouterr().out


def test_the_matrix_changes_one_thing_at_a_time(device):
    plan = default_plan(device.record, preferred_lanes(device.record))
    for quick in (True, False):
        plans = dict(matrix_plans(plan, quick=quick))
        assert plans.pop("default") == plan
        assert all(other != plan for other in plans.values())
        assert {p.composition for p in plans.values()} == {"packets", "classical", "whole-path"}
        assert 1 in {p.lanes for p in plans.values()}


def test_on_a_gpu_the_matrix_has_the_plans_of_a_gpu():
    plan = ExecutionPlan(lanes=1, items=1 << 18, wave_rays=1 << 22, local_size=64, interleaved=True)
    plans = [p for _, p in matrix_plans(plan, quick=False)]
    assert {p.local_size for p in plans} >= {1, 32, 64, 128, 256}
    assert {p.wave_rays for p in plans} >= {1 << 10, 1 << 20, 1 << 22}
    assert {p.interleaved for p in plans} == {True, False}


def test_a_driver_without_a_registration_is_found(tmp_path, monkeypatch):
    library = tmp_path / "lib" / icd.LIBRARY
    library.parent.mkdir()
    library.write_bytes(b"")
    monkeypatch.setenv("LD_LIBRARY_PATH", "")
    assert library in list(icd.libraries((str(tmp_path), str(library.parent))))
    folder = tmp_path / "vendors"
    folder.mkdir()
    tried = list(icd.environments(library, folder))
    assert (folder / "photizon-nvidia.icd").read_text(encoding="utf-8").strip() == str(library)
    assert all(set(e) & {"OCL_ICD_VENDORS", "OCL_ICD_FILENAMES"} for e in tried)
    assert any(e.get("LD_LIBRARY_PATH", "").startswith(str(library.parent)) for e in tried)


@pytest.mark.slow
def test_the_whole_path_runs_on_this_device(run_python, device, tmp_path):
    selector = f"{device.record.platform_index}:{device.record.device_index}"
    arguments = ["gpu.py", "--quick", "--device", selector, "--out", str(tmp_path)]
    code = BARE.format(names=NOT_THERE) + (
        f"sys.argv = {arguments!r}\nfrom benchmarks import gpu\nsys.exit(gpu.main())"
    )
    said = run_python(code)
    assert said.splitlines()[-2] == "ALL CHECKS PASSED"
    (written,) = tmp_path.glob("gpu-*.json")
    data = json.loads(written.read_text(encoding="utf-8"))
    assert data["failures"] == []
    assert all(len(set(d.values())) == 1 for d in data["matrix"]["digests"].values())
