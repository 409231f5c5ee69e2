"""Parameters of a node, declared once in a table: name, default, unit, range, description.

What is checked here is the type and the range of each value alone. Whether values fit together is
for the ``build`` function of the node, which makes the configuration of its room from them and
raises ValueError with the reason.
"""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import fields
import difflib
import math
from typing import Any

from rcl_interfaces.msg import FloatingPointRange
from rcl_interfaces.msg import IntegerRange
from rcl_interfaces.msg import ParameterDescriptor

FOREIGN = ('use_sim_time', 'qos_overrides.', 'start_type_description_service')
"""Names (or their beginnings) of the parameters that rclpy declares on its own."""


@dataclass(frozen=True)
class Spec:
    """One row of a parameter table.

    :param name: of the parameter; in a table for each NAME of a list, its part after the dot.
    :param default: its value when nobody sets it, and by that its type. An empty tuple of a type,
        such as ``(float,)``, is a list of that type that is absent until it is set.
    :param description: one sentence.
    :param unit: of the value, empty where it has none.
    :param minimum: the least allowed value, None for no limit.
    :param maximum: the greatest allowed value, None for no limit.
    :param choices: the allowed values of a string, empty for any.
    :param read_only: whether only the start sets it.
    :param shown: what others see of the value, such as an address without its password.
    :param valid: raises ValueError with what was expected, where type and range do not say all.
    """

    name: str
    default: Any
    description: str
    unit: str = ''
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = False
    shown: Callable[[Any], Any] = lambda value: value
    valid: Callable[[Any], object] = lambda value: value

    @property
    def optional(self) -> bool:
        """Whether the parameter is absent until somebody sets it."""
        return isinstance(self.default, tuple)

    @property
    def type_name(self) -> str:
        """The type in words: float, int, bool, str, or list of one of them."""
        if isinstance(self.default, tuple):
            return f'list of {self.default[0].__name__}'
        if isinstance(self.default, list):
            return f'list of {type(self.default[0]).__name__}'
        return type(self.default).__name__

    @property
    def range_text(self) -> str:
        """The range in words, empty when there is none."""
        if self.choices:
            return ', '.join(choice or "''" for choice in self.choices)
        if self.minimum is None and self.maximum is None:
            return ''
        low = '' if self.minimum is None else f'{self.minimum:g}'
        high = '' if self.maximum is None else f'{self.maximum:g}'
        return f'{low}..{high}'

    @property
    def allowed_text(self) -> str:
        """The range and the unit in words, after a comma, empty when there is no range."""
        one_of = 'one of ' if self.choices else ''
        return f', {one_of}{self.range_text} {self.unit}'.rstrip() if self.range_text else ''

    def check(self, name: str, value: Any) -> Any:
        """The value in the parameter's type, an int being taken for a float.

        :param name: the full name, for the reason.
        :raises ValueError: it has another type, is not finite, or lies outside the range.
        """
        scalar = self.default[0] if isinstance(self.default, tuple | list) else self.default
        kind = scalar if isinstance(scalar, type) else type(scalar)
        many = isinstance(self.default, tuple | list)
        items = list(value) if isinstance(value, Sequence) and not isinstance(value, str) else None
        if many != (items is not None):
            expected = f'{self.type_name}{self.allowed_text}'
            raise ValueError(f'{name}: expected a {expected}, got {value!r}')
        checked = [self._check_one(name, item, kind) for item in items or [value]]
        return ([] if not items else checked) if many else checked[0]

    def _check_one(self, name: str, value: Any, kind: Any) -> Any:
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind:
            expected = f'{self.type_name}{self.allowed_text}'
            raise ValueError(f'{name}: expected {expected}, got {value!r}')
        if kind is float and not math.isfinite(value):
            raise ValueError(f'{name}: expected a finite number{self.allowed_text}, got {value}')
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        if kind in (int, float) and not low <= value <= high:
            raise ValueError(f'{name}: expected {self.allowed_text[2:]}, got {value}')
        if self.choices and value not in self.choices:
            raise ValueError(f'{name}: expected {self.allowed_text[2:]}, got {value!r}')
        try:
            self.valid(value)
        except ValueError as error:
            raise ValueError(f'{name}: {error}') from error
        return value

    def descriptor(self) -> ParameterDescriptor:
        """What ``ros2 param describe`` shows."""
        descriptor = ParameterDescriptor(
            description=self.description + (f' [{self.unit}]' if self.unit else ''),
            additional_constraints=self.range_text,
            read_only=self.read_only,
            # The types are checked here, so that 30 is taken for 30.0 and the reason is ours.
            dynamic_typing=True,
        )
        if self.minimum is not None and self.maximum is not None:
            low, high = self.minimum, self.maximum
            if type(self.default) is float:
                descriptor.floating_point_range = [
                    FloatingPointRange(from_value=float(low), to_value=float(high))
                ]
            elif type(self.default) is int:
                descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
        return descriptor


