"""A small scene for every kind of the registry; a kind that has none here gets one by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from photizon_cl.errors import SceneError
from photizon_cl.scene.described import is_required, parameters_of
from photizon_cl.scene.files import load
from photizon_cl.scene.parameters import BAD, Choice, Parameter

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.described import Described
    from photizon_cl.scene.model import Scene

__all__ = ["example", "guess"]

_BEAM = {
    "name": "beam",
    "kind": "collimated-disk",
    "flux": 1.0,
    "position": [0.0, 0.0, 0.3],
    "axis": "-z",
    "radius": 0.04,
}
_LAMP = {
    "name": "lamp",
    "kind": "cosine-point",
    "flux": 1.0,
    "position": [0.0, 0.0, 0.2],
    "axis": "-z",
}
_BLACK = {"kind": "absorber"}
_GLASS = {"kind": "fresnel", "index": 1.5168}
_SILVER = {"kind": "mirror", "reflectance": 0.95}


def _element(name: str, kind: str, z: float, axis: str, **more: Any) -> dict[str, Any]:
    return {"name": name, "kind": kind, "position": [0.0, 0.0, z], "axis": axis, **more}


def _target(z: float, half: float, **detector: Any) -> dict[str, Any]:
    size = {"half_width": half, "half_height": half}
    return _element("target", "rectangle", z, "+z", **size, surface=_BLACK, detector=detector)


_MIRROR_45 = _element(
    "plate",
    "rectangle",
    0.0,
    "+z",
    tilt_deg=[0.0, 45.0],
    half_width=0.1,
    half_height=0.1,
    surface={"kind": "mirror", "reflectance": 0.9},
)
_SCREEN = {
    **_element("target", "rectangle", 0.0, "-x", half_width=0.1, half_height=0.1),
    "position": [0.3, 0.0, 0.0],
    "surface": _BLACK,
    "detector": {"map": [16, 16]},
}
_CEILING = _element(
    "ceiling",
    "disk",
    0.3,
    "-z",
    radius=0.3,
    surface={"kind": "lambertian", "reflectance": 0.8},
)

# (group, kind) → sources, elements, other tables
_CURATED: dict[tuple[str, str], tuple[list[Any], list[Any], dict[str, Any]]] = {
    ("element", "rectangle"): ([_LAMP], [_target(0.0, 0.1, map=[16, 16])], {}),
    ("element", "disk"): (
        [_LAMP],
        [
            _element(
                "target", "disk", 0.0, "+z", radius=0.1, surface=_BLACK, detector={"map": [16, 16]}
            )
        ],
        {},
    ),
    ("element", "sphere"): (
        [{**_LAMP, "position": [0.0, 0.0, 0.0]}],
        [
            _element(
                "wall",
                "sphere",
                0.0,
                "+z",
                radius=0.1,
                port_fraction=0.2,
                surface={"kind": "lambertian", "reflectance": 0.5},
            )
        ],
        {},
    ),
    ("element", "cpc"): (
        [{**_BEAM, "tilt_deg": [0.0, 15.0], "position": [0.0, -0.0123, 0.15], "radius": 0.02}],
        [
            _element(
                "concentrator",
                "cpc",
                0.0,
                "+z",
                exit_radius=0.02,
                acceptance_deg=30.0,
                surface={"kind": "mirror", "reflectance": 0.95},
            ),
            _element("exit", "disk", 0.0, "+z", radius=0.02, surface=_BLACK, detector={}),
        ],
        {},
    ),
    ("element", "baffled-tube"): (
        [{**_LAMP, "position": [0.0, 0.0, -0.02], "axis": "+z"}],
        [
            _element(
                "tube",
                "baffled-tube",
                0.0,
                "+z",
                half_width=0.03,
                length=0.2,
                baffles=3,
                clear_half_width=0.02,
                surface={"kind": "lambertian", "reflectance": 0.05},
            ),
            _element(
                "end",
                "rectangle",
                0.2,
                "-z",
                half_width=0.03,
                half_height=0.03,
                surface=_BLACK,
                detector={},
            ),
        ],
        {},
    ),
    ("element", "plano-convex"): (
        [_BEAM],
        [
            _element(
                "lens",
                "plano-convex",
                0.0,
                "+z",
                curvature_radius=0.1034,
                aperture_radius=0.05,
                surface=_GLASS,
            ),
            _target(-0.18, 0.03, map=[16, 16]),
        ],
        {"run": {"roulette_floor": 1e-6}},
    ),
    ("element", "biconvex"): (
        [_BEAM],
        [
            _element(
                "lens",
                "biconvex",
                0.0,
                "+z",
                front_radius=0.2,
                back_radius=0.2,
                aperture_radius=0.05,
                surface=_GLASS,
            ),
            _target(-0.18, 0.03, map=[16, 16]),
        ],
        {"run": {"roulette_floor": 1e-6}},
    ),
    ("element", "lens"): (
        [{**_BEAM, "radius": 0.02}],
        [
            _element(
                "lens",
                "lens",
                0.0,
                "+z",
                front_radius=0.06,
                back_radius=-0.2,
                thickness=0.012,
                aperture_radius=0.025,
                surface=_GLASS,
            ),
            _target(-0.15, 0.03, map=[16, 16]),
        ],
        {"run": {"roulette_floor": 1e-6}},
    ),
    ("element", "cylinder"): (
        [{**_LAMP, "position": [0.0, 0.0, 0.02], "axis": "+z"}],
        [
            _element(
                "tube",
                "cylinder",
                0.0,
                "+z",
                radius=0.05,
                length=0.15,
                surface=_BLACK,
                detector={"map": [16, 12]},
            )
        ],
        {},
    ),
    ("element", "cone"): (
        [_BEAM],
        [
            _element(
                "funnel",
                "cone",
                0.1,
                "-z",
                entrance_radius=0.05,
                exit_radius=0.02,
                length=0.1,
                surface=_SILVER,
            ),
            _element("exit", "disk", 0.0, "+z", radius=0.02, surface=_BLACK, detector={}),
        ],
        {},
    ),
    ("element", "conic"): (
        [_BEAM],
        [
            _element(
                "dish",
                "conic",
                0.0,
                "+z",
                curvature_radius=0.2,
                conic_constant=-1.0,
                aperture_radius=0.05,
                surface=_SILVER,
            ),
            _element("focus", "disk", 0.1, "-z", radius=0.001, surface=_BLACK, detector={}),
        ],
        {},
    ),
    ("surface", "absorber"): ([_LAMP], [_target(0.0, 0.1, map=[16, 16])], {}),
    ("surface", "mirror"): ([_BEAM], [_MIRROR_45, _SCREEN], {}),
    ("surface", "lambertian"): (
        [_BEAM],
        [
            _element(
                "plate",
                "disk",
                0.0,
                "+z",
                radius=0.05,
                surface={"kind": "lambertian", "reflectance": 0.8},
            )
        ],
        {"far_field": {}},
    ),
    ("surface", "fresnel"): (
        [_BEAM],
        [
            _element("ball", "sphere", 0.0, "+z", radius=0.05, surface=_GLASS),
            _target(-0.1, 0.03, map=[16, 16]),
        ],
        {"run": {"roulette_floor": 1e-6}},
    ),
    ("detector", "detector"): (
        [{**_LAMP, "axis": "+z", "position": [0.0, 0.0, 0.1]}],
        [_target(0.0, 0.1, map=[16, 16], generations=4), _CEILING],
        {},
    ),
}


def example(group: str, kind: str, cls: type[Described]) -> Scene:
    """Return the scene that a kind's page shows.

    Parameters
    ----------
    group : str
        ``element``, ``surface``, ``source`` or ``detector``.
    kind : str
        As the scene file names it.
    cls : type
        Its class, from the registry.
    """
    if (group, kind) in _CURATED:
        sources, elements, more = _CURATED[group, kind]
    else:
        sources, elements, more = _by_itself(group, kind, cls)
    tables = {"schema": "photizon/1", "name": kind, "source": sources, **more}
    return load({**tables, "element": elements})


def _by_itself(
    group: str, kind: str, cls: type[Described]
) -> tuple[list[Any], list[Any], dict[str, Any]]:
    values = guess(cls)
    if group == "source":
        axis = {"axis": "-z"} if "axis" in parameters_of(cls) else {}
        source = {**values, "name": "lamp", "kind": kind, "position": [0.0, 0.0, 0.2], **axis}
        return [source], [_target(0.0, 0.2, map=[16, 16])], {}
    if group == "surface":
        plate = {**_MIRROR_45, "surface": {"kind": kind, **values}}
        return [_BEAM], [plate, _SCREEN], {}
    if group == "scatter":
        surface = {"kind": "mirror", "reflectance": 0.95, "scatter": {"kind": kind, **values}}
        return [_BEAM], [{**_MIRROR_45, "surface": surface}, _SCREEN], {}
    if group == "coating":
        glass = {**_GLASS, "coating": {"kind": kind, **values}}
        parameters = parameters_of(cls).values()
        lines = {"spectrum": {"wavelengths_nm": [450.0, 550.0, 650.0]}}
        more = lines if any(p.needs_spectrum for p in parameters) else {}
        return [_BEAM], [{**_MIRROR_45, "surface": glass}, _SCREEN], more
    if group == "element":
        surface = {"kind": "lambertian", "reflectance": 0.5}
        return [_LAMP], [{**values, "name": "thing", "kind": kind, "surface": surface}], {}
    return [_LAMP], [_target(0.0, 0.1)], {}


def guess(cls: type[Described]) -> dict[str, Any]:
    """Return values for the required parameters of a class, as a scene file would give them.

    Left out are those that are objects themselves.
    """
    found: dict[str, Any] = {}
    for name, parameter in parameters_of(cls).items():
        if is_required(cls, name) and (value := _value(name, parameter)) is not None:
            found[name] = value
    found.update(cls.sample)
    if cls.label == "surface":
        try:
            cls(**found)
        except SceneError:  # parts of one whole
            found = {name: 0.4 if value == 0.8 else value for name, value in found.items()}
            found.update(cls.sample)
            try:
                cls(**found)
            except SceneError as error:
                error.add_note(f"give {cls.__name__} a `sample`: what was guessed is refused")
                raise
    return found


def _value(name: str, parameter: Parameter) -> Any:
    first: Mapping[str, Any] = {
        "name": "thing",
        "flux": 1.0,
        "position": [0.0, 0.0, 0.0],
        "axis": "+z",
    }
    by_unit = {"m": (0.05,), "deg": (30.0, 10.0), "W": (1.0,)}.get(parameter.unit, ())
    options = parameter._options if isinstance(parameter, Choice) else ()
    tried = ([first[name]] if name in first else []) + [*by_unit, *options, 0.8, 1.5, 2, "text"]
    for value in (*tried, [0.0, 0.0], [0.0, 0.0, 0.0], [4, 4]):
        if parameter.read(value, name, []) is not BAD:
            return value
    return None
