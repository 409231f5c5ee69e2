"""One parameter: its type, default, unit, range and description, and the validation of values."""

from collections.abc import Callable
from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

USER, EXPERT, DOCUMENT = 'user', 'expert', 'document'
"""Who sets a parameter: the owner of a robot; somebody who knows the method; somebody who
reproduces one of the documents that the package implements."""


@dataclass(frozen=True)
class Spec:
    """The declaration of a parameter.

    :param name: of the parameter; for one of each NAME in a list, the part after the dot.
    :param default: the value if it is not set, which also determines the type. An empty tuple of a
        type, such as ``(float,)``, is a list of that type, absent until it is set.
    :param description: one sentence.
    :param unit: of the value, empty if it has none.
    :param limits: the least and the greatest allowed value; None for any.
    :param choices: the allowed values of a string, empty for any.
    :param length: number of items of a list, None for any.
    :param audience: USER, EXPERT or DOCUMENT.
    :param read_only: whether it can be set only on start.
    :param int_is_text: whether an integer means its digits, since quotes around a name of digits
        are easily forgotten.
    :param shown: the value as displayed, such as an address without its password.
    :param valid: further validation; raises ValueError with what was expected.
    """

    name: str
    default: Any
    description: str
    unit: str = ''
    limits: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    length: int | None = None
    audience: str = USER
    read_only: bool = False
    int_is_text: bool = False
    shown: Callable[[Any], Any] = lambda value: value
    valid: Callable[[Any], object] = lambda value: value

    @property
    def optional(self) -> bool:
        """Whether the parameter is absent until it is set."""
        return isinstance(self.default, tuple)

    @property
    def many(self) -> bool:
        """Whether the value is a list."""
        return isinstance(self.default, tuple | list)

    @property
    def kind(self) -> type[Any]:
        """The type of the value, or of each item of a list."""
        scalar = self.default[0] if self.many else self.default
        return scalar if isinstance(scalar, type) else type(scalar)

    @property
    def type_name(self) -> str:
        """The type in words: float, int, bool, str, or a list of one of these."""
        return f'list of {self.kind.__name__}' if self.many else self.kind.__name__

    @property
    def range_text(self) -> str:
        """The range in words, empty if there is none."""
        if self.choices:
            return ', '.join(choice or "''" for choice in self.choices)
        return f'{self.limits[0]:g}..{self.limits[1]:g}' if self.limits else ''

    @property
    def allowed_text(self) -> str:
        """The range and the unit in words, after a comma; empty if there is no range."""
        one_of = 'one of ' if self.choices else ''
        return f', {one_of}{self.range_text} {self.unit}'.rstrip() if self.range_text else ''

    def check(self, name: str, value: Any) -> Any:
        """The value in the parameter's type; an int is accepted for a float, and so is what NumPy
        has of both.

        :param name: the full name, for the reason.
        :return: a list if :attr:`many`, otherwise a scalar.
        :raises ValueError: it has another type, is not finite, or lies outside the range.
        """
        value = _plain(value)
        is_list = isinstance(value, Sequence) and not isinstance(value, str)
        count = f' of {self.length}' if self.length is not None else ''
        if self.many != is_list or (self.length is not None and len(value) != self.length):
            expected = f'{self.type_name}{count}{self.allowed_text}'
            raise ValueError(f'{name}: expected a {expected}, got {value!r}')
        if self.many:
            return [self._check_one(name, item) for item in value]
        return self._check_one(name, value)

    def _check_one(self, name: str, value: Any) -> Any:
        kind: Any = self.kind
        value = _plain(value)
        if kind is float and type(value) is int:
            value = float(value)
        if self.int_is_text and type(value) is int:
            value = str(value)
        if type(value) is not kind:
            expected = f'{self.type_name}{self.allowed_text}'
            raise ValueError(f'{name}: expected {expected}, got {value!r}')
        if kind is float and not math.isfinite(value):
            raise ValueError(f'{name}: expected a finite number{self.allowed_text}, got {value}')
        if self.limits and not self.limits[0] <= value <= self.limits[1]:
            raise ValueError(f'{name}: expected {self.allowed_text[2:]}, got {value}')
        if self.choices and value not in self.choices:
            raise ValueError(f'{name}: expected {self.allowed_text[2:]}, got {value!r}')
        try:
            self.valid(value)
        except ValueError as error:
            raise ValueError(f'{name}: {error}') from error
        return value


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as numbers and lists of Python; all else as it is."""
    return value.tolist() if hasattr(value, 'tolist') else value
