"""The text of a program: templates in the order in which C needs them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from hostcode.errors import HostError
from hostcode.program.codes import CODE
from hostcode.program.fields import ENDING_TYPES, HIT_TYPES, RAY_TYPES, REALS, declare, of_type
from hostcode.program.spec import CACHE_LINE, PROBE_STAGES, TALLY_STAGES
from hostcode.program.structs import ITEM, LAUNCH, LAUNCH_TYPES, c_struct
from hostcode.templates import lane, render

if TYPE_CHECKING:
    from hostcode.program.parts import EffectParts
    from hostcode.program.spec import ProgramSpec

__all__ = ["HOOKS", "PLACES", "RECORDS", "hook_name", "program_source"]

PLACES: Final = ("search", "surfaces", "survive", "tally")
"""Where the templates of effects stand: behind the elements' functions, before the surfaces',
before what may end a ray between two interactions, among what counts endings, which is a program of
its own."""

HOOKS: Final = ("travel", "surface", "survive", "arrival")
"""Where the statements of effects stand: in an interaction, see kernels/lib/interaction.mako, and
where an arrival is counted, see kernels/lib/detector.mako."""

RECORDS: Final = ("arrivals", "escapes")
"""What effects may have recorded for the tally stage, see kernels/lib/shade.mako."""


def _parts(spec: ProgramSpec) -> list[tuple[str, dict[str, Any]]]:
    """Return the templates of a program in order, each with what it is rendered with besides."""
    placed = [entry for part in spec.parts for entry in part.templates]

    def at(place: str) -> list[str]:
        return [template for where, template in placed if where == place]

    if spec.stages == TALLY_STAGES:
        return [(name, {}) for name in ("prelude", "lib/launch", "lib/limbs")] + _tally_parts(spec)
    names = ["prelude", "lib/launch", "lib/philox", "lib/elementary", "lib/vectors", "lib/limbs"]
    names.append("lib/packets")
    if spec.splits:
        names.append("lib/children")
    wanted = [kind.libraries for kind in spec.classes]
    wanted += [kind.libraries for kind in spec.surfaces]
    wanted += [kind.libraries for kind in spec.sources]
    wanted += [part.libraries for part in spec.parts]
    names += dict.fromkeys(library for libraries in wanted for library in libraries)
    parts: list[tuple[str, dict[str, Any]]] = [(name, {}) for name in names]
    for cls in spec.classes:
        parts += [(name, {"cls": cls}) for name in (*cls.templates, "lib/meet")]
    names = [*at("search"), "lib/faces", "lib/nearest", "lib/locate"]
    parts += [(name, {}) for name in names]
    if spec.stages == PROBE_STAGES:
        return [*parts, ("lib/arguments", {}), ("stages/probe", {})]
    names = ["lib/ledger", "lib/event", "lib/directions", *at("surfaces")]
    parts += [(name, {}) for name in names]
    parts += [(f"surfaces/{kind.kind}", {"surface": kind}) for kind in spec.surfaces]
    names = [*at("survive"), "lib/shade", "lib/survive"]
    parts += [(name, {}) for name in names]
    if spec.launches:
        parts.append(("lib/sources", {}))
        parts += [(f"sources/{kind.stem}", {"source": kind}) for kind in spec.sources]
        parts.append(("lib/generate", {}))
    names = ["lib/queue", "lib/interaction", "lib/arguments", "lib/report"]
    names += [f"stages/{stage}" for stage in spec.stages]
    return parts + [(name, {}) for name in names]


def _tally_parts(spec: ProgramSpec) -> list[tuple[str, dict[str, Any]]]:
    """Return the templates behind the common ones of the program that counts what was recorded."""
    libraries = dict.fromkeys(library for part in spec.parts for library in part.libraries)
    filters = dict.fromkeys(entry for form in spec.forms for entry in form.filters)
    placed = [entry for part in spec.parts for entry in part.templates]
    parts: list[tuple[str, dict[str, Any]]] = []
    parts += [(name, {}) for name in (*libraries, "lib/cells", "lib/bins")]
    parts += [("lib/keyed", {})] if spec.keyed else []
    parts += [(f"filters/{stem}", {"option": option}) for stem, option in filters]
    parts += [(template, {}) for place, template in placed if place == "tally"]
    return [*parts, ("stages/tally", {})]


def hook_name(part: EffectParts, place: str) -> str:
    """Return what compilers are told to call an effect's statements at a place."""
    return f"hook {place} of {part.effect or 'an effect'}"


