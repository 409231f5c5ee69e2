"""Arrays that callers give: checked, with what is expected in one line."""

import reprlib

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray


def given_table(values: ArrayLike, name: str, columns: tuple[str, ...]) -> NDArray[np.float64]:
    """The values as an array, (N, number of columns); without rows if there are none.

    :raises ValueError: they have another shape, or are not numbers.
    """
    expected = f'{name}: expected an array (N, {len(columns)}): {", ".join(columns)}'
    try:
        table = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise ValueError(f'{expected}, got {reprlib.repr(values)}') from None
    if not table.size:
        return table.reshape(0, len(columns))
    if table.ndim != 2 or table.shape[1] != len(columns):
        raise ValueError(f'{expected}, got shape {table.shape}')
    return table


def given_for_each(values: ArrayLike, name: str, count: int) -> NDArray[np.float64]:
    """Numbers that are not negative: one for all, or (count,) one for each.

    :raises ValueError: they are not.
    """
    try:
        given = np.asarray(values)
    except ValueError:
        raise ValueError(f'{name}: expected numbers, got {reprlib.repr(values)}') from None
    if given.dtype.kind not in 'iufb' or np.any(given < 0):
        raise ValueError(f'{name}: expected numbers from 0, got {reprlib.repr(values)}')
    if given.ndim and given.shape != (count,):
        raise ValueError(f'{name}: expected one, or one for each of {count}, got {given.shape}')
    return np.asarray(given, np.float64)


def given_size(values: object) -> tuple[int, int]:
    """Width and height of a picture [px].

    :raises ValueError: they are not two whole numbers from 0.
    """
    if isinstance(values, np.ndarray):
        values = values.tolist()
    if not isinstance(values, (tuple, list)) or len(values) != 2:
        raise ValueError(f'image_size: expected (width, height), got {reprlib.repr(values)}')
    width, height = given_for_each(values, 'image_size', 2)
    if not (width.is_integer() and height.is_integer()):
        raise ValueError(f'image_size: expected whole pixels, got {values!r}')
    return int(width), int(height)
