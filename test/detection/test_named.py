"""Colors by name, such as red: which of all that it stands for is found."""

import cv2
import numpy as np
import pytest
from support.lit_balls import draw_lit_ball
from support.lit_balls import wheel

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.extent import count_colors
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.named import assess
from colortrack_ros.detection.named import candidates
from colortrack_ros.detection.presets import PRESETS

CSS = {
    'red': {
        'red': 0xFF0000,
        'darkred': 0x8B0000,
        'crimson': 0xDC143C,
        'firebrick': 0xB22222,
        'indianred': 0xCD5C5C,
        'tomato': 0xFF6347,
    },
    'orange': {'orange': 0xFFA500, 'darkorange': 0xFF8C00, 'orangered': 0xFF4500},
    'yellow': {'yellow': 0xFFFF00, 'gold': 0xFFD700, 'khaki': 0xF0E68C},
    'green': {
        'lime': 0x00FF00,
        'green': 0x008000,
        'darkgreen': 0x006400,
        'forestgreen': 0x228B22,
        'seagreen': 0x2E8B57,
        'yellowgreen': 0x9ACD32,
        'olivedrab': 0x6B8E23,
        'darkseagreen': 0x8FBC8F,
        'palegreen': 0x98FB98,
        'lawngreen': 0x7CFC00,
    },
    'cyan': {'cyan': 0x00FFFF, 'darkcyan': 0x008B8B, 'turquoise': 0x40E0D0, 'teal': 0x008080},
    'blue': {
        'blue': 0x0000FF,
        'navy': 0x000080,
        'darkblue': 0x00008B,
        'royalblue': 0x4169E1,
        'dodgerblue': 0x1E90FF,
        'skyblue': 0x87CEEB,
        'steelblue': 0x4682B4,
        'lightsteelblue': 0xB0C4DE,
        'midnightblue': 0x191970,
        'cornflowerblue': 0x6495ED,
    },
    'purple': {
        'purple': 0x800080,
        'indigo': 0x4B0082,
        'darkviolet': 0x9400D3,
        'mediumpurple': 0x9370DB,
        'blueviolet': 0x8A2BE2,
    },
    'magenta': {'magenta': 0xFF00FF, 'mediumvioletred': 0xC71585, 'orchid': 0xDA70D6},
    'pink': {'pink': 0xFFC0CB, 'hotpink': 0xFF69B4, 'deeppink': 0xFF1493, 'lightpink': 0xFFB6C1},
    'white': {'white': 0xFFFFFF, 'whitesmoke': 0xF5F5F5},
    'black': {'black': 0x000000},
}
"""Colors of CSS of each name, and such as one would call so."""

WALL, WOOD, SKIN = (180, 190, 190), (120, 80, 60), (205, 160, 132)
RED, CRIMSON, DARK_BLUE = (200, 60, 40), (170, 20, 60), (20, 40, 110)
NAMES = ('red', 'orange', 'yellow', 'green', 'cyan', 'blue', 'magenta')
SHOWN = (
    (200, 40, 40), (230, 125, 35), (230, 200, 50), (50, 150, 60), (40, 180, 190), (30, 70, 170),
    (190, 45, 150),
)  # fmt: skip


