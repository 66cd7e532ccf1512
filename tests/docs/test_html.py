"""The documentation builds without a warning and covers what there is."""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass, field
from typing import ClassVar

from photizon_docs import parts
from photizon_docs.command_line import command_line
from photizon_docs.tables import GROUPS

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.scene.declarations import positive_length
from photizon_cl.scene.sources.cosine_point import CosinePoint


def test_it_builds_without_a_warning(build):
    assert build.status == 0, build.said
    assert "warning" not in build.said.lower()


def test_every_kind_has_a_page_with_a_figure(build):
    for group, kinds in GROUPS.items():
        folder = build.pages / "parts" / f"{group}s"
        assert {p.stem for p in folder.glob("*.html")} == {*kinds, "index"}
        for kind in kinds:
            # kinds of two groups may have one name, and Sphinx numbers their figures
            page = (folder / f"{kind}.html").read_text("utf-8")
            found = re.search(rf"_images/({re.escape(kind)}\d*\.png)", page)
            assert found, f"{group} {kind}"
            assert (build.pages / "_images" / found[1]).exists()


def test_nothing_is_fetched_when_a_page_is_read(build):
    for page in build.pages.rglob("*.html"):
        text = page.read_text("utf-8")
        loaded = re.findall(r'<(?:script|img)[^>]+src="([^"]+)"', text)
        loaded += re.findall(r'<link[^>]+rel="(?:stylesheet|preload)[^>]+href="([^"]+)"', text)
        assert not [address for address in loaded if "//" in address], page.name


def test_every_public_name_is_in_the_reference(build):
    text = (build.pages / "python.html").read_text("utf-8")
    for name in pz.__all__:
        if name != "__version__":
            kind = "module-" if inspect.ismodule(getattr(pz, name)) else ""
            assert f'id="{kind}photizon_cl.{name}"' in text, name


def test_every_verb_and_option_is_in_the_reference(capsys):
    text = command_line()
    assert main(["--help"]) == 0
    for verb in re.findall(r"^    ([a-z][\w-]*) ", capsys.readouterr().out, re.M):
        assert f"\n## {verb}\n" in text
        assert main([verb, "--help"]) == 0
        for option in re.findall(r"--[a-z][\w-]*", capsys.readouterr().out):
            assert option == "--help" or option in text, (verb, option)


def test_a_new_kind_gets_a_page_by_itself(monkeypatch):
    @dataclass(frozen=True, kw_only=True)
    class Novel(CosinePoint):
        """A source nobody has written an example for.

        Parameters
        ----------
        waist : float
            In metres.
        """

        kind: ClassVar[str] = "novel"
        waist: float = field(metadata=positive_length("width of the waist"))

    from photizon_cl.scene import registry

    monkeypatch.setitem(registry.SOURCES, "novel", Novel)
    monkeypatch.setattr(pz, "Novel", Novel, raising=False)
    text, scene = parts.page("source", "novel", Novel)
    assert "| `waist` | width of the waist | m |" in text
    assert "pz.Novel(" in text
    assert scene.source[0].waist == 0.05
    assert "`novel`" in parts.group_index("source")