class ParameterTable:
    """The parameters of one kind of node.

    :param specs: the fixed ones.
    :param each: by the parameter that lists names, those that exist once for each NAME in it, as
        ``NAME.spec``.
    """

    def __init__(
        self, specs: Iterable[Spec], each: Mapping[str, Iterable[Spec]] | None = None
    ) -> None:
        self.specs = {spec.name: spec for spec in specs}
        self.groups = {names: {s.name: s for s in group} for names, group in (each or {}).items()}
        self.each = {name: spec for group in self.groups.values() for name, spec in group.items()}

    def find(self, name: str) -> Spec:
        """The row of a full parameter name.

        :raises ValueError: there is none; the nearest known name is given.
        """
        spec = self.specs.get(name)
        owner, _, suffix = name.rpartition('.')
        if spec is None and owner:
            spec = self.each.get(suffix)
        if spec is None:
            known = [*self.specs, *(f'{owner or "NAME"}.{suffix}' for suffix in self.each)]
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
            raise ValueError(f'{name}: no such parameter; the nearest is {near}')
        return spec

    def defaults(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The given values, completed by the defaults of what is not given."""
        every = dict(self.specs)
        for listing, group in self.groups.items():
            names = values.get(listing, self.specs[listing].default)
            if not self.specs[listing].optional or listing in values:
                every |= {f'{name}.{key}': spec for name in names for key, spec in group.items()}
        return {n: s.default for n, s in every.items() if not s.optional} | dict(values)

    def consistent(
        self, given: Mapping[str, Any], build: Callable[[Mapping[str, Any]], Any]
    ) -> tuple[dict[str, Any], dict[str, str]]:
        """As many of the given values as are valid together, and why the others are not.

        :param given: from the command line and the YAML files.
        :param build: raises ValueError for values that do not fit together.
        :return: all values, defaults included; and the reason for each refused name.
        """
        accepted: dict[str, Any] = {}
        refused: dict[str, str] = {}
        for name, value in given.items():
            try:
                accepted[name] = self.find(name).check(name, value)
            except ValueError as error:
                refused[name] = str(error)
        try:
            build(self.defaults(accepted))
        except ValueError:
            accepted, reasons = self._largest_consistent(accepted, build)
            refused.update(reasons)
        return self.defaults(accepted), refused

    def _largest_consistent(
        self, given: Mapping[str, Any], build: Callable[[Mapping[str, Any]], Any]
    ) -> tuple[dict[str, Any], dict[str, str]]:
        accepted: dict[str, Any] = {}
        waiting = dict(given)
        while True:
            reasons = {}
            for name, value in waiting.items():
                try:
                    build(self.defaults(accepted | {name: value}))
                    accepted[name] = value
                except ValueError as error:
                    reasons[name] = str(error)
            # One value may need another one to be valid, so try again as long as it helps.
            if len(reasons) in (0, len(waiting)):
                return accepted, reasons
            waiting = {name: waiting[name] for name in reasons}


def own_values(setup: type, values: Mapping[str, Any]) -> dict[str, Any]:
    """Of the parameters those that a setup, a dataclass, has as fields of the same name."""
    return {field.name: values[field.name] for field in fields(setup) if field.name in values}
