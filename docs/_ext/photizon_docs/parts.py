"""One page for every element, surface, source and detector of the registry."""

from __future__ import annotations

import contextlib
import io
import re
import textwrap
from dataclasses import replace
from inspect import cleandoc
from typing import TYPE_CHECKING, Any

from hostcode.assets import kernels_dir
from photizon_cl.errors import SceneError
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.detectors import Detector
from photizon_cl.scene.elements import Element
from photizon_docs.emit import as_python, as_toml
from photizon_docs.examples import example, guess
from photizon_docs.tables import GROUPS, link, parameter_table, table

if TYPE_CHECKING:
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.model import Scene

__all__ = ["escape_bars", "group_index", "page"]

_HEADING = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.M)
_INTRO = {
    "element": "What light can hit: a piece of geometry with one surface.",
    "surface": "What a ray that hits an element does.",
    "source": "Where rays start. Sources do not block light.",
    "detector": "What is counted of what arrives at an element.",
    "scatter": "What a surface sends aside of its specular rays: see [scatter](/scatter.md).",
    "coating": "What a border of two media reflects and lets pass: see [coatings](/coatings.md).",
}


def group_index(group: str) -> str:
    """Return the page that lists a group."""
    rows = [(link(group, kind, ".."), _first(cls)) for kind, cls in GROUPS[group].items()]
    listed = "\n".join(GROUPS[group])
    return (
        f"# {group.capitalize()}s\n\n{_INTRO[group]}\n\n"
        f"{table(('kind', 'what it is'), rows)}\n```{{toctree}}\n:hidden:\n\n{listed}\n```\n"
    )


def _first(cls: type[Described]) -> str:
    return cleandoc(cls.__doc__ or "").splitlines()[0].replace("`", "")


def page(group: str, kind: str, cls: type[Described]) -> tuple[str, Scene]:
    """Return a kind's page and the scene that it shows."""
    scene = example(group, kind, cls)
    item = _shown(group, cls, scene)
    lines = [f"# {kind}", "", f"*{group}*, in Python `photizon_cl.{cls.__name__}`", ""]
    lines += [_rst(_description(cls)), f"![{kind} with the paths of a few rays]({kind}.png)\n"]
    lines += [f"## Parameters\n\n{parameter_table(cls) or 'It takes none.'}\n"]
    if group == "element":
        lines += [_geometry(cls), _takes(cls, item)]
    elif group == "source":
        lines += [_start(cls)]
    elif group == "surface":
        lines += [_taken_by(item)]
    elif group in ("scatter", "coating"):
        lines += [_on_surfaces(group, item)]
    else:
        lines += [_carried_by()]
    lines += [_example(kind, scene), _quantities(cls, item), _device(group, cls)]
    return "\n".join(lines), scene


def _shown(group: str, cls: type[Described], scene: Scene) -> Any:
    pool: list[Any] = [*scene.source, *scene.element]
    pool += [e.surface.lobe for e in scene.element] + [e.surface.coat for e in scene.element]
    pool += [e.surface for e in scene.element] + [e.detector for e in scene.element if e.detector]
    return next(item for item in pool if type(item) is cls)


# -- prose from docstrings ------------------------------------------------------------------------


def _sections(cls: type[Described]) -> dict[str, str]:
    pieces = _HEADING.split(cleandoc(cls.__doc__ or ""))
    return {"": pieces[0], **dict(zip(pieces[1::2], pieces[2::2], strict=True))}


def _description(cls: type[Described]) -> str:
    sections = _sections(cls)
    return "\n\n".join(part for part in (sections[""], sections.get("Notes", "")) if part)


def _rst(text: str) -> str:
    return f"```{{eval-rst}}\n{escape_bars(text.strip())}\n```\n"


def escape_bars(text: str) -> str:
    """Return reStructuredText in which |x| is a magnitude and no substitution."""
    return re.sub(r"\|(\w+)\|", r"\\|\1\\|", text)


