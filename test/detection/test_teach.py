"""Colors that are taught by pixels and boxes, in one picture or several."""

import numpy as np
import pytest

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.extent import LARGEST_GROUND
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.teach import Example
from colortrack_ros.detection.teach import teach_color
from colortrack_ros.scenes import open_scene

RED, DARK, PINK, WALL = (200, 40, 50), (90, 15, 20), (235, 130, 140), (170, 170, 160)


def squares(*colors, light=1.0, encoding='rgb8'):
    """Squares of 40 px, 60 px apart, on a wall; their middles are at (40 + 60 k, 60)."""
    image = np.full((120, 60 * len(colors) + 20, 3), WALL, float)
    for k, color in enumerate(colors):
        image[40:80, 60 * k + 20 : 60 * k + 60] = color
    noise = np.random.default_rng(0).normal(0, 2, image.shape)
    rgb = np.clip(light * image + noise, 0, 255).astype(np.uint8)
    if encoding == 'mono8':
        return Frame(rgb[..., 1].copy(), encoding)
    alpha = np.full((*rgb.shape[:2], ENCODINGS[encoding] - 3), 255, np.uint8)
    order = rgb if encoding.startswith('rgb') else rgb[..., ::-1]
    return Frame(np.concatenate([order, alpha], axis=2), encoding)


def at(frame, k):
    return Example(frame, (40 + 60 * k, 60, 1, 1))


