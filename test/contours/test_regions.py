import numpy as np
import pytest

from colortrack_ros.contours.areas import find_areas
from colortrack_ros.contours.regions import in_common
from colortrack_ros.contours.regions import match
from colortrack_ros.contours.regions import resized
from colortrack_ros.contours.regions import shifts

NOBODY = np.zeros((0, 4))


def areas(*boxes):
    mask = np.zeros((240, 320), np.uint8)
    for left, top, right, bottom in boxes:
        mask[top : bottom + 1, left : right + 1] = 255
    return find_areas(mask, 16, np.array(boxes, float))


def matched(own, *boxes):
    regions, nobodys = match(np.array(own, float).reshape(-1, 4), areas(*boxes))
    return regions, nobodys


def test_each_area_goes_to_the_target_that_it_overlaps_best():
    own = [(100, 50, 120, 90), (10, 10, 40, 60)]
    regions, nobodys = matched(own, (12, 12, 40, 60), (98, 52, 118, 90), (200, 10, 230, 50))
    assert regions.box.tolist() == [[98, 52, 118, 90], [12, 12, 40, 60]]
    assert not regions.shared.any()
    assert np.count_nonzero(nobodys) == 1


def test_a_target_without_an_area_has_none():
    regions, nobodys = matched([(10, 10, 40, 60)], (100, 100, 130, 150))
    assert (regions.first.tolist(), nobodys.tolist()) == ([-1], [True])
    assert np.isnan(regions.box).all()
    for count in (0, 1):
        regions, nobodys = matched([(10, 10, 40, 60)] * count)
        assert (len(regions), len(nobodys)) == (count, 0)


def test_parts_of_a_target_above_each_other_are_one_region():
    regions, nobodys = matched([(10, 10, 40, 100)], (10, 10, 40, 70), (14, 75, 30, 100))
    assert regions.box.tolist() == [[10, 10, 40, 100]]
    assert not nobodys.any()


def test_what_steps_out_of_a_target_to_the_side_is_nobodys():
    regions, nobodys = matched([(10, 10, 60, 100)], (10, 10, 38, 100), (42, 10, 60, 100))
    assert regions.box.tolist() == [[10, 10, 38, 100]]
    assert np.count_nonzero(nobodys) == 1


def test_targets_in_one_area_share_it():
    regions, nobodys = matched([(10, 10, 40, 100), (35, 10, 60, 100)], (10, 10, 60, 100))
    assert regions.shared.tolist() == [True, True]
    assert regions.box.tolist() == [[10, 10, 60, 100]] * 2
    assert not nobodys.any()


def test_a_region_at_the_border_is_known_as_such():
    regions, _ = matched([(0, 10, 40, 60), (100, 10, 130, 60)], (0, 10, 40, 60), (100, 10, 130, 60))
    assert regions.cut.tolist() == [[True, False, False, False], [False] * 4]


@pytest.mark.parametrize(
    ('region', 'expected'),
    [
        ((13, 12, 43, 62), (3, 2)),  # as large as before
        ((13, 12, 23, 62), (3, 2)),  # its right is covered: its left tells
        ((25, 12, 43, 62), (3, 2)),
        ((13, 12, 90, 62), (3, 2)),  # something joined it on the right
    ],
)
def test_a_target_goes_where_the_sides_that_fit_have_gone(region, expected):
    own = np.array([[10.0, 10, 40, 60]])
    uncut = np.zeros((1, 4), bool)
    np.testing.assert_allclose(shifts(own, np.array([region], float), uncut), [expected])


def test_the_border_of_the_picture_is_no_side_of_a_target():
    own, region = np.array([[0.0, 10, 40, 60]]), np.array([[0.0, 10, 52, 60]])
    cut = np.array([[True, False, False, False]])
    np.testing.assert_allclose(shifts(own, region, cut), [(12, 0)])
    np.testing.assert_allclose(shifts(-own[:, [2, 1, 0, 3]] * [1, -1, 1, -1],
                                      -region[:, [2, 1, 0, 3]] * [1, -1, 1, -1],
                                      cut[:, [2, 1, 0, 3]]), [(-12, 0)])  # fmt: skip


def test_of_targets_in_one_area_the_outermost_sides_tell():
    own = np.array([[10.0, 10, 40, 60], [35, 10, 65, 60]])
    region = np.tile([[12.0, 10, 64, 60]], (2, 1))
    np.testing.assert_allclose(in_common(own, region, np.zeros(2, int)), [(2, 0), (-1, 0)])


def test_nodes_are_stretched_with_their_box():
    nodes = np.array([[(10.0, 10.0), (20.0, 10.0), (20.0, 30.0)]])
    box, wider = np.array([[10.0, 10, 20, 30]]), np.array([[0.0, 10, 20, 30]])
    np.testing.assert_allclose(resized(nodes, box, wider), [[(0, 10), (20, 10), (20, 30)]])
