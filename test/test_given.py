"""Detections of points and boxes that others have found."""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.data import Detections

PIXELS = st.floats(0, 4000, width=32)
BOX = st.tuples(PIXELS, PIXELS, PIXELS, PIXELS).map(
    lambda box: (min(box[0], box[2]), min(box[1], box[3]), max(box[0], box[2]), 2 + max(box[1::2]))
)


@given(st.lists(BOX, min_size=1, max_size=5))
def test_a_box_keeps_its_edges_and_its_middle_is_counted_from_the_center_of_the_first_pixel(boxes):
    found = Detections.from_boxes(boxes, 7, image_size=(640, 480))
    rows, edges = found.rows, np.array(boxes)
    assert (found.stamp, found.image_size) == (7, (640, 480))
    np.testing.assert_array_equal(rows['box_u'], edges[:, 0])
    np.testing.assert_array_equal(rows['box_v'], edges[:, 1])
    np.testing.assert_allclose(rows['box_u'] + rows['box_w'], edges[:, 2], rtol=1e-6)
    np.testing.assert_allclose(rows['box_v'] + rows['box_h'], edges[:, 3], rtol=1e-6)
    np.testing.assert_allclose(rows['u'], edges[:, ::2].mean(axis=1) - 0.5)
    np.testing.assert_allclose(rows['v'], edges[:, 1::2].mean(axis=1) - 0.5)
    assert (rows['cov_uu'] == 0).all()


@pytest.mark.parametrize('none', [[], np.zeros((0, 4)), np.zeros((0, 6), np.float32)])
def test_a_picture_without_objects_has_no_detections(none):
    assert len(Detections.from_boxes(none, 7, scores=[], colors=[]).rows) == 0
    assert len(Detections.from_points([], 7, sigma=2.0).rows) == 0


def test_points_have_the_noise_that_is_given_for_all_or_for_each():
    z = [[3, 4], [5.5, 6.5]]
    rows = Detections.from_points(z, sigma=[1, 2], scores=0.5, colors=3).rows
    assert rows['u'].tolist() == [3, 5.5]
    assert rows['v'].tolist() == [4, 6.5]
    assert rows['cov_uu'].tolist() == rows['cov_vv'].tolist() == [1, 4]
    assert rows['score'].tolist() == [0.5, 0.5]
    assert rows['color'].tolist() == [3, 3]
    assert not rows['box_w'].any()
    assert Detections.from_points(z, sigma=3).rows['cov_vv'].tolist() == [9, 9]


@pytest.mark.parametrize('color', [1.5, np.nan, np.inf, 1 << 32])
def test_a_class_that_is_no_whole_number_is_refused_rather_than_taken_for_another(color):
    with pytest.raises(ValueError, match='colors: expected whole numbers'):
        Detections.from_points([[3, 4]], colors=[color])
    assert Detections.from_points([[3, 4]], colors=[7.0]).rows['color'].tolist() == [7]
