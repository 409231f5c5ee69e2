import numpy as np
import pytest
from rclpy.serialization import serialize_message

from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.messages import cloud_of_locations
from colortrack_ros.messages import locations_of_serialized_cloud
from colortrack_ros.messages import MessageError


def locations():
    rows = np.zeros(3, LOCATION)
    for number, name in enumerate(LOCATION.names):
        rows[name] = number + 1
    rows['track_id'] = [4, 5, 9]
    return Locations(rows, 5_000_000_001, 'odom')


def test_locations_come_back_from_their_message():
    back = locations_of_serialized_cloud(serialize_message(cloud_of_locations(locations())))
    np.testing.assert_array_equal(back.rows, locations().rows)
    assert (back.stamp, back.frame_id) == (5_000_000_001, 'odom')


def test_x_y_z_come_first_as_rviz_and_nav2_take_them():
    message = cloud_of_locations(locations())
    assert [(f.name, f.offset, f.datatype) for f in message.fields[:3]] == [
        ('x', 0, 7),
        ('y', 4, 7),
        ('z', 8, 7),
    ]
    assert message.point_step == 336
    assert message.header.frame_id == 'odom'


@pytest.mark.parametrize('name', ['x', 'vz', 'covariance'])
def test_numbers_that_are_not_finite_are_refused_with_the_object(name):
    wrong = locations()
    wrong.rows[name][1] = np.nan
    with pytest.raises(MessageError, match=f'^object 5: expected finite numbers, got {name} nan$'):
        locations_of_serialized_cloud(serialize_message(cloud_of_locations(wrong)))


def test_a_message_without_objects_is_read():
    back = locations_of_serialized_cloud(serialize_message(cloud_of_locations(Locations(stamp=7))))
    assert len(back.rows) == 0
    assert back.stamp == 7
