"""Every malformed scene gives exactly its problems: path, value found, what was expected."""

import copy
import json
import math
import pickle

import pytest
import tomli_w
from malformed import CASES, GOOD, edited

from photizon_cl.errors import Problem, SceneError
from photizon_cl.scene.files import load

IDS = [name for name, _, _ in CASES]


def problems_of(source):
    with pytest.raises(SceneError) as caught:
        load(source)
    assert caught.value.exit_code == 2
    assert len(str(caught.value).splitlines()) == len(caught.value.problems)
    return caught.value.problems


def compare(problems, expected, file):
    assert [problem.path for problem in problems] == [path for path, _, _ in expected]
    for problem, (path, found, wanted) in zip(problems, expected, strict=True):
        assert problem.found == found
        assert problem.expected.startswith(wanted)
        assert problem.file == file
        line = f"{path}: found {found}, expected {wanted}"
        assert str(problem).startswith(line if file is None else f"{file}: {line}")


def test_the_scene_that_is_edited_is_good():
    assert load(GOOD).name == "good"
    assert len(CASES) >= 100


@pytest.mark.parametrize(("name", "changes", "expected"), CASES, ids=IDS)
def test_tables(name, changes, expected):
    compare(problems_of(edited(changes)), expected, None)


@pytest.mark.parametrize(("name", "changes", "expected"), CASES, ids=IDS)
def test_json(name, changes, expected, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(edited(changes)), encoding="utf-8")
    compare(problems_of(path), expected, str(path))


