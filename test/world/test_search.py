"""A search tries its hypotheses picture by picture."""

import numpy as np
import pytest

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.search import Needed
from colortrack_ros.world.search import Search
from colortrack_ros.world.search import SEARCH_TIME


class Pictures:
    """None; notes how many mistakes are asked for at once, of which the third explains most."""

    newest = 0

    def __init__(self):
        self.asked = []

    def misfits(self, mistakes):
        off = 10.0 + np.abs(np.arange(len(mistakes)) + sum(self.asked) - 2.0)[:, None]
        self.asked.append(len(mistakes))
        return off


def test_a_picture_that_comes_twice_tries_nothing_twice():
    pictures = Pictures()
    search = Search(pictures, Needed(1, True, True, 1.0))
    search.go_on(0)
    assert pictures.asked == []
    for k in range(1, round(30 * SEARCH_TIME) + 2):
        for _ in range(2):
            if search.found is None:
                search.go_on(k * NANOSECONDS // 30)
    line, _, off = search.found
    assert off.tolist() == [10.0]
    assert line
    assert min(pictures.asked) > 0


@pytest.mark.parametrize(
    ('given', 'off', 'met'),
    [
        ((2.6, 26.0), (0.1, 0.2), True),
        ((0.9, 40.0), (0.1, 0.2), False),  # one stands as given
        ((2.6, 6.0), (0.1, 0.2), False),  # they hardly move
        ((2.6, 26.0), (0.1, 1.1), False),  # one still moves
        ((2.6, 26.0), (0.9, 0.9), False),  # not so much better
        ((26.0, 26.0, 26.0), (0.1, 0.1, np.inf), False),  # one cannot be there
    ],
)
def test_a_mistake_is_made_if_by_it_things_stand_that_as_given_all_move_and_in_sum_by_much(
    given, off, met
):
    needed = Needed(objects=2, known=False, alone=False, misfit=6.0)
    assert needed.met(np.array(given), np.array(off)) == met
