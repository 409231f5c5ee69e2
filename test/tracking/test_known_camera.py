"""A tracker that knows the pose of the camera."""

from dataclasses import replace
import sys

import numpy as np
import pytest
from support.paths import ROOT
from support.robot_that_drives import BALLS
from support.robot_that_drives import driving
from support.robot_that_drives import ids_of_things
from support.robot_that_drives import named
from support.robot_that_drives import of_a_robot_that_drives
from support.robot_that_drives import RADIUS
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.view import View

sys.path.append(str(ROOT / 'benchmark'))

from world import CAMERA
from world import MOUNT


def of_a_robot_that_turns(yaws, ego_motion, place, seed=0):
    """Yield, by frame, the tracks and the pixels of objects at place, (K, 3); NaN if unseen."""
    rng, tracker = np.random.default_rng(seed), Tracker(TrackerConfig(ego_motion=ego_motion))
    for k, yaw in enumerate(yaws):
        view = View(CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, yaw)), MOUNT)
        z = CAMERA.project(view.optical.inverse().apply(place))
        z[~CAMERA.contains(z)] = np.nan
        seen = z[np.isfinite(z[:, 0])]
        detections = points(seen + rng.normal(0, 0.5, seen.shape), k * FRAME, 0.25)
        detections = replace(detections, image_size=(640, 480), viewpoint=view)
        yield tracker.update(detections).rows, z


def is_renamed(frames):
    """Whether any object has had two IDs; frames after the second are not asked for."""
    first = {}
    return any(
        first.setdefault(thing, name) != name for names in named(frames) for thing, name in names
    )


AROUND = np.array([(2.5, -0.6, 0.1), (3.0, 0.5, 0.1), (4.0, 1.8, 0.3), (2.0, 1.9, 0.1)])
TO_AND_FRO = np.radians(45) * np.cumsum(np.sign(np.sin(0.1 + np.arange(240) / 19))) * FRAME / 1e9
"""Yaw: 45 degrees/s for 2.5 s, and back."""


@pytest.mark.slow
def test_what_leaves_the_picture_by_a_known_turn_comes_back_with_its_id():
    known = ids_of_things(of_a_robot_that_turns(TO_AND_FRO, 'odometry', AROUND))
    assert sorted(known.values()) == [{1}, {2}, {3}, {4}]
    assert is_renamed(of_a_robot_that_turns(TO_AND_FRO, 'none', AROUND))


@pytest.mark.slow
def test_after_a_whole_turn_everything_has_its_id_again():
    whole = np.radians(75) * np.arange(160) * FRAME / 1e9
    ids = ids_of_things(of_a_robot_that_turns(whole, 'odometry', AROUND))
    assert sorted(ids.values()) == [{1}, {2}, {3}, {4}]


def test_a_known_turn_that_begins_at_once_is_followed_with_few_objects():
    """Two objects would be too few to estimate the turn from their motion."""
    jerks = np.radians(3) * (np.arange(60) // 5 % 2)
    for rows, z in of_a_robot_that_turns(jerks, 'odometry', AROUND[:2]):
        at = np.stack([rows['u'], rows['v']], axis=1)
        assert np.abs(at[:, None] - z).max(axis=2).min(axis=1).max(initial=0) < 3
        known = rows[rows['age'] > 0.5]
        assert np.abs(known['time_since_update']).max(initial=0) == 0
    assert set(rows['track_id']) == {1, 2}


def test_a_picture_whose_viewpoint_is_not_known_costs_nothing_but_its_turn():
    tracker = Tracker(TrackerConfig(ego_motion='odometry'))
    for k in range(30):
        view = View(CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), MOUNT)
        detections = replace(points([(300.0, 200.0)], k * FRAME), viewpoint=view)
        if k % 7 == 3:
            detections = replace(detections, viewpoint=None)
        rows = tracker.update(detections).rows
    assert rows['track_id'].tolist() == [1]
    assert rows['hits'].tolist() == [30]


@pytest.mark.slow
@pytest.mark.parametrize(('seconds', 'turn'), [(12, 40), (16, 80)])
def test_balls_alike_keep_their_ids_while_a_robot_drives_and_swings(seconds, turn):
    """Each leaves the picture and returns within five seconds, seen from another place."""
    poses = [*driving(seconds, turn=turn)]
    ids = ids_of_things(of_a_robot_that_drives(poses, ego_motion='odometry'))
    assert sorted(ids) == [0, 1, 2, 3]
    assert sorted(len(names) for names in ids.values()) == [1, 1, 1, 1]
    assert is_renamed(of_a_robot_that_drives(poses, ego_motion='none'))


