"""Names of media, and whether those that a scene's objects give are there."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import Problem, join, show
from photizon_cl.scene.declarations import declare
from photizon_cl.scene.described import Described, Known, parameters_of
from photizon_cl.scene.parameters import Name

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from photizon_cl.scene.parameters import Parameter

__all__ = ["VACUUM", "MediumName", "media_of", "medium_name", "named_by"]

VACUUM: Final = "vacuum"
"""The medium that every scene has: index 1, no absorption."""
_MOST_NAMES: Final = 12


class MediumName(Name):
    """The name of a medium of the scene, or of the vacuum."""

    silent = True

    @property
    def expected(self) -> str:  # noqa: D102
        return f"the name of a medium of the scene, or {show(VACUUM)}"


def medium_name(meaning: str) -> dict[str, Parameter]:
    """Declare the name of a medium."""
    return declare(MediumName(meaning))


def media_of(media: Sequence[Known | None], **groups: Sequence[Known | None]) -> list[Problem]:
    """Return the problems of a scene's media, and of the names by which its objects call them.

    Parameters
    ----------
    media : sequence of Known or None
        The good values of the scene's media; None where an entry could not be read at all.
    **groups : sequence of Known or None
        Sources and elements, by the key of the scene that has them.
    """
    problems = []
    for i, known in enumerate(media):
        if known is not None and known.get("name") == VACUUM:
            hint = "it is always there, with index 1 and without absorption"
            expected = f"another name than {show(VACUUM)}"
            problems.append(Problem(f"medium[{i}].name", show(VACUUM), expected, hint=hint))
    listed = [str(known.get("name")) for known in media if known and known.get("name")]
    if len(listed) < len(media):  # one whose name is not known may be meant
        return problems
    there = list(dict.fromkeys((VACUUM, *listed)))
    for group, objects in groups.items():
        for i, known in enumerate(objects):
            for path, name in _called(known, f"{group}[{i}]"):
                if name not in there:
                    problems.append(_unknown(path, name, there))
    return problems


def named_by(thing: Described) -> Iterator[str]:
    """Give the names of the media that an object and those within it call."""
    for item, parameter in parameters_of(type(thing)).items():
        value = getattr(thing, item)
        if isinstance(parameter, MediumName) and value is not None:
            yield value
        elif isinstance(value, Described):
            yield from named_by(value)


def _called(value: Any, path: str) -> Iterator[tuple[str, str]]:
    """Give the path and value of every name of a medium in an object and those within it."""
    if not isinstance(value, Known):
        return
    for item, parameter in parameters_of(value.cls).items():
        where, found = join(path, item), value.get(item)
        if isinstance(parameter, MediumName) and found is not None:
            yield where, found
        elif isinstance(found, Known):
            yield from _called(found, where)


def _unknown(path: str, name: str, there: Sequence[str]) -> Problem:
    near = difflib.get_close_matches(name, there, 1) or difflib.get_close_matches(
        name.lower(), there, 1
    )
    hint = f"did you mean {show(near[0])}?" if near else "a [[medium]] table adds one"
    some = ", ".join(map(show, there[:_MOST_NAMES]))
    more = " …" if len(there) > _MOST_NAMES else ""
    return Problem(path, show(name), f"the name of a medium: {some}{more}", hint=hint)
