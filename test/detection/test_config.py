from math import inf
from math import nan

import numpy as np
import pytest

from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.color_table import ColorTable
from colortrack_ros.detection.presets import PRESETS
from colortrack_ros.parameters.config import specs_of

LAB = (50.0, 10.0, 10.0)
RANGES = [spec for spec in specs_of(DetectorConfig) if spec.limits]


@pytest.mark.parametrize('tolerance', [-1.0, 200.1, nan, inf])
def test_a_tolerance_out_of_range_is_refused(tolerance):
    with pytest.raises(
        ValueError, match=r'red\.tolerance: expected above 0, at most 200.0, or 0 .*, got '
    ):
        ReferenceColor('red', LAB, tolerance)


@pytest.mark.parametrize('lab', [(nan, 0, 0), (0, inf, 0), (-1, 0, 0), (50, 0, 129), (50, 0)])
def test_a_lab_out_of_range_is_refused(lab):
    with pytest.raises(ValueError, match=r'red\.lab: expected .*, got '):
        ReferenceColor('red', lab)


@pytest.mark.parametrize('rgb', [(256, 0, 0), (0, -1, 0), (0, nan, 0), (1, 2), (1, 2, 3, 4)])
def test_an_rgb_out_of_range_is_refused(rgb):
    with pytest.raises(ValueError, match=r'red\.rgb: expected .* 0\.\.255, got '):
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
        ('method', 'magic'),
        ('channel', 'cyan'),
        ('background_model', 'mean'),
    ],
)
def test_a_parameter_out_of_range_is_refused_by_name(parameter, value):
    with pytest.raises(ValueError, match=rf'^{parameter}: expected .*, got '):
        DetectorConfig(**{parameter: value})


@pytest.mark.parametrize('spec', RANGES, ids=lambda spec: spec.name)
def test_a_number_out_of_its_range_is_refused_by_name(spec):
    low, high = map(spec.kind, spec.limits)
    for value in (low, high):
        given = {'min_area': 1} | {spec.name: value}
        assert getattr(DetectorConfig(**given), spec.name) == value
    for value in (low - 1, high + 1, nan):
        with pytest.raises(ValueError, match=rf'^{spec.name}: expected .*, got {value}$'):
            DetectorConfig(**{spec.name: value})


def test_a_color_without_a_name_is_refused():
    with pytest.raises(ValueError, match='colors: expected a name'):
        ReferenceColor('', LAB)


@pytest.mark.parametrize('axes', [(0, 1, 1), (1, 201, 1), (1, 1, nan), (1, 1)])
def test_an_ellipsoid_out_of_range_is_refused(axes):
    with pytest.raises(ValueError, match=r'red\.tolerance_lab: expected three numbers'):
        ReferenceColor('red', LAB, tolerance_lab=axes)


@pytest.mark.parametrize('of', [list, np.array])
def test_a_color_of_lists_or_arrays_is_that_of_tuples(of):
    """It raised `unhashable type` in the detector's first lines."""
    parts = {
        'tolerance_lab': (20.0, 9.0, 9.0),
        'samples': (LAB, (50.0, 1.0, 2.0)),
        'others': (LAB,),
    }
    given = {name: of(part) for name, part in parts.items()}
    assert ReferenceColor('red', of(LAB), **given) == ReferenceColor('red', LAB, **parts)
    Detector(DetectorConfig(colors=(ReferenceColor('red', of(LAB), **given),)))


@pytest.mark.parametrize('wrong', ['205,58,34', ('1', '2', '3'), None, 5, ((1, 2, 3),), (1, 2)])
def test_what_is_no_color_is_refused_by_name(wrong):
    for make, field in (
        (lambda: ReferenceColor.from_rgb('red', wrong), 'rgb'),
        (lambda: ReferenceColor('red', wrong), 'lab'),
        (lambda: ReferenceColor('red', LAB, tolerance_lab=wrong or 5), 'tolerance_lab'),
        (lambda: ReferenceColor('red', LAB, samples=(wrong,)), 'samples'),
        (lambda: ReferenceColor('red', LAB, tolerance='5'), 'tolerance'),
    ):
        with pytest.raises(ValueError, match=rf'^red\.{field}: expected .*, got '):
            make()


@pytest.mark.parametrize('config', [None, {}, 'my.yaml', ReferenceColor('red', LAB)])
def test_a_detector_of_something_else_than_a_configuration_is_refused(config):
    with pytest.raises(ValueError, match=r'^config: expected a DetectorConfig, got '):
        Detector(config)


def test_an_unknown_preset_is_refused_with_those_there_are():
    with pytest.raises(
        ValueError, match=r"ball\.preset: expected one of red, orange.*, got 'puce'"
    ):
        ReferenceColor.from_preset('ball', 'puce')
    with pytest.raises(ValueError, match=r"ball\.preset: expected one of red.*, got 'puce'"):
        ReferenceColor('ball', LAB, preset='puce')


@pytest.mark.parametrize(
    ('name', 'rgbs'),
    {
        'red': [(200, 40, 35), (160, 25, 30), (205, 58, 34), (230, 30, 40)],
        'orange': [(235, 130, 30), (250, 150, 50), (220, 110, 25)],
        'yellow': [(235, 205, 45), (250, 225, 80), (214, 170, 40)],
        'green': [(50, 150, 60), (30, 110, 45), (70, 190, 70)],
        'cyan': [(40, 180, 190), (60, 200, 215)],
        'blue': [(35, 75, 175), (38, 84, 176), (20, 40, 130), (30, 90, 220)],
        'purple': [(110, 50, 150), (90, 30, 140), (150, 80, 200), (128, 0, 128)],
        'magenta': [(190, 40, 150), (220, 60, 180)],
        'pink': [(255, 150, 180), (235, 120, 150), (230, 90, 140), (250, 180, 190)],
        'white': [(250, 250, 250), (225, 228, 230)],
        'black': [(15, 15, 15), (35, 32, 30)],
    }.items(),
)
def test_presets_hold_the_colors_of_their_name_and_no_gray(name, rgbs):
    table = ColorTable(
        tuple(
            ReferenceColor(name, lab, tolerance_lab=axes) for name, (lab, axes) in PRESETS.items()
        )
    )
    labels = table.label_colors(np.array(rgbs))
    assert [list(PRESETS)[label - 1] for label in labels if label] == [name] * len(rgbs)
    assert not table.label_colors(
        np.array([(128, 128, 128), (90, 85, 80), (205, 160, 132), (230, 150, 130)])
    ).any()
