import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.split import distance_of

RED = (34, 58, 205)
FIXED = ReferenceColor.from_rgb('red', RED[::-1], 50.0)


def found(discs, angle=0.0, **parameters):
    """Detections of discs (distance along a line, radius), and where they are."""
    image = np.full((240, 320, 3), 120, np.uint8)
    way = np.array([np.cos(angle), np.sin(angle)])
    centers = [np.array([160, 120]) + distance * way for distance, _ in discs]
    for center, (_, radius) in zip(centers, discs, strict=True):
        cv2.circle(image, tuple(map(int, np.rint(center))), radius, RED, -1)
    rows = (
        Detector(DetectorConfig(colors=(FIXED,), split=True, **parameters))
        .detect(Frame(image))
        .rows
    )
    return rows, np.array(centers)


@pytest.mark.parametrize('angle', np.linspace(0, np.pi, 7))
@pytest.mark.parametrize(
    'discs',
    [
        [(-28, 30), (28, 30)],
        [(-24, 30), (24, 30)],
        [(-20, 30), (28, 18)],
        [(-50, 26), (0, 26), (50, 26)],
    ],
)
def test_discs_that_touch_are_cut_apart(discs, angle):
    rows, centers = found(discs, angle)
    assert len(rows) == len(discs)
    for center in centers:
        distance = np.hypot(rows['u'] - center[0], rows['v'] - center[1])
        assert distance.min() < 0.2 * 30


@pytest.mark.parametrize('discs', [[(0, 40)], [(0, 3)], [(0, 1)], [(-8, 30), (8, 30)], []])
def test_what_has_no_neck_stays_whole(discs):
    rows, _ = found(discs, erosion_size=1, min_area=1)
    assert len(rows) == min(len(discs), 1)


def test_discs_may_touch_that_are_too_large_together_but_not_a_crowd():
    rows, _ = found([(-28, 30), (28, 30)], max_area=3000)
    assert len(rows) == 2
    rows, _ = found([(-28, 30), (28, 30)], max_area=600)
    assert len(rows) == 0


def test_noise_and_smears_are_not_cut():
    random = np.random.default_rng(0)
    image = np.full((240, 320, 3), 120, np.uint8)
    cv2.line(image, (60, 60), (160, 120), RED, 30)
    cv2.ellipse(image, (220, 160), (60, 25), 30, 0, 360, RED, -1)
    noise = random.normal(0, 12, image.shape)
    frame = Frame(np.clip(image + noise, 0, 255).astype(np.uint8))
    assert len(Detector(DetectorConfig(colors=(FIXED,), split=True)).detect(frame).rows) == 2


def test_a_ragged_outline_is_no_neck():
    random = np.random.default_rng(1)
    image = np.full((100, 320, 3), 120, np.uint8)
    for u in range(20, 300):
        image[30 + random.integers(0, 4) : 70 - random.integers(0, 4), u] = RED
    assert len(Detector(DetectorConfig(colors=(FIXED,), split=True)).detect(Frame(image)).rows) == 1


def test_distances_of_a_mask_are_exact_wherever_they_lie_in_memory():
    mask = np.zeros((49, 37), np.uint8)
    cv2.circle(mask, (18, 24), 15, 1, -1)
    inside, outside = np.argwhere(mask), np.argwhere(mask == 0)
    squared = ((inside[:, None] - outside) ** 2).sum(axis=2).min(axis=1)
    distance = distance_of(mask)[mask != 0]
    np.testing.assert_array_equal(distance, np.sqrt(squared.astype(np.float32)))