@pytest.mark.parametrize(("name", "changes", "expected"), CASES, ids=IDS)
def test_toml(name, changes, expected, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(tomli_w.dumps(edited(changes)), encoding="utf-8")
    compare(problems_of(str(path)), expected, str(path))


@pytest.mark.parametrize(
    ("suffix", "content", "place", "found", "expected", "hint"),
    [
        (".toml", b"", "", "an empty file", "a scene file", "preset"),
        (".json", b" \n\t\n", "", "an empty file", "a scene file", "preset"),
        (".toml", b'name = "caf\xe9"\n', "line 1", "the byte 0xe9", "text in UTF-8", "UTF-8"),
        (".json", b'{\n"name": "\xff"}', "line 2", "the byte 0xff", "text in UTF-8", "UTF-8"),
        (".toml", b"a = 1\nb = = 2\n", "line 2, column 5", "a syntax error", "valid TOML", ""),
        (".toml", b"a = 1\na = 2\n", "line 2, column 6", "a syntax error", "valid TOML", ""),
        (".toml", b'a = "x\n', "line 1, column 7", "a syntax error", "valid TOML", ""),
        (".toml", b"a = \n", "line 1, column 5", "a syntax error", "valid TOML", ""),
        (".toml", b"a = [1,\n 2", "line 2, column 3", "a syntax error", "valid TOML", ""),
        (
            ".toml",
            b"a = 1\nb = 250mm\n",
            "line 2",
            "a syntax error",
            "valid TOML",
            "250 mm is 0.25",
        ),
        (".toml", "b = [0.1, 5 °]\n".encode(), "line 1", "a syntax error", "valid TOML", "units"),
        (".toml", b"a = 2026-13-45\n", "line 1", "a syntax error", "valid TOML", ""),
        (".toml", b"\x00", "line 1, column 1", "a syntax error", "valid TOML", ""),
        (".toml", b"a = " + b"9" * 5000, "", "a syntax error", "valid TOML", "digits"),
        (".toml", b"a = " + b"[" * 100000, "", "more than 64 tables or arrays within", "fewer", ""),
        (".json", b'{"a": 1,}', "line 1, column", "a syntax error", "valid JSON", ""),
        (".json", b'{\n  "a": tru\n}', "line 2, column 8", "a syntax error", "valid JSON", ""),
        (".json", b"{} x", "line 1, column 4", "a syntax error", "valid JSON", ""),
        (".json", b'{"a": ' + b"9" * 5000 + b"}", "", "a syntax error", "valid JSON", "digits"),
        (".json", b"[" * 200000, "", "a syntax error", "valid JSON", "deep"),
        (".json", b"[1]", "", "[1]", "a table", ""),
        (".json", b"null", "", "null", "a table", ""),
        (".json", b'"box-room"', "", '"box-room"', "a table", ""),
        (".yaml", b"a: 1\n", "", 'the ending ".yaml"', "a file that ends in .toml or .json", ""),
        ("", b"a = 1\n", "", 'the ending ""', "a file that ends in .toml or .json", ""),
    ],
)
def test_unreadable_content(suffix, content, place, found, expected, hint, tmp_path):
    path = tmp_path / f"scene{suffix}"
    path.write_bytes(content)
    (problem,) = problems_of(path)
    assert problem.file == str(path)
    assert problem.path.startswith(place)
    assert problem.found.startswith(found)
    assert problem.expected.startswith(expected)
    assert hint in problem.hint
    assert str(problem).startswith(str(path) + ": ")


def test_unreadable_places(tmp_path):
    (problem,) = problems_of(tmp_path)
    assert (problem.found, problem.file) == ("a directory", str(tmp_path))
    folder = tmp_path / "folder.toml"
    folder.mkdir()
    assert problems_of(folder)[0].found == "a directory"
    (problem,) = problems_of(tmp_path / "absent.toml")
    assert problem.found == "no such file"
    assert problems_of(tmp_path / "absent.toml" / "deeper.json")[0].found == "no such file"
    link = tmp_path / "loop.toml"
    link.symlink_to(link)
    assert len(problems_of(link)) == 1
    assert len(problems_of("a\0b.toml")) == 1
    assert len(problems_of("x" * 5000)) == 1
    assert len(problems_of("x" * 5000 + ".toml")) == 1


def test_a_file_that_may_not_be_read(tmp_path, monkeypatch):
    path = tmp_path / "scene.toml"
    path.write_text("a = 1")

    def refuse(self, *mode):
        raise PermissionError(13, "Permission denied")

    # Patched rather than chmod: the superuser may read everything.
    monkeypatch.setattr("pathlib.Path.open", refuse)
    (problem,) = problems_of(path)
    assert problem.found == "a file that cannot be read: Permission denied"


def test_a_file_too_large(tmp_path):
    path = tmp_path / "scene.toml"
    with path.open("wb") as file:
        file.truncate(2**24 + 1)
    assert problems_of(path)[0].found == f"{2**24 + 1} bytes"


def test_a_name_that_is_nothing_lists_presets_and_the_nearest():
    (problem,) = problems_of("integratingsphere")
    assert problem.found == '"integratingsphere", which is neither a preset nor a file'
    assert "did you mean integrating-sphere?" in problem.hint
    assert "box-room" in problem.hint
    assert problems_of("")[0].expected


@pytest.mark.parametrize("source", [None, 3, 2.5, ["box-room"], object])
def test_a_source_of_the_wrong_type(source):
    assert len(problems_of(source)) == 1


def test_json_repeated_keys(tmp_path):
    text = json.dumps(GOOD)
    text = text.replace('"seed": 7', '"seed": 7, "seed": 8, "seed": 9')
    text = text.replace('"kind": "absorber"', '"kind": "mirror", "kind": "absorber"')
    path = tmp_path / "scene.json"
    path.write_text('{"name": "first", ' + text[1:])
    problems = problems_of(path)
    assert [p.path for p in problems] == ["name", "element[0].surface.kind", "run.seed"]
    assert {p.found for p in problems} == {"the key more than once"}


def test_json_literals_that_are_not_json(tmp_path):
    text = json.dumps(edited([(("source", 0, "flux"), 123456.5)]))
    for literal, shown in (("NaN", "nan"), ("-Infinity", "-inf"), ("1e999", "inf")):
        path = tmp_path / "scene.json"
        path.write_text(text.replace("123456.5", literal))
        (problem,) = problems_of(path)
        assert (problem.path, problem.found) == ("source[0].flux", shown)
        assert problem.hint == "it must be finite"


def test_null_is_not_absent():
    problems = problems_of(edited([(("element", 0, "detector"), None), (("far_field",), None)]))
    assert [p.found for p in problems] == ["null", "null"]


def test_lone_surrogates(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(edited([(("name",), "a\ud800"), (("notes",), "\udfff")])))
    problems = problems_of(path)
    assert [p.path for p in problems] == ["name", "notes"]
    str(problems[0]).encode("utf-8")


def test_hints_say_what_to_do():
    def hint(*path_and_value):
        *path, value = path_and_value
        return problems_of(edited([(tuple(path), value)]))[0].hint

    assert hint("element", 2, "raduis", 2.0) == "did you mean radius?"
    assert hint("element", 2, "Radius", 2.0) == "did you mean radius?"
    assert hint("element", 0, "kind", "Rectangle") == 'did you mean "rectangle"?'
    assert hint("run", "seed", 1e3) == "write 1000, without a decimal point or exponent"
    assert hint("element", 1, "radius", "0.5") == "write the number without quotes"
    assert hint("element", 1, "radius", True) == "a boolean is not a number"
    assert "two brackets" in hint("element", {})
    assert hint("element", 0, "surface", "absorber") == 'write { kind = "absorber" }'
    assert "counts what ends on a surface" in hint("element", 1, "detector", {})
    assert "close the port" in hint("element", 2, "port_fraction", 0.1)
    assert hint("source", 1, "share", 2.0).startswith("source[1] gives one")


def test_problems_name_the_element():
    (problem,) = problems_of(edited([(("element", 1, "surface", "reflectance"), -0.1)]))
    assert problem.owner == 'element "plate"'
    assert str(problem) == (
        "element[1].surface.reflectance: found -0.1, expected a number in [0, 1] "
        '(in element "plate"; the rest, 1 − ρ, is absorbed)'
    )


def test_keys_that_are_not_text():
    tables = copy.deepcopy(GOOD)
    tables[3] = 4
    tables["element"][0][("a", 1)] = math.pi
    assert [p.path for p in problems_of(tables)] == ["3", 'element[0]["a", 1]']


def test_long_values_are_cut():
    (problem,) = problems_of(edited([(("element", 1, "radius"), "x" * 10**6)]))
    assert len(problem.found) == 60
    deep = []
    for _ in range(10000):
        deep = [deep]
    assert problems_of(edited([(("element", 1, "radius"), deep)]))[0].found == "[[[…]]]"


def test_errors_survive_pickling():
    error = SceneError([Problem("a.b", "1", "2", file="f.toml", hint="h")])
    copied = pickle.loads(pickle.dumps(error))
    assert copied.problems == error.problems
    assert str(copied) == "f.toml: a.b: found 1, expected 2 (h)"


AWKWARD = [
    None, True, 0, -1, 2**70, 0.5, -0.0, 1e308, math.nan, math.inf, "", "disk", "x" * 99, "\ud800",
    [], [1], [0, 0, 0], [[1]], ["a", None], {}, {"kind": "mirror"}, {"kind": []}, {"name": "lamp"},
    {"map": [1, 2]}, [{}], [{"kind": "disk", "name": "q"}], b"bytes", object(), 1j,
]  # fmt: skip


def test_any_value_anywhere_is_read_or_refused_cleanly():
    paths = []

    def walk(value, path):
        if path:
            paths.append(path)
        items = value.items() if isinstance(value, dict) else enumerate(value)
        for key, child in items if isinstance(value, dict | list) else ():
            if isinstance(child, dict | list):
                walk(child, (*path, key))
            else:
                paths.append((*path, key))

    walk(GOOD, ())
    for path in paths:
        for value in AWKWARD:
            lines, count = outcome(edited([(path, value)]))
            lines.encode("utf-8")
            assert len(lines.splitlines()) == count


def outcome(tables):
    try:
        load(tables)
    except SceneError as error:
        return str(error), len(error.problems)
    return "", 0
