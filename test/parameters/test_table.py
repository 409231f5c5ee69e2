from hypothesis import given
from hypothesis import strategies as st
import pytest

from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec

TABLE = ParameterTable(
    [
        Spec('low', 1, 'The least.', limits=(0, 100)),
        Spec('high', 10, 'The greatest.', limits=(0, 100)),
        Spec('rate', 0.5, 'A rate.', unit='Hz', limits=(-1.0, 9.0)),
        Spec('method', 'lab', 'One of two.', choices=('lab', 'hsv')),
        Spec('names', ['red'], 'The names.'),
    ],
    each={
        'names': [
            Spec('lab', (float,), 'A color.'),
            Spec('tolerance', 25.0, 'How near.', limits=(0.0, 200.0)),
        ],
    },
)


def build(values):
    if values['low'] > values['high']:
        raise ValueError(f'low: expected at most high, {values["high"]}, got {values["low"]}')
    for name in values['names']:
        if name != 'red' and f'{name}.lab' not in values:
            raise ValueError(f'{name}.lab: expected a color, got none')
    return values


@pytest.mark.parametrize(
    ('name', 'value', 'reason'),
    [
        ('low', 101, 'low: expected 0..100, got 101'),
        ('low', 1.0, 'low: expected int, 0..100, got 1.0'),
        ('low', True, 'low: expected int, 0..100, got True'),
        ('rate', -1.5, 'rate: expected -1..9 Hz, got -1.5'),
        ('rate', float('nan'), 'rate: expected a finite number, -1..9 Hz, got nan'),
        ('rate', float('inf'), 'rate: expected a finite number, -1..9 Hz, got inf'),
        ('rate', 'fast', "rate: expected float, -1..9 Hz, got 'fast'"),
        ('rate', [1.0], r'rate: expected a float, -1..9 Hz, got \[1.0\]'),
        ('method', 'rgb', "method: expected one of lab, hsv, got 'rgb'"),
        ('names', 'red', "names: expected a list of str, got 'red'"),
        ('names', [1], 'names: expected list of str, got 1'),
        ('red.lab', 3.0, 'red.lab: expected a list of float, got 3.0'),
        ('red.tolerance', 300.0, 'red.tolerance: expected 0..200, got 300.0'),
        ('lwo', 1, 'lwo: no such parameter; the nearest is low'),
        ('red.tolerence', 1.0, 'red.tolerence: no such parameter; the nearest is red.tolerance'),
    ],
)
def test_a_value_of_the_wrong_type_or_range_is_refused_with_a_reason(name, value, reason):
    with pytest.raises(ValueError, match=reason):
        TABLE.find(name).check(name, value)
    values, refused = TABLE.consistent({name: value}, build)
    assert list(refused) == [name]
    assert values == TABLE.defaults({})


def test_an_int_is_taken_for_a_float():
    assert TABLE.find('rate').check('rate', 3) == 3.0
    assert TABLE.find('red.lab').check('red.lab', [50, 1.5, -3]) == [50.0, 1.5, -3.0]


def test_optional_parameters_are_absent_until_set():
    assert TABLE.defaults({}) == {
        'low': 1,
        'high': 10,
        'rate': 0.5,
        'method': 'lab',
        'names': ['red'],
        'red.tolerance': 25.0,
    }


@given(st.permutations(['names', 'low', 'high', 'blue.lab', 'green.lab']))
def test_values_that_need_each_other_are_taken_in_any_order(order):
    given_values = {
        'names': ['blue', 'green'],
        'low': 50,
        'high': 60,
        'blue.lab': [1.0, 2.0, 3.0],
        'green.lab': [1.0, 2.0, 3.0],
    }
    values, refused = TABLE.consistent({name: given_values[name] for name in order}, build)
    assert refused == {}
    assert values == TABLE.defaults(given_values)


@given(st.permutations(['rate', 'low', 'high']))
def test_of_values_that_contradict_each_other_the_rest_stays(order):
    given_values = {'rate': 2.0, 'low': 50, 'high': 40}
    values, refused = TABLE.consistent({name: given_values[name] for name in order}, build)
    assert values['rate'] == 2.0
    assert len(refused) == 1
    assert values['low'] <= values['high']


@pytest.mark.parametrize('name', ['low', 'red.lab', 'anything.tolerance'])
def test_a_table_knows_its_names_and_those_of_each_name_in_a_list(name):
    assert name in TABLE


@pytest.mark.parametrize('name', ['', 'lab', '.lab', 'red.', 'red.low', 'lowest'])
def test_a_table_does_not_know_other_names(name):
    assert name not in TABLE
    with pytest.raises(ValueError, match='no such parameter'):
        TABLE.find(name)
