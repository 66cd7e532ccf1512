"""``photizon report``, and what notebooks get."""

from __future__ import annotations

import builtins
import os

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main


@pytest.fixture
def saved(results, tmp_path):
    results["empty"].save(tmp_path / "run", figures=False)
    return tmp_path / "run"


def listing(folder):
    return sorted(p.name for p in folder.iterdir())


def test_writes_beside_the_result_and_prints_the_path(saved, capsys):
    before = listing(saved)
    assert main(["report", str(saved)]) == 0
    out = capsys.readouterr()
    assert out.out == f"{saved / 'report.html'}\n"
    assert out.err == ""
    assert listing(saved) == sorted({*before, "figures", "report.html"})
    text = (saved / "report.html").read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE html>")
    assert "<title>empty – report</title>" in text
    umask = os.umask(0)
    os.umask(umask)
    assert (saved / "report.html").stat().st_mode & 0o777 == 0o666 & ~umask
    pz.open_result(saved)  # still a result


def test_makes_figures_that_are_missing_and_keeps_the_others(saved):
    assert main(["report", str(saved)]) == 0
    names = listing(saved / "figures")
    assert "ledger.png" in names
    (saved / "figures" / names[0]).unlink()
    (saved / "figures" / "ledger.png").write_bytes(b"mine")
    assert main(["report", str(saved)]) == 0
    assert listing(saved / "figures") == names
    assert (saved / "figures" / "ledger.png").read_bytes() == b"mine"
    assert b"bWluZQ==" not in (saved / "report.html").read_bytes()  # the page has its own


def test_the_same_result_gives_the_same_page(saved):
    assert main(["report", str(saved)]) == 0
    first = (saved / "report.html").read_bytes()
    assert main(["report", str(saved / "result.nc")]) == 0
    assert (saved / "report.html").read_bytes() == first


