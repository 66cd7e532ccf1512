"""What an effect counts is shown everywhere: one kernel file, one class and one row are enough.

The effect is made in a copy, as docs/add-a-kind.md makes its own, and run by the command line.
"""

from __future__ import annotations

import csv
import html
import json
import re

import pytest
from pages import Runner, apply_hunks

import photizon_cl as pz

KERNEL = """\
// Power that meets each element, with its count.
FN void count_landings(const launch_t *launch, const ledger_t *ledger, lint element, mask met,
                       image_t image) {
% for l in range(lanes):
    if (${lane("met", l)}) {
        __global long *cell = ledger->tally + (launch->landings + ${lane("element", l)}) * CELL;
        atom_add(cell, ${lane("image.p0", l)});
        atom_add(cell + 1, ${lane("image.p1", l)});
        atom_add(cell + 2, ${lane("image.p2", l)});
        atom_add(cell + 3, 1L);
    }
% endfor
}
"""

CLASS = '''\
"""Power that meets each element."""

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect


class Landings(Effect):
    name = "landings"
    what = "power that meets each element"
    costs = "four atomic additions an interaction"

    def needed(self, scene, settings):
        return "an element reflects" if any(e.surface.reflects for e in scene.element) else None

    def cells(self, scene):
        return (len(scene.element),)

    def labels(self, scene):
        return tuple(e.name for e in scene.element)

    def parts(self, draft):
        return EffectParts(
            templates=(("survive", "effects/landings"),),
            hooks=(("surface", "count_landings(launch, ledger, element, met, before);"),),
            launch=(("landings", "ulong", "first cell of the landings"),),
        )
'''

ROW = """\
 from photizon_cl.compile.effects.far_field import FarField
+from photizon_cl.compile.effects.landings import Landings
@@
     FarField(),
+    Landings(),
"""

LAMP = """\
schema = "photizon/1"
name = "plates"

[[source]]
name = "lamp"
kind = "cosine-point"
flux = 2.0
position = [0.0, 0.0, 1.0]
axis = "-z"
"""

PLATE = """
[[element]]
name = {name}
kind = "rectangle"
position = [{x}, 0.0, 0.0]
axis = "+z"
half_width = 0.1
half_height = 0.5
"""
WHITE = 'surface = { kind = "lambertian", reflectance = 0.5 }\n'
BLACK = 'surface = { kind = "absorber" }\n'

HOSTILE = "<b>&µ, [x] %"
NAMES = [HOSTILE, *(f"plate {n}" for n in range(1, 13)), "tallies.landings"]
RUN = ("--rays-per-batch", "2048", "--no-figures")


def plates(names):
    """Return a scene of plates side by side; behind the first a black one has a detector."""
    text = LAMP
    for n, name in enumerate(names):
        text += PLATE.format(name=json.dumps(name, ensure_ascii=False), x=0.21 * n)
        text += BLACK + "detector = {}\n" if n and n == len(names) - 1 else WHITE
    return text


@pytest.fixture
def runner(checkout):
    """Return a copy of the product with two scenes, which has the result of one of them."""
    (checkout / "one.toml").write_text(plates(["plate"]), encoding="utf-8")
    (checkout / "plates.toml").write_text(plates(NAMES), encoding="utf-8")
    runner = Runner(checkout, apart=True)
    runner.command(["run", "one.toml", "--batches", "3", *RUN, "--out", "before"])
    before = (checkout / "before" / "summary.json").read_bytes()

    effects = checkout / "photizon_cl" / "compile" / "effects"
    (checkout / "kernels" / "effects" / "landings.mako").write_text(KERNEL, encoding="utf-8")
    (effects / "landings.py").write_text(CLASS, encoding="utf-8")
    table = effects / "table.py"
    table.write_text(apply_hunks(table.read_text("utf-8"), ROW), encoding="utf-8")
    # it did not count: one cell less, as files have in which interactions have no row of their own
    opened = runner.process(
        "-c",
        "import json, sys, photizon_cl as pz\n"
        "sys.stdout.reconfigure(encoding='utf-8')\n"
        "result = pz.open_result('before')\n"
        "assert dict(result.tallies) == {}\n"
        "print(json.dumps(result.summary()))",
    )
    assert json.loads(opened) == json.loads(before)
    return runner


