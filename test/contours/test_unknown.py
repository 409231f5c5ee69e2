import numpy as np
import pytest
from support.contour_pictures import follow
from support.contour_pictures import known
from support.contour_pictures import noise
from support.contour_pictures import texture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours.unknown import goes_on

PITCH, HIGH, SPEED = 36, 26, 4
"""From one thing on the road to the next, their height, and their way in a frame [px]: where the
narrow ones are, the road is not seen for 0.3 s."""


@pytest.mark.parametrize(
    ('unknown', 'expected'),
    [
        (np.s_[40:70, 60:90], True),  # beside all of a side
        (np.s_[20:40, 30:60], True),  # above all of it
        (np.s_[40:70, 25:30], True),
        (np.s_[70:75, 30:60], True),
        (np.s_[60:90, 60:90], False),  # beside a third of a side
        (np.s_[40:70, 70:90], False),  # farther away
        (np.s_[50:54, 60:150], False),  # a stripe that begins there
        (np.s_[40:70, 30:60], False),  # all of the place itself: it goes on nowhere
    ],
)
def test_what_ends_where_the_background_is_unknown_is_told_from_what_ends_near_it(
    unknown, expected
):
    where = np.zeros((120, 160), bool)
    where[unknown] = True
    assert goes_on(np.array([[30.0, 40.0, 59.0, 69.0]]), where).tolist() == [expected]


def test_boxes_at_the_border_and_beyond_it_and_none_do_no_harm():
    where = np.zeros((120, 160), bool)
    where[:, 20:140] = True
    box = [[-9, -9, 19, 19], [140, 100, 180, 130], [-5, 0, 9, 19], [300, 300, 320, 320]]
    assert goes_on(np.array(box, float), where).tolist() == [True, True, False, False]
    assert goes_on(np.zeros((0, 4)), where).tolist() == []


def road(k):
    """A road down which narrow dark things go, every fourth of them wide, and later a wide one."""
    image = texture(3)
    for j in [-16, *range(-10, 7)]:
        top, side = PITCH * j + SPEED * k, 30 * (j % 4 == 0)
        image[max(top, 0) : max(top + HIGH, 0), 140 - side : 180 + side] = 40 + 40 * (j % 2)
    return np.clip(image + noise(k, image.shape), 0, 255).astype(np.uint8)


@pytest.mark.slow
def test_sides_of_what_hides_a_road_that_was_never_seen_are_hardly_told_and_it_is_later():
    results = follow([road(k) for k in range(185)], ContourConfig())
    told = [tracks.rows[known(tracks)] for tracks in results]
    assert sum(map(len, told[:110])) < 50  # 207 if all are told
    assert [len(rows) for rows in told[170:]] == [1] * 15
    assert told[-1]['box_w'] == pytest.approx(100, abs=5)
