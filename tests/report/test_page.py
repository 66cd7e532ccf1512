"""What a report says, and that it stands alone."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest

from photizon_cl.compile.effects.table import EFFECT_ROWS as EFFECTS
from photizon_cl.result.text import with_error
from photizon_cl.views.report import figures, page, tables

NAMES = ("room", "sphere", "hostile", "capped", "single", "empty")


class Reader(HTMLParser):
    """The text of a page, its tags and attributes, and its tables by their identifiers."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.parts, self.tables = [], [], [], {}
        self.cell = None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag == "table":
            self.rows = self.tables[dict(attrs)["id"]] = []
        elif tag == "tr":
            self.rows.append([])
        elif tag in ("th", "td"):
            self.cell = []

    def handle_endtag(self, tag):
        if tag in ("th", "td"):
            self.rows[-1].append(" ".join("".join(self.cell).split()))
            self.cell = None

    def handle_data(self, data):
        self.parts.append(data)
        if self.cell is not None:
            self.cell.append(data)

    @property
    def text(self):
        return " ".join("".join(self.parts).split())

    def row(self, table, head):
        """Return the cells behind a row's heading."""
        return next(row[1:] for row in self.tables[table] if row[0] == head)


@pytest.fixture(scope="module")
def read(pages):
    return {name: Reader(path.read_text(encoding="utf-8")) for name, path in pages.items()}


@pytest.mark.parametrize("name", NAMES)
def test_a_page_needs_nothing_but_itself(read, pages, name):
    found = read[name]
    assert not {"script", "link", "iframe", "object", "base", "form"} & set(found.tags) - {"link"}
    for tag, attribute, value in found.attributes:
        assert not attribute.startswith("on"), (tag, attribute)
        if attribute in ("src", "href"):
            assert value.startswith(("data:", "#")), value
        assert attribute not in ("srcset", "background", "poster", "action", "data")
    style = (page._HERE / "style.css").read_text(encoding="utf-8")
    assert "url(" not in style
    assert "@import" not in style
    assert pages[name].stat().st_size < 5_000_000


@pytest.mark.parametrize("name", NAMES)
def test_provenance_is_complete(read, results, name):
    import numpy as np
    import pyopencl

    import photizon_cl as pz

    result, text = results[name], read[name].text
    for fact in (
        result.tally_digest,
        result.scene.digest(),
        result.info.device,
        result.info.precision,
        result.recipe,
        np.__version__,
        pyopencl.VERSION_TEXT,
        pz.__version__,
        "What this run does not claim",
    ):
        assert fact in text
    for advisory in result.advisories:
        assert " ".join(advisory[1:].split()) in text
    inside = {row[0] for row in read[name].tables["table-effects"][1:]}
    outside = {row[0] for row in read[name].tables["table-left-out"][1:]}
    assert inside == result.compiled.effects
    assert outside == set(EFFECTS) - inside


@pytest.mark.parametrize("name", NAMES)
def test_numbers_are_those_of_the_result(read, results, name):
    result, found = results[name], read[name]

    def shown(value, sigma):
        texts = with_error(value, sigma)
        plain = [re.sub(r"e-0*(\d+)$", r" × 10−\1", text) for text in texts]
        return [plain[0].replace("-", "−"), "–" if sigma is None else plain[1]]

    rows = {f"absorbed by {n}": row for n, row in result.ledger.absorbed.items()}
    rows |= {"emitted": result.ledger.emitted, "depth-capped": result.ledger.depth_capped}
    for head, row in rows.items():
        assert found.row("table-ledger", head)[:2] == shown(row.value, row.sigma)
    for n, (element, detector) in enumerate(result.detectors.items()):
        cells = found.row("table-detectors", element)
        assert cells[:2] == shown(detector.power.value, detector.power.sigma)
        assert cells[3] == f"{detector.power.count:,}"
        for rung in detector.ladder or ():
            if rung.count:
                last = " or more" if rung is detector.ladder[-1] else ""
                cells = found.row(f"table-ladder-{n}", f"{rung.generation}{last}")
                assert cells[:2] == shown(rung.value, rung.sigma)
                assert cells[3] == f"{rung.count:,}"


def test_every_figure_is_there_with_words_of_its_own(read, results):
    for name, result in results.items():
        alts = [
            v for tag, attribute, v in read[name].attributes if (tag, attribute) == ("img", "alt")
        ]
        assert len(alts) == len(list(figures.drawings(result)))
        assert len(set(alts)) == len(alts)
        for alt in alts:
            assert re.search(r"\d", alt)
            assert "Figure “" not in alt  # the words for kinds that have none of their own


def test_words_for_a_kind_of_figure_that_is_new(results):
    from photizon_cl.views.report.words import describe

    alt, caption = describe(results["room"], "new-kind", "")
    assert "new kind" in alt
    assert caption == "New kind."


