import numpy as np
import pytest
from visualization_msgs.msg import Marker

from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
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