def _sentences(cls: type[Described], *words: str) -> str:
    text = " ".join(_sections(cls)[""].split("::")[0].split())
    parts = re.split(r"(?<=[.;:]) (?=[A-Z`])", text)
    return " ".join(p for p in parts if any(word in p for word in words))


# -- elements -------------------------------------------------------------------------------------


def _geometry(cls: type[Any]) -> str:
    place = _sentences(cls, "`position`") or "`position` is where it sits, `axis` its local w."
    normal = _sentences(cls, "ormal")
    side = (
        'It is flat: a detector on it counts what arrives against its normal, `side = "front"`, or '
        'on its `"back"`; without a name the front.'
        if cls.flat
        else f'A detector on it counts the side that it names, `side = "inside"` or '
        f'`"outside"`; without a name `"{cls.default_side}"`.'
    )
    normals = normal or "Its normals point out of the body."
    return (
        "## Position, axis and sides\n\n"
        f"{place} The local frame (u, v, w) follows from `axis`, see "
        f"[conventions](/conventions.md).\n\n{normals} {side}\n"
    )


def _takes(cls: type[Any], item: Any) -> str:
    bare = _bare(cls)
    rows = []
    for kind, surface in GROUPS["surface"].items():
        made = surface(**guess(surface))
        rows.append((f"surface {link('surface', kind)}", _verdict(bare, item, surface=made)))
    tried = {
        "power": Detector(),
        "map": Detector(map=(4, 4)),
        "generations": Detector(generations=4),
        "side": Detector(side="front" if cls.flat else "inside"),
    }
    black = GROUPS["surface"]["absorber"]()
    at = link("detector", "detector")
    for what, detector in tried.items():
        verdict = _verdict(bare, item, surface=black, detector=detector)
        rows.append((f"{at}: {what}", verdict))
    lead = "A detector stands on an `absorber`, or on what light passes.\n"
    return f"## What it takes\n\n{table(('what', 'taken?'), rows)}\n{lead}"


def _bare(cls: type[Any]) -> Any:
    values = {**guess(cls), "surface": GROUPS["surface"]["absorber"]()}
    return cls(**values)


def _verdict(bare: Any, item: Any, **change: Any) -> str:
    plain, shown = _refusal(bare, change), _refusal(item, change)
    if not plain and not shown:
        return "yes"
    if plain:
        return f"no: {plain}"
    own = [name for name in parameters_of(type(item)) if name not in parameters_of(Element)]
    causes = [f"`{n}`" for n in own if _refusal(_with(bare, item, n), change)]
    return f"yes; not with {' or '.join(causes)}: {shown}"


def _with(bare: Any, item: Any, name: str) -> Any:
    try:
        return replace(bare, **{name: getattr(item, name)})
    except SceneError:
        return bare


def _refusal(item: Any, change: dict[str, Any]) -> str:
    try:
        replace(item, **({"detector": None, **change} if isinstance(item, Element) else change))
    except SceneError as error:
        return error.problems[0].hint or error.problems[0].expected
    return ""


# -- sources, surfaces, detectors -----------------------------------------------------------------


def _start(cls: type[Any]) -> str:
    axis = (
        "`axis` is the direction of emission, the local w; `tilt_deg` turns the whole source. The "
        "local frame (u, v, w) is that of the [conventions](/conventions.md)."
        if cls.directed
        else "It has no axis and no tilt: its u, v and w are the world's x, y and z."
    )
    return (
        f"## Position and axis\n\n`position` is the centre of the source. {axis}\n\n"
        "It does not block light. Flux is what is launched, whatever medium surrounds it.\n"
    )


def _taken_by(surface: Any) -> str:
    rows = []
    for name, cls in GROUPS["element"].items():
        shown = _shown("element", cls, example("element", name, cls))
        rows.append((link("element", name), _verdict(_bare(cls), shown, surface=surface)))
    carries = not _refusal(_bare(GROUPS["element"]["rectangle"]), _detecting(surface))
    detector = (
        "It can carry a [detector](/parts/detectors/index.md)."
        if carries
        else "It carries no detector: one counts what ends on a surface, or passes it."
    )
    splits = " A ray that hits it goes on as two." if surface.splits else ""
    return f"## Where it goes\n\n{table(('element', 'taken?'), rows)}\n{detector}{splits}\n"