def room(k, *things, ground=WALL):
    """A picture of lit balls, (u, radius, rgb) each, the k-th of four a second."""
    image = np.full((240, 400, 3), ground[::-1], np.float64)
    for u, radius, rgb in things:
        draw_lit_ball(image, u, 120, radius, rgb)
    image += np.random.default_rng(k).normal(0, 3, image.shape)
    return Frame(image.clip(0, 255).astype(np.uint8), stamp=k * NANOSECONDS // 4)


def detector_of(*names):
    return Detector(DetectorConfig(colors=tuple(ReferenceColor.from_preset(n, n) for n in names)))


def boxes(rows):
    """Center and width of each detection, rounded to 20 px."""
    return [(round(row['u'] / 20) * 20, round(row['box_w'] / 20) * 20) for row in rows]


@pytest.mark.slow
@pytest.mark.parametrize('ground', [WALL, WOOD, SKIN])
@pytest.mark.parametrize(('name', 'rgb'), [('red', RED), ('red', CRIMSON), ('blue', DARK_BLUE)])
def test_a_thing_is_found_whole_by_the_name_of_its_color(name, rgb, ground):
    detector = detector_of(name)
    found = [boxes(detector.detect(room(k, (100, 40, rgb), ground=ground)).rows) for k in range(6)]
    assert found == [[(100, 80)]] * 6


@pytest.mark.slow
def test_each_of_seven_names_finds_its_own_ball():
    image, places = wheel(SHOWN, 0.6)
    detector = detector_of(*NAMES)
    detector.detect(Frame(image))
    rows = detector.detect(Frame(image, stamp=NANOSECONDS // 4)).rows
    found = {int(row['color']): (row['u'], row['v'], row['box_w']) for row in rows}
    assert len(rows) == len(NAMES)
    for color, (u, v) in enumerate(places):
        assert found[color] == pytest.approx((u, v, 56), abs=3)


@pytest.mark.slow
def test_a_lamp_that_is_there_first_makes_way_for_the_ball():
    detector = detector_of('red')
    lamp = (300, 8, (230, 30, 90))
    first = [boxes(detector.detect(room(k, lamp)).rows) for k in range(8)]
    assert first[-1] == [(300, 20)]
    later = [boxes(detector.detect(room(k, lamp, (100, 40, RED))).rows) for k in range(8, 16)]
    assert all((100, 80) in each for each in later[4:])


@pytest.mark.slow
def test_what_is_hidden_for_a_while_is_not_given_up_for_something_else_of_its_name():
    detector = detector_of('red')
    book = (300, 20, CRIMSON)
    for k in range(8):
        detector.detect(room(k, book, (100, 40, RED)))
    hidden = [boxes(detector.detect(room(k, book)).rows) for k in range(8, 24)]
    back = [boxes(detector.detect(room(k, book, (100, 40, RED))).rows) for k in range(24, 32)]
    assert all((300, 40) not in each for each in hidden)
    assert all((100, 80) in each for each in back)


@pytest.mark.slow
def test_when_its_thing_is_gone_for_good_another_of_its_name_is_found():
    detector = detector_of('red')
    for k in range(8):
        detector.detect(room(k, (300, 20, CRIMSON), (100, 40, RED)))
    for k in range(8, 40):
        rows = detector.detect(room(k, (300, 20, CRIMSON))).rows
    assert boxes(rows) == [(300, 40)]


@pytest.mark.slow
def test_a_name_that_no_pixel_has_is_told_with_the_color_that_is_nearest():
    detector = detector_of('red')
    for k in range(12):
        assert not len(detector.detect(room(k, (100, 40, DARK_BLUE))).rows)
    assert detector.trouble.startswith('red has not been seen yet')
    assert detector.trouble.endswith('with pick_color')
    assert not list(candidates(count_colors(room(0).image, 'bgr8'), 'red'))


def test_all_but_the_green_of_a_lawn_is_found_by_its_name():
    lawn = ReferenceColor('lawn', (55.0, -46.0, 36.0), preset='green', inverted=True)
    detector = Detector(DetectorConfig(colors=(lawn,)))
    for k in range(4):
        rows = detector.detect(room(k, (100, 40, RED), ground=(50, 130, 50))).rows
    assert boxes(rows) == [(100, 80)]


@pytest.mark.slow
def test_what_is_hidden_right_after_it_was_found_is_not_given_up_either():
    detector, other = detector_of('red'), (300, 20, (215, 20, 80))
    first = detector.detect(room(100, other, (100, 40, RED)))
    hidden = [boxes(detector.detect(room(k, other)).rows) for k in range(101, 108)]
    assert boxes(first.rows) == [(100, 80)]
    assert not any(hidden)
    assert boxes(detector.detect(room(108, other, (100, 40, RED))).rows) == [(100, 80)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ('names', 'rgb'), [(('red', 'orange'), (225, 80, 35)), (('magenta', 'pink'), (230, 90, 160))]
)
@pytest.mark.parametrize('turn', [1, -1])
def test_one_thing_that_two_names_stand_for_is_of_the_one_that_fits_best(names, rgb, turn):
    """It was of one in this picture and of the other in the next."""
    detector = detector_of(*names[::turn])
    for k in range(12):
        rows = detector.detect(room(k, (100, 40, rgb))).rows
        assert boxes(rows) == [(100, 80)]
        assert names[::turn][rows['color'][0]] == names[0]


@pytest.mark.slow
@pytest.mark.parametrize('turn', [1, -1])
def test_a_thing_that_comes_when_those_of_two_names_are_gone_is_of_one_of_them(turn):
    """Both names went over to it in one picture, and it was two things for good."""
    names = ('red', 'orange')[::turn]
    detector, ball = detector_of(*names), (200, 40, (255, 80, 0))
    for k in range(8):
        detector.detect(room(k, (60, 30, (90, 20, 30)), (340, 30, (250, 190, 90))))
    for k in range(8, 34):
        detector.detect(room(k))
    for k in range(34, 40):
        rows = detector.detect(room(k, ball)).rows
        assert boxes(rows) == [(200, 80)]
        assert names[rows['color'][0]] == 'red'


@pytest.mark.slow
@pytest.mark.parametrize('turn', [1, -1])
def test_a_color_that_was_picked_keeps_its_thing_beside_a_name_of_it(turn):
    ball = ReferenceColor.from_rgb('ball', RED), ReferenceColor.from_preset('red', 'red')
    detector = Detector(DetectorConfig(colors=ball[::turn]))
    for k in range(24):
        rows = detector.detect(room(k, (100, 40, RED))).rows
        assert boxes(rows) == [(100, 80)]
        assert ball[::turn][rows['color'][0]].name == 'ball'


@pytest.mark.parametrize(
    ('name', 'css'), [(name, css) for name, each in CSS.items() for css in each]
)
def test_a_disc_of_a_pure_color_is_found_by_the_name_of_it(name, css):
    """As it is drawn by a program, or by a simulator: none is too vivid, too light, or too dark."""
    image = np.full((240, 320, 3), (150, 140, 150), np.uint8)
    bgr = tuple(CSS[name][css].to_bytes(3, 'little'))
    cv2.circle(image, (150, 100), 20, bgr, cv2.FILLED)
    rows = detector_of(name).detect(Frame(image)).rows
    assert [(row['u'], row['v']) for row in rows] == [pytest.approx((150, 100), abs=0.5)]


@pytest.mark.parametrize(
    ('rgb', 'name'),
    [
        ((255, 0, 0), 'red'),
        ((0, 0, 255), 'blue'),
        ((200, 60, 40), 'red'),
        ((100, 120, 85), 'green'),
        ((255, 255, 255), 'white'),
        ((128, 128, 128), ''),
        (SKIN, ''),
    ],
)
def test_who_guesses_a_color_that_is_not_there_is_told_its_name(rgb, name):
    detector = Detector(DetectorConfig(colors=(ReferenceColor.from_rgb('ball', rgb),)))
    for k in range(4):
        detector.detect(Frame(np.full((60, 80, 3), (70, 70, 60), np.uint8), stamp=k * NANOSECONDS))
    told = detector.trouble.partition('pick_color')[2]
    assert told == (f', or set ball.preset, such as {name}' if name else '')


@pytest.mark.parametrize('name', list(PRESETS)[:-2])
@pytest.mark.parametrize('ground', [WALL, WOOD, SKIN, (128, 128, 128), (140, 140, 132)])
def test_grays_wood_and_skin_have_no_name(name, ground):
    rows = detector_of(name).detect(room(0, (100, 40, SKIN), (300, 40, WOOD), ground=ground)).rows
    assert not len(rows)


@pytest.mark.slow
def test_a_dull_thing_is_found_by_its_hue_until_something_typical_comes():
    detector, dull = detector_of('green'), (300, 40, (100, 120, 85))
    first = [boxes(detector.detect(room(k, dull)).rows) for k in range(8)]
    assert first == [[(300, 80)]] * 8
    both = [
        boxes(detector.detect(room(k, dull, (100, 20, (30, 150, 60)))).rows) for k in range(8, 12)
    ]
    assert both[-1] == [(100, 40)]


@pytest.mark.slow
def test_of_a_wall_and_a_thing_of_one_name_the_thing_is_found():
    """The wall fills the picture, or has no gap around its colors, and falls into specks."""
    detector = detector_of('red')
    for k in range(4):
        rows = detector.detect(room(k, (100, 40, (215, 20, 80)), ground=(150, 60, 40))).rows
        assert boxes(rows) == [(100, 80)]


@pytest.mark.parametrize(('a', 'is_red'), [(2.0, False), (18.0, True)])
def test_black_with_a_tinge_here_and_there_is_not_red(a, is_red):
    frame, red = room(0), ReferenceColor.from_preset('red', 'red')
    frame.image[150:170] = 12, 12, 40
    both, extent = sample_colors(frame.image, 'bgr8'), Extent((8.0, a, 4.0), (9, 25, 12), 0.3, 8000)
    assert assess(*both, red, (10.0, 18.0, 9.0), 1.5, extent).is_sound == is_red


@pytest.mark.slow
def test_thin_things_of_a_name_are_not_given_up_for_a_texture_without_a_gap_around_its_colors():
    detector = detector_of('yellow')
    for k in range(12):
        frame = room(k)
        for left in range(20, 200, 24):
            frame.image[40:60, left : left + 2] = 40, 200, 230
        dry_grass = np.random.default_rng(k).uniform([90, 110, 120], [175, 180, 190], (170, 170, 3))
        frame.image[60:230, 220:390] = dry_grass if k > 7 else WALL
        detector.detect(frame)
    assert 'runs into' not in detector.trouble
