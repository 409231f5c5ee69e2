import numpy as np
import pytest

from colortrack_ros.contours.areas import find_areas
from colortrack_ros.contours.records import CONTOUR_FIELDS
from colortrack_ros.contours.regions import in_common
from colortrack_ros.contours.regions import is_double
from colortrack_ros.contours.regions import is_hidden
from colortrack_ros.contours.regions import is_piece
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


def hidden(own, *boxes):
    own = np.array(own, float)
    return is_hidden(own, match(own, areas(*boxes))[0]).tolist()


def test_of_two_in_an_area_as_large_as_one_of_them_the_other_is_hidden():
    front, behind = (10, 10, 40, 100), (14, 14, 34, 90)
    assert hidden([behind, front], (10, 10, 40, 100)) == [True, False]
    assert hidden([front, behind], (10, 10, 40, 100)) == [False, True]


def test_of_two_contours_of_one_thing_the_better_one_is_seen():
    assert hidden([(11, 11, 41, 101), (10, 10, 40, 100)], (10, 10, 40, 100)) == [True, False]


def test_of_two_side_by_side_none_is_hidden():
    assert hidden([(10, 10, 40, 100), (35, 10, 60, 100)], (10, 10, 60, 100)) == [False, False]
    assert hidden([(10, 10, 40, 100), (80, 10, 99, 90)], (10, 10, 40, 100)) == [False, False]


def double(own, single, *boxes, told=False, speed=0.0):
    records, own = np.zeros(len(own), CONTOUR_FIELDS), np.array(own, float)
    records['single'], records['told'] = single, told
    velocity = np.zeros((len(own), 2))
    velocity[-1, 0] = speed
    return is_double(own, match(own, areas(*boxes))[0], records, velocity).tolist()


def test_parts_above_each_other_that_were_never_seen_alone_are_one_thing():
    head, body = (24, 10, 44, 40), (10, 38, 36, 100)
    assert double([head, body], [False, False], (10, 10, 46, 100)) == [True, False]
    assert double([head, body], [True, False], (10, 10, 46, 100)) == [False, False]


def test_a_piece_of_another_one_is_no_thing_of_its_own_though_it_was_seen_alone():
    foot, body = (10, 88, 20, 100), (10, 10, 36, 86)
    assert double([foot, body], [True, True], (10, 10, 36, 100)) == [True, False]
    assert double([foot, body], [True, True], (10, 10, 36, 100), told=True) == [False, False]
    assert double([foot, body], [True, True], foot, body) == [False, False]  # not in one area
    beside, far = (42, 80, 50, 100), (10, 10, 25, 45)
    assert double([beside, body], [True, True], (10, 10, 50, 100)) == [False, False]
    assert double([far, body], [True, True], (10, 10, 36, 100)) == [False, False]


def test_what_the_larger_one_passes_by_is_no_piece_of_it():
    person, bus = (60, 60, 70, 100), (10, 10, 120, 90)
    for speed, ends in ((0.0, True), (200.0, False)):
        assert double([person, bus], [True] * 2, (10, 10, 120, 100), speed=speed) == [ends, False]


def test_a_piece_is_much_smaller_than_what_is_above_or_below_it_in_the_same_area():
    def pieces(*own, within):
        own = np.array(own, float)
        return is_piece(own, match(own, areas(*within))[0]).tolist()

    foot, body, all_of_it = (10, 88, 20, 100), (10, 10, 36, 86), (10, 10, 36, 100)
    assert pieces(foot, body, within=[all_of_it]) == [True, False]
    assert pieces(foot, body, within=[foot, body]) == [False, False]
    assert pieces((10, 50, 36, 100), body, within=[all_of_it]) == [False, False]
    assert pieces((42, 80, 50, 100), body, within=[(10, 10, 50, 100)]) == [False, False]


def test_what_is_as_large_as_the_area_is_no_piece_of_what_strays_into_it():
    foot, astray = (10, 80, 20, 100), (0, 60, 60, 140)
    assert double([foot, astray], [True, True], (10, 80, 20, 100)) == [False, False]


def test_two_side_by_side_that_were_never_seen_alone_are_two_things():
    assert (
        double([(10, 10, 40, 100), (36, 10, 60, 99)], [False] * 2, (10, 10, 60, 100)) == [False] * 2
    )
    own = [(10, 10, 40, 100), (80, 40, 99, 60)]
    assert double(own, [False] * 2, (10, 10, 40, 100), (80, 40, 99, 60)) == [False] * 2
