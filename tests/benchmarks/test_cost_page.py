"""The page *What accuracy costs* is what the kept studies print."""

from __future__ import annotations

from benchmarks.cost_page import PAGE, STUDIES, kept, page
from photizon_cl.result.cost_advice import advice
from photizon_cl.result.cost_file import read_study
from photizon_cl.scene.files import load


def test_the_page_is_what_the_kept_studies_print():
    text = PAGE.read_text(encoding="utf-8")
    assert page(text) == text
    for preset, _, _ in STUDIES:
        assert f"$ photizon cost {preset}" in text


def test_kept_studies_are_of_the_presets_as_they_are():
    for preset, quantity, _ in STUDIES:
        study = read_study(kept(preset))
        assert study.scene_digest == load(preset).digest()
        assert quantity in (None, study.quantity)
        assert study.seconds < 180.0
        assert study.advice[: len(advice(study))] == advice(study)
