"""Depth pictures, 16UC1 in mm and 32FC1 in m (REP-118)."""

import array

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image

from colortrack_ros.messages.errors import MessageError
from colortrack_ros.messages.header import header_of
from colortrack_ros.messages.images import fields_of_serialized_image

ENCODED = {'16UC1': ('u2', 1e-3), '32FC1': ('f4', 1.0)}
"""Pixel type and unit [m] of each encoding."""


def depth_of_serialized_image(cdr: bytes) -> tuple[int, NDArray[np.float32]]:
    """The stamp [ns] of a serialized Image, and its depths, (H, W) [m]; 0 or NaN in holes.

    :raises MessageError: it is not a depth picture, or size, step and data do not agree.
    """
    (stamp, _), height, width, encoding, big_endian, step, data = fields_of_serialized_image(cdr)
    if encoding not in ENCODED:
        raise MessageError(f'depth picture in {encoding!r}: expected {" or ".join(ENCODED)}')
    kind, unit = ENCODED[encoding]
    pixel = np.dtype(('>' if big_endian else '<') + kind)
    if step < width * pixel.itemsize or len(data) != step * height:
        raise MessageError(
            f'depth picture of {len(data)} bytes, step {step}: expected {height} rows of at least '
            f'{width * pixel.itemsize} bytes ({width}x{height} {encoding})'
        )
    rows = np.frombuffer(data, np.uint8).reshape(height, step)[:, : width * pixel.itemsize]
    depth = np.ascontiguousarray(rows).view(pixel).astype(np.float32)
    return stamp, depth * np.float32(unit) if unit != 1 else depth


def image_of_depth(depth: NDArray[np.float32], stamp: int, frame_id: str) -> Image:
    """A depth picture, 32FC1.

    :param depth: (H, W) [m], NaN in holes.
    """
    data = array.array('B')
    data.frombytes(np.ascontiguousarray(depth, '<f4').data.cast('B'))
    height, width = depth.shape
    image = Image(header=header_of(stamp, frame_id), height=height, width=width)
    image.encoding, image.step, image.data = '32FC1', 4 * width, data
    return image
