"""Reference colors that follow the light."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from support.cameras import encode

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.light import ColorFollower
from colortrack_ros.detection.light import FOLLOW_STEP

GREEN = ReferenceColor.from_rgb('green', (40, 160, 60))
BALL = ReferenceColor('ball', (60.0, 40.0, 30.0), 20.0)


def followed(found, bound, seconds=60):
    """Where the reference is [CIELAB] after so many seconds of nothing but this color."""
    follower, color = ColorFollower((BALL,), bound), BALL
    for k in range(seconds):
        moved = follower.follow(np.array([found]), np.zeros(1, int), k * NANOSECONDS)
        (color,) = moved or (color,)
    return color


def test_it_ends_at_what_is_found_where_that_is_near():
    assert followed((55.0, 42.0, 28.0), 10.0).lab == pytest.approx(
        (55.0, 42.0, 28.0), abs=FOLLOW_STEP
    )


@pytest.mark.parametrize('bound', [2.0, 8.0])
def test_it_goes_no_further_than_the_bound_towards_what_is_far(bound):
    way = np.subtract(followed((20.0, 10.0, 60.0), bound).lab, BALL.lab)
    assert np.linalg.norm(way) == pytest.approx(bound, abs=0.3)
    straight = np.array([-40.0, -30.0, 30.0])
    assert way @ straight > 0.99 * np.linalg.norm(way) * np.linalg.norm(straight)


def test_in_less_light_the_tolerance_shrinks_half_as_much():
    color = followed((22.0, 40.0, 30.0), 100.0)
    assert color.tolerance == pytest.approx(20 * np.sqrt((22 + 16) / (60 + 16)), rel=0.05)


def test_a_color_whose_tolerance_is_estimated_is_left_to_that():
    sought = replace(BALL, name='sought', tolerance=0.0)
    follower, moved = ColorFollower((sought, BALL), 50.0), (sought, BALL)
    seen = np.array([[50.0, 40.0, 30.0]] * 2)
    for k in range(60):
        moved = follower.follow(seen, np.arange(2), k * NANOSECONDS) or moved
    assert moved[0] is sought
    assert moved[1].lab[0] < 55
    alone = ColorFollower((sought,), 50.0)
    assert not any(alone.follow(seen[:1], np.zeros(1, int), k * NANOSECONDS) for k in range(60))


@pytest.mark.slow
@pytest.mark.parametrize('encoding', ['bgr8', 'yuyv', 'nv12'])
def test_a_color_alone_follows_the_light_in_any_encoding_seen_or_not(encoding):
    ball = ReferenceColor.from_rgb('ball', (205, 58, 34))
    detector = Detector(DetectorConfig(colors=(ball,), follow_light=40.0))
    found = []
    for k in range(60):
        image = np.full((120, 160, 3), 120, np.uint8)
        if k >= 5:
            cv2.circle(image, (80, 60), 25, (34 + k, 58 + k, 205 - k), -1)
        frame = encode(image, encoding)
        found.append(len(detector.detect(replace(frame, stamp=k * NANOSECONDS)).rows))
    assert found == [0] * 5 + [1] * 55


@pytest.mark.slow
@pytest.mark.parametrize(
    ('given', 'change'),
    [
        ({'tolerance': 0.0}, lambda config: {'min_area': config.min_area + 1}),
        ({'tolerance': 15.0}, lambda config: {'min_area': config.min_area + 1}),
        ({'tolerance': 0.0}, lambda config: {'colors': (replace(config.colors[0], min_area=50),)}),
        ({'tolerance': 0.0}, lambda config: {'colors': (GREEN, *config.colors)}),
    ],
    ids=['min_area', 'min_area, tolerance given', 'min_area of the color', 'another color'],
)
def test_a_color_that_has_followed_the_light_is_not_lost_when_something_else_is_set(given, change):
    """A detector whose min_area was set in the evening found nothing until the next morning."""
    ball = replace(ReferenceColor.from_rgb('ball', (200, 60, 40)), **given)
    config = DetectorConfig(colors=(ball,), follow_light=80.0)
    detector, rng = Detector(config), np.random.default_rng(0)
    room = cv2.GaussianBlur(rng.uniform(80, 150, (120, 160, 3)), (0, 0), 9)
    for k in range(120):
        lamp = 1 - np.array([0.5, 0.5, 0.5]) * np.clip(k / 90, 0, 1)
        picture = cv2.circle(room.copy(), (40 + k % 50, 60), 14, (40, 60, 200), -1) * lamp
        noisy = (picture + rng.normal(0, 2, picture.shape)).astype(np.uint8)
        if k == 110:
            detector.configure(replace(config, **change(config)))
        rows = detector.detect(Frame(noisy, 'bgr8', k * NANOSECONDS // 5)).rows
        if k >= 105:
            assert rows['u'] == pytest.approx([40 + k % 50], abs=1.0), k
