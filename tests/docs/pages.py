"""Runs the examples of a page: files, commands, Python, and what they are said to print.

- ``toml``, ``python`` and other blocks with a caption that names a file write that file; a caption
  that ends in "(added at the end)" appends. A written scene is loaded; a sweep file is not one.
- ``diff`` blocks change the file of their caption: each hunk's old lines must stand in it once.
- ``console`` blocks run each line after ``$`` and compare what it prints.
- ``python`` blocks run in one namespace a page; an ``output`` block is what the last one printed.

In shown output ``…`` stands for anything: time, device, digest. Run as a script it fills a page's
output in.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

from sybil import Sybil
from sybil.parsers.myst import CodeBlockParser

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.scene.sweeps import SWEEP_SCHEMA

ROOT = Path(__file__).resolve().parents[2]
CAPTION = re.compile(r"(?P<file>[\w./-]+\.\w+)(?P<added> \(added at the end\))?")


def matches(shown: str, printed: str) -> bool:
    """Say whether a text is the one shown, where ``…`` stands for anything."""
    wanted = ".*?".join(re.escape(part) for part in shown.strip().split("…"))
    return re.fullmatch(wanted, printed.strip(), re.S) is not None


VARYING = (
    (re.compile(r"[\d.]+ M\s+interactions\s+in\s+[\d.]+ s\s+on\s+.*?\)(?=\n)", re.S), "…"),
    (re.compile(r"sha256:[0-9a-f]{64}"), "sha256:…"),
    (re.compile(r"[\d.e-]+ s of\s+tracing"), "…"),
)
"""What differs between machines, and how the pages show it."""

OF_A_DEVICE = re.compile(r"Portable Computing|pthread-|Intel\(R\)|NVIDIA")


def apply_hunks(text: str, diff: str) -> str:
    """Return a text with a diff's hunks applied; line numbers play no part."""
    for hunk in re.split(r"^@@.*\n", diff, flags=re.M):
        lines = [line for line in hunk.splitlines() if line]
        old = "".join(f"{line[1:]}\n" for line in lines if line[0] in " -")
        new = "".join(f"{line[1:]}\n" for line in lines if line[0] in " +")
        if lines:
            assert text.count(old) == 1, f"these lines stand {text.count(old)} times:\n{old}"
            text = text.replace(old, new)
    return text


class Runner:
    """Evaluates a page's blocks in a directory.

    `apart` runs commands and Python in processes of their own that import the packages of that
    directory: for a page that changes them.
    """

    def __init__(self, folder: Path, *, apart: bool = False, fill: bool = False) -> None:
        self.folder, self.apart, self.ran = folder, apart, 0
        self.fill = fill
        self.changes: list[tuple[int, str, str]] = []
        self.names: dict[str, object] = {}
        self.printed = ""

    def run(self, page: Path) -> int:
        """Evaluate every example of a page in order; return how many there were."""
        blocks = {
            "console": self.console,
            "python": self.python,
            "output": self.output,
            "toml": self.file,
            "c": self.file,
            "diff": self.diff,
        }
        parsers = [CodeBlockParser(language, call) for language, call in blocks.items()]
        for example in Sybil(parsers).parse(page):
            with contextlib.chdir(self.folder):
                example.evaluate()
            self.ran += 1
        return self.ran

    def caption(self, example):
        options = example.region.lexemes.get("options") or {}
        # a caption is Markdown, so underscores in it may be escaped
        found = CAPTION.fullmatch((options.get("caption") or "").replace("\\", ""))
        return found and (self.folder / found["file"], bool(found["added"]))

    def file(self, example):
        caption, text = self.caption(example), str(example.parsed)
        if caption is None:
            tomllib.loads(text)  # a fragment
            return
        path, added = caption
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text((path.read_text("utf-8") if added else "") + text, encoding="utf-8")
        if path.suffix == ".toml" and not self.apart and SWEEP_SCHEMA not in text:
            pz.load(path)

    def diff(self, example):
        path, _ = self.caption(example)
        path.write_text(apply_hunks(path.read_text("utf-8"), str(example.parsed)), encoding="utf-8")

    def python(self, example):
        if self.caption(example):
            self.file(example)
        elif self.apart:
            self.printed = self.process("-c", str(example.parsed))
        else:
            out = io.StringIO()
            # as many lines as stand above it, so that a traceback names the page's own
            source = "\n" * (example.line + example.parsed.line_offset) + example.parsed
            with contextlib.redirect_stdout(out):
                exec(compile(source, example.path, "exec"), self.names)
            self.printed = out.getvalue()

    def compare(self, example, shown, printed):
        named = OF_A_DEVICE.search(shown)
        assert not named, f"other machines' devices have other names: {named and named.group()}"
        if matches(shown, printed):
            return
        assert self.fill, f"shown:\n{shown}\nprinted:\n{printed}"
        for pattern, mark in VARYING:
            printed = pattern.sub(mark, printed)
        self.changes.append((example.region.start, shown, printed.strip("\n") + "\n"))

    def output(self, example):
        self.compare(example, str(example.parsed), self.printed)

    def console(self, example):
        for part in re.split(r"^\$ ", str(example.parsed), flags=re.M)[1:]:
            command, _, shown = part.partition("\n")
            words = shlex.split(command)
            assert words[0] == "photizon", f"not a photizon command: {command}"
            printed = self.command(words[1:])
            self.compare(example, f"$ {command}\n{shown}", f"$ {command}\n{printed}")

    def command(self, words):
        if self.apart:
            return self.process("-m", "photizon_cl.cli.main", *words)
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main(words)
        wrong = "found" in err.getvalue() and status == 2
        assert status == 0 or wrong, f"exit status {status}:\n{err.getvalue()}"
        return err.getvalue() if wrong else out.getvalue()

    def process(self, *words, timeout_s=120):
        done = subprocess.run(
            [sys.executable, *words],
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": str(self.folder)},
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout


def fill(page: Path, *, apart: bool = False) -> None:
    """Write what a page's commands and Python blocks print into it; for whoever edits a page.

    Run in a scratch directory: ``python tests/docs/pages.py docs/tutorial.md``.
    """
    runner = Runner(Path.cwd(), apart=apart, fill=True)
    runner.run(page)
    text = page.read_text("utf-8")
    for start, shown, printed in reversed(runner.changes):
        body = text.index("\n", start) + 1
        at = text.index(shown, body)
        text = text[:at] + printed + text[at + len(shown) :]
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    fill(Path(sys.argv[1]).resolve())
