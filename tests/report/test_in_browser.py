"""Reports in a real browser, and broken pages that the same check must reject."""

from __future__ import annotations

import pytest
from pagecheck import faults, printed

NAMES = ("room", "sphere", "hostile", "capped", "single", "empty")
PIXEL = (
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwAD"
    "hgGAWjR9awAAAABJRU5ErkJggg=="
)
GOOD = f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>good</title><link rel="icon" href="data:,">
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>@media print {{ tr, figure {{ break-inside: avoid }}
details::details-content {{ display: block; content-visibility: visible }} }}
.scroll {{ overflow-x: auto }} a {{ color: inherit }}</style></head>
<body style="background: #ffffff; color: #222222"><a href="#main">Skip to the results</a>
<main id="main"><h1>One</h1><h2>Two</h2>
<figure><img src="{PIXEL}" alt="a pixel" width="300" height="300">
<figcaption>It</figcaption></figure>
<table><caption>Rows</caption><thead><tr><th scope="col">a</th><th scope="col">b</th></tr></thead>
<tbody><tr><th scope="row">x</th><td>1</td></tr></tbody></table>
<details><summary>More</summary><p>What is folded away.</p></details>
</main></body></html>
"""

BROKEN = {
    "image from elsewhere": ('src="data', 'src="http://example.invalid/x.png#', "external request"),
    "image of nothing": ("iVBORw0KG", "AAAA", "image not shown"),
    "no alt text": (' alt="a pixel"', "", "without alt text"),
    "no caption of a figure": ("<figcaption>It</figcaption>", "", "figure without caption"),
    "unequal widths": (
        "<table>",
        f'<figure><img src="{PIXEL}" alt="b" width="200"><figcaption></figcaption></figure><table>',
        "figures of unequal widths: 300, 200 px",
    ),
    "logged error": ("</main>", "<script>console.error('x')</script></main>", "console error: x"),
    "thrown error": ("</main>", "<script>throw Error('boom')</script></main>", "boom"),
    "a script": ("</main>", "<script></script></main>", "a script"),
    "too wide": ("<h2>", '<h2 style="width: 1500px">', "wider than 1280 px"),
    "too wide for a phone": ("<h2>", '<h2 style="width: 500px">', "wider than 3"),
    "pale text": ("<h2>", '<h2 style="color: #999999">', "contrast 2.85"),
    "pale text of half opacity": ("<h2>", '<h2 style="opacity: 0.4">', "contrast"),
    "no caption of a table": ("<caption>Rows</caption>", "", "table without caption"),
    "no scope": ('<th scope="row">', "<th>", "heading without scope"),
    "row without heading": ('<th scope="row">x</th>', "<td>x</td>", "row without heading"),
    "heading order": ("<h2>Two</h2>", "<h3>Two</h3>", "heading order"),
    "no language": (' lang="en"', "", "no lang"),
    "link to nowhere": ('id="main"', "", "link to nowhere"),
    "blank": ("<main", '<main style="visibility: hidden"', "blank"),
    "folded away on paper": ("details::details-content", "u", "print: stays folded away"),
    "split rows": ("tr, figure", "u", "may be split"),
    "dark paper": ("@media print {", "@media print { body { background: #000000 !important }",
                   "print: paper is"),
}  # fmt: skip


@pytest.mark.parametrize(
    "name",
    # its figures are those of the others, and many
    [pytest.param(n, marks=pytest.mark.slow) if n in ("room", "sphere") else n for n in NAMES],
)
def test_reports_have_no_faults(browser, pages, name):
    assert faults(browser, pages[name]) == []


@pytest.mark.parametrize("name", ["room", "hostile"])
def test_reports_print_on_a4(browser, pages, name):
    sheets, sizes = printed(browser, pages[name])
    assert 3 <= sheets <= 20
    assert sizes == {(595, 842)}


def test_a_good_page_passes(browser, tmp_path):
    path = tmp_path / "good.html"
    path.write_text(GOOD, encoding="utf-8")
    assert faults(browser, path) == []


@pytest.mark.parametrize("defect", BROKEN)
def test_broken_pages_are_rejected(browser, tmp_path, defect):
    good, bad, expected = BROKEN[defect]
    assert good in GOOD
    path = tmp_path / "broken.html"
    path.write_text(GOOD.replace(good, bad, 1), encoding="utf-8")
    found = faults(browser, path, schemes=["light"], shot="blank" in expected)
    assert any(expected in fault for fault in found), found


def test_notebook_form_reads_in_the_dark(browser, results, tmp_path):
    # As a dark notebook shows it: in a cell that sets colours, and nothing else of ours around.
    path = tmp_path / "notebook.html"
    cell = results["room"]._repr_html_()
    path.write_text(
        GOOD.replace("background: #ffffff; color: #222222", "background: #111111; color: #e0e0e0")
        .replace("<h2>Two</h2>", f"<h2>Two</h2><div class='scroll'>{cell}</div>")
        .replace("@media print {", "@media print { body { background: #fff !important; color: "
                 "#222 !important } "),
        encoding="utf-8",
    )  # fmt: skip
    assert faults(browser, path) == []
