"""Subscribes to detections, those of others included."""

from collections.abc import Callable
from dataclasses import dataclass

from rclpy.node import Node
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Detections
from colortrack_ros.messages import BOXES
from colortrack_ros.messages import BoxReader
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.messages.vision import vision
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import parameter

CLOUD = 'sensor_msgs/msg/PointCloud2'
"""Type of the detector's messages."""


@dataclass(frozen=True)
class DetectionsConfig(Config):
    """Where detections come from, and as what."""

    detections_topic: str = topic_name('detections', 'the detections')
    detections_type: str = parameter(
        CLOUD,
        "Type of the messages of detections: the detector's, or the boxes of others, such as of "
        'networks (needs vision_msgs).',
        choices=(CLOUD, BOXES),
        read_only=True,
    )
    classes: tuple[str, ...] = parameter(
        str,
        'Of boxes: IDs of the classes to take, in the order of their color index, others are left '
        'out; none: all are taken, and not told apart.',
        read_only=True,
        int_is_text=True,
    )
    min_box_score: float = parameter(
        0.1,
        'Of boxes: those with a lower score are left out. Of those that YOLOX gives a score below '
        '0.1, three in four are on nothing; 0 takes all.',
        limits=(0.0, 1.0),
        read_only=True,
    )

    def check(self) -> None:
        """Each class has one color index."""
        if len(set(self.classes)) < len(self.classes):
            raise ValueError(f'classes: expected each ID once, got {list(self.classes)}')

    def reader(self, tell: Callable[[str], object]) -> Callable[[bytes], Detections]:
        """Read a message of detections_type; raises MessageError.

        :param tell: takes a line for each class that is left out, and for low scores.
        """
        return self.reader_of(self.detections_type, tell)

    def reader_of(self, kind: str, tell: Callable[[str], object]) -> Callable[[bytes], Detections]:
        """The same for a message of another type."""
        if kind == BOXES:
            return BoxReader(self.classes, self.min_box_score, tell).read
        return detections_of_serialized_cloud


def subscribe_to_detections(
    node: Node,
    config: DetectionsConfig,
    take: Callable[[bytes], object],
    refuse: Callable[[str], object],
) -> None:
    """Subscribe to the detections, as :func:`subscribe_to`.

    :raises StartError: their type is not installed.
    """
    kind = PointCloud2
    if config.detections_type == BOXES:
        if vision is None:
            raise StartError(
                f'detections_type is {BOXES}, and vision_msgs is not installed: sudo apt install '
                'ros-jazzy-vision-msgs'
            )
        kind = vision.Detection2DArray
    subscribe_to(node, kind, config.detections_topic, take, refuse)
