"""Writes a picked color into a params file, and changes nothing else in its text."""

from collections.abc import Mapping
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.presets import PRESETS
from colortrack_ros.detection.reference import DEFAULT_COLORS
from colortrack_ros.files import read_params_file
from colortrack_ros.files import write_file
from colortrack_ros.parameters.params_file import flow
from colortrack_ros.parameters.params_file import given_in
from colortrack_ros.parameters.params_file import has_node
from colortrack_ros.parameters.params_file import quoted
from colortrack_ros.parameters.params_file import with_values

SHADES = ('lab', 'rgb', 'preset', 'samples', 'tolerance', 'tolerance_lab')
"""The entries of which one says what color a name is; of a common name, a tolerance alone does."""

REPLACED = (*SHADES, 'others', 'min_area', 'max_area')
"""What another color has no use for."""


def yaml_of(color: ReferenceColor, limits: Mapping[str, float]) -> str:
    """The parameters of a color, ready to paste below the detector's ros__parameters."""
    name = quoted(color.name)
    of_shape = [f'{key}: {limit}' for key, limit in limits.items()]
    return '\n'.join([f'colors: [{name}]', f'{name}: {flow(_entry(color))}', *of_shape])


def write_color(path: Path, color: ReferenceColor, limits: Mapping[str, float]) -> None:
    """Write a color into a params file, which is created if there is none.

    Comments, order, and everything else stay; a name of which no SHADES are given, such as the
    built-in ``red``, is dropped from the list of colors.

    :raises ValueError: it cannot be read or written, or is not a params file.
    """
    try:
        text = read_params_file(path) if path.exists() else ''
        if text.strip() and not has_node(text, 'detector'):
            raise ValueError('there is none in it')
        values = color_values(given_in(text, 'detector'), color, limits)
        write_file(path, with_values(text, 'detector', values).encode())
    except OSError as error:
        raise ValueError(f'{path}: {error.strerror}') from error
    except (LookupError, TypeError, ValueError) as error:
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ValueError(f'{path}: expected a params file with a detector: {why}') from error


def color_values(
    old: Mapping[str, Any], color: ReferenceColor, limits: Mapping[str, float]
) -> dict[str, Any]:
    """What a color that was picked or taught changes in a detector's values, None for what goes.

    A color that is listed keeps its place, which is its number in detections. Beside other colors,
    whose things may be of another size, it has limits of the area of its own.

    :param old: the values that are given, by full name.
    :param limits: of the area and the shape, by parameter.
    """
    chosen = {name.rpartition('.')[0] for name in old if name.rpartition('.')[2] in SHADES}
    listed = old.get('colors', [])
    if listed != [default.name for default in DEFAULT_COLORS]:
        chosen |= {*PRESETS}
    names = [name for name in listed if name in chosen or name == color.name]
    if color.name not in names:
        names.append(color.name)
    single = len(names) == 1
    own = {f'{color.name}.' * (not single and key in REPLACED) + key: limits[key] for key in limits}
    mine = [f'{color.name}.{key}' for key in REPLACED] + ['min_area'] * single
    gone = dict.fromkeys(key for key in mine if key in old)
    new = {f'{color.name}.{key}': value for key, value in _entry(color).items()}
    return {'colors': names, **gone, **new, **own}


def _entry(color: ReferenceColor) -> dict[str, Any]:
    entry: dict[str, Any] = {'lab': list(color.lab)}
    if color.is_sampled:
        samples = [color.lab, *color.samples]
        entry = {'samples': _levels(samples), 'others': _levels(color.others)}
    axes = [] if color.is_sought else list(color.axes)
    return {key: value for key, value in (entry | {'tolerance_lab': axes}).items() if value}


def _levels(labs: Sequence[tuple[float, float, float]]) -> list[float]:
    """Red, green and blue of colors, one after the other, as rcl takes them."""
    return rgb_from_lab(np.reshape(labs, (-1, 3))).reshape(-1).astype(float).tolist()
