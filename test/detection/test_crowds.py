"""Many things of colors without a tolerance: what is beside many that touch, or below another."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor

YELLOW, BLUE, PURPLE, WATER = (215, 150, 15), (40, 80, 220), (140, 35, 195), (40, 160, 190)


def detect(colors, *discs):
    """Detections of colors, r,g,b, in water with discs (u, v, radius, r,g,b) in that order."""
    image = np.full((240, 320, 3), WATER[::-1], np.float32)
    for u, v, radius, rgb in discs:
        cv2.circle(image, (u, v), radius, rgb[::-1], cv2.FILLED)
    image = cv2.GaussianBlur(image, (0, 0), 0.7)
    image += np.random.default_rng(0).normal(0, 3, image.shape).astype(np.float32)
    sought = [ReferenceColor.from_rgb(f'c{k}', rgb, 0.0) for k, rgb in enumerate(colors)]
    detector = Detector(DetectorConfig(colors=tuple(sought)))
    return detector.detect(Frame(np.clip(image, 0, 255).astype(np.uint8))), detector


def test_beside_thirty_rings_that_touch_each_single_one_is_found():
    crowd = [(100 + 13 * i, 60 + 13 * j, 8, YELLOW) for i in range(6) for j in range(5)]
    beside = [
        (84, 70, 6, YELLOW),
        (84, 105, 6, YELLOW),
        (190, 70, 6, YELLOW),
        (120, 140, 6, YELLOW),
    ]
    away = [(30 + 24 * i, v, 6, YELLOW) for i in range(11) for v in (20, 180, 210)]
    found, detector = detect([YELLOW], *crowd, *beside, *away)
    assert len(found.rows) == 1 + len(beside) + len(away)
    assert not detector.trouble, 'none of them is a speck'


def test_one_thing_has_most_of_the_pixels_and_what_comes_off_it_is_no_other():
    pieces = [
        (150, 96, 5, YELLOW),
        (150, 104, 5, YELLOW),
        (94, 145, 7, YELLOW),
        (106, 146, 7, YELLOW),
        (250, 40, 4, YELLOW),
        (20, 200, 5, YELLOW),
    ]
    found, _ = detect([YELLOW], (100, 100, 34, YELLOW), *pieces)
    (row,) = found.rows
    assert [row['u'], row['v']] == pytest.approx([100, 100], abs=1)


def test_the_shade_below_a_thing_that_has_the_color_of_another_is_no_thing():
    balls = [(60 + 60 * i, 60, 20, PURPLE) for i in range(4)]
    shaded = [(160, 165, 20, tuple(0.7 * x for x in PURPLE)), (160, 160, 20, BLUE)]
    found, _ = detect([PURPLE, BLUE], *balls, *shaded)
    assert sorted(found.rows['color']) == [0, 0, 0, 0, 1]


def test_a_thing_before_a_larger_one_of_another_color_is_a_thing():
    found, _ = detect([PURPLE, BLUE], (160, 120, 60, BLUE), (150, 110, 14, PURPLE))
    assert sorted(found.rows['color']) == [0, 1]
