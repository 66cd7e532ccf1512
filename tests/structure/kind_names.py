"""Where the product names a kind: identifiers and strings of Python and of the kernels.

Comments and docstrings are prose and do not count. In identifiers a kind counts between
underscores and in any case (``hit_sphere``, ``SPHERE``), since a name made of a kind is written for
that kind. In strings it counts as a file spells it, and as the class is called where that is all of
the string or no ordinary word (``BaffledTube``; "Lambertian" may be the adjective).
"""

from __future__ import annotations

import ast
import inspect
import io
import re
import tokenize
from pathlib import Path
from typing import TYPE_CHECKING

from photizon_cl.scene.registry import COATINGS, ELEMENTS, SCATTERS, SOURCES, SURFACES

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

ADJECTIVES = ("gaussian", "lambertian", "table")
"""Kinds of scatter that are words of their own, or other kinds as well; so are all coatings."""
KINDS = {kind: cls for group in (SOURCES, ELEMENTS, SURFACES) for kind, cls in group.items()}
KINDS |= {kind: cls for kind, cls in SCATTERS.items() if kind not in ADJECTIVES}
ORDINARY = {"disk_usage"}
"""Identifiers that are another's."""
WORDS = ("clear", "mixed", "lens")
"""Kinds that are ordinary words: only their class, their function or a string of nothing else names
them."""
ELSEWHERE = {("hostcode/program/precision.py", "mixed")}
"""Where a word means something else: a precision."""
_OWN = re.compile(
    rf"(meet|hit)_({'|'.join(WORDS)})|{'|'.join(word.capitalize() for word in WORDS)}"
)
_QUOTED = re.compile(rf"(meet|hit)_({'|'.join(WORDS)})|[\"']({'|'.join(WORDS)})[\"']")
_STRINGS = {tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", None)}


def _pattern(words: Iterable[str], flags: int = 0) -> re.Pattern[str]:
    longest_first = sorted(words, key=len, reverse=True)
    return re.compile(rf"(?<![A-Za-z0-9])({'|'.join(longest_first)})(?![A-Za-z0-9])", flags)


def _kind(name: str, kinds: Iterable[str]) -> str:
    """Return the kind that a name stands for, whichever way it is spelt."""
    plain = re.sub("[-_]", "", name).lower()
    return next(kind for kind in kinds if kind.replace("-", "") == plain)


def _patterns(kinds: Iterable[str]) -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Return what a kind is in an identifier, and in a string."""
    spelt = [kind.replace("-", "[-_]") for kind in kinds]
    classes = ["".join(part.capitalize() for part in kind.split("-")) for kind in kinds]
    long = [name for kind, name in zip(kinds, classes, strict=True) if "-" in kind]
    return _pattern([*spelt, *classes], re.IGNORECASE), _pattern([*spelt, *long])


def in_python(text: str, kinds: Iterable[str]) -> Iterator[tuple[int, str]]:
    """Give line and kind of each place in the text of a Python module."""
    identifiers, strings = _patterns([*kinds])
    docs = _docstrings(ast.parse(text))
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.NAME and token.string not in ORDINARY:
            found = identifiers.findall(token.string)
        elif token.type in _STRINGS and token.start not in docs:
            whole = identifiers.fullmatch(token.string.strip("\"'"))
            found = [whole[1]] if whole else strings.findall(token.string)
        else:
            continue
        for name in found:
            kind = _kind(name, kinds)
            bare = token.string.strip("\"'")
            if kind not in WORDS or (
                bare == kind if token.type in _STRINGS else _OWN.fullmatch(bare)
            ):
                yield token.start[0], kind


def _docstrings(tree: ast.AST) -> set[tuple[int, int]]:
    """Return where strings start that are statements: docstrings, and those behind attributes."""
    return {
        (node.lineno, node.col_offset)
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    }


def in_kernel(text: str, kinds: Iterable[str]) -> Iterator[tuple[int, str]]:
    """Give line and kind of each place in the text of a template."""
    identifiers, _ = _patterns([*kinds])
    blank = re.sub(
        r"/\*.*?\*/|<%doc>.*?</%doc>",
        lambda found: re.sub(r"[^\n]", " ", found[0]),
        text,
        flags=re.DOTALL,
    )
    for number, line in enumerate(blank.splitlines(), 1):
        code = re.sub(r"(//|##).*", "", line)
        for name in identifiers.findall(code):
            kind = _kind(name, kinds)
            if kind not in WORDS or _QUOTED.search(code):
                yield number, kind


def places(root: Path) -> list[tuple[str, int, str]]:
    """Return file, line and kind of each place where the product names one beside its own file."""
    product = root / "photizon_cl"
    classes = (*KINDS.values(), *SCATTERS.values(), *COATINGS.values())
    own = {Path(inspect.getfile(cls)) for cls in classes}
    own |= {root / "kernels" / f"{cls.label}s" / f"{cls.kernel}.mako" for cls in classes}
    # the list of kinds, and that of presets, whose names say what they show
    own |= {product / "scene" / "registry.py", product / "scene" / "presets.py"}
    found = []
    for folder, suffix, read in (
        (product, ".py", in_python),
        (product, ".mako", in_kernel),
        (root / "hostcode", ".py", in_python),
        (root / "kernels", ".mako", in_kernel),
    ):
        for path in sorted(folder.rglob(f"*{suffix}")):
            # the measurements of hard cases are tests that come along with the product
            if path in own or product / "stability" in path.parents:
                continue
            name = path.relative_to(root).as_posix()
            for line, kind in read(path.read_text(encoding="utf-8"), KINDS):
                if (name, kind) not in ELSEWHERE:
                    found.append((name, line, kind))
    return found
