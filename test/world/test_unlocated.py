"""What cannot be located is told, and colors of which too little is told have a name."""

import numpy as np
import pytest
from support.ball_before_camera import BALL
from support.ball_before_camera import view_of
from support.balls_seen import FRAME
from support.balls_seen import RADIUS
from support.balls_seen import seen

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig

ROBOT = Pose(np.zeros(3), np.eye(3))


def config(method='ground', **changes):
    kind = Kind('red', KindConfig(**{'diameter': 2 * RADIUS} | changes))
    return LocatorConfig(method=method, colors=(kind,))


def located(points, pitch=0.25, seconds=1.2, **changes):
    """The objects after some time in which points are seen, and what is told."""
    told, view = [], view_of(ROBOT, Pose.of_rpy((0.1, 0, 0.5), (0, pitch, 0)))
    locator = Locator(config(**changes), told.append)
    for k in range(1, round(seconds * NANOSECONDS / FRAME)):
        found = locator.update(*seen(view, points, k * FRAME), view)
    return found.rows, told


def test_what_is_too_uncertain_to_be_located_is_told_while_nothing_is():
    """The center of what stands on a table: its height is known to 0.3 m, below the camera's."""
    rows, told = located([(3.0, 0.4, 0.3)], diameter=0.0, height=0.3, height_sigma=0.3)
    assert not len(rows)
    assert 'the standard deviation of its range is above 50 % of it: it is not located' in told[0]
    assert 'height_sigma' in told[0]


def test_ranges_that_are_too_uncertain_at_first_are_no_matter():
    """What is wrong with the calibration, which the next pictures show, was told no more."""
    assert (
        located([(3.0, 0.4, 0.3)], seconds=0.5, diameter=0.0, height=0.3, height_sigma=0.3)[1] == []
    )


def test_what_is_too_far_away_is_not_told_of_beside_what_is_located():
    rows, told = located([BALL, (19.5, -2.0, RADIUS)], pitch=0.0)
    assert len(rows) == 1
    assert told == []


@pytest.mark.parametrize(
    ('method', 'changes', 'heightless'),
    [
        ('ground', {}, ()),
        ('ground', {'diameter': 0.0}, ('red',)),
        ('fused', {'diameter': 0.0, 'motion': 'still'}, ('red',)),
        ('ground', {'diameter': 0.0, 'height': 0.0}, ()),
        ('depth', {'diameter': 0.0}, ()),
    ],
)
def test_a_color_whose_height_nothing_tells_has_a_name(method, changes, heightless):
    assert config(method, **changes).heightless == heightless


@pytest.mark.parametrize('method', ['depth', 'fused'])
@pytest.mark.parametrize(
    ('depth', 'line'),
    [
        (np.nan, 'of nothing but holes'),
        (0.0, 'of nothing but holes'),
        (np.inf, 'of nothing but holes'),
        (0.003, 'depth picture of 0.003 m on average: expected mm in 16UC1, m in 32FC1'),
        (2950.0, 'depth picture of 2950 m on average: expected mm in 16UC1, m in 32FC1'),
    ],
)
def test_depths_of_no_camera_are_told_and_not_used(method, depth, line):
    """In another unit camera_pose was said to be wrong; of holes nothing was told."""
    told, view = [], view_of(ROBOT, Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0)))
    locator = Locator(config(method), told.append)
    depths = np.full((480, 640), depth, np.float32)
    for k in range(1, 4):
        rows = locator.update(*seen(view, [BALL], k * FRAME), view, depths).rows
    assert line in told[0]
    assert len(set(told)) == 1
    assert len(rows) == (method == 'fused')
    assert method == 'depth' or np.hypot(rows['x'] - BALL[0], rows['y'] - BALL[1]) < 0.1


def test_depths_of_the_object_alone_are_used():
    told, view = [], view_of(ROBOT, Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0)))
    tracks, detections = seen(view, [BALL], FRAME)
    blob = detections.rows[0]
    top, left = int(blob['box_v']), int(blob['box_u'])
    depths = np.full((480, 640), np.nan, np.float32)
    depths[top : top + int(blob['box_h']), left : left + int(blob['box_w'])] = 2.8
    locator = Locator(config('depth'), told.append)
    assert len(locator.update(tracks, detections, view, depths).rows) == 1
    assert told == []


def test_a_sky_of_a_simulator_is_no_other_unit():
    told, view = [], view_of(ROBOT, Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0)))
    depths = np.full((480, 640), 2.8, np.float32)
    depths[:, 300:] = depths[:60] = 65504.0
    locator = Locator(config('depth'), told.append)
    assert len(locator.update(*seen(view, [BALL], FRAME), view, depths).rows) == 1
    assert told == []
