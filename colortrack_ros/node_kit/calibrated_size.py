"""Compares the size of pictures with the one of which CameraInfo says that it is."""

from rclpy.node import Node
from sensor_msgs.msg import CameraInfo

from colortrack_ros.data import Frame
from colortrack_ros.encodings import size_of
from colortrack_ros.messages import image_size_of_camera_info
from colortrack_ros.messages import MessageError
from colortrack_ros.messages.serialized import message_of_serialized
from colortrack_ros.node_kit.topics import subscribe_to

PICTURES_PER_LOOK = 10
"""Pictures per comparison of sizes. Two in a row have to agree, as a camera may change its mode.
Chosen."""

ODD_PIXEL = 1
"""Difference [px] that is none: drivers that bin round odd sizes up or down."""


class CalibratedSize:
    """Watch over the size of which a camera is said to be calibrated.

    Nothing in a message of detections tells how large the picture was. With the calibration of
    larger ones, a robot locates all objects elsewhere, and nothing tells it while it stands.

    :param node: the one that takes the pictures; topic: of the CameraInfo.
    :param pictures: topic of the pictures, for the message.
    """

    def __init__(self, node: Node, topic: str, pictures: str) -> None:
        self._topic, self._pictures, self._cdr = topic, pictures, b''
        self._frames, self._line, self._trouble = 0, '', ''
        # what is no CameraInfo is refused where it is used
        subscribe_to(node, CameraInfo, topic, self._take, lambda _: None)

    def trouble(self, frame: Frame) -> str:
        """Return what is wrong with the size of a picture, one line; empty if nothing is."""
        self._frames += 1
        if self._frames % PICTURES_PER_LOOK == 0 and self._cdr:
            before, self._line = self._line, self._compared(frame)
            if before == self._line:
                self._trouble = self._line
        return self._trouble

    def _take(self, cdr: bytes) -> None:
        self._cdr = cdr

    def _compared(self, frame: Frame) -> str:
        try:
            info = message_of_serialized(self._cdr, CameraInfo)
            width, height = image_size_of_camera_info(info)
        except MessageError:
            return ''
        rows, columns = size_of(frame)
        fits = max(abs(width - columns), abs(height - rows)) <= ODD_PIXEL
        # of another frame, it is another camera's
        if not width or fits or info.header.frame_id != frame.frame_id:
            return ''
        return (
            f'CameraInfo on {self._topic} is of {width}x{height} pictures, those on '
            f'{self._pictures} have {columns}x{rows}: what locates by it is wrong; calibrate the '
            'camera for this size, or set camera_info_topic to that of these pictures'
        )
