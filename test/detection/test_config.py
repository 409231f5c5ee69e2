from math import inf
from math import nan

import pytest

from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor

LAB = (50.0, 10.0, 10.0)


@pytest.mark.parametrize('tolerance', [0.0, -1.0, 200.1, nan, inf])
def test_a_tolerance_out_of_range_is_refused(tolerance):
    with pytest.raises(ValueError, match=r'red\.tolerance is .*, expected above 0, at most 200'):
        ReferenceColor('red', LAB, tolerance)


@pytest.mark.parametrize('lab', [(nan, 0, 0), (0, inf, 0), (-1, 0, 0), (50, 0, 129), (50, 0)])
def test_a_lab_out_of_range_is_refused(lab):
    with pytest.raises(ValueError, match=r'red\.lab is .*, expected'):
        ReferenceColor('red', lab)


@pytest.mark.parametrize('rgb', [(256, 0, 0), (0, -1, 0), (0, nan, 0), (1, 2), (1, 2, 3, 4)])
def test_an_rgb_out_of_range_is_refused(rgb):
    with pytest.raises(ValueError, match=r'red\.rgb is .*, expected .* 0\.\.255'):
        ReferenceColor.from_rgb('red', rgb)


@pytest.mark.parametrize(
    ('parameter', 'value'),
    [
        ('colors', ()),
        ('colors', (ReferenceColor('red', LAB), ReferenceColor('red', LAB))),
        ('colors', tuple(ReferenceColor(str(k), LAB) for k in range(255))),
        ('min_area', 0),
        ('max_area', 19),
        ('erosion_size', 2),
        ('erosion_size', 0),
        ('erosion_size', 101),
        ('opening_size', -1),
        ('closing_size', 4),
        ('threads', 0),
        ('threads', 65),
    ],
)
def test_a_parameter_out_of_range_is_refused_by_name(parameter, value):
    with pytest.raises(ValueError, match=rf'^{parameter} is .*, expected'):
        DetectorConfig(**{parameter: value})


def test_a_color_without_a_name_is_refused():
    with pytest.raises(ValueError, match='colors is'):
        ReferenceColor('', LAB)
