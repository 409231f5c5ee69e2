import pytest

from colortrack_ros.detection import ReferenceColor
from colortrack_ros.nodes.detector import DetectorSetup
from colortrack_ros.parameters import build
from colortrack_ros.parameters import ParameterTable


def colors(**values):
    given = {name.replace('__', '.'): value for name, value in values.items()}
    return build(DetectorSetup, ParameterTable.of(DetectorSetup).defaults(given)).config.colors


def test_a_color_is_given_as_lab_rgb_or_preset():
    assert colors(colors=['b'], b__lab=[50.0, 10.0, 20.0], b__tolerance=9.0) == (
        ReferenceColor('b', (50.0, 10.0, 20.0), 9.0),
    )
    assert colors(colors=['b'], b__rgb=[1.0, 2.0, 3.0], b__tolerance=9.0) == (
        ReferenceColor.from_rgb('b', (1.0, 2.0, 3.0), 9.0),
    )
    assert colors(colors=['b'], b__preset='blue') == (ReferenceColor.from_preset('b', 'blue'),)
    (color,) = colors(colors=['b'], b__preset='blue', b__tolerance_lab=[9.0, 8.0, 7.0])
    assert color.axes == (9.0, 8.0, 7.0)


@pytest.mark.parametrize(
    ('values', 'reason'),
    [
        ({'colors': []}, r'colors: expected 1 to 254 names, got \[\]'),
        ({'colors': ['b', 'b'], 'b__preset': 'blue'}, 'each name once'),
        (
            {'colors': ['b']},
            'b: expected one of b.lab, b.rgb and b.preset, got none of them, and b is none of red',
        ),
        (
            {'colors': ['b'], 'b__lab': [1.0, 2.0, 3.0], 'b__rgb': [1.0, 2.0, 3.0]},
            'b: expected one of b.lab, b.rgb and b.preset, got lab and rgb',
        ),
        (
            {'colors': ['b'], 'b__lab': [1.0, 2.0]},
            r'b.lab: expected three numbers .*, got \(1.0, 2.0\)',
        ),
        ({'colors': ['b'], 'b__rgb': [1.0, 2.0, 256.0]}, 'b.rgb: expected .*0..255, got .*256.0'),
        (
            {'colors': ['b'], 'b__rgb': [0.8, 0.1, 0.1]},
            r'b.rgb: expected .* 0..255, not in 0..1, got',
        ),
        (
            {'colors': ['b'], 'b__rgb': [1.0, 0.5, 0.0]},
            r'b.rgb: expected .* 0..255, not in 0..1, got',
        ),
        (
            {'colors': ['b'], 'b__samples': [0.8, 0.1, 0.1]},
            'b.samples: expected .* not in 0..1, got',
        ),
        ({'red__tolerance': -1.0}, 'tolerance: expected 0..200 CIELAB units, got -1.0'),
        ({'min_area': 9, 'max_area': 8}, 'max_area: expected at least min_area, 9 px, got 8'),
        (
            {'red__min_area': 9, 'max_area': 8, 'min_area': 1},
            'red.max_area: expected at least 9 px',
        ),
        ({'mask': '/no/such.png'}, 'mask: expected .*, got .*/no/such.png'),
        ({'regions': ['door'], 'door__polygon': [1.0, 2.0, 3.0]}, 'door.polygon: expected pairs'),
        ({'regions': ['door']}, 'door.polygon: expected at least three corners'),
        ({'erosion_size': 4}, 'erosion_size: expected an odd number in 1..99, got 4'),
    ],
)
def test_values_that_do_not_fit_are_refused_by_name_value_and_range(values, reason):
    with pytest.raises(ValueError, match=reason):
        colors(**values)
