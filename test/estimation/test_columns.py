"""Tables: whatever is done to the rows is done to every column."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import pytest

from colortrack_ros.columns import Columns


@dataclass
class Inner(Columns):
    axis = 1
    modes: NDArray


@dataclass
class Outer(Columns):
    name: NDArray
    inner: Inner
    width: int = 640


def table(*names: int) -> Outer:
    return Outer(np.array(names), Inner(np.stack([names, np.negative(names)])))


def contents(outer: Outer) -> list:
    assert outer.width == 640
    return [outer.name.tolist(), outer.inner.modes.tolist()]


@pytest.mark.parametrize('rows', [[2, 0], [True, False, True]])
def test_taking_rows_takes_them_of_every_column_and_leaves_the_table(rows):
    whole, rows = table(5, 6, 7), np.array(rows)
    names = np.array([5, 6, 7])[rows]
    assert contents(whole.take(rows)) == contents(table(*names))
    assert contents(whole) == contents(table(5, 6, 7))
    whole.keep(rows)
    assert contents(whole) == contents(table(*names))


def test_rows_are_joined_and_replaced_in_every_column():
    joined = table(5)
    joined.extend(table(6, 7))
    assert contents(joined) == contents(table(5, 6, 7))
    assert (len(joined), len(joined.inner)) == (3, 3)
    joined.put(np.array([2, 0]), table(8, 9))
    assert contents(joined) == contents(table(9, 6, 8))