def _on_surfaces(key: str, item: Any) -> str:
    rows = []
    for kind, cls in GROUPS["surface"].items():
        takes = key in parameters_of(cls)
        why = _refusal(cls(**guess(cls)), {key: item}) if takes else f"it has no `{key}`"
        rows.append((link("surface", kind), f"no: {why}" if why else "yes"))
    return f"## Where it goes\n\n{table(('surface', 'taken?'), rows)}\n"


def _detecting(surface: Any) -> dict[str, Any]:
    return {"surface": surface, "detector": Detector()}


def _carried_by() -> str:
    rows = []
    black = GROUPS["surface"]["absorber"]()
    for name, cls in GROUPS["element"].items():
        element: Any = cls
        bare = _bare(element)
        a_map = _verdict(bare, bare, surface=black, detector=Detector(map=(4, 4)))
        side = f"`{element.default_side}`, or the one named"
        rows.append((link("element", name), a_map, side))
    return f"## Where it goes\n\n{table(('element', 'map?', 'side that is counted'), rows)}"


# -- numbers, device, example ---------------------------------------------------------------------


def _quantities(cls: type[Any], item: Any) -> str:
    rows = []
    values = item.derived() if hasattr(item, "derived") else {}
    for name, (value, unit) in values.items():
        rows.append((name, f"{value:.6g} {unit}".strip()))
    text = ""
    if rows:
        text += (
            "## Derived quantities\n\n`photizon check` prints them. Of the example above:\n\n"
            + table(("quantity", "value"), rows)
        )
    own = [
        (f"`{name}`", " ".join(cleandoc(member.__doc__).split()))
        for owner in reversed(cls.__mro__[:-1])
        for name, member in vars(owner).items()
        if isinstance(member, property) and member.__doc__ and not name.startswith("_")
        and name not in _INNER
    ]  # fmt: skip
    if own:
        latest = dict(own)
        text += "\nIn Python, as properties:\n\n" + table(("property", "what"), latest.items())
    return text


_INNER = frozenset(
    {
        "class_axis", "local_box", "ported", "half_sizes", "reach", "faces", "sole_face", "outline",
        "hole", "face", "draws_position", "self_view_factor", "diffuse_reflectance", "lobe",
        "branches", "scattered", "width", "kinks", "sharpness", "falls", "nodes", "pieces", "coat",
    }
)  # fmt: skip


def _device(group: str, cls: type[Any]) -> str:
    path = kernels_dir() / f"{group}s" / f"{cls.kernel}.mako"
    if not path.is_file():
        return ""
    comment: list[str] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("//"):
            comment.append(re.sub(r"\$\{.*?\}", "", line[2:].removeprefix(" ")))
        elif comment and not line.startswith("##"):
            break
    return (
        "## Formulas on the device\n\n"
        f"What `kernels/{group}s/{cls.kernel}.mako` says of itself, with the sources of its "
        "formulas:\n\n```text\n" + "\n".join(comment) + "\n```\n"
    )


def _example(kind: str, scene: Scene) -> str:
    code = (
        "import photizon_cl as pz\n\n"
        + as_python(scene)
        + textwrap.dedent(
            """\
            result = pz.trace(scene, batches=8, rays_per_batch=1024)
            for name, row in result.ledger.absorbed.items():
                print(f"{name}: {row.value:.4f} ± {row.sigma:.4f} W")
            print(f"escaped: {result.ledger.escaped.value:.4f} W")
            """
        )
    )
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, kind, "exec"), {})
    return (
        f"## Example\n\n```{{code-block}} toml\n:caption: {kind}.toml\n\n{as_toml(scene)}```\n\n"
        f"The same in Python, traced with a few rays:\n\n```python\n{code}```\n\n"
        f"```output\n{printed.getvalue()}```\n"
    )