def _check(part: EffectParts) -> None:
    """See that all that an effect brings has a place and a type that there are."""
    asked: list[tuple[str, str, tuple[str, ...]]] = []
    asked += [(f"place of the template {name}", place, PLACES) for place, name in part.templates]
    asked += [(f"place of the hook {statement}", place, HOOKS) for place, statement in part.hooks]
    asked += [("what is recorded", what, RECORDS) for what in part.records]
    asked += [(f"type of the ray's {f.name}", f.type, RAY_TYPES) for f in part.ray]
    asked += [(f"type of the hit's {f.name}", f.type, HIT_TYPES) for f in part.hit]
    asked += [(f"type of the ending's {f.name}", f.type, ENDING_TYPES) for f in part.ending]
    asked += [(f"type of the launch's {name}", c, LAUNCH_TYPES) for name, c, _ in part.launch]
    for what, found, allowed in asked:
        if found not in allowed:
            whose = f"effect {part.effect}" if part.effect else "an effect"
            raise HostError(
                f'{whose}: {what}: found "{found}", expected one of {", ".join(allowed)}'
            )


def _hooks(spec: ProgramSpec) -> dict[str, list[str]]:
    """Return the statements at each place, each with whose it is for the compiler's messages."""
    return {
        place: [
            f'#line 1 "{hook_name(part, place)}"\n    {statement}'
            for part in spec.parts
            for where, statement in part.hooks
            if where == place
        ]
        for place in HOOKS
    }


def program_source(spec: ProgramSpec) -> str:
    """Return the OpenCL C text of a program.

    Raises
    ------
    KernelBuildError
        Where a template does not render.
    HostError
        Where an effect names a place or a type that there is not.
    """
    for part in spec.parts:
        _check(part)
    ray, ending = spec.ray_fields, spec.ending_fields
    context: dict[str, Any] = {
        "real": spec.real,
        "weight": spec.weight,
        "lanes": spec.lanes,
        "packets": spec.packets,
        "cached_bytes": spec.cached_bytes,
        "cache_line": CACHE_LINE,
        "lane": lambda value, number: lane(value, number, spec.lanes),
        "effects": spec.effects,
        "classes": spec.classes,
        "plain": spec.plain,
        "surfaces": spec.surfaces,
        "sources": spec.sources,
        "forms": spec.forms,
        "records": spec.records,
        "recorded": spec.recorded,
        "splits": spec.splits,
        "extras": spec.extras,
        "children": spec.children,
        "pairs": spec.pairs,
        "events": spec.events,
        "keyed": spec.keyed,
        "passes": spec.passes,
        "orders": spec.orders,
        "ends": spec.ends,
        "densities": spec.densities,
        "coats": spec.coats,
        "amplitudes": spec.amplitudes,
        "hooks": _hooks(spec),
        "interleaved": spec.interleaved,
        "private_tallies": spec.private_tallies,
        "n_elements": spec.n_elements,
        "ledger": spec.ledger,
        "books": spec.books,
        "ledger_rows": spec.n_elements + len(spec.ledger) if spec.n_elements else 0,
        "columns": spec.columns,
        "strides": spec.strides,
        "code": CODE,
        "launch_struct": c_struct("launch_t", LAUNCH + spec.launch_members),
        "item_struct": c_struct("item_t", ITEM),
        "ray_fields": ray,
        "ray_struct": declare(ray),
        "ray_real": of_type(ray, *REALS),
        "ray_word": of_type(ray, "word"),
        "ray_long": of_type(ray, "long", "ulong"),
        "hit_fields": spec.hit_fields,
        "ending_fields": ending,
        "ending_struct": declare(ending),
        "ending_real": of_type(ending, *REALS),
        "ending_word": of_type(ending, "word"),
        "counts": dict(entry for part in spec.parts for entry in part.parameters),
    }
    return "".join(render(f"{name}.mako", **context, **extra) for name, extra in _parts(spec))
