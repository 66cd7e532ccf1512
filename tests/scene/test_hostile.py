"""Scenes that are made to take time, memory or the reader's screen: one line each, at once."""

from __future__ import annotations

import time
import tracemalloc

import pytest

from photizon_cl.cli.main import main
from photizon_cl.errors import MOST_PROBLEMS, Problem, SceneError, key, printable, show
from photizon_cl.scene.files import load, parse_toml
from photizon_cl.scene.limits import toml_excess
from photizon_cl.scene.presets import preset_names, preset_path

HEAD = 'schema = "photizon/1"\nname = "x"\n'
LAMP = '[[source]]\nname = "s"\nkind = "isotropic-point"\nflux = 1\nposition = [0, 0, 0]\n'

HOSTILE = {
    "a key of very many parts": (".toml", lambda: ".".join(["a"] * 100_000) + " = 1\n"),
    "a table of very many parts": (".toml", lambda: "[" + ".".join(["a"] * 100_000) + "]\n"),
    "quoted parts": (".toml", lambda: ".".join(['"a"'] * 50_000) + " = 1\n"),
    "parts in an inline table": (".toml", lambda: "x = { " + ".".join("a" * 50_000) + " = 1 }\n"),
    "parts after a long string": (
        ".toml", lambda: 'notes = """\n' + "a" * 9999 + '"""\n' + ".".join("a" * 50_000) + " = 1\n"
    ),
    "many keys of some parts": (
        ".toml", lambda: "".join(f"a{i}.b.c.d.e.f.g.h = 1\n" for i in range(150_000))
    ),
    "many tables": (".toml", lambda: "".join(f"[a{i}]\n" for i in range(600_000))),
    "deep arrays": (".toml", lambda: "a = " + "[" * 100_000 + "]" * 100_000),
    "deep tables": (".toml", lambda: "a = " + "{a = " * 50_000 + "1" + "}" * 50_000),
    "many lists": (".json", lambda: "[" + "[]," * 3_000_000 + "0]"),
    "keys that stand twice": (
        ".json", lambda: "{" + ",".join(f'"k{i}": 1, "k{i}": 2' for i in range(20_000)) + "}"
    ),
    "unknown keys": (".toml", lambda: HEAD + "".join(f"key{i} = 1\n" for i in range(150_000))),
    "elements that are none": (".json", lambda: '{"element": [' + "0," * 1_000_000 + "0]}"),
    "elements without anything": (".toml", lambda: HEAD + "[[element]]\n" * 150_000),
    "elements of one name": (
        ".toml", lambda: HEAD + LAMP + LAMP * 8_000
    ),
    "a very long key": (".toml", lambda: HEAD + "k" * 10_000_000 + " = 1\n"),
    "a very long key in quotes": (".toml", lambda: f'{HEAD}"{"k " * 5_000_000}" = 1\n'),
    "a very long kind": (".toml", lambda: f'{HEAD}[[source]]\nkind = "{"k" * 10_000_000}"\n'),
    "a very long number": (".toml", lambda: f"{HEAD}[run]\nseed = 0x{'f' * 10_000_000}\n"),
}  # fmt: skip


def told_by(path, capsys):
    assert main(["check", str(path)]) == 2
    out, err = capsys.readouterr()
    assert not out
    return err


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_scenes_end_at_once(name, tmp_path, capsys):
    suffix, text = HOSTILE[name]
    path = tmp_path / f"scene{suffix}"
    path.write_text(text(), encoding="utf-8")
    started = time.perf_counter()
    err = told_by(path, capsys)
    assert time.perf_counter() - started < 8.0
    assert 1 <= len(err.splitlines()) <= MOST_PROBLEMS
    assert len(err) < 100_000
    assert max(map(len, err.splitlines())) < 800
    assert "Traceback" not in err


@pytest.mark.parametrize(
    "name", ["a key of very many parts", "many tables", "many lists", "many keys of some parts"]
)
def test_what_is_refused_takes_no_memory(name, tmp_path):
    suffix, text = HOSTILE[name]
    path = tmp_path / f"scene{suffix}"
    path.write_text(text(), encoding="utf-8")
    tracemalloc.start()
    try:
        with pytest.raises(SceneError):
            load(path)
        assert tracemalloc.get_traced_memory()[1] < 400e6
    finally:
        tracemalloc.stop()