def columns(frame, picked):
    config = DetectorConfig(colors=(picked.color,), **picked.limits)
    return sorted((Detector(config).detect(frame).rows['u'] // 60).astype(int).tolist())


def test_each_color_that_is_shown_is_it_and_what_is_shown_as_another_is_not():
    frame = squares(RED, DARK, PINK)
    assert columns(frame, teach_color([at(frame, 0)])) == [0]
    assert columns(frame, teach_color([at(frame, 0), at(frame, 1)])) == [0, 1]
    both = teach_color([at(frame, 0), at(frame, 1)], [at(frame, 2)])
    assert columns(frame, both) == [0, 1]


def test_pictures_in_different_light_give_one_color_for_both():
    bright, dim = squares(RED, PINK), squares(RED, PINK, light=0.5)
    picked = teach_color([at(bright, 0), at(dim, 0)], [at(bright, 1), at(dim, 1)])
    assert columns(bright, picked) == columns(dim, picked) == [0]
    assert columns(dim, teach_color([at(bright, 0)])) != [0]


def test_a_thing_inside_a_larger_one_of_its_color_is_measured_by_itself():
    """A button on a coat, a fish in water that is found as well: the larger one's box holds it."""
    image = np.full((240, 400, 3), WALL, float)
    image[60:180, 60:180], image[70:170, 70:170], image[110:130, 110:130] = RED, WALL, RED
    noise = np.random.default_rng(0).normal(0, 2, image.shape)
    frame = Frame((image + noise).astype(np.uint8), 'rgb8')
    picked = teach_color([Example(frame, (120, 120, 1, 1))], [Example(frame, (300, 120, 1, 1))])
    assert 18**2 <= picked.area <= 22**2
    found = Detector(DetectorConfig(colors=(picked.color,), **picked.limits)).detect(frame).rows
    assert len(found) == 2  # the frame around it has the very same color


def test_a_ball_shown_once_keeps_its_dark_side_when_its_shadow_is_said_to_be_something_else():
    v, u = np.mgrid[:160, :240]
    x, y = (u - 120) / 50, (v - 80) / 50
    z = np.sqrt(np.clip(1 - x**2 - y**2, 0, 1))
    light = 0.28 + 0.72 * np.clip(0.6 * z - 0.35 * x - 0.7 * y, 0, 1)
    image = np.full((160, 240, 3), (205.0, 165.0, 115.0))
    image[z > 0] = np.array([215, 100, 60]) * light[z > 0, None]
    image[130:150, 20:80] = 84, 40, 8
    image += np.random.default_rng(0).normal(0, 3, image.shape)
    frame = Frame(np.clip(image, 0, 255).astype(np.uint8), 'rgb8')
    for place in ((120, 80), (130, 95)):
        picked = teach_color([Example(frame, (*place, 1, 1))], [Example(frame, (50, 140, 1, 1))])
        (row,) = (
            Detector(DetectorConfig(colors=(picked.color,), **picked.limits)).detect(frame).rows
        )
        assert row['area'] > 0.8 * np.count_nonzero(z)
        assert np.hypot(row['u'] - 120, row['v'] - 80) < 3


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_a_box_gives_its_dark_and_its_light_shades(encoding):
    frame = squares(RED, WALL, encoding=encoding)
    picked = teach_color([Example(frame, (22, 42, 36, 36))])
    assert picked.area == pytest.approx(38 * 38, rel=0.02)
    assert columns(frame, picked) == [0]


def test_a_box_of_two_colors_takes_both_in():
    frame = squares(RED, WALL)
    frame.image[60:80, 20:60] = DARK
    picked = teach_color([Example(frame, (22, 42, 36, 36))])
    assert picked.area == pytest.approx(38 * 38, rel=0.05)


def test_another_thing_of_the_very_same_shades_does_not_take_a_thing_to_pieces():
    frame = squares(WALL, WALL)
    shades = np.linspace(0.4, 1.2, 40)[:, None, None] * np.array([150.0, 165.0, 70.0])
    frame.image[40:80, 20:60] = shades
    frame.image[45:75, 80:110] = shades[5:35]
    examples = [Example(frame, (40, v, 1, 1)) for v in (45, 60, 75)]
    picked = teach_color(examples, [Example(frame, (95, v, 1, 1)) for v in (52, 67)])
    assert picked.area > 0.9 * 38 * 38
    assert picked.telling == {}, 'squares of 28 and 38 px are too much alike'
    assert columns(frame, picked) == [0, 1]


@pytest.mark.parametrize(
    ('width', 'height', 'limit'),
    [
        (12, 12, {'min_area': pytest.approx(38 * 10, abs=20)}),
        (60, 60, {'max_area': pytest.approx(38 * 58, abs=40)}),
        (80, 16, {'min_aspect': pytest.approx((14 / 78) ** 0.5, abs=0.02)}),
    ],
)
def test_what_has_the_color_and_is_not_it_is_told_by_its_size_or_its_shape(width, height, limit):
    frame = squares(RED, WALL, WALL)
    frame.image[60 - height // 2 : 60 + height // 2, 100 : 100 + width] = frame.image[40, 20]
    other = Example(frame, (100 + width // 2, 60, 1, 1))
    picked = teach_color([at(frame, 0)], [other])
    assert picked.telling == limit
    assert columns(frame, picked) == [0]


def test_a_box_shows_the_ellipse_inside():
    mask = Example(squares(RED), (10, 30, 40, 60)).part().mask
    assert mask.shape == (60, 40)
    assert not mask[[0, 0, -1, -1], [0, -1, 0, -1]].any()
    assert mask[[0, -1, 30, 30, 30], [20, 20, 0, -1, 20]].all()
    assert mask.mean() == pytest.approx(np.pi / 4, rel=0.02)


@pytest.mark.parametrize('turn', range(4))
def test_a_click_in_a_corner_shows_the_pixels_around_it(turn):
    image = np.full((60, 80, 3), WALL, np.uint8)
    image[:20, :20] = RED
    corner = np.zeros((60, 80), bool)
    corner[0, 0] = True
    ((v, u),) = np.argwhere(np.rot90(corner, turn)).tolist()
    part = Example(Frame(np.ascontiguousarray(np.rot90(image, turn)), 'rgb8'), (u, v, 1, 1)).part()
    assert part.shown.size == 16
    assert part.mask.sum() == 400


def test_what_fills_the_pictures_is_refused_with_what_to_do():
    wall = Frame(np.full((60, 80, 3), 170, np.uint8))
    with pytest.raises(ValueError, match='fills the pictures: give examples of what is not it'):
        teach_color([Example(wall, (40, 30, 1, 1)), Example(wall, (10, 10, 20, 20))])


@pytest.mark.parametrize('box', [(-1, 0, 1, 1), (30, 0, 1, 1), (5, 5, 26, 1), (0, 0, 0, 1)])
def test_a_box_outside_of_the_picture_is_refused(box):
    frame = Frame(np.zeros((20, 30, 3), np.uint8))
    with pytest.raises(ValueError, match=r'box: expected .* in the picture of 30 x 20 px, got '):
        teach_color([Example(frame, box)])


def test_colors_come_back_from_cielab():
    rgb = np.random.default_rng(0).integers(0, 256, (5000, 3))
    np.testing.assert_array_equal(rgb_from_lab(lab_from_rgb(rgb)), rgb)


DOOR, CARPET, PULLOVER, PAINTING = (66, 106), (214, 332), (530, 194), (216, 57)
"""Places in frame 20 of the scene `clutter` at 640x360 that nearly have the balls' colors."""


def clutter(color):
    """The scene, and (frame, u, v) of balls of a color that are wholly seen, every fifth frame."""
    scene = open_scene('clutter?width=640&height=360&seed=7')
    number = list(scene.colors).index(color)
    seen = [
        (k, ball['u'], ball['v'])
        for k in range(0, len(scene), 5)
        for ball in scene.truth(k)
        if ball['color'] == number and ball['visible'] == 1
    ]
    return scene, seen


def click(scene, k, u, v):
    return Example(Frame(scene.render(k)), (round(u), round(v), 1, 1))


@pytest.mark.parametrize('color', ['red', 'yellow', 'blue'])
def test_three_clicks_on_a_ball_and_four_on_a_room_of_nearly_its_color_find_the_ball_alone(color):
    scene, seen = clutter(color)
    third = len(seen) // 3
    examples = [click(scene, *seen[k]) for k in (third // 2, third + third // 2, -third // 2)]
    room = [click(scene, 20, *place) for place in (DOOR, CARPET, PULLOVER, PAINTING)]
    picked = teach_color(examples, room)
    assert picked.color.tolerance < 7, 'where the room begins, not where the last of it ends'
    detector = Detector(DetectorConfig(colors=(picked.color,), min_area=picked.area // 4))
    for k, u, v in seen[::4]:
        rows = detector.detect(Frame(scene.render(k))).rows
        balls = scene.truth(k)
        away = np.hypot(rows['u'][:, None] - balls['u'], rows['v'][:, None] - balls['v'])
        assert (away.min(axis=1) < 15).all(), k
        assert np.hypot(rows['u'] - u, rows['v'] - v).min() < 4, k


def test_a_click_on_a_ball_before_the_room_of_nearly_its_color_does_not_teach_the_room():
    scene, seen = clutter('yellow')
    before = [(k, u, v) for k, u, v in seen if 35 < u < 90 and 85 < v < 255]
    alone = [(k, u, v) for k, u, v in seen if 200 < u < 560 and 130 < v < 250]
    examples = [click(scene, *place) for place in (before[0], alone[0], alone[-1])]
    areas = [np.count_nonzero(example.part().mask) for example in examples]
    assert areas[0] > 10 * areas[1], 'it runs into the door'
    picked = teach_color(examples, [click(scene, 20, *DOOR)])
    rows = Detector(DetectorConfig(colors=(picked.color,), **picked.limits))
    (found,) = rows.detect(Frame(scene.render(alone[1][0]))).rows
    assert np.hypot(found['u'] - alone[1][1], found['v'] - alone[1][2]) < 4


def test_a_wall_that_fills_the_picture_is_known_as_a_whole():
    frame = squares(RED)
    part = Example(frame, (8, 8, 1, 1)).part(LARGEST_GROUND)
    assert np.count_nonzero(part.mask) > 0.95 * (120 * 80 - 40 * 40)