@pytest.mark.slow
def test_what_an_effect_counts_is_in_every_view(runner):
    folder = runner.folder
    printed = runner.command(["run", "plates.toml", "--batches", "3", *RUN, "--out", "out"])
    summary = json.loads((folder / "out" / "summary.json").read_text("utf-8"))
    cells = summary["tallies"]["landings"]
    assert list(cells) == NAMES
    # every bounce is counted, and half of what meets a white plate stays there
    assert sum(cell["count"] for cell in cells.values()) == summary["interactions"]
    for name, cell in cells.items():
        absorbed = summary["ledger"]["absorbed"][name]
        part = 1.0 if name == NAMES[-1] else 0.5
        assert cell["value"] == pytest.approx(absorbed["value"] / part, rel=1e-12)
        assert cell["sigma"] == pytest.approx(absorbed["sigma"] / part, rel=1e-9)
    largest = sorted(cells, key=lambda name: -cells[name]["value"])

    # printed: the largest ten
    (part,) = (part.splitlines() for part in printed.split("\n\n") if part.startswith("landings"))
    assert re.fullmatch(r"landings +W +± σ +count", part[0])
    assert [re.split(r" {2,}", line)[0] for line in part[1:]] == [*largest[:10], "… 4 more"]
    assert part[1].endswith(f" {cells[largest[0]]['count']}")

    # a table of its own, in the effect's order, to the bit
    with open(folder / "out" / "tally-landings.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {
        r["label"]: {
            "value": float(r["value_W"]),
            "sigma": float(r["sigma_W"]),
            "count": int(r["count"]),
        }
        for r in rows
    } == cells
    assert [r["label"] for r in rows] == NAMES

    # arrays with labels, which a detector of the same name does not replace
    code = (
        "import json, photizon_cl as pz, xarray as xr\n"
        "with xr.open_dataset('out/result.nc', engine='h5netcdf') as data:\n"
        "    at = 'tallies.landings'\n"
        "    columns = [data[f'{at}.{name}'] for name in ('label', 'power', 'sigma', 'count')]\n"
        "    dims = {a.dims for a in columns}\n"
        "    units = [a.attrs.get('units') for a in columns]\n"
        "    rows = list(zip(*(a.values.tolist() for a in columns)))\n"
        "    detector = float(data['tallies.landings_.power'])\n"
        "result = pz.open_result('out')\n"
        "assert result.tallies == pz.open_result('out/result.nc').tallies\n"
        "assert result.detectors['tallies.landings'].power.value == detector\n"
        "opened = {name: cell.summary() for name, cell in result.tallies['landings'].items()}\n"
        "more = pz.open_result('out').refine(batches=4)\n"
        "whole = pz.trace('plates.toml', batches=4, rays_per_batch=2048)\n"
        "assert (more.tallies, more.tally_digest) == (whole.tallies, whole.tally_digest)\n"
        "print(json.dumps([sorted(map(list, dims)), units, rows, opened, result._repr_html_()]))"
    )
    dims, units, rows, opened, notebook = json.loads(runner.process("-c", code))
    assert dims == [["tallies.landings.label"]]
    assert units == [None, "W", "W", "1"]
    assert rows == [[name, c["value"], c["sigma"], c["count"]] for name, c in cells.items()]
    assert opened == cells
    assert "landings: power that meets each element" in notebook

    # who does not know the effect is told, and gets no other numbers
    with pytest.raises(pz.ResultError, match='has counts of "landings", which this version'):
        pz.open_result(folder / "out")

    # a section of the report
    runner.command(["report", "out"])
    page = (folder / "out" / "report.html").read_text("utf-8")
    section = page[page.index('<h2 id="tallies">') :].partition("</section>")[0]
    assert "landings: power that meets each element" in section
    assert '<a href="#tallies">' in page
    heads = re.findall(r'<th scope="row">(.*?)</th>', section)
    assert [html.unescape(head) for head in heads] == largest
    assert HOSTILE not in section

    # a scene without it has nothing of it; its table is known as ours, and goes
    for name in ("result.nc", "report.html"):
        (folder / "out" / name).unlink()
    scene = (folder / "plates.toml").read_text("utf-8")
    (folder / "plates.toml").write_text(scene.replace(WHITE, BLACK), encoding="utf-8")
    printed = runner.command(["run", "plates.toml", "--batches", "2", *RUN, "--out", "out"])
    assert "\n\nlandings" not in printed
    assert "tallies" not in json.loads((folder / "out" / "summary.json").read_text("utf-8"))
    assert not (folder / "out" / "tally-landings.csv").exists()
