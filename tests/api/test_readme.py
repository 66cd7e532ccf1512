"""What the README says that a command prints, it prints."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from photizon_cl.cli.main import main

README = Path(__file__).resolve().parents[2] / "README.md"


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README.read_text("utf-8"), re.M | re.S)


@pytest.mark.usefixtures("few_figures")
@pytest.mark.skipif(not README.exists(), reason="no README beside the tests")
def test_the_ledger_is_what_the_command_prints(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (shown,) = (text for text in blocks("") if text.startswith("Integrating sphere"))
    assert main(["run", "integrating-sphere", "--out", "out/integrating-sphere"]) == 0
    printed = capsys.readouterr().out
    start = "ledger "  # above it stand time and device, which are the machine's
    assert printed[printed.index(start) :] == shown[shown.index(start) :]


@pytest.mark.usefixtures("few_figures")
@pytest.mark.skipif(not README.exists(), reason="no README beside the tests")
def test_the_python_example_runs(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    (code,) = blocks("python")
    exec(compile(code, "README.md", "exec"), {})
    assert (tmp_path / "out" / "room" / "result.nc").exists()
    assert len(capsys.readouterr().out.splitlines()) == 3
