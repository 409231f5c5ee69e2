"""The node that draws the tracks onto the pictures."""

import dataclasses
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.drawing import draw_tracks
from colortrack_ros.drawing import Trails
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import tracks_of_serialized_cloud
from colortrack_ros.nodes.health import HEALTH
from colortrack_ros.nodes.health import Health
from colortrack_ros.nodes.live_parameters import declare
from colortrack_ros.nodes.parameters import ParameterTable
from colortrack_ros.nodes.runtime import run
from colortrack_ros.nodes.topics import DEPTH
from colortrack_ros.nodes.topics import PICTURE_DEPTH
from colortrack_ros.nodes.topics import publish_on
from colortrack_ros.nodes.topics import subscribe_to
from colortrack_ros.nodes.topics import topic

WAITING = 30
"""Pictures that wait for their tracks, and tracks that wait for their picture."""

TO_BGR = {
    'rgb8': cv2.COLOR_RGB2BGR,
    'bgra8': cv2.COLOR_BGRA2BGR,
    'rgba8': cv2.COLOR_RGBA2BGR,
    'mono8': cv2.COLOR_GRAY2BGR,
}

TABLE = ParameterTable(
    [
        topic('image_topic', 'camera/image_raw', 'the pictures'),
        topic('tracks_topic', 'tracks', 'the tracks'),
        topic('overlay_topic', 'overlay/image_raw', 'the pictures with the tracks drawn on them'),
        PICTURE_DEPTH,
        DEPTH,
        *HEALTH,
    ]
)


class OverlayNode(Node):
    """Images and tracks in; for each pair with the same stamp one Image out."""

    def __init__(self, **options: Any) -> None:
        super().__init__('overlay', allow_undeclared_parameters=True, **options)
        setup = declare(self, TABLE, dict, lambda _: None)
        self._trails = Trails()
        self._frames: dict[int, Frame] = {}
        self._tracks: dict[int, Tracks] = {}
        self.health = Health(self)
        self._publisher = publish_on(self, Image, setup['overlay_topic'])
        subscribe_to(self, Image, setup['image_topic'], self._take_image)
        subscribe_to(self, PointCloud2, setup['tracks_topic'], self._take_tracks)

    def _take_image(self, cdr: bytes) -> None:
        try:
            frame = frame_of_serialized_image(cdr)
        except MessageError as error:
            return self.health.refuse(str(error))
        return self._take(self._frames, frame)

    def _take_tracks(self, cdr: bytes) -> None:
        try:
            tracks = tracks_of_serialized_cloud(cdr)
        except MessageError as error:
            return self.health.refuse(str(error))
        return self._take(self._tracks, tracks)

    def _take(self, waiting: dict, item: Frame | Tracks) -> None:
        self.health.took_in()
        waiting[item.stamp] = item
        if item.stamp in self._frames and item.stamp in self._tracks:
            self._paint(self._frames.pop(item.stamp), self._tracks.pop(item.stamp))
        while len(waiting) > WAITING:
            waiting.pop(next(iter(waiting)))

    def _paint(self, frame: Frame, tracks: Tracks) -> None:
        self._trails.update(tracks)
        if self._publisher.get_subscription_count() == 0:
            return
        image = writable_bgr(frame)
        draw_tracks(image, tracks, self._trails)
        picture = dataclasses.replace(frame, image=image, encoding='bgr8')
        self._publisher.publish(image_of_frame(picture))
        self.health.gave_out(frame.stamp)


def writable_bgr(frame: Frame) -> NDArray[np.uint8]:
    """A copy of the frame's picture to draw on, (H, W, 3) BGR."""
    if frame.encoding == 'bgr8':
        return frame.image.copy()
    image: NDArray = cv2.cvtColor(frame.image, TO_BGR[frame.encoding])
    return image


def main() -> int:
    """Run the node."""
    return run(lambda _: [OverlayNode()])
