"""The harness runs, its tables are well-formed, and what it times are the same bits."""

from __future__ import annotations

import json
import re

import pytest

from benchmarks import __main__ as command
from benchmarks import builds, cells, digests, facts, specialised, throughput
from benchmarks.report import Report, Spread, table
from benchmarks.runner import Runner, compiled_preset
from hostcode.device.device import preferred_lanes
from hostcode.program.plan import default_plan
from photizon_cl.scene.presets import preset_names
from photizon_cl.studies.effects import EVERY_EFFECT, EVERYTHING

TINY = throughput.Settings(
    scenes=("box-room",),
    rounds=2,
    seconds=0.001,
    lanes=(1, 8),
    compositions=(cells.PACKETS, cells.CLASSICAL),
    rays_per_batch=600,
    batches=2,
)


slow = pytest.mark.slow
"""A benchmark's own run builds a program for every cell, and says nothing of the engine."""


@pytest.fixture(scope="module")
def measured(device):
    report = Report(quiet=True)
    data = throughput.measure(device.record, TINY, report)
    return report.kept, data


@slow
def test_every_cell_is_measured_and_has_a_ratio(measured, device):
    _, data = measured
    found = data["scenes"]["box-room"]["cells"]
    widths = {1, 8} | {preferred_lanes(device.record)}
    assert {c["lanes"] for c in found} <= widths
    per_count = {}
    for cell in found:
        per_count.setdefault(cell["cores"], []).append(cell)
        assert len(cell["rates"]) == TINY.rounds
        assert all(rate > 0.0 for rate in cell["rates"])
    for of_count in per_count.values():
        whole = [c for c in of_count if c["composition"] == cells.WHOLE_PATH]
        assert len(whole) == 1
        assert whole[0]["over_whole_path"]["median"] == 1.0
        assert sum(c["default"] for c in of_count) == 1
        combinations = {(c["composition"], c["lanes"]) for c in of_count}
        assert len(combinations) == len(of_count) >= 5


@slow
def test_all_cells_traced_the_same_bits_as_a_run_by_itself(measured, device):
    _, data = measured
    plan = default_plan(device.record, preferred_lanes(device.record)).with_(items=3)
    alone = Runner(device, compiled_preset("box-room", TINY.rays_per_batch), plan, TINY.batches)
    assert data["scenes"]["box-room"]["digest"] == alone.digest()


@slow
def test_the_table_is_well_formed(measured):
    lines, _ = measured
    top = next(n for n, line in enumerate(lines) if line.startswith("composition"))
    rows = lines[top + 2 :]
    rows = rows[: rows.index("")]
    starts = [match.start() for match in re.finditer("-+", lines[top + 1])]
    assert len(starts) >= 4
    assert len(rows) >= 5
    for row in rows:
        parts = re.split(r"  +", row)
        assert len(parts) == len(starts)
        assert re.fullmatch(r"\d+\*?", parts[1])
        assert all(re.match(r"\d+\.\d", part) for part in parts[2:])


@slow
def test_the_verdicts_are_said_with_their_numbers(measured):
    lines, data = measured
    said = [verdict["text"] for verdict in data["acceptance"]]
    assert set(said) <= set(lines)
    assert any("default over the scalar whole path" in text for text in said)
    assert any("overhead" in text and "enqueue calls" in text for text in said)
    for text in said:
        assert re.match(r"(holds|FAILS|for the record)", text)
        assert re.search(r": \d+\.\d\d", text)
    for verdict in data["acceptance"]:
        assert verdict["holds"] in (True, False, None)


@slow
def test_the_data_is_plain_json(measured, tmp_path):
    lines, data = measured
    report = Report(quiet=True)
    report.say(*lines)
    text, numbers = report.write(tmp_path, "name", data)
    assert json.loads(numbers.read_text(encoding="utf-8"))["scenes"].keys() == {"box-room"}
    assert "box-room" in text.read_text(encoding="utf-8")


