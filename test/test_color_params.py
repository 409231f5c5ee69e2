"""A picked color is written into a params file, and nothing else in it changes."""

import pytest
import yaml

from colortrack_ros.detection import ReferenceColor
from colortrack_ros.tools.color_params import write_color
from colortrack_ros.tools.color_params import yaml_of

BALL = ReferenceColor('ball', (44.0, 64.0, 34.5), 20.0, (50.0, 20.0, 18.5))
ALONE = ReferenceColor('ball', BALL.lab)
ENTRY = {'lab': [44.0, 64.0, 34.5], 'tolerance_lab': [50.0, 20.0, 18.5]}
LIMITS = {'min_area': 70}


def written(tmp_path, text, color=BALL, limits=None):
    path = tmp_path / 'my.yaml'
    path.write_text(text)
    write_color(path, color, LIMITS if limits is None else limits)
    (detector,) = yaml.safe_load(path.read_text()).values()
    return path.read_text(), detector['ros__parameters']


def test_a_file_that_is_not_there_is_made(tmp_path):
    path = tmp_path / 'my.yaml'
    write_color(path, BALL, LIMITS)
    given = yaml.safe_load(path.read_text())['/**/detector']['ros__parameters']
    assert given == {'colors': ['ball'], 'ball': ENTRY, 'min_area': 70}


@pytest.mark.parametrize(
    'text',
    [
        'detector:\n  ros__parameters:\n    colors: [red]\n    split: true  # touching\n',
        'detector:\n  ros__parameters:\n    split: true  # touching\n    colors: # x\n    - red\n',
        'detector: {ros__parameters: {split: true}}  # touching\n',
        '/cam/detector:\n  ros__parameters: {colors: [red], red: {min_area: 9}, split: true}',
        'detector:\n  ros__parameters:\n    ball:\n      rgb: [1, 2, 3]\n    split: true',
    ],
)
def test_the_rest_stays_and_a_red_that_nobody_chose_goes(tmp_path, text):
    after, given = written(tmp_path, text)
    assert given['colors'] == ['ball']
    assert given['ball'] == ENTRY
    assert given['min_area'] == 70
    assert given['split'] is True
    assert ('# touching' in after) == ('# touching' in text)


@pytest.mark.parametrize('red', ['{preset: red}', '{tolerance: 9.0}'])
def test_other_colors_keep_their_shades_and_areas_and_the_new_one_has_its_own(tmp_path, red):
    text = 'detector: {ros__parameters: {colors: [red], red: %s, min_area: 30}}'
    _, given = written(tmp_path, text % red)
    assert given['colors'] == ['red', 'ball']
    assert given['red'] == yaml.safe_load(red)
    assert given['min_area'] == 30
    assert given['ball'] == {**ENTRY, 'min_area': 70}


def test_a_color_that_is_picked_anew_keeps_its_place_among_the_others(tmp_path):
    text = 'detector: {ros__parameters: {colors: [ball, red], ball: {rgb: [9, 9, 9]}, %s}}'
    _, given = written(tmp_path, text % 'red: {preset: red}')
    assert given['colors'] == ['ball', 'red']
    assert given['ball'] == {**ENTRY, 'min_area': 70}


def test_colors_that_are_listed_by_their_common_names_stay(tmp_path):
    _, given = written(tmp_path, 'detector: {ros__parameters: {colors: [red, blue]}}')
    assert given['colors'] == ['red', 'blue', 'ball']


def test_limits_of_the_area_are_of_the_color_and_those_of_the_shape_of_all(tmp_path):
    text = 'detector: {ros__parameters: {colors: [red], red: {preset: red}, max_area: 9000}}'
    limits = {'min_area': 70, 'max_area': 900, 'min_aspect': 0.5}
    _, given = written(tmp_path, text, limits=limits)
    assert given['ball'] == {**ENTRY, 'min_area': 70, 'max_area': 900}
    assert (given['max_area'], given['min_aspect']) == (9000, 0.5)


def test_what_else_a_color_has_stays(tmp_path):
    text = 'detector:\n  ros__parameters:\n    ball:\n      tolerance: 9.0\n      diameter: 0.2\n'
    _, given = written(tmp_path, text)
    assert given['ball'] == {'diameter': 0.2, **ENTRY}


@pytest.mark.parametrize('name', ['yes', '1', 'a: b', '#', "it's", '[x', 'ball one', 'é', '"'])
def test_any_name_is_written_as_a_name(tmp_path, name):
    color = ReferenceColor(name, BALL.lab, 20.0, BALL.tolerance_lab)
    assert yaml.safe_load(yaml_of(color, {'min_area': 9})) == {
        'colors': [name],
        name: ENTRY,
        'min_area': 9,
    }
    _, given = written(tmp_path, 'detector:\n  ros__parameters:\n    split: true\n', color)
    assert given['colors'] == [name]
    assert given[name] == ENTRY


@pytest.mark.parametrize('text', ['tracker: {}', '- 1', 'a: [', 'detector: 3', 'detector: {x: 1}'])
def test_what_is_no_params_file_is_left_alone(tmp_path, text):
    path = tmp_path / 'my.yaml'
    path.write_text(text)
    with pytest.raises(ValueError, match='expected a params file with a detector'):
        write_color(path, BALL, LIMITS)
    assert path.read_text() == text


def test_samples_take_the_place_of_a_shade_and_a_shade_that_of_samples(tmp_path):
    path = tmp_path / 'mine.yaml'
    taught = ReferenceColor('ball', BALL.lab, 20.0, (30.0, 20.0, 20.0), (BALL.lab,), (BALL.lab,))
    write_color(path, BALL, LIMITS)
    write_color(path, taught, LIMITS)
    entry = yaml.safe_load(path.read_text())['/**/detector']['ros__parameters']['ball']
    assert set(entry) == {'samples', 'others', 'tolerance_lab'}
    assert all(isinstance(level, float) for level in entry['samples'])
    write_color(path, BALL, LIMITS)
    entry = yaml.safe_load(path.read_text())['/**/detector']['ros__parameters']['ball']
    assert set(entry) == {'lab', 'tolerance_lab'}


@pytest.mark.parametrize(
    ('others', 'min_area'), [('', None), ('    blue: {preset: blue}\n    colors: [blue]\n', 30)]
)
def test_a_color_alone_takes_out_what_the_color_before_had(tmp_path, others, min_area):
    """The least area of all goes with it, unless other colors have it, too."""
    ball = '    ball: {samples: [9.0, 9.0, 9.0], tolerance_lab: [9.0, 9.0, 9.0], min_area: 900}\n'
    text = f'detector:\n  ros__parameters:\n{ball}    min_area: 30\n{others}'
    _, given = written(tmp_path, text, ALONE, {})
    assert given['ball'] == {'lab': [44.0, 64.0, 34.5]}
    assert given.get('min_area') == min_area
    assert yaml.safe_load(yaml_of(ALONE, {})) == {'colors': ['ball'], 'ball': given['ball']}
