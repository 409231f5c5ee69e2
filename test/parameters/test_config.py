from dataclasses import dataclass
import re
from typing import NamedTuple

import numpy as np
import pytest

from colortrack_ros.parameters import build
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import named
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import part


@dataclass(frozen=True)
class Shade(Config):
    lab: tuple[float, ...] = parameter(float, 'The color.')
    tolerance: float = parameter(25.0, 'How near.', limits=(0.0, 200.0))


class Color(NamedTuple):
    name: str
    lab: tuple[float, ...]
    tolerance: float


def color(name: str, shade: Shade) -> Color:
    if not shade.lab:
        raise ValueError(f'{name}.lab: expected a color, got none')
    return Color(name, shade.lab, shade.tolerance)


@dataclass(frozen=True)
class Order(Config):
    window: float = parameter(0.0, 'How long.', unit='s', limits=(0.0, 10.0))


@dataclass(frozen=True)
class Whole(Config):
    low: int = parameter(1, 'The least.', limits=(0, 100))
    high: int = parameter(10, 'The greatest.', limits=(0, 100), audience=EXPERT)
    size: tuple[int, int] = parameter((0, 0), 'Width and height.', unit='px', limits=(0, 9999))
    colors: tuple[Color, ...] = named([Color('red', (1.0,), 2.0)], 'The colors.', Shade, color)
    order: Order = part(Order)

    def check(self) -> None:
        if self.low > self.high:
            raise ValueError(f'low: expected at most high, {self.high}, got {self.low}')


def test_a_field_declares_the_parameter_of_the_table():
    table = ParameterTable.of(Whole)
    assert list(table.specs) == ['low', 'high', 'size', 'colors', 'window']
    assert table.find('high').audience == EXPERT
    assert table.find('blue.tolerance').limits == (0.0, 200.0)
    assert table.find('size').length == 2


def test_values_make_the_configuration_and_its_parts():
    values = {'colors': ['blue'], 'blue.lab': [1.0, 2.0, 3.0], 'low': 3, 'window': 0.5}
    whole = build(Whole, ParameterTable.of(Whole).defaults(values))
    assert whole.colors == (Color('blue', (1.0, 2.0, 3.0), 25.0),)
    assert (whole.low, whole.high, whole.order.window) == (3, 10, 0.5)


def test_without_values_there_are_the_defaults():
    assert build(Whole, {}) == Whole()
    assert Whole().colors == (Color('red', (1.0,), 2.0),)


@pytest.mark.parametrize(
    ('values', 'reason'),
    [
        ({'low': -1}, 'low: expected 0..100, got -1'),
        ({'low': 'x'}, "low: expected int, 0..100, got 'x'"),
        ({'size': (1, 2, 3)}, 'size: expected a list of int of 2, 0..9999 px, got (1, 2, 3)'),
        ({'size': (1, -2)}, 'size: expected 0..9999 px, got -2'),
        ({'low': 20}, 'low: expected at most high, 10, got 20'),
    ],
)
def test_a_configuration_refuses_what_the_table_refuses(values, reason):
    with pytest.raises(ValueError, match=f'^{re.escape(reason)}$'):
        Whole(**values)


def test_an_int_is_taken_for_a_float():
    window = Order(window=3).window
    assert (window, type(window)) == (3.0, float)


def test_numbers_and_arrays_of_numpy_are_taken():
    whole = Whole(low=np.int64(3), size=np.array([640, 480]), order=Order(np.float32(0.5)))
    assert whole == Whole(low=3, size=(640, 480), order=Order(0.5))
    assert [type(value) for value in (whole.low, *whole.size)] == [int] * 3
    assert Whole(size=[np.int32(640), 480]).size == (640, 480)
    with pytest.raises(ValueError, match=r'size: expected list of int, .* got 0\.5'):
        Whole(size=np.array([0.5, 1.0]))
    with pytest.raises(ValueError, match=r'window: expected a finite number, .* got nan'):
        Order(np.float64('nan'))


def test_what_a_name_lacks_is_told_with_the_name():
    with pytest.raises(ValueError, match=r'^blue\.lab: expected a color, got none$'):
        build(Whole, {'colors': ['blue']})
