"""sensor_msgs/PointCloud2 <-> Locations."""

import numpy as np
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.messages.clouds import cloud_of_rows
from colortrack_ros.messages.clouds import rows_of_cloud
from colortrack_ros.messages.errors import MessageError
from colortrack_ros.messages.header import stamp_of
from colortrack_ros.messages.serialized import message_of_serialized


def cloud_of_locations(locations: Locations) -> PointCloud2:
    """One point for each object; x, y, z come first, as RViz and Nav2 take them."""
    return cloud_of_rows(locations.rows, locations.stamp, locations.frame_id)


def locations_of_cloud(message: PointCloud2) -> Locations:
    """The objects of a message, in any order of its fields, further fields ignored.

    :raises MessageError: a field is missing or has another type, sizes do not agree, or numbers
        are not finite.
    """
    rows = rows_of_cloud(message, LOCATION)
    for name in ('x', 'y', 'z', 'vx', 'vy', 'vz', 'covariance'):
        wrong = ~np.isfinite(rows[name])
        if wrong.any():
            row = wrong.nonzero()[0][0]
            raise MessageError(
                f'object {rows["track_id"][row]}: expected finite numbers, got {name} '
                f'{rows[name][wrong][0]}'
            )
    return Locations(rows, stamp_of(message.header), message.header.frame_id)


def locations_of_serialized_cloud(cdr: bytes) -> Locations:
    """The objects of a serialized message.

    :param cdr: as a subscription with ``raw=True`` hands it over.
    :raises MessageError: as :func:`locations_of_cloud`, and for bytes of something else.
    """
    return locations_of_cloud(message_of_serialized(cdr, PointCloud2))
