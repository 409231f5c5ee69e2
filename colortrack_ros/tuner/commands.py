"""The commands of the page; each message is validated before anything is done."""

from collections.abc import Callable
from collections.abc import Mapping
import json
import re
from typing import Any

LONGEST_TEXT, MOST_VALUES = 4096, 64
"""Limits of a message: paths are shorter, and a form has fewer values."""

LARGEST_NUMBER = 1 << 31
"""Larger than any number of frames or pixels: frames at 60 Hz reach it after more than a year."""

NAME = re.compile(r'[A-Za-z0-9_-]{1,40}')
"""Names of colors and regions, which become part of a parameter's name."""

Check = Callable[[str, Any], Any]


class CommandError(ValueError):
    """A message is not a valid command: what was given, and what was expected."""


def whole(name: str, value: Any) -> int:
    """An integer."""
    if type(value) is not int or abs(value) > LARGEST_NUMBER:
        raise CommandError(f'{name}: expected an integer, got {_short(value)}')
    return value


def text(name: str, value: Any) -> str:
    """A one-line string."""
    if not isinstance(value, str) or len(value) > LONGEST_TEXT or '\0' in value:
        raise CommandError(f'{name}: expected a text, got {_short(value)}')
    try:
        value.encode()
    except UnicodeEncodeError:
        raise CommandError(f'{name}: expected a text, got half a character') from None
    return value


def identifier(name: str, value: Any) -> str:
    """The name of a color."""
    if not isinstance(value, str) or not NAME.fullmatch(value):
        expected = 'letters, digits, _ and -, up to 40 of them'
        raise CommandError(f'{name}: expected {expected}, got {_short(value)}')
    return value


def flag(name: str, value: Any) -> bool:
    """A boolean."""
    if not isinstance(value, bool):
        raise CommandError(f'{name}: expected true or false, got {_short(value)}')
    return value


def mapping(name: str, value: Any) -> Mapping[str, Any]:
    """Values by name, which the parameter tables validate."""
    if not isinstance(value, dict) or not 1 <= len(value) <= MOST_VALUES:
        raise CommandError(f'{name}: expected 1 to {MOST_VALUES} values by name')
    for key in value:
        if len(text(name, key)) > 200:
            raise CommandError(f'{name}: expected names, got {_short(key)}')
    return value


COMMANDS: dict[str, dict[str, Check]] = {
    'shown': {},
    'play': {},
    'pause': {},
    'seek': {'frame': whole},
    'step': {'by': whole},
    'set': {'node': text, 'values': mapping, 'follows': flag},
    'undo': {},
    'sample': {
        'color': identifier,
        'is_it': flag,
        'u': whole,
        'v': whole,
        'width': whole,
        'height': whole,
    },
    'remove_color': {'color': identifier},
    'rename_color': {'color': identifier, 'to': identifier},
    'background': {},
    'learn_background': {},
    'load': {'path': text},
    'diff': {'path': text},
    'save': {'path': text, 'digest': text},
    'lines': {},
    'plane': {},
    'nodes': {},
    'attach': {'node': text, 'to': text},
    'survey': {},
    'label': {'id': whole, 'frame': whole, 'u': whole, 'v': whole, 'width': whole, 'height': whole},
    'gone': {'id': whole, 'frame': whole},
    'unlabel': {'id': whole, 'frame': whole},
    'labels_at': {'frame': whole},
    'load_labels': {'path': text},
    'save_labels': {'path': text, 'overwrite': flag},
}
"""The fields of each command; all are required."""


def parse(message: str) -> tuple[str, dict[str, Any]]:
    """Parse a command and its fields.

    :raises CommandError: it is not a valid command.
    """
    try:
        content = json.loads(message, parse_constant=_no_constant)
    except (ValueError, RecursionError):
        raise CommandError('expected JSON') from None
    if not isinstance(content, dict):
        raise CommandError(f'expected an object with a field "do", got {_short(content)}')
    command = content.pop('do', None)
    if not isinstance(command, str) or command not in COMMANDS:
        raise CommandError(f'do: expected one of {", ".join(COMMANDS)}, got {_short(command)}')
    fields = COMMANDS[command]
    if set(content) != set(fields):
        raise CommandError(
            f'{command}: expected the fields {sorted(fields)}, got {_short(content)}'
        )
    return command, {name: check(name, content[name]) for name, check in fields.items()}


def _no_constant(constant: str) -> None:
    raise ValueError(constant)


def _short(value: Any) -> str:
    """A value as shown in a reason."""
    given = repr(value)
    return given if len(given) <= 80 else f'{given[:77]}...'