def test_out_names_the_file(saved, tmp_path, capsys):
    out = tmp_path / "a b.html"
    assert main(["report", str(saved), "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    assert out.stat().st_size > 10_000
    assert "report.html" not in listing(saved)
    assert main(["report", str(saved), "--out", str(out)]) == 0  # a report is replaced


def refused(capsys, *arguments):
    assert main(["report", *map(str, arguments)]) == 2
    out = capsys.readouterr()
    assert out.out == ""
    assert "Traceback" not in out.err
    return out.err


def test_other_files_are_not_replaced(saved, tmp_path, capsys):
    arrays = (saved / "result.nc").read_bytes()
    assert "not replaced" in refused(capsys, saved, "--out", saved / "result.nc")
    assert (saved / "result.nc").read_bytes() == arrays
    (saved / "report.html").write_text("<p>my notes</p>", encoding="utf-8")
    assert "another file with --out" in refused(capsys, saved)
    assert "is a directory" in refused(capsys, saved, "--out", tmp_path)
    assert "does not exist" in refused(capsys, saved, "--out", tmp_path / "no" / "r.html")
    assert "expected a path" in refused(capsys, saved, "--out", "")
    assert not [name for name in listing(saved) if name.startswith(".")]


def test_a_report_is_a_file_of_ours_where_the_arrays_are_removed(results, saved):
    assert main(["report", str(saved)]) == 0
    (saved / "result.nc").unlink()  # as the message says that keeps the longer result
    results["empty"].save(saved, figures=False)
    assert "report.html" not in listing(saved)  # it was the other result's
    assert "result.nc" in listing(saved)
    (saved / "result.nc").unlink()
    (saved / "report.html").write_text("<p>my notes</p>", encoding="utf-8")
    with pytest.raises(pz.ResultError, match="holds files and no photizon result"):
        results["empty"].save(saved, figures=False)
    assert (saved / "report.html").read_text(encoding="utf-8") == "<p>my notes</p>"


def test_what_is_no_result_is_refused(saved, tmp_path, capsys):
    assert "is not there: give the directory" in refused(capsys, tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    assert "holds no result.nc: give the directory" in refused(capsys, tmp_path / "empty")
    assert "expected a path" in refused(capsys, "")
    (tmp_path / "text").write_text("no result", encoding="utf-8")
    assert "run the scene again" in refused(capsys, tmp_path / "text")
    assert main(["report"]) == 2


@pytest.mark.parametrize("damage", ["cut", "zeroed", "emptied", "other"])
def test_a_damaged_result_is_refused(saved, capsys, damage):
    file = saved / "result.nc"
    whole = file.read_bytes()
    half = len(whole) // 2
    file.write_bytes(
        {
            "cut": whole[:half],
            "zeroed": whole[:half] + bytes(len(whole) - half),
            "emptied": b"",
            "other": b"\x89HDF\r\n\x1a\n" + os.urandom(4000),
        }[damage]
    )
    err = refused(capsys, saved)
    assert "is damaged or not a photizon result" in err
    assert "run the scene again" in err
    assert "report.html" not in listing(saved)


def test_a_page_that_cannot_be_written_leaves_no_trace(saved, capsys, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("photizon_cl.atomic.os.replace", full)
    (saved / "figures").mkdir()
    before = listing(saved)
    err = refused(capsys, saved)
    assert "No space left on device" in err
    assert "--out" in err
    assert listing(saved) == before
    assert listing(saved / "figures") == []


# -- notebooks -----------------------------------------------------------------------------------


def test_notebooks_show_ledger_and_detectors(results):
    text = results["room"]._repr_html_()
    assert text.startswith('<div class="photizon-result">')
    for part in ("absorbed by floor", "Detectors", "seed 1", 'scope="row"', "<caption"):
        assert part in text
    for outside in ("http:", "https:", "src=", "<script", "<link", "<style"):
        assert outside not in text
    assert len(text) < 20_000
    hostile = results["hostile"]._repr_html_()
    assert "<b>" not in hostile
    assert "<script" not in hostile
    assert "a&lt;b&gt; &amp; &#34;c&#34; ${1+1}" in hostile
    assert "σ unknown" in results["single"]._repr_html_()


def test_the_ledger_as_a_data_frame(results):
    result = results["capped"]
    frame = result.to_dataframe()
    assert list(frame.columns) == ["row", "value_W", "sigma_W", "share"]
    by_row = frame.set_index("row")
    assert by_row.loc["emitted", "share"] == 1.0
    for name, row in result.ledger.absorbed.items():
        assert by_row.loc[f"absorbed: {name}", "value_W"] == row.value
        assert by_row.loc[f"absorbed: {name}", "sigma_W"] == row.sigma
    outside = ["emitted", "roulette killed", "roulette boosted"]
    assert by_row.drop(outside)["share"].sum() == pytest.approx(1.0, abs=1e-12)
    assert results["single"].to_dataframe()["sigma_W"].isna().all()


def test_rows_are_named_as_in_the_file(results):
    from photizon_cl.result.arrays import dataset

    named = dataset(results["room"])["ledger.row"].values
    assert list(results["room"].to_dataframe()["row"]) == list(named)


def test_a_ladder_as_a_data_frame(results):
    result = results["room"]
    frame = result.to_dataframe("floor")
    assert list(frame.columns) == ["generation", "value_W", "sigma_W", "share", "count"]
    ladder = result.detectors["floor"].ladder
    np.testing.assert_array_equal(frame["value_W"], [rung.value for rung in ladder])
    np.testing.assert_array_equal(frame["count"], [rung.count for rung in ladder])
    assert frame["count"].sum() == result.detectors["floor"].power.count


def test_data_frames_that_there_are_not(results):
    with pytest.raises(pz.ArgumentError, match=r'found "wall", expected .* \("floor"'):
        results["room"].to_dataframe("wall")
    with pytest.raises(pz.ArgumentError, match="none has one in this scene"):
        results["single"].to_dataframe("t")


def test_without_pandas_it_is_said_what_to_install(results, monkeypatch):
    real = builtins.__import__

    def without(name, *rest):
        if name == "pandas":
            raise ModuleNotFoundError("No module named 'pandas'")
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(pz.PhotizonError, match="pip install pandas"):
        results["room"].to_dataframe()
