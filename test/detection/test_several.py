"""A blob of several discs that were never seen apart says where each of them may be."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.several import places_inside

RED = (34, 58, 205)


def one_blob(draw):
    """The covariance and the centroid of the only detection in a picture that draw paints."""
    image = np.full((240, 320, 3), 120, np.uint8)
    draw(image)
    (row,) = Detector(DetectorConfig()).detect(Frame(image)).rows
    covariance = np.array([[row['cov_uu'], row['cov_uv']], [row['cov_uv'], row['cov_vv']]])
    return covariance, np.array([row['u'], row['v']])


def discs(places, radii):
    def draw(image):
        for (u, v), radius in zip(places, radii, strict=True):
            cv2.circle(image, (round(16 * u), round(16 * v)), round(16 * radius), RED, -1, shift=4)

    return draw


def squared_errors(places, radii):
    covariance, centroid = one_blob(discs(places, radii))
    error = np.array(places) - centroid
    return np.einsum('ki,ij,kj->k', error, np.linalg.inv(covariance), error) / 2


@pytest.mark.parametrize('angle', [0.0, 0.6, 1.6, 2.4])
@pytest.mark.parametrize(('radii', 'share'), [((24, 24), 1.0), ((18, 18), 0.75), ((20, 30), 0.95)])
def test_two_discs_are_each_off_along_the_line_between_them(angle, radii, share):
    way = np.array([np.cos(angle), np.sin(angle)])
    apart = share * sum(radii)
    places = [(160, 120) - apart / 2 * way, (160, 120) + apart / 2 * way]
    covariance, centroid = one_blob(discs(places, radii))
    along, across = (x @ covariance @ x for x in (way, np.array([-way[1], way[0]])))
    truth = np.mean([((place - centroid) @ way) ** 2 for place in places])
    assert 0.8 * truth < along < 1.6 * truth
    assert across < 0.2 * along


@pytest.mark.parametrize('places', [
    [(100, 120), (146, 120), (192, 120)], [(100, 120), (146, 120), (123, 158)],
    [(100, 120), (146, 120), (192, 120), (192, 166)],
])  # fmt: skip
def test_each_of_three_or_four_is_where_the_covariance_says(places):
    assert 0.4 < squared_errors(places, [24] * len(places)).mean() < 1.25


@pytest.mark.parametrize('paint', [
    lambda image: cv2.rectangle(image, (100, 80), (180, 130), RED, -1),
    lambda image: cv2.ellipse(image, (160, 120), (60, 30), 30, 0, 360, RED, -1),
    lambda image: [cv2.rectangle(image, (100, 60), (120, 150), RED, -1),
                   cv2.rectangle(image, (100, 130), (170, 150), RED, -1)],
    lambda image: [cv2.line(image, (100, 80), (180, 120), RED, 30)],
    lambda image: [cv2.circle(image, (160, 120), 40, RED, -1),
                   cv2.circle(image, (150, 110), 12, (255, 255, 255), -1)],
])  # fmt: skip
def test_a_single_thing_of_another_shape_is_not_several(paint):
    image = np.full((240, 320, 3), 120, np.uint8)
    paint(image)
    detector = Detector(DetectorConfig())
    assert len(detector.detect(Frame(image)).rows) == 1
    assert not places_inside(detector.blobs, detector.blobs.inside(320, 240)).any()


def test_a_thin_rod_at_any_angle_is_single():
    image = np.full((480, 640, 3), 120, np.uint8)
    for k in range(48):
        place = 40 + 80 * (k % 8) + 0.13 * k, 40 + 80 * (k // 8) + 0.07 * k
        corners = cv2.boxPoints((place, (40, 12), 3.7 * k + 1.0))
        cv2.fillPoly(image, [np.rint(16 * corners).astype(np.int32)], RED, shift=4)
    rows = Detector(DetectorConfig()).detect(Frame(image)).rows
    assert len(rows) == 48
    assert (rows['cov_uu'] + rows['cov_vv'] < 4).all()


def test_a_highlight_is_no_reason_to_take_two_for_one():
    def draw(image):
        discs([(136, 120), (184, 120)], [25, 25])(image)
        for u in (130, 178):
            cv2.circle(image, (u, 112), 5, (255, 255, 255), -1)

    covariance, _ = one_blob(draw)
    assert covariance[0, 0] > 0.8 * 24**2
