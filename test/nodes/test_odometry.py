"""Odometry that cannot be of one robot is told."""

import pytest
from rclpy.serialization import serialize_message

from colortrack_ros.messages import odometry_on_ground
from colortrack_ros.node_kit.odometry import OdometryBuffer
from colortrack_ros.node_kit.odometry import OdometryConfig

STEP = 20_000_000


@pytest.mark.parametrize('off', [0.0, 0.4])
def test_two_drivers_of_one_name_are_told_by_their_poses(off):
    """Their name alone could be that of one that was killed and started again."""
    told = []
    buffer = OdometryBuffer(OdometryConfig(), told.append)
    for k in range(50):
        for x, late in ((0.0, 0), (off, STEP // 2)):
            place, stamp = (x + 0.01 * k, 0.0, 0.0), k * STEP + late
            message = odometry_on_ground(place, (0.5, 0.0), stamp, 'odom', 'base_link')
            buffer.take(serialize_message(message))
    assert bool(told) == (off > 0)
    assert all('odometry goes to and fro by 0.' in line for line in told)
    assert all(
        line.endswith('several nodes publish it, or its poses are that noisy') for line in told
    )
