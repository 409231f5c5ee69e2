"""Subscribes to pictures and passes them to a worker."""

from collections.abc import Callable
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from dataclasses import replace
from functools import partial
from typing import Any
from typing import Protocol

from rclpy.node import Node
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image

from colortrack_ros.data import Frame
from colortrack_ros.flow.order import OrderConfig
from colortrack_ros.flow.stage import In
from colortrack_ros.flow.stage import Out
from colortrack_ros.flow.stage import Worker
from colortrack_ros.messages import frame_of_serialized_compressed_image
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.node_kit.clocks import lacks_clock
from colortrack_ros.node_kit.clocks import seconds_of
from colortrack_ros.node_kit.losses import Losses
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import part
from colortrack_ros.picture_files import MAX_PIXELS

TRANSPORTS = {'raw': (Image, '{}'), 'compressed': (CompressedImage, '{}/compressed')}
"""Message type and topic of each image_transport."""


def full_range() -> Any:
    """The field for the range of the luma of YUV pictures."""
    return parameter(
        False,
        'Whether the luma of YUV images goes from 0 to 255; else from 16 to 235, as most drivers '
        'mean it. Both after ITU-R BT.601.',
        read_only=True,
        audience=EXPERT,
    )


class BacklogConfig(Protocol):
    """The limits of a node's backlog and order."""

    @property
    def max_lag(self) -> float:
        """See :class:`Worker` [s]."""

    @property
    def order(self) -> OrderConfig:
        """See :class:`Order`."""


def lag_limit(default: float, items: str) -> Any:
    """The field that says when a node that is too slow starts to skip.

    :param items: what it skips, in words.
    """
    return parameter(
        default,
        f'Longest time that processing the waiting {items} may take; else the oldest are skipped.',
        unit='s',
        limits=(0.0, 60.0),
        audience=EXPERT,
    )


@dataclass(frozen=True)
class IntakeConfig(Config):
    """Where pictures come from, and which of them are processed."""

    max_lag: float = lag_limit(0.05, 'images')
    order: OrderConfig = part(OrderConfig)
    image_topic: str = topic_name('camera/image_raw', 'the images')
    image_transport: str = parameter(
        'raw',
        'Whether images come raw, or as JPEG or PNG on <image_topic>/compressed.',
        choices=TRANSPORTS,
        read_only=True,
    )
    max_pixels: int = parameter(
        MAX_PIXELS,
        'A JPEG or PNG that claims more pixels is refused before it is decoded.',
        unit='px',
        limits=(1, 1 << 30),
        read_only=True,
        audience=EXPERT,
    )
    yuv_full_range: bool = full_range()

    def frame_of(self, cdr: bytes, kind: type) -> Frame:
        """Deserialize a picture.

        :param kind: Image or CompressedImage.
        :raises MessageError: it is refused.
        """
        if kind is CompressedImage:
            return frame_of_serialized_compressed_image(cdr, self.max_pixels)
        return replace(frame_of_serialized_image(cdr), full_range=self.yuv_full_range)


def worker_of(
    node: Node,
    work: Callable[[In], Out],
    refuse: Callable[[str], object],
    config: BacklogConfig,
    name: str = '',
) -> Worker[In, Out]:
    """A stage with a thread of its own and the clock of a node.

    :param name: of the thread; empty: the node's name.
    """
    over = partial(lacks_clock, node)
    worker = Worker(work, refuse, seconds_of(node), over, name or node.get_name())
    configure(worker, config)
    return worker


@contextmanager
def whole_updates(tracker: Any) -> Iterator[None]:
    """Reset a tracker after an update that failed: its tracks may be half updated."""
    try:
        yield
    except Exception as error:
        tracker.reset(f'{type(error).__name__} in an update')
        raise


def configure(worker: Worker[Any, Any], config: BacklogConfig) -> None:
    """Apply other values."""
    worker.configure(config.order)
    worker.max_lag = config.max_lag


def receive_images(
    node: Node,
    worker: Worker[Frame, Any],
    config: IntakeConfig,
    refuse: Callable[[str], object],
    losses: Losses,
) -> None:
    """Subscribe to images, pass them, unread, to a worker, and count those that do not come."""
    kind, name = TRANSPORTS[config.image_transport]

    def receive(cdr: bytes) -> None:
        worker.put_unread(lambda: config.frame_of(cdr, kind), len(cdr))

    def number(of_message: int | None) -> None:
        losses.see(of_message, lambda: node.count_publishers(images.topic_name) == 1)

    images = subscribe_to(node, kind, name.format(config.image_topic), receive, refuse, number)