@pytest.mark.parametrize(
    ("name", "says", "silent"),
    [
        ("room", ["σ is an estimate", "A bin holds its mean|fewer than 10"], ["No error at all"]),
        ("single", ["No error at all here", "fewer than 10 arrivals"], ["σ is an estimate"]),
        ("capped", ["Rays were cut at the generation cap of 6", "Roulette ended weak rays",
                    "unpolarised light", "no proof of darkness"], ["No bias from"]),
        ("sphere", ["No bias from the generation cap"], ["Roulette ended", "Detectors count"]),
        ("empty", ["Statistical error only", "Incoherent geometrical"], ["Detectors count", "bin"]),
    ],
)  # fmt: skip
def test_claims_fit_the_run(read, name, says, silent):
    text = read[name].text
    claims = text[text.index("What this run does not claim", 2000) :]
    claims = claims[: claims.index("How it was run")]
    assert "wrong by 5 % leaves an answer that is wrong" in claims
    for words in says:
        assert re.search(words, claims), words
    for words in silent:
        assert words not in claims


def test_markup_in_names_stays_text(read):
    found = read["hostile"]
    assert "script" not in found.tags
    assert found.tags.count("title") == 1
    assert "</title><script>throw 1</script>" in found.text
    assert 'a<b> & "c" ${1+1}' in found.text
    assert "## no comment % for x in y:" in found.text


def test_the_scene_reads_as_it_was_run(pages, results, read):
    import tomllib

    import photizon_cl as pz

    for name, result in results.items():
        text = pages[name].read_text(encoding="utf-8")
        toml = Reader(re.search(r'<pre class="scene">(.*?)</pre>', text, re.DOTALL)[1])
        assert pz.load(tomllib.loads("".join(toml.parts))) == result.scene


def test_figures_beyond_the_room_stay_files(results):
    result = results["room"]
    every = figures.draw(result)
    least = min(len(d.png) for d in every.drawn if d.kind == "ledger")
    few = figures.draw(result, most_bytes=least + 100_000)
    assert few.left_out
    assert {d.kind for d in few.drawn} <= {"layout", "ledger", "map"}
    assert sorted([d.name for d in few.drawn] + list(few.left_out)) == sorted(every.files)
    text = page.render(result, few, None)
    for name in few.left_out:
        assert f"<code>figures/{name}</code>" in text
    # a full page draws only what is not there
    none = figures.draw(result, there=every.files, most_bytes=0)
    assert none.files == {}
    assert sorted(none.left_out) == sorted(every.files)


def test_a_figure_that_cannot_be_drawn_is_said(results, monkeypatch):
    def failing(path):
        raise ValueError("Image size of 9 x 99999 pixels is too large")

    monkeypatch.setattr(figures, "drawings", lambda _: iter([("ledger", "", "l.png", failing)]))
    drawn = figures.draw(results["room"])
    assert "too large" in page.render(results["room"], drawn, None)


@pytest.mark.slow  # the largest is drawn in 20 s
def test_the_largest_map_fits(tmp_path):
    from report_scenes import plate, scene

    import photizon_cl as pz
    from photizon_cl.run.report import write_report

    big = scene("big", element=[plate("t", detector={"map": [2048, 2048]})])
    result = pz.trace(pz.load(big), batches=6, rays_per_batch=2**22)
    result.save(tmp_path, figures=False)
    assert write_report(tmp_path).page.stat().st_size < 5_000_000


def test_long_tables_are_cut_and_say_so(results):
    from photizon_cl.views.report import tables

    result = results["room"]
    cut = tables.ledger_table(result, most=2)
    assert len(cut.rows) == 1 + 2 + 1 + 2 + 1
    assert "4 other elements" in cut.rows[3][0]
    assert "no σ" in cut.note
    largest = sorted(result.ledger.absorbed, key=lambda n: -result.ledger.absorbed[n].value)[:2]
    assert {row[0] for row in cut.rows[1:3]} == {f"absorbed by {name}" for name in largest}
    assert "1 detectors with less power" in tables.detector_table(results["hostile"], 0).note


def test_the_checks_of_every_scalar_are_tabulated(read, results):
    for name in ("room", "sphere", "capped"):
        checks = results[name].checks
        rows = read[name].tables["table-checks"][1:]
        assert [row[0] for row in rows] == list(checks)
        for row, found in zip(rows, checks.values(), strict=True):
            assert row[5] == ("yes" if found.believable else "no")
            marks = [cell.endswith("*") for cell in row[1:5]]
            assert marks == [not good for good in found.good.values()], row
            wanted = f"{100.0 * found.relative_sigma:.3g} %"
            assert row[1].removesuffix(" *") == wanted
    assert "table-checks" not in read["single"].tables
    assert "#checks" not in {value for _, _, value in read["single"].attributes}


def test_of_very_many_checks_those_that_fail_are_shown(results):
    found = tables.checks_table(results["capped"], most=1)
    checks = results["capped"].checks
    wanted = next((n for n, c in checks.items() if not c.believable), next(iter(checks)))
    assert [row[0] for row in found.rows] == [wanted]
    assert f"{len(checks) - 1} quantities are left out" in found.note
