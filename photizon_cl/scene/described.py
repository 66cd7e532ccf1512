"""The base of the description classes: frozen dataclasses whose fields are declared parameters.

Construction in Python raises `SceneError` with every problem of the object. The file reader checks
the same declarations one by one. Conditions between values are stated once for both, in
`Described.cross_check`, over whatever values were good.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Generic, Self, TypeVar

from photizon_cl.errors import Problem, SceneError, show
from photizon_cl.scene.names import ByName
from photizon_cl.scene.parameters import BAD, METADATA_KEY, Parameter

if TYPE_CHECKING:
    from collections.abc import Mapping

_In = TypeVar("_In", contravariant=True)
_Out = TypeVar("_Out", covariant=True)


class Accepts(Generic[_In, _Out]):
    """What type checkers are told of a field that takes more than it keeps: a list for a tuple.

    Only an annotation: ``map: Accepts[Sequence[int] | None, tuple[int, int] | None]``.
    """

    def __get__(self, owner: object, cls: type | None = None) -> _Out:
        raise NotImplementedError

    def __set__(self, owner: object, value: _In) -> None:
        raise NotImplementedError


ABSENT: Final[Any] = None
"""The default of an optional field that `Accepts` annotates."""
REQUIRED: Final[Any] = dataclasses.MISSING
"""The default of a required one: none, but type checkers look at `Accepts` only beside one."""


@dataclass(frozen=True)
class Known:
    """The good values of an object that is being checked; others may have been refused.

    Parameters
    ----------
    cls : type of Described
        Class of the object.
    values : mapping
        Canonical values by field name. Nested objects stand here as `Known` themselves, lists of
        them as tuples; a refused value is absent.
    """

    cls: type[Described]
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The kind of the object, as the file names it."""
        return self.cls.kind

    def get(self, field_name: str) -> Any:
        """Return a good value, or None."""
        return self.values.get(field_name)


