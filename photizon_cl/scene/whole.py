"""Objects that are one value: read whole, from a table of a file or as an instance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from photizon_cl.errors import Problem, join, key, show
from photizon_cl.scene.described import Described, Known, is_required, parameters_of
from photizon_cl.scene.names import similar
from photizon_cl.scene.parameters import BAD

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["read_whole"]

_D = TypeVar("_D", bound=Described)


def read_whole(
    cls: type[Described] | Mapping[str, type[Described]],
    found: Mapping[str, Any],
    path: str,
    problems: list[Problem],
    title: str,
) -> Any:
    """Return the object that a table describes, or add to `problems` and return `BAD`.

    Parameters
    ----------
    cls : type, or mapping of str to type
        Its class, or the classes by the kind that the table names.
    found : mapping
        The table.
    path : str
        Its path, for messages.
    problems : list of Problem
        What is wrong is added here.
    title : str
        What it is, as the subject of a sentence.
    """
    before = len(problems)
    accepted: list[str] = []
    if isinstance(cls, Mapping):
        kind = found.get("kind")
        if not (isinstance(kind, str) and kind in cls):
            shown = show(kind) if "kind" in found else "nothing"
            expected = "one of " + " ".join(map(show, cls))
            hint = _meant(kind, cls) if "kind" in found else f"{title} requires the key kind"
            problems.append(Problem(join(path, "kind"), shown, expected, hint=hint))
            return BAD
        accepted, cls = ["kind"], cls[kind]
    accepted += parameters_of(cls)
    for item in getattr(found, "repeated", ()):
        expected = "every key once in its object"
        problems.append(Problem(join(path, key(item)), "the key more than once", expected))
    for item in found:
        if item not in accepted:
            expected = f"no such key; {title} takes {', '.join(accepted)}"
            where, hint = join(path, key(item)), _meant(item, accepted)
            problems.append(Problem(where, show(found[item]), expected, hint=hint))
    values: dict[str, Any] = {}
    for item, parameter in parameters_of(cls).items():
        where = join(path, item)
        if item in found:
            value = parameter.read(found[item], where, problems)
            if value is not BAD:
                values[item] = value
        elif is_required(cls, item):
            hint = f"{title} requires the key {item}"
            problems.append(Problem(where, "nothing", parameter.expected, hint=hint))
    if len(problems) == before:
        problems += [problem.under(path) for problem in cls.cross_check(Known(cls, values))]
    return BAD if len(problems) > before else cls(**values)


def _meant(word: object, known: Iterable[str]) -> str:
    near = similar(word, known)
    return f"did you mean {near[0]}?" if near else ""