def test_the_rest_of_very_many_problems_is_counted():
    problems = [Problem(f"element[{i}]", "0", "a table") for i in range(1000)]
    error = SceneError(problems)
    assert error.problems[:-1] == tuple(problems[: MOST_PROBLEMS - 1])
    assert str(error).endswith(f"found at least 901 more problems, expected none (the first "
                               f"{MOST_PROBLEMS - 1} are told)")  # fmt: skip
    assert SceneError(error.problems).problems == error.problems
    assert SceneError(problems[:MOST_PROBLEMS]).problems == tuple(problems[:MOST_PROBLEMS])


@pytest.mark.parametrize(
    "text",
    [
        'notes = "a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t"\n',
        "notes = 'a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t'\n",
        'notes = """\na.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t = [[[[[\n"""\n',
        'notes = """a\\"""" # b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t\n',
        "notes = '''\n''a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t'''\n",
        "# a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t\n",
        "a = [" + ", ".join(["1.5"] * 40) + "]\n",
        "a = [" + ", ".join(["{ b.c = 1.5 }"] * 40) + "]\n",
        "a = { b = 1.5, c = [" + "1.5, " * 40 + "], d.e = 2.5 }\n",
        "a = [\n" + "  1.5,\n" * 40 + "]\nb.c = 1\n",
        "a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p = 1\n",
        'notes = "' + "[" * 100 + '"\n',
    ],
)
def test_what_only_looks_so_is_let_through(text):
    assert toml_excess(text) == ("", "")
    parse_toml(text)


def test_presets_are_far_from_the_limits():
    for name in preset_names():
        assert toml_excess(preset_path(name).read_text("utf-8") * 500) == ("", "")


# -- what may be shown -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[2J", "\\u001b[2J"),
        ("a\u202eb", "a\\u202eb"),
        ("\u2066x\u2069", "\\u2066x\\u2069"),
        ("\U000e0001", "\\U000e0001"),
        ("\x9b\x85", "\\u009b\\u0085"),
        ("two\nlines", "two\\u000alines"),
        ("Größe שלום σ", "Größe שלום σ"),
    ],
)
def test_what_could_fool_a_reader_is_escaped(text, shown):
    assert printable(text) == shown
    assert show(text).isprintable()
    assert key(text).isprintable()


def test_long_keys_are_cut():
    assert len(key("k" * 10**6)) < 80
    assert key("half_width") == "half_width"


@pytest.mark.parametrize(
    "arguments",
    [
        ["check", "box-room", "\x1b[2J\u202e"],
        ["\x1b[2J\u202e"],
        ["run", "box-room", "--seed", "\x1b[2J\u202e"],
        ["run", "box-room", "--\x1b[2J\u202e"],
        ["run", "box-room", "--device", "\x1b[2J\u202e"],
        ["run", "--recipe", "\x1b[2J\u202e"],
        ["check", "\x1b[2J\u202e"],
        ["check", "\x1b[2J\u202e.toml"],
        ["kinds", "\x1b[2J\u202e"],
        ["presets", "\x1b[2J\u202e"],
        ["report", "\x1b[2J\u202e"],
        ["resume", "\x1b[2J\u202e"],
        ["check", "x" * 100_000],
        ["check", "box-room", "x" * 100_000],
    ],
)
def test_arguments_are_shown_escaped(arguments, capsys):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert not out
    assert all(line.isprintable() for line in err.splitlines())
    assert "\\u202e" in err or "\\x1b" in err or "xxx" in err
    assert len(err) < 5000


def test_titles_are_shown_escaped(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    text = f'{HEAD}title = "left\\u202eright\\u200b"\n{LAMP}'
    path.write_text(text, encoding="utf-8")
    assert main(["check", str(path)]) == 0
    out = capsys.readouterr().out
    assert "left\\u202eright\\u200b" in out
    assert all(line.isprintable() for line in out.splitlines())
    assert load(path).heading == "left\\u202eright\\u200b"
