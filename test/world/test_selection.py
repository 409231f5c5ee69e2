import numpy as np
import pytest

from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.world.selection import Selector

ROBOT = np.zeros(3)


def locations(*positions, **columns):
    rows = np.zeros(len(positions), LOCATION)
    rows['x'] = positions
    rows['track_id'] = 1 + np.arange(len(rows))
    rows['state'] = 1
    for name, values in columns.items():
        rows[name] = values
    return Locations(rows)


@pytest.mark.parametrize(
    ('rule', 'expected'),
    [('nearest', 2), ('largest', 3), ('oldest', 1), ('most_certain', 2), ('3', 3), ('blue', 3)],
)
def test_each_rule_chooses_its_object(rule, expected):
    covariance = np.array([4.0, 1, 9])[:, None, None] * np.eye(6)
    all_of = locations(3, 1, 2, diameter=[0.1, 0.1, 0.4], color=[0, 0, 1], covariance=covariance)
    row = Selector(rule, ['red', 'blue']).choose(all_of, ROBOT)
    assert all_of.rows['track_id'][row] == expected


def test_two_that_are_alike_do_not_take_turns():
    selector = Selector('nearest', [])
    chosen = [selector.choose(locations(2, x), ROBOT) for x in (2.1, 1.9, 1.7, 1.5)]
    assert chosen == [0, 0, 0, 1]


def test_a_target_that_has_gone_gives_way():
    selector = Selector('nearest', [])
    assert selector.choose(locations(1, 5), ROBOT) == 0
    assert selector.choose(locations(5, track_id=2), ROBOT) == 0
    assert selector.choose(locations(), ROBOT) is None


def test_a_tentative_object_is_no_target():
    assert Selector('nearest', []).choose(locations(1, state=0), ROBOT) is None


@pytest.mark.parametrize('text', ['reddest', '', '\u00b2', '9' * 5000, '-1', '1.0', ' 1'])
def test_what_is_no_rule_is_refused_with_those_there_are(text):
    """Digits that are no number, as a superscript, raised an error for each picture."""
    with pytest.raises(ValueError, match='nearest, largest, oldest, most_certain, red, or a track'):
        Selector(text, ['red'])


@pytest.mark.parametrize('text', ['0', '7', str(2**32 - 1), '9' * 10])
def test_an_id_that_nothing_has_selects_nothing(text):
    assert Selector(text, ['red']).choose(locations(1, 2), ROBOT) is None
