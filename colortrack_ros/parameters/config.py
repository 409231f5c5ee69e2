"""Configurations whose fields declare parameters: tables, checks, and pages follow from them.

::

    @dataclass(frozen=True)
    class TrackerConfig(Config):
        process_noise: float = parameter(
            0.0, 'Standard deviation of the acceleration; 0 learns it.', unit='px/s^2',
            limits=(0.0, 1e6),
        )

``TrackerConfig(process_noise=-1.0)`` raises ValueError with the reason,
``ParameterTable.of(TrackerConfig)`` is the node's table, and ``build(TrackerConfig, values)`` makes
the configuration of the values in it.
"""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import Field
from dataclasses import field
from dataclasses import fields
from dataclasses import replace
from typing import Any
from typing import TypeVar

from colortrack_ros.parameters.spec import Spec
from colortrack_ros.parameters.spec import USER

Built = TypeVar('Built', bound='Config')

_SPEC, _NAMED, _PART = 'spec', 'named', 'part'
"""Keys of a field's metadata, one for each kind of field."""


def parameter(
    default: Any,
    description: str,
    *,
    choices: Iterable[str] = (),
    **declared: Any,
) -> Any:
    """A field that is a parameter; see :class:`Spec` for the other arguments.

    :param default: a tuple means a list of that length, a list means one of any length, and a type,
        such as ``float``, means a list of that type that is absent, ``()``, until it is set.
    :param declared: the optional arguments of :class:`Spec`.
    """
    absent = isinstance(default, type)
    listed = isinstance(default, tuple)
    spec = Spec(
        name='',
        default=(default,) if absent else list(default) if listed else default,
        description=description,
        choices=tuple(choices),
        length=len(default) if listed else None,
        **declared,
    )
    value = () if absent else tuple(default) if isinstance(default, list) else default
    return field(default=value, metadata={_SPEC: spec})


@dataclass(frozen=True)
class Named:
    """A list of names with parameters ``NAME.spec`` for each NAME in it.

    :param spec: of the list of names.
    :param each: the configuration that declares what each NAME has.
    :param make: makes an item of the field from a name and its configuration; raises ValueError.
    """

    spec: Spec
    each: type['Config']
    make: Callable[[str, Any], Any]


def require_name(name: str) -> None:
    """Refuse an empty name, whose parameters could not be told from others.

    :raises ValueError: it is empty.
    """
    if not name:
        raise ValueError("expected names that are not empty, got ''")


def named(
    default: Sequence[Any],
    description: str,
    each: type['Config'],
    make: Callable[[str, Any], Any],
    *,
    read_only: bool = False,
    audience: str = USER,
    valid: Callable[[str], object] = require_name,
) -> Any:
    """A field that is a tuple of items, each with a name and parameters of its own.

    :param default: items with an attribute ``name``; if empty, the list is absent until it is set.
    :param each: declares the parameters of each item.
    :param make: makes an item from its name and an instance of ``each``; raises ValueError.
    :param valid: raises ValueError for a name that cannot be one.
    """
    names = [item.name for item in default]
    spec = Spec(
        '', names or (str,), description, read_only=read_only, audience=audience, valid=valid
    )
    return field(default=tuple(default), metadata={_NAMED: Named(spec, each, make)})


def part(config: type['Config']) -> Any:
    """A field that is itself a configuration; its parameters keep their names."""
    return field(default_factory=config, metadata={_PART: config})


@dataclass(frozen=True)
class Config:
    """The base of all configurations: validates every parameter, then calls :meth:`check`.

    :raises ValueError: a value has the wrong type or is out of its range; the reason names it.
    """

    def __post_init__(self) -> None:
        for item in fields(self):
            if _SPEC in item.metadata:
                value = _spec(item).check(item.name, getattr(self, item.name))
                value = tuple(value) if isinstance(value, list) else value
                object.__setattr__(self, item.name, value)
        self.check()

    def check(self) -> None:
        """Raise ValueError if values contradict each other."""


def specs_of(config: type[Config]) -> Iterator[Spec]:
    """The parameters of a configuration and of its parts, in the order of the fields."""
    for item in fields(config):
        if _PART in item.metadata:
            yield from specs_of(item.metadata[_PART])
        elif _NAMED in item.metadata:
            yield replace(item.metadata[_NAMED].spec, name=item.name)
        elif _SPEC in item.metadata:
            yield _spec(item)


def groups_of(config: type[Config]) -> Iterator[tuple[str, Named]]:
    """For each parameter that lists names, the parameters of each NAME in it."""
    for item in fields(config):
        if _PART in item.metadata:
            yield from groups_of(item.metadata[_PART])
        elif _NAMED in item.metadata:
            yield item.name, item.metadata[_NAMED]


def build(config: type[Built], values: Mapping[str, Any], prefix: str = '') -> Built:
    """Build a configuration from values of its parameters and defaults for the others.

    :param prefix: of the names in ``values``, such as ``NAME.``.
    :raises ValueError: values contradict each other; the reason names the parameter.
    """
    given: dict[str, Any] = {}
    for item in fields(config):
        key = prefix + item.name
        if _PART in item.metadata:
            given[item.name] = build(item.metadata[_PART], values, prefix)
        elif key not in values:
            continue
        elif _NAMED in item.metadata:
            group = item.metadata[_NAMED]
            given[item.name] = tuple(
                group.make(name, build(group.each, values, f'{name}.')) for name in values[key]
            )
        else:
            given[item.name] = values[key]
    return config(**given)


def _spec(item: 'Field[Any]') -> Spec:
    return replace(item.metadata[_SPEC], name=item.name)
