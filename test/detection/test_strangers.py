"""Things of another hue that are in the same gap as the color that was picked."""

import numpy as np
import pytest
from support.lit_balls import draw_lit_ball

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.pick import pick_color
from colortrack_ros.detection.strangers import find_own_extent

WALL = (180, 190, 190)
RED, ORANGE, PINK = (200, 40, 40), (230, 120, 30), (230, 90, 140)
GREEN, LIME = (60, 170, 60), (150, 200, 50)
PAIRS = {
    'red': (RED, ORANGE),
    'orange': (ORANGE, RED),
    'red beside pink': (RED, PINK),
    'green': (GREEN, LIME),
}


def balls(k, *colors, light=1.0):
    """Balls of 80 px before a plain wall, lit from above, in the k-th picture of four a second."""
    image = np.full((240, 170 * len(colors), 3), WALL, np.float64)
    for i, color in enumerate(colors):
        if color:
            draw_lit_ball(image, 85 + 170 * i, 120, 40, color, least=0.4)
    image = image * light + np.random.default_rng(k).normal(0, 3, image.shape)
    return Frame(image.clip(0, 255).astype(np.uint8), stamp=k * NANOSECONDS // 4)


def color_of(rgb, light=1.0, name='ball'):
    return ReferenceColor.from_rgb(name, tuple(light * x for x in rgb), 0.0)


def found_in(detector, frame):
    """Which ball each detection is, and whether its box is that of the whole ball."""
    rows = detector.detect(frame).rows
    return sorted(
        (int(row['u'] // 170), bool(min(row['box_w'], row['box_h']) > 60)) for row in rows
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ('pair', 'light'),
    [(pair, light) for pair in PAIRS for light in (0.5, 0.7)]
    + [('red', 1.0), ('orange', 1.0), ('red beside pink', 1.0)],
)
def test_picked_ball_is_found_alone_beside_one_of_a_near_color(pair, light):
    mine, other = PAIRS[pair]
    detector = Detector(DetectorConfig(colors=(color_of(mine, light),)))
    found = [found_in(detector, balls(k, mine, other)) for k in range(8)]
    assert found[4:] == [[(0, True)]] * 4


@pytest.mark.slow
@pytest.mark.parametrize('pair', PAIRS)
def test_ball_of_a_near_color_that_comes_later_is_left_out(pair):
    mine, other = PAIRS[pair]
    detector = Detector(DetectorConfig(colors=(color_of(mine, 0.7),)))
    for k in range(12):
        found_in(detector, balls(k, mine, None))
    found = [found_in(detector, balls(k, mine, other)) for k in range(12, 20)]
    assert all(places == [(0, True)] for places in found[4:])


@pytest.mark.slow
def test_configured_ball_is_not_lost_when_one_of_a_near_color_comes_in_its_first_second():
    detector = Detector(DetectorConfig(colors=(color_of(RED), color_of(ORANGE, name='other'))))
    for k in range(10):
        image = np.full((240, 320, 3), WALL, np.float64)
        draw_lit_ball(image, 90, 120, 40, RED, least=0.4)
        if k > 2:
            draw_lit_ball(image, 230, 120, 40, ORANGE, least=0.4)
        image += np.random.default_rng(k).normal(0, 3, image.shape)
        frame = Frame(image.clip(0, 255).astype(np.uint8), stamp=k * NANOSECONDS // 4)
        rows = detector.detect(frame).rows
        assert rows['box_h'][rows['color'] == 0] == pytest.approx([79], abs=3), k


@pytest.mark.slow
def test_cap_of_about_its_hue_does_not_make_a_stranger_of_the_ball_that_comes_back():
    """While the ball is cut by the border, only the cap has pixels of the ball's light side."""
    cap = tuple(0.8 * x for x in ORANGE)
    detector = Detector(DetectorConfig(colors=(color_of(ORANGE, 0.8),)))

    ways = [170] * 6 + list(range(170, 400, 10)) + list(range(400, 170, -10))
    for k, left in enumerate(ways):
        image = np.full((240, 340, 3), WALL, np.float64)
        draw_lit_ball(image, left, 120, 40, ORANGE, least=0.4)
        draw_lit_ball(image, 40, 200, 10, cap, least=0.95)
        image += np.random.default_rng(k).normal(0, 3, image.shape)
        frame = Frame(image.clip(0, 255).astype(np.uint8), stamp=k * NANOSECONDS // 8)
        rows = detector.detect(frame).rows
    assert rows['area'].max() > 0.9 * np.pi * 40**2


@pytest.mark.slow
def test_ball_in_other_light_is_no_stranger_of_one_that_looks_there_as_it_was_picked():
    """The yellow one took its color, and it was lost for good, in its own light, too."""
    yellow, warm = (220, 190, 40), (1.0, 0.7, 1.1)
    detector = Detector(DetectorConfig(colors=(color_of(ORANGE, 0.7),)))
    for k in range(40):
        light = np.array(warm if 14 <= k < 30 else (1, 1, 1))
        found = found_in(detector, balls(k, ORANGE, yellow if k > 20 else None, light=light))
        assert (0, True) in found, k


def test_equal_balls_in_other_light_are_no_strangers():
    dark = tuple(0.6 * x for x in RED)
    detector = Detector(DetectorConfig(colors=(color_of(RED, 0.9),)))
    assert found_in(detector, balls(0, RED, dark, RED)) == [(0, True), (1, True), (2, True)]


def test_picture_of_two_near_colors_gives_each_pick_its_own():
    frame = balls(0, RED, ORANGE)
    for place, hue in ((85, 33), (255, 58)):
        a, b = pick_color(frame, place, 110).color.lab[1:]
        assert np.degrees(np.arctan2(b, a)) == pytest.approx(hue, abs=6)


def test_strangers_are_named():
    frame = balls(0, RED, ORANGE)
    extent, apart = find_own_extent(*sample_colors(frame.image, 'bgr8'), color_of(RED, 0.7).lab)
    (stranger,) = apart
    assert np.degrees(np.arctan2(stranger[2], stranger[1])) == pytest.approx(58, abs=6)
    assert np.hypot(*extent.lab[1:]) > 30


def test_color_that_is_not_in_the_picture_has_no_extent():
    frame = balls(0, GREEN)
    found = find_own_extent(*sample_colors(frame.image, 'bgr8'), color_of(RED).lab, [(50, 0, 0)])
    assert found == (None, [(50, 0, 0)])
