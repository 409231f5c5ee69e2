"""Writes a picked color into a params file, and changes nothing else in its text."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.lab import rgb_from_lab

SHADES = ('lab', 'rgb', 'preset', 'samples')
"""The entries of which one says what color a name is."""

REPLACED = (*SHADES, 'others', 'tolerance')
"""What another color has no use for."""

Splice = tuple[int, int, str]
"""Begin and end of a text, and what replaces it."""


def yaml_of(color: ReferenceColor, min_area: int) -> str:
    """The parameters of a color, ready to paste below the detector's ros__parameters."""
    return (
        f'colors: [{_scalar(color.name)}]\n'
        f'{_scalar(color.name)}: {_flow(_entry(color))}\n'
        f'min_area: {min_area}'
    )


def write_color(path: Path, color: ReferenceColor, min_area: int) -> None:
    """Write a color into a params file, which is created if there is none.

    Comments, order, and everything else stay; a name without a shade, such as the built-in ``red``,
    is dropped from the list of colors.

    :raises ValueError: it cannot be read or written, or is not a params file with a detector.
    """
    try:
        text = path.read_text() if path.exists() else ''
        changed = _changed(text, color, min_area)
        path.write_text(changed)
    except OSError as error:
        raise ValueError(f'{path}: {error.strerror}') from error
    except (yaml.YAMLError, LookupError, TypeError, ValueError, AttributeError) as error:
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ValueError(f'{path}: expected a params file with a detector: {why}') from error


def _changed(text: str, color: ReferenceColor, min_area: int) -> str:
    if not text.strip():
        block = yaml_of(color, min_area).replace('\n', '\n    ')
        return f'{text}/**/detector:\n  ros__parameters:\n    {block}\n'
    node, old = _parameters(text)
    names = [name for name in old.get('colors', []) if name != color.name and _chosen(name, old)]
    kept = {k: v for k, v in old.get(color.name, {}).items() if k not in REPLACED}
    least = min(old.get('min_area', min_area), min_area) if names else min_area
    new = {
        'colors': [*names, color.name],
        color.name: {**kept, **_entry(color)},
        'min_area': least,
    }
    for begin, end, value in sorted(_splices(text, node, new), reverse=True):
        text = text[:begin] + value + text[end:]
    return text


def _parameters(text: str) -> tuple[Any, dict[str, Any]]:
    """The detector's parameters, as a YAML node and as values."""
    root: Any = yaml.compose(text, yaml.SafeLoader)
    detectors = [
        (key.value, value)
        for key, value in root.value
        if key.value.rpartition('/')[2] == 'detector'
    ]
    name, detector = detectors[0]
    (node,) = (value for key, value in detector.value if key.value == 'ros__parameters')
    return node, yaml.safe_load(text)[name]['ros__parameters']


def _chosen(name: str, parameters: dict[str, Any]) -> bool:
    """Whether a name of the list has a shade of its own."""
    return any(key in parameters.get(name, {}) for key in SHADES)


def _splices(text: str, node: Any, new: dict[str, Any]) -> list[Splice]:
    """The splices that give some keys of a mapping new values."""
    splices = [
        _replacement(text, key, value, _flow(new[key.value]))
        for key, value in node.value
        if key.value in new
    ]
    known = {key.value for key, _ in node.value}
    added = [f'{_scalar(k)}: {_flow(new[k])}' for k in new if k not in known]
    if not added:
        return splices
    end = _end(node)
    if node.flow_style:
        comma = ', ' if node.value else ''
        return [*splices, (end - 1, end - 1, comma + ', '.join(added))]
    # After the comment at the end of the last line.
    end = (text + '\n').index('\n', end)
    indent = '\n' + ' ' * node.start_mark.column
    return [*splices, (end, end, indent + indent.join(added))]


def _replacement(text: str, key: Any, value: Any, new: str) -> Splice:
    """Put a value on the line of its key, before a comment."""
    begin, start = key.end_mark.index, value.start_mark.index
    between = text[begin:start]
    if '\n' not in between:
        return start, _end(value), new
    return begin, _end(value), f': {new}{between[1:].rstrip()}'


def _end(node: Any) -> int:
    """Where a node ends, without the comments after it, which YAML counts to a block."""
    if isinstance(node, yaml.ScalarNode) or node.flow_style or not node.value:
        return int(node.end_mark.index)
    last = node.value[-1]
    return _end(last[1] if isinstance(last, tuple) else last)


def _entry(color: ReferenceColor) -> dict[str, Any]:
    if not color.is_sampled:
        return {'lab': list(color.lab), 'tolerance_lab': list(color.axes)}
    entry = {'samples': _levels([color.lab, *color.samples]), 'others': _levels(color.others)}
    return {k: v for k, v in entry.items() if v} | {'tolerance_lab': list(color.axes)}


def _levels(labs: Sequence[tuple[float, float, float]]) -> list[float]:
    """Red, green and blue of colors, one after the other, as rcl takes them."""
    return rgb_from_lab(np.reshape(labs, (-1, 3))).reshape(-1).astype(float).tolist()


def _flow(value: Any) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=4096)
    return text.removesuffix('...\n').strip()


def _scalar(text: str) -> str:
    """A name as YAML, in quotes where it needs them."""
    return _flow([text])[1:-1]
