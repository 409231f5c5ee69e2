import cv2
import numpy as np
import pytest

from colortrack_ros.contours.areas import find_areas

NOBODY = np.zeros((0, 4))


def ellipses(*places, shape=(200, 300)):
    """A mask of ellipses with these centers and half axes."""
    mask = np.zeros(shape, np.uint8)
    for center, axes in places:
        cv2.ellipse(mask, center, axes, 0, 0, 360, 255, cv2.FILLED)
    return mask


def test_areas_have_their_boxes_centers_and_sizes_and_no_holes():
    mask = np.zeros((100, 120), np.uint8)
    mask[10:30, 20:50] = 255
    mask[15:20, 25:30] = 0
    mask[0:40, 80:100] = 255
    areas = find_areas(mask, 50, NOBODY)
    order = np.argsort(areas.box[:, 0])
    assert areas.box[order].tolist() == [[20, 10, 49, 29], [80, 0, 99, 39]]
    assert areas.center[order].tolist() == [[34.5, 19.5], [89.5, 19.5]]
    assert areas.size[order].tolist() == [600, 800]
    assert areas.cut[order].tolist() == [[False] * 4, [False, True, False, False]]
    assert not areas.piece.any()
    outline = areas.outline(int(order[0]))
    assert (outline.min(axis=0).tolist(), outline.max(axis=0).tolist()) == ([20, 10], [49, 29])


def test_small_areas_are_none():
    mask = np.zeros((50, 50), np.uint8)
    mask[5:9, 5:9] = 1
    assert [len(find_areas(mask, least, NOBODY)) for least in (16, 17)] == [1, 0]


def test_an_empty_mask_has_no_areas():
    assert len(find_areas(np.zeros((50, 50), np.uint8), 1, NOBODY)) == 0
    assert len(find_areas(np.zeros((0, 0), np.uint8), 1, NOBODY)) == 0


def test_two_things_that_touch_side_by_side_are_cut_where_they_touch():
    mask = ellipses(((100, 100), (20, 50)), ((142, 100), (20, 50)), ((121, 100), (9, 9)))
    areas = find_areas(mask, 50, NOBODY)
    assert areas.piece.tolist() == [True, True]
    np.testing.assert_allclose(sorted(areas.center[:, 0]), [101, 141], atol=3)
    assert areas.size.sum() == np.count_nonzero(mask)


@pytest.mark.parametrize(
    'places',
    [
        [((100, 100), (20, 50))],
        [((100, 60), (15, 18)), ((100, 110), (22, 40))],  # a head above a body
        [((100, 100), (40, 50)), ((145, 100), (8, 8))],  # a hand
    ],
)
def test_one_thing_is_not_cut(places):
    areas = find_areas(ellipses(*places), 50, NOBODY)
    assert areas.piece.tolist() == [False]


def test_what_is_as_large_as_a_target_that_is_known_is_not_cut():
    mask = ellipses(((100, 100), (20, 50)), ((142, 100), (20, 50)), ((121, 100), (9, 9)))
    assert len(find_areas(mask, 50, np.array([[82.0, 52, 159, 148]]))) == 1
    assert len(find_areas(mask, 50, np.array([[82.0, 52, 115, 148]]))) == 2