@slow
def test_cells_that_disagree_are_no_result(measured):
    cell = cells.Cell(cells.PACKETS, cells.ExecutionPlan(), 1)
    timing = throughput.Timing(1.0, 1, 0.0, 1.0, "sha256:one")
    other = throughput.Timing(1.0, 1, 0.0, 1.0, "sha256:other")
    with pytest.raises(AssertionError, match="disagree"):
        throughput._same_digest("scene", [throughput.Series(cell, [timing, other])])


FAST = ("lambertian-sphere",)
"""Presets that are traced in all modes every time: each is a program more."""


LIKE_OTHERS = ("cassegrain", "square-lightpipe")
"""Presets whose elements the baffled ones have as well, the telescope and the tube."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name in LIKE_OTHERS else ())
        for name in preset_names()
    ],
)
def test_a_preset_gives_its_stored_digest(name, device):
    # the bits are the same at every width, and narrow lanes build fastest
    made = digests.entry(device, name, default_plan(device.record, 4))
    same, why = digests.compare(made, digests.stored().get(name))
    assert same, f"{why}; after a change on purpose: python -m benchmarks.digests --write"


@pytest.mark.parametrize(
    ("name", "mode"),
    [
        pytest.param(name, mode, marks=() if name in FAST else pytest.mark.slow)
        for name in preset_names()
        for mode in ("mixed", "fp32")
    ],
)
def test_a_preset_gives_its_stored_digest_in_single_precision(name, mode, device):
    made = digests.entry(device, name, default_plan(device.record, 4), precision=mode)
    same, why = digests.compare(made, digests.stored(mode).get(name))
    assert same, f"{why}; after a change on purpose: python -m benchmarks.digests --write"


def test_a_changed_preset_is_told_from_a_wrong_device():
    entry = {"digest": "sha256:a", "interactions": 1, "tables": "sha256:t"}
    assert digests.compare(entry, dict(entry))[0] is True
    assert digests.compare({**entry, "digest": "sha256:b"}, entry)[0] is False
    assert digests.compare({**entry, "digest": "sha256:b", "tables": "sha256:u"}, entry)[0] is None
    assert digests.compare(entry, None)[0] is None


def test_a_build_is_measured(device):
    selector = f"{device.record.platform_index}:{device.record.device_index}"
    found = builds.one("cosine-fourth", selector)
    assert 0.0 < found["program"] <= found["build"] <= found["first_result"]
    assert found["kernels"] >= 1
    assert found["source_bytes"] > found["source_lines"] > 100


def test_facts_name_no_machine_or_directory(device):
    text = json.dumps(facts.facts(device.record))
    assert str(facts.ROOT) not in text
    assert not re.search(r"/(home|tmp|root|work)\b", text)


def test_spread_and_table():
    spread = Spread.of([3.0, 1.0, 2.0, 4.0, 5.0])
    assert (spread.median, spread.low, spread.high, spread.least, spread.most) == (3, 2, 4, 1, 5)
    assert spread.text(1) == "3.0 [2.0–4.0]"
    assert Spread.of([7.0]).text(0, 100.0) == "700 [700–700]"
    assert table(["a", "bb"], [["x", "1"], ["yyy", "22"]]) == [
        "a    bb",
        "---  --",
        "x     1",
        "yyy  22",
    ]


def test_an_unknown_device_is_said_and_not_raised(capsys):
    assert command.main(["--device", "no such device"]) == 2
    assert "no such device" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("slowdown", "same_bits", "holds"), [(2.5, True, True), (1.9, True, False), (2.5, False, False)]
)
def test_a_specialised_program_that_gains_too_little_or_differs_is_told(slowdown, same_bits, holds):
    ratio = {"median": slowdown, "low": 1.8, "high": 2.6, "rounds": 3}
    prices = {
        EVERYTHING: {"slowdown": ratio, "same_bits": same_bits},
        EVERY_EFFECT: {"slowdown": {**ratio, "median": 1.2}, "same_bits": True},
    }
    report = Report(quiet=True)
    assert specialised.verdicts({"box-room": prices}, report) == holds
    said = "\n".join(report.kept)
    assert f"{EVERYTHING}: {slowdown:.2f} [1.80–2.60], wanted ≥ 2" in said
    assert f"{EVERY_EFFECT}: 1.20" in said
    assert ("FAILS" in said) != holds
