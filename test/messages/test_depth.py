import array

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image

from colortrack_ros.messages import depth_of_serialized_image
from colortrack_ros.messages import MessageError


def image(pixels, encoding, padding=0, /, **changes):
    rows = np.pad(pixels.view(np.uint8), ((0, 0), (0, padding)))
    message = Image(
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        step=rows.shape[1],
        data=array.array('B', rows.tobytes()),
    )
    message.header.stamp.sec = 3
    for name, value in changes.items():
        setattr(message, name, value)
    return serialize_message(message)


DEPTH = np.array([[0.5, 1.25, 0], [2, 3, 8]], np.float32)


@pytest.mark.parametrize('padding', [0, 4])
def test_meters_and_millimeters_are_the_same_depths(padding):
    for pixels, encoding in ((DEPTH, '32FC1'), ((1000 * DEPTH).astype(np.uint16), '16UC1')):
        stamp, depth = depth_of_serialized_image(image(pixels, encoding, padding))
        assert stamp == 3 * 10**9
        np.testing.assert_allclose(depth, DEPTH)
        assert depth.dtype == np.float32


def test_big_endian_depths_are_read():
    swapped = (1000 * DEPTH).astype('>u2')
    depth = depth_of_serialized_image(image(swapped, '16UC1', is_bigendian=1))[1]
    np.testing.assert_allclose(depth, DEPTH)


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [({'encoding': 'bgr8'}, "'bgr8': expected 16UC1 or 32FC1"), ({'height': 5}, 'expected 5 rows')],
)
def test_what_is_no_depth_picture_is_refused_with_a_reason(changes, reason):
    with pytest.raises(MessageError, match=reason):
        depth_of_serialized_image(image(DEPTH, '32FC1', **changes))
