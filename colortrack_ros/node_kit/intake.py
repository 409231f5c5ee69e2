"""Pictures on the way from a topic to what works on them."""

from collections.abc import Callable
from dataclasses import dataclass
import threading
import time

from rclpy.node import Node
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image

from colortrack_ros.data import Frame
from colortrack_ros.flow.backlog import Backlog
from colortrack_ros.flow.order import IDLE
from colortrack_ros.flow.order import Order
from colortrack_ros.flow.order import OrderConfig
from colortrack_ros.messages import frame_of_serialized_compressed_image
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import MessageError
from colortrack_ros.node_kit.clocks import lacks_clock
from colortrack_ros.node_kit.clocks import seconds_of
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import part

READERS = {
    'raw': (Image, '{}', frame_of_serialized_image),
    'compressed': (CompressedImage, '{}/compressed', frame_of_serialized_compressed_image),
}
"""For each value of image_transport the message, its topic and what reads it."""


@dataclass(frozen=True)
class IntakeConfig(Config):
    """Where pictures come from, and which of them are worked on."""

    max_lag: float = parameter(
        0.05,
        'When working off the waiting images would take longer, the oldest are skipped.',
        unit='s',
        minimum=0.0,
        maximum=60.0,
        audience=EXPERT,
    )
    order: OrderConfig = part(OrderConfig)
    image_topic: str = topic_name('camera/image_raw', 'the images')
    image_transport: str = parameter(
        'raw',
        'Whether images come raw, or as JPEG or PNG on <image_topic>/compressed.',
        choices=READERS,
        read_only=True,
    )


class ImageIntake:
    """Reads images in a thread of its own, in the order of their stamps, and hands them on.

    :param node: whose images they are.
    :param work: takes a frame whose turn it is.
    :param refuse: takes the reason why an image is dropped.
    :ivar paused: whether what arrives is dropped unread.
    """

    def __init__(
        self, node: Node, work: Callable[[Frame], object], refuse: Callable[[str], object]
    ) -> None:
        self.paused = False
        self._node, self._refuse = node, refuse
        self._backlog: Backlog[bytes] = Backlog()
        self._order: Order[Frame] = Order(work, refuse, seconds_of(node))
        self._worker = threading.Thread(target=self._work, name=node.get_name())

    @property
    def skipped(self) -> int:
        """How many images have been skipped."""
        return self._backlog.skipped

    def configure(self, config: IntakeConfig) -> None:
        """Take other values into use."""
        self._backlog.max_lag = config.max_lag
        self._order.configure(config.order)

    def subscribe(self, image_topic: str, image_transport: str) -> None:
        """Take the images of a topic from now on."""
        kind, name, self._read = READERS[image_transport]
        subscribe_to(self._node, kind, name.format(image_topic), self._receive)
        self._worker.start()

    def _receive(self, cdr: bytes) -> None:
        if not self.paused:
            self._backlog.put(cdr)

    def _work(self) -> None:
        while not self._backlog.closed:
            cdr = self._backlog.get(IDLE)
            start = time.monotonic()
            if cdr is None:
                self._order.look(lambda: lacks_clock(self._node))
                continue
            try:
                frame = self._read(cdr)
                self._order.push(frame.stamp, frame)
            except MessageError as error:
                self._refuse(str(error))
            self._backlog.took(time.monotonic() - start)

    def close(self) -> None:
        """End the thread."""
        self._backlog.close()
        if self._worker.is_alive():
            self._worker.join()
