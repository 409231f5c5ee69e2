"""Three-fold skewness, pixel by pixel, and what is usual of a color."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.shape import PIXEL_MOMENT
from colortrack_ros.detection.skewness import three_fold_skewness
from colortrack_ros.detection.skewness import UsualSkewness


def blobs_of(*polygons):
    image = LabelImage.empty(300, 400)
    mask = np.zeros((300, 400), np.uint8)
    for corners in polygons:
        cv2.fillPoly(mask, [np.array(corners)], 1)
    image.pixels[...] = mask
    return find_blobs(image, 1), mask


def regular(corners, at=(200, 150), size=90, turn=0.3, squeeze=1.0):
    angle = turn + 2 * np.pi * np.arange(corners) / corners
    outline = size * np.stack([np.cos(angle), squeeze * np.sin(angle)], axis=1)
    return np.rint(outline + at).astype(np.int32)


@pytest.mark.parametrize('seed', range(8))
def test_it_is_the_third_moment_of_the_pixels_of_a_blob_that_is_made_round(seed):
    rng = np.random.default_rng(seed)
    blobs, mask = blobs_of(rng.integers((0, 0), (400, 300), (5, 2)))
    assert len(blobs.area) == 1
    v, u = mask.nonzero()
    x = np.stack([u, v]) - np.mean([u, v], axis=1)[:, None]
    second = x @ x.T / x.shape[1] + PIXEL_MOMENT * np.eye(2)
    p, q = np.linalg.inv(np.linalg.cholesky(second)) @ x
    expected = abs(((p + 1j * q) ** 3).mean())
    assert three_fold_skewness(blobs)[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize('squeeze', [1.0, 0.4])
def test_a_triangle_has_much_of_it_and_what_is_the_same_upside_down_has_none(squeeze):
    of = {n: three_fold_skewness(blobs_of(regular(n, squeeze=squeeze))[0])[0] for n in (3, 4, 40)}
    assert of[3] == pytest.approx(2.26, abs=0.1)  # 8 sqrt(2) / 5
    assert max(of[4], of[40]) < 0.02


def test_what_a_color_is_first_seen_with_is_usual_and_what_is_cut_later_is_not():
    usual = UsualSkewness(1)
    whole, cut = blobs_of(regular(40))[0], blobs_of(regular(3))[0]
    wholly = np.array([True])
    first = usual.beyond(whole, wholly, 0)
    later = usual.beyond(cut, wholly, NANOSECONDS // 30)
    assert first < 0.02
    assert later > 0.9 * three_fold_skewness(cut)
    cones = UsualSkewness(1)
    for k in range(3):
        known = cones.beyond(cut, wholly, k * NANOSECONDS)
    assert known < 0.3 * three_fold_skewness(cut)


def test_a_color_of_several_shapes_has_a_wide_range_of_usual_ones():
    usual, wholly = UsualSkewness(1), np.array([True])
    outlines = regular(40), regular(40)[:20], regular(3)
    shapes = [blobs_of(outline)[0] for outline in outlines]
    for k in range(60):
        known = usual.beyond(shapes[k % 3], wholly, k * NANOSECONDS)
    assert known < 0.3 * three_fold_skewness(shapes[2])


def test_a_pause_teaches_no_more_than_a_second():
    usual = UsualSkewness(1)
    whole, cut = blobs_of(regular(40))[0], blobs_of(regular(3))[0]
    usual.beyond(whole, np.array([True]), 0)
    usual.beyond(cut, np.array([True]), 3600 * NANOSECONDS)
    of_rest = usual.beyond(cut, np.array([False]), 3600 * NANOSECONDS)
    assert of_rest > 0.6 * three_fold_skewness(cut)