class Described:
    """Base of the description classes: frozen dataclasses whose fields are declared parameters."""

    kind: ClassVar[str] = ""
    label: ClassVar[str] = ""
    sample: ClassVar[Mapping[str, Any]] = MappingProxyType({})
    """Values for an example, where those that suit each parameter do not suit each other."""
    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})
    """Parameters that say the same in another way: one that is given stands for the others."""
    usual: ClassVar[Mapping[str, Any]] = MappingProxyType({})
    """What there is where nothing is said, of parameters whose default is None since another one
    may stand for them; `REQUIRED` where nothing is."""
    one_value: ClassVar[bool] = False
    """Whether it is one value, which is checked and read as such."""
    over_wavelength: ClassVar[bool] = False
    """Whether it depends on wavelength, which the scene's ``[spectrum]`` then gives."""
    foreseen: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """Keys that the format will have and that are refused so far: what to do without them."""

    def __post_init__(self) -> None:
        """Check every value and bring it to canonical form.

        Raises
        ------
        SceneError
            With every problem found.
        """
        cls = type(self)
        problems: list[Problem] = []
        values: dict[str, Any] = {}
        for item, parameter in parameters_of(cls).items():
            value = getattr(self, item)
            if value is None and is_optional(cls, item):
                values[item] = None
                continue
            read = parameter.read(value, item, problems)
            if read is not BAD:
                values[item] = _known(read)
                object.__setattr__(self, item, read)
        problems += cls.cross_check(Known(cls, values))
        if problems:
            owner = getattr(self, "name", None)
            title = f"{cls.__name__} {show(owner)}" if isinstance(owner, str) else cls.__name__
            raise SceneError(
                dataclasses.replace(problem.under(cls.label), owner=problem.owner or title)
                for problem in problems
            )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Return the problems between values, each with a path relative to this object."""
        return []

    def unchecked(self, **values: Any) -> Self:
        """Return it with other values, canonical and known to be good: they are not checked again.

        What follows from values that were checked need not pass the same check: a sum is rounded.
        """
        made = object.__new__(type(self))
        for entry in _fields(type(self)):
            value = values.get(entry.name, getattr(self, entry.name))
            object.__setattr__(made, entry.name, value)
        return made

    def to_table(self) -> dict[str, Any]:
        """Return the object as a table of the file, kind after name, without what is absent."""
        values: dict[str, Any] = {}
        for key, parameter in parameters_of(type(self)).items():
            value = getattr(self, key)
            if value is None or (key == "tilt_deg" and value == (0.0, 0.0)):
                continue
            if parameter.silent and value == default_of(type(self), key):
                continue
            if isinstance(value, Described):
                values[key] = value.to_table()
            else:
                values[key] = _listed(value) if isinstance(value, tuple) else value
        default = {key for key in values if getattr(self, key) == default_of(type(self), key)}
        for key in values.keys() - default:
            for other in default.intersection(self.alternatives.get(key, ())):
                del values[other]
        if not self.kind or self.kind == self.label:
            return values
        head = {"name": values.pop("name")} if "name" in values else {}
        return {**head, "kind": self.kind, **values}


def _listed(values: tuple[Any, ...]) -> list[Any]:
    return [v.to_table() if isinstance(v, Described) else v for v in values]


def _known(value: object) -> Any:
    if isinstance(value, Described) and not value.one_value:
        cls = type(value)
        return Known(cls, {item: _known(getattr(value, item)) for item in parameters_of(cls)})
    if isinstance(value, tuple):
        return tuple(_known(item) for item in value)
    return value


def parameters_of(cls: type[Described]) -> dict[str, Parameter]:
    """Return the declared parameters of a class by name, in the order of its fields."""
    declared = {item.name: item.metadata.get(METADATA_KEY) for item in _fields(cls)}
    return {name: value for name, value in declared.items() if isinstance(value, Parameter)}


def is_required(cls: type[Described], item: str) -> bool:
    """Say whether a parameter has no default."""
    entry = next(f for f in _fields(cls) if f.name == item)
    missing = dataclasses.MISSING
    return entry.default is missing and entry.default_factory is missing


def is_optional(cls: type[Described], item: str) -> bool:
    """Say whether a parameter may be absent, which its default None stands for."""
    return any(f.name == item and f.default is None for f in _fields(cls))


def default_of(cls: type[Described], item: str) -> Any:
    """Return the default of a parameter; `dataclasses.MISSING` where it is required."""
    entry = next(f for f in _fields(cls) if f.name == item)
    if entry.default_factory is not dataclasses.MISSING:
        return entry.default_factory()
    return entry.default


def shown_default(cls: type[Described], item: str) -> Any:
    """Return what people are told of a parameter's default: that, or what it stands for."""
    return cls.usual.get(item, default_of(cls, item))


_FIELDS: Final[dict[type, tuple[dataclasses.Field[Any], ...]]] = {}
"""Of each class once: a scene may have thousands of objects of it."""


def _fields(cls: type[Described]) -> tuple[dataclasses.Field[Any], ...]:
    if cls not in _FIELDS:
        _FIELDS[cls] = dataclasses.fields(cls)  # type: ignore[arg-type]  # each is a dataclass
    return _FIELDS[cls]


class Nested(Parameter):
    """Another description object, given as an instance (the reader builds it from a table)."""

    def __init__(self, base: type[Described], article: str = "a", *, meaning: str = "") -> None:
        super().__init__(meaning)
        self.base = base
        self._article = article

    @property
    def expected(self) -> str:  # noqa: D102
        return f"{self._article} {self.base.label}"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if isinstance(value, self.base):
            return value
        hint = "call the class to make one" if isinstance(value, type) else ""
        return self.refuse(value, path, problems, hint)


class NestedList(Nested):
    """A sequence of description objects with names, kept as a `ByName`."""

    def __init__(self, base: type[Described], least: int, *, meaning: str = "") -> None:
        super().__init__(base, meaning=meaning)
        self.least = least

    @property
    def expected(self) -> str:  # noqa: D102
        return f"at least one {self.base.label}" if self.least else f"a list of {self.base.label}s"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if not isinstance(value, list | tuple) or len(value) < self.least:
            return self.refuse(value, path, problems)
        items = [Nested.read(self, item, f"{path}[{i}]", problems) for i, item in enumerate(value)]
        return BAD if any(item is BAD for item in items) else ByName(items)