@pytest.mark.slow
def test_odometry_that_turns_and_drives_too_little_costs_no_id():
    """It reports 3 % too little, as with worn wheels."""
    ids = ids_of_things(
        of_a_robot_that_drives(
            driving(12), odometry=lambda pose: tuple(0.97 * p for p in pose), ego_motion='odometry'
        )
    )
    assert [len(names) for names in ids.values()] == [1] * 4


@pytest.mark.slow
def test_a_ball_that_was_put_elsewhere_while_nobody_looked_is_another():
    """It is moved by 1.3 m, to where nothing was, and looks larger there."""
    moved = BALLS.copy()
    moved[0] = (1.9, 0.8, RADIUS)
    frames = of_a_robot_that_drives(
        [(0, 0, 0.8 * np.sin(2 * np.pi * k / 120)) for k in range(150)],
        lambda k: BALLS if k < 30 else moved,
        ego_motion='odometry',
    )
    assert len(ids_of_things(frames)[0]) == 2


@pytest.mark.slow
def test_what_stands_is_published_with_the_velocity_that_driving_gives_it_in_the_picture():
    last, inside = None, []
    for k, (rows, z) in enumerate(
        of_a_robot_that_drives(driving(3.5, turn=20), ego_motion='odometry')
    ):
        for row in rows[rows['time_since_update'] == 0] if k > 24 else ():
            mine = int(np.nanargmin(np.hypot(z[:, 0] - row['u'], z[:, 1] - row['v'])))
            e = np.array([row['du'], row['dv']]) - (z - last)[mine] / (FRAME / 1e9)
            inside.append(e @ np.linalg.solve(row['covariance'][2:, 2:], e) < 5.991)
        last = z
    assert len(inside) > 50
    assert np.mean(inside) > 0.85


def unseen(poses, hidden, **config):
    """Return the error of the first ball's track in the last frame in which it is hidden."""
    away = np.array([[0.0, 0.0, -50.0]])
    frames = of_a_robot_that_drives(
        poses, lambda k: BALLS[:1] + away * (k in hidden), ego_motion='odometry', **config
    )
    rows, _ = [*frames][hidden[-1]]
    x, y, yaw = poses[hidden[-1]]
    view = View(CAMERA, Pose.of_rpy((x, y, 0), (0, 0, yaw)), MOUNT)
    true = CAMERA.project(view.optical.inverse().apply(BALLS[:1]))[0]
    return np.hypot(rows['u'][0] - true[0], rows['v'][0] - true[1])


def test_an_acceleration_that_is_the_cameras_is_not_taken_for_an_objects():
    """The ball is hidden just as a short turn ends."""
    yaws = np.cumsum(np.interp(np.arange(60), (15, 30, 31), (0, 0.03, 0)))
    poses = [(0.0, 0.0, yaw) for yaw in yaws]
    model = {'motion_model': 'known_acceleration', 'acceleration_span': 0.2}
    assert unseen(poses, range(31, 45), **model) < 15


@pytest.mark.slow
def test_a_ball_that_is_hidden_as_the_robot_stops_stays_where_it_is():
    """Its center is above the ground, so its distance follows from its lower edge."""
    poses = [(min(0.5 * k * FRAME / 1e9, 1.2), 0.0, 0.0) for k in range(90)]
    assert unseen(poses, range(60, 80)) < 6


@pytest.mark.slow
@pytest.mark.parametrize(('seconds', 'degrees'), [(2.0, 60.0), (4.0, 150.0)])
def test_what_comes_into_view_elsewhere_is_not_what_a_turn_took_out_of_view(seconds, degrees):
    """The first thing is still where it was, which the camera no longer shows."""
    yaws = np.radians(np.clip(45 * (np.arange(330) * FRAME / 1e9 - seconds), 0, degrees))
    other = 2.5 * np.array([np.cos(yaws[-1]), np.sin(yaws[-1]), 0.1])
    things = np.array([(2.5, -0.6, 0.1), other])
    *_, (rows, _) = of_a_robot_that_turns(yaws, 'odometry', things)
    assert rows['track_id'].tolist() == [2]
