"""What every row of the registry must hold in files: what is written is read back as it was."""

from __future__ import annotations

import json
import tomllib

from contract import GROUPS, every_kind, everything, of_kind, shown
from photizon_docs.emit import as_toml

from photizon_cl.scene.files import load
from photizon_cl.scene.writing import to_json, to_toml

WRITERS = ((to_toml, "full.toml"), (as_toml, "short.toml"), (to_json, "full.json"))


def given_back(scene, folder):
    """Return the scene as each kind of file gives it back."""
    found = []
    for write, name in WRITERS:
        (folder / name).write_text(write(scene), encoding="utf-8")
        found.append(load(folder / name))
    return found


@every_kind
def test_files_give_back_what_they_hold(group, kind, tmp_path):
    scene = shown(group, kind)
    assert load(scene.to_dict()) == scene
    for again in given_back(scene, tmp_path):
        assert again == scene
        assert of_kind(again, group, kind) == of_kind(scene, group, kind)


def test_a_scene_of_everything_comes_back(tmp_path):
    scene = everything()
    kinds = {
        "element": {e.kind for e in scene.element},
        "surface": {e.surface.kind for e in scene.element},
        "source": {s.kind for s in scene.source},
        "scatter": {e.surface.lobe.kind for e in scene.element if e.surface.lobe is not None},
        "coating": {e.surface.coat.kind for e in scene.element if e.surface.coat is not None},
    }
    assert kinds == {group: set(rows) for group, rows in GROUPS.items()}
    for again in given_back(scene, tmp_path):
        assert again == scene
        assert again.to_dict() == scene.to_dict()
    both = tomllib.loads(to_toml(scene)), json.loads(to_json(scene))
    assert both[0] == both[1] == json.loads(json.dumps(scene.to_dict()))
