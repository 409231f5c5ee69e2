import numpy as np
import pytest
from visualization_msgs.msg import Marker

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.data import TENTATIVE
from colortrack_ros.messages import LocationMarkerWriter
from colortrack_ros.messages import poses_of_locations
from colortrack_ros.messages import target_of_locations


def locations(count=2):
    rows = np.zeros(count, LOCATION)
    rows['x'], rows['y'], rows['z'], rows['vy'] = 3.0, 1.0, 0.1, 2.0
    rows['track_id'] = 4 + np.arange(count)
    rows['state'], rows['diameter'] = 1, 0.2
    rows['covariance'] = np.eye(6) * 0.04
    return Locations(rows, 5 * 10**9, 'odom')


def test_poses_are_in_meters_with_x_along_the_way_of_the_object():
    message = poses_of_locations(locations())
    assert message.header.frame_id == 'odom'
    assert len(message.poses) == 2
    pose = message.poses[0]
    assert (pose.position.x, pose.position.y) == (3.0, 1.0)
    assert 2 * np.arctan2(pose.orientation.z, pose.orientation.w) == pytest.approx(np.pi / 2)


def test_the_target_has_the_covariance_of_its_position():
    pose, certain = target_of_locations(locations(), 1)
    assert pose.pose == certain.pose.pose
    covariance = np.reshape(certain.pose.covariance, (6, 6))
    np.testing.assert_allclose(covariance[:3, :3], 0.04 * np.eye(3))
    assert np.linalg.eigvalsh(covariance).min() > 0


def test_markers_are_as_large_as_the_objects_and_go_with_them():
    writer = LocationMarkerWriter()
    first = writer.write(locations()).markers
    (ball,) = (m for m in first if m.ns == 'object' and m.id == 4)
    assert ball.scale.x == pytest.approx(0.2)
    assert ball.header.frame_id == 'odom'
    gone = [m.id for m in writer.write(locations(1)).markers if m.action == Marker.DELETE]
    assert gone == [5, 5, 5]


def test_the_first_markers_delete_those_that_a_locator_that_was_killed_has_left():
    writer = LocationMarkerWriter()
    actions = [m.action for m in writer.write(locations(1)).markers]
    assert actions == [Marker.DELETEALL] + 3 * [Marker.ADD]
    assert [m.action for m in writer.write(locations(1)).markers] == 3 * [Marker.ADD]


def test_what_coasts_is_amber_and_what_is_tentative_is_not_shown():
    some = locations(3)
    some.rows['state'] = [CONFIRMED, COASTING, TENTATIVE]
    balls = {m.id: m.color for m in LocationMarkerWriter().write(some).markers if m.ns == 'object'}
    assert set(balls) == {4, 5}
    assert (balls[4].g, balls[4].a) == pytest.approx((0.8, 0.8))
    assert (balls[5].r, balls[5].a) == pytest.approx((0.9, 0.5))


def test_an_arrow_ends_where_the_object_will_be_in_a_second_and_the_id_stands_above_it():
    markers = {m.ns: m for m in LocationMarkerWriter().write(locations(1)).markers}
    start, end = markers['speed'].points
    assert (start.x, start.y, start.z) == pytest.approx((3.0, 1.0, 0.1))
    assert (end.x, end.y, end.z) == pytest.approx((3.0, 3.0, 0.1))
    name = markers['name']
    assert (name.text, name.pose.position.z) == ('4', pytest.approx(0.3))


def test_an_object_of_unknown_size_is_shown_all_the_same():
    some = locations(1)
    some.rows['diameter'] = 0
    (ball,) = (m for m in LocationMarkerWriter().write(some).markers if m.ns == 'object')
    assert ball.scale.x > 0
