"""Values in the text of a params file change, and nothing else."""

import pytest
import yaml

from colortrack_ros.parameters.params_file import given_in
from colortrack_ros.parameters.params_file import with_values

FILE = """\
# of the robot
/**/camera:
  ros__parameters: {source: scene:five}

/**/detector:
  ros__parameters:   # what we look for
    colors: [ball, cone]  # in this order
    ball:
      rgb: [205, 58, 34]   # the big one
      tolerance: 25.0
    cone: {lab: [62.0, 20.0, 65.0], tolerance: 20.0}  # orange
    min_area: 40
    # the end

/**/tracker:
  ros__parameters:
    process_noise: 10.0
"""


def test_the_values_of_a_node_are_read_by_their_full_names():
    assert given_in(FILE, 'detector') == {
        'colors': ['ball', 'cone'],
        'ball.rgb': [205, 58, 34],
        'ball.tolerance': 25.0,
        'cone.lab': [62.0, 20.0, 65.0],
        'cone.tolerance': 20.0,
        'min_area': 40,
    }
    assert given_in('robot1: {detector: {ros__parameters: {a.b: 1}}}', 'detector') == {'a.b': 1}
    assert given_in('', 'detector') == {}


CHANGES = [
    {'min_area': 7},
    {'max_area': 900, 'split': True},
    {'ball.tolerance': 3.5, 'cone.tolerance': None},
    {'ball.rgb': None, 'ball.lab': [1.0, 2.0, 3.0], 'ball.tolerance': None},
    {'cone.lab': None, 'cone.tolerance': None, 'colors': ['ball']},
    {'colors': ['ball', 'cup'], 'cup.samples': [1.0, 2.0, 3.0], 'cup.tolerance': 1e-5},
    {'ball.tolerance': None, 'ball.rgb': None},
    {'min_area': None},
    {'gate': None},
    dict.fromkeys(given_in(FILE, 'detector')),
]


@pytest.mark.parametrize('change', CHANGES)
@pytest.mark.parametrize('form', ['blocks', 'flow', 'list of lines'])
def test_only_the_changed_values_change(change, form):
    text = FILE
    if form == 'flow':
        text = yaml.safe_dump(yaml.safe_load(FILE), default_flow_style=True, width=60)
    elif form == 'list of lines':
        text = text.replace('[ball, cone]  # in', '\n    - ball\n    - cone\n    # in')
    before = given_in(text, 'detector')
    after = with_values(text, 'detector', change)
    expected = {k: v for k, v in {**before, **change}.items() if v is not None}
    assert given_in(after, 'detector') == expected
    whole, rest = yaml.safe_load(text), yaml.safe_load(after)
    whole.pop('/**/detector'), rest.pop('/**/detector')
    assert rest == whole
    if form != 'flow':
        lost = set(text.splitlines()) - set(after.splitlines())
        parts = {name.rpartition('.')[2] for name in change} | {'ball', 'cone', '- ', 'order'}
        assert [line for line in lost if not any(part in line for part in parts)] == []


@pytest.mark.parametrize('change', CHANGES)
def test_lines_end_as_windows_ends_them_where_all_do(change):
    after = with_values(FILE.replace('\n', '\r\n'), 'detector', change)
    assert after == with_values(FILE, 'detector', change).replace('\n', '\r\n')


def test_a_node_that_the_file_has_not_is_added_below():
    after = with_values(
        '# mine\n/**/camera: {ros__parameters: {loop: true}}\n', 'tracker', {'a': 1}
    )
    assert after.startswith('# mine\n/**/camera: {ros__parameters: {loop: true}}\n')
    assert given_in(after, 'tracker') == {'a': 1}
    assert with_values('', 'detector', {'ball.lab': [1.0, 2.0, 3.0], 'ball.tolerance': 2.0}) == (
        '/**/detector:\n  ros__parameters:\n    ball: {lab: [1.0, 2.0, 3.0], tolerance: 2.0}\n'
    )


@pytest.mark.parametrize('text', ['- 1', 'a: [', '3', '/**/detector: {ros__parameters: 4}'])
def test_what_is_no_params_file_is_refused(text):
    with pytest.raises(ValueError, match='expected'):
        with_values(text, 'detector', {'min_area': 4})


def test_a_file_with_anchors_is_not_damaged():
    text = (
        '/**/detector:\n  ros__parameters:\n    ball: &b {tolerance: 3.0}\n    cone: *b\n'
        '/**/tracker:\n  ros__parameters: {}\n'
    )
    assert given_in(text, 'detector') == {'ball.tolerance': 3.0, 'cone.tolerance': 3.0}
    with pytest.raises(ValueError, match='by hand'):
        with_values(text, 'detector', {'cone.tolerance': 4.0})


@pytest.mark.parametrize(
    'text',
    [
        '/**/detector: &d\n  ros__parameters:\n    min_area: 30\n/front/detector: *d\n',
        '/**/detector:\n  ros__parameters: &p {min_area: 30}\n/x:\n  ros__parameters: *p\n',
        '/**/detector:\n  ros__parameters:\n    min_area: &a 30\n/x: {ros__parameters: {y: *a}}\n',
    ],
)
def test_what_other_nodes_take_over_by_an_alias_is_not_changed_with_it(text):
    with pytest.raises(ValueError, match='by hand'):
        with_values(text, 'detector', {'min_area': 40})


def test_anchors_elsewhere_and_values_that_are_no_number_are_no_hindrance():
    other = 'rates: &r {rate: .nan}\n/x:\n  ros__parameters: *r\n'
    text = f'/**/detector:\n  ros__parameters:\n    min_area: 30\n{other}'
    changed = with_values(text, 'detector', {'min_area': 40})
    assert changed == text.replace('30', '40')


def test_names_of_other_alphabets_are_written_as_they_are():
    text = with_values('', 'detector', {'colors': ['grün', '赤'], 'grün.rgb': [20, 200, 30]})
    assert 'colors: [grün, 赤]' in text
    assert given_in(text, 'detector') == {'colors': ['grün', '赤'], 'grün.rgb': [20, 200, 30]}
