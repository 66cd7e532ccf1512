"""The command line reference, from the parser itself: a new verb appears by itself."""

from __future__ import annotations

import argparse
from typing import Any

from photizon_cl.cli.main import parser as command_parser
from photizon_docs.tables import table

__all__ = ["command_line"]

_WIDTH = 88


def command_line() -> str:
    """Return one section for each verb."""
    parser = command_parser()
    verbs = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    rows = [(f"[`{c.dest}`](#verb-{c.dest})", c.help or "") for c in verbs._choices_actions]
    parts = [table(("verb", "does"), rows)]
    for made in verbs.choices.values():
        made.fill()
    parts += [_verb(name, made) for name, made in verbs.choices.items()]
    return "\n".join(parts)


def _verb(name: str, parser: argparse.ArgumentParser) -> str:
    actions = [a for a in parser._actions if not isinstance(a, argparse._HelpAction)]
    usage = " ".join([parser.prog, *map(_usage, actions)])
    required = {id(a): group for group in parser._mutually_exclusive_groups for a in [group]}
    exclusive = [
        " and ".join(f"`{a.option_strings[0]}`" for a in group._group_actions)
        for group in required.values()
    ]
    lines = [f"(verb-{name})=", f"## {name}", "", parser.description or "", ""]
    lines += ["```text", *_wrapped(usage), "```", ""]
    lines += [table(("argument", "meaning"), [(_name(a), _meaning(a)) for a in actions])]
    lines += [f"{pair} exclude each other.\n" for pair in exclusive]
    return "\n".join(lines)


def _usage(action: argparse.Action) -> str:
    name = _name(action).replace("`", "")
    optional = bool(action.option_strings) and not action.required
    optional = optional or action.nargs in ("?", "*")
    return f"[{name}]" if optional else name


def _wrapped(usage: str) -> list[str]:
    lines = [""]
    for word in usage.replace("] [", "]\n[").split("\n"):
        if lines[-1] and len(lines[-1]) + len(word) + 1 > _WIDTH:
            lines.append("        ")
        lines[-1] += (" " if lines[-1].strip() else "") + word
    return lines


def _name(action: argparse.Action) -> str:
    value: Any = action.metavar or action.dest.upper()
    if action.choices is not None and not action.metavar:
        value = "|".join(map(str, action.choices))
    if not action.option_strings:
        return f"`{value}`"
    takes = "" if action.nargs == 0 else f" {value}"
    return f"`{', '.join(action.option_strings)}{takes}`"


def _meaning(action: argparse.Action) -> str:
    text = action.help or ""
    default = action.default
    named = default not in (None, False, argparse.SUPPRESS, []) and "default" not in text
    return (text % vars(action) if "%(" in text else text) + (
        f"; default `{default}`" if named and action.option_strings else ""
    )
