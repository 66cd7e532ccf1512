"""The imports of the product, read from its source: at the top, in functions, for types."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from pathlib import Path

PACKAGES = ("photizon_cl", "hostcode")


@dataclass(frozen=True)
class Import:
    """One module imports another.

    Parameters
    ----------
    place : str
        File and line.
    source, target : str
        The modules.
    types_only : bool
        Whether it stands under ``if TYPE_CHECKING``.
    """

    place: str
    source: str
    target: str
    types_only: bool


def imports(root: Path) -> list[Import]:
    """Return every import of one product module by another below a folder."""
    files = {_module(path, root): path for name in PACKAGES for path in (root / name).rglob("*.py")}
    found: list[Import] = []
    for source, path in sorted(files.items()):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node, types_only in _import_nodes(tree, False):
            place = f"{path.relative_to(root)}:{node.lineno}"
            for target in _targets(node, files, source, path.name == "__init__.py"):
                found.append(Import(place, source, target, types_only))
    return found


def _module(path: Path, root: Path) -> str:
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _import_nodes(
    node: ast.AST, types_only: bool
) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child, types_only
        elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            positive = isinstance(child.test, ast.Name | ast.Attribute)
            for part, types in ((child.body, positive), (child.orelse, not positive)):
                yield from _import_nodes(ast.Module(part, []), types_only or types)
        else:
            yield from _import_nodes(child, types_only)


def _targets(
    node: ast.Import | ast.ImportFrom, modules: Iterable[str], source: str, package: bool
) -> Iterator[str]:
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    else:
        base = source.split(".")[: -(node.level - package) or None] if node.level else []
        module = ".".join([*base, *(node.module or "").split(".")]).strip(".")
        whole = {f"{module}.{alias.name}" for alias in node.names}
        names = [n if n in modules else module for n in sorted(whole)]
    yield from dict.fromkeys(name for name in names if name.split(".")[0] in PACKAGES)


def folder(module: str) -> str:
    """Return the folder of a module as the table names it: the first two parts of its name."""
    return ".".join(module.split(".")[:2])


def violations(found: Iterable[Import], allowed: Mapping[str, Iterable[str]]) -> list[str]:
    """Return the imports that the table does not allow, those for types included.

    Parameters
    ----------
    found : iterable of Import
        All imports.
    allowed : mapping
        Folder (or module at a package's top) → what it may import besides itself.
    """
    wrong = []
    for item in found:
        source, target = folder(item.source), folder(item.target)
        if source == target:
            continue
        if source not in allowed:
            wrong.append(f"{item.place}: {source} is not in the table")
        elif target not in allowed[source]:
            wrong.append(f"{item.place}: {source} may not import {item.target}")
    return wrong


def cycle(found: Iterable[Import]) -> list[str]:
    """Return the modules of a cycle of imports, at the top or in functions; empty without one."""
    graph: dict[str, set[str]] = {}
    for item in found:
        if not item.types_only and item.source != item.target:
            graph.setdefault(item.source, set()).add(item.target)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []
