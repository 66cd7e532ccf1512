"""A notebook: a preset changed, run, plotted and refined, executed as a person would."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOK = """\
import photizon_cl as pz
scene = pz.load("box-room").replace({'element."wall -x".surface.reflectance': 0.9})
scene
---
pz.draw(scene, rays=10)
---
result = pz.trace(scene, batches=4, rays_per_batch=2048)
result
---
result.detectors["floor"]
---
pz.figures.irradiance(result, "floor")
---
%matplotlib inline
result.to_dataset()["floor"]["irradiance"].plot()
---
better = result.refine(batches=8)
before, after = (r.ledger.absorbed["floor"] for r in (result, better))
print(f"{before:.3f} {after:.3f}", result.batches, better.batches)
---
scene.element["wal -x"]
"""
CELLS = NOTEBOOK.split("---\n")


def outputs(cell, kind):
    return [o.data[kind] for o in cell.outputs if kind in o.get("data", {})]


def test_a_preset_changed_run_plotted_and_refined(tmp_path, monkeypatch):
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))
    # no file of the person who runs this is read or written
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    monkeypatch.delenv("MPLBACKEND", raising=False)
    notebook = nbformat.v4.new_notebook(
        cells=[nbformat.v4.new_code_cell(source) for source in CELLS],
        metadata={"kernelspec": {"name": "python3", "display_name": "", "language": "python"}},
    )
    client = nbclient.NotebookClient(
        notebook, timeout=120, allow_errors=True, resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    cells = notebook.cells
    failed = [o.ename for cell in cells[:-1] for o in cell.outputs if o.output_type == "error"]
    assert not failed
    shown = "".join(outputs(cells[0], "text/plain"))
    assert shown == "<photizon_cl.Scene 'box-room': 1 source, 6 elements>"
    # figures show themselves, a result shows its ledger
    for number in (1, 4, 5):
        assert outputs(cells[number], "image/png")
    assert "ledger" in outputs(cells[2], "text/html")[0]
    assert outputs(cells[3], "text/plain")[0].startswith("<DetectorResult ")
    assert cells[6].outputs[0].text.endswith(" 4 8\n")
    (error,) = cells[-1].outputs
    assert (error.ename, 'did you mean "wall -x"' in error.evalue) == ("UnknownNameError", True)
