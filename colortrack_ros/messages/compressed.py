"""sensor_msgs/CompressedImage <-> Frame."""

import array
from typing import Any

import cv2
import numpy as np
from sensor_msgs.msg import CompressedImage

from colortrack_ros.data import Frame
from colortrack_ros.encodings import BAYER
from colortrack_ros.encodings import size_of
from colortrack_ros.encodings import writable_bgr
from colortrack_ros.messages.cdr import CdrError
from colortrack_ros.messages.cdr import Reader
from colortrack_ros.messages.errors import MessageError
from colortrack_ros.messages.header import header_of
from colortrack_ros.messages.images import SIXTEEN_BIT
from colortrack_ros.picture_files import claimed_size
from colortrack_ros.picture_files import JPEG_END
from colortrack_ros.picture_files import JPEG_START
from colortrack_ros.picture_files import MAX_PIXELS
from colortrack_ros.picture_files import PNG_START
from colortrack_ros.picture_files import read_jpeg_header

LONGEST_SIDE = 65535
"""Largest width and height of a JPEG [px]: its header has 16 bits for each."""


def compressed_of_frame(frame: Frame, quality: int) -> CompressedImage:
    """A CompressedImage with the frame as JPEG.

    :param quality: 1..100.
    :raises MessageError: no JPEG can hold it.
    """
    height, width = size_of(frame)
    if not (0 < width <= LONGEST_SIDE and 0 < height <= LONGEST_SIDE):
        expected = f'1x1 to {LONGEST_SIDE}x{LONGEST_SIDE} pixels'
        raise MessageError(f'JPEG: expected {expected}, got {width}x{height}')
    bgr = frame.image if frame.encoding == 'bgr8' else writable_bgr(frame)
    _, jpeg = cv2.imencode('.jpg', bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])
    data = array.array('B')
    data.frombytes(jpeg.reshape(-1).data)
    return CompressedImage(
        header=header_of(frame.stamp, frame.frame_id),
        format='bgr8; jpeg compressed bgr8',
        data=data,
    )


def frame_of_serialized_compressed_image(cdr: bytes, max_pixels: int = MAX_PIXELS) -> Frame:
    """The Frame of a serialized CompressedImage, decoded to bgr8, or Bayer if that was compressed.

    An Exif orientation is ignored, since the CameraInfo describes the picture as the camera took
    it.

    :param max_pixels: a picture that claims more pixels is refused before it is decoded.
    :raises MessageError: these are not the bytes of a CompressedImage, or not a whole JPEG or PNG.
    """
    try:
        reader = Reader(cdr)
        stamp, frame_id = reader.header()
        kind = reader.string()
        data = bytes(reader.bytes_())
    except CdrError as error:
        raise MessageError(f'not a serialized sensor_msgs/CompressedImage: {error}') from error
    label = f'compressed image of {len(data)} bytes, format {kind!r}'
    width, height = _size_of(data, label)
    if width * height > max_pixels:
        raise MessageError(
            f'{label}: expected at most max_pixels, {max_pixels}, got {width}x{height}'
        )
    image: Any  # cv2's type allows None and any dtype
    try:
        pattern = _pattern_of(kind)
        flags = cv2.IMREAD_ANYCOLOR if pattern else cv2.IMREAD_COLOR
        flags |= cv2.IMREAD_IGNORE_ORIENTATION
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except cv2.error:
        image = None
    if image is None:
        raise MessageError(f'{label}: expected a JPEG or PNG that can be decoded')
    return Frame(image, pattern if image.ndim == 2 else 'bgr8', stamp, frame_id)


def _pattern_of(kind: str) -> str:
    """The 8-bit Bayer encoding of a format, such as `bayer_rggb8; png compressed`, or empty.

    compressed_image_transport compresses a Bayer pattern as it is, as a gray picture.
    """
    encoding = kind.partition(';')[0].strip()
    encoding = SIXTEEN_BIT.get(encoding, encoding)
    return encoding if encoding in BAYER else ''


def _size_of(data: bytes, label: str) -> tuple[int, int]:
    """Width and height that a picture claims [px]."""
    if data.startswith(PNG_START) and (size := claimed_size(data)):
        return size
    if not data.startswith(JPEG_START):
        raise MessageError(f'{label}: expected a JPEG or PNG')
    size, scan = read_jpeg_header(data)
    # OpenCV 4 fills missing parts with gray.
    if size is None or data.rfind(JPEG_END, scan) < 0:
        raise MessageError(f'{label}: expected a whole JPEG, this one is cut short or broken')
    return size
