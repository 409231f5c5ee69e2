"""Publishers and subscriptions with the package's QoS, which parameters can override."""

from collections.abc import Callable
from collections.abc import Iterator
import contextlib
from dataclasses import dataclass
from typing import Any

from nav_msgs.msg import Odometry
from rclpy.exceptions import NameValidationException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from rclpy.qos import QoSPolicyKind
from rclpy.qos import QoSProfile
from rclpy.qos import ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from rclpy.validate_full_topic_name import validate_full_topic_name
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image

from colortrack_ros.messages import MessageError
from colortrack_ros.messages.vision import vision
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters.config import require_name

PICTURES = (Image, CompressedImage)
SENSED = (*PICTURES, CameraInfo, Odometry)
"""Messages of the drivers of a camera and of a robot."""

LOSABLE = (*SENSED, *((vision.Detection2DArray,) if vision else ()))
"""Messages that others may send as best effort: those, and the boxes of networks."""

OVERRIDABLE = (
    QoSPolicyKind.HISTORY,
    QoSPolicyKind.DEPTH,
    QoSPolicyKind.RELIABILITY,
    QoSPolicyKind.DURABILITY,
)
"""The policies that parameters ``qos_overrides.TOPIC.publisher.*`` and ``.subscription.*`` may
change."""


LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""The policies of what publishers keep for those who subscribe later."""

LOOKED_EVERY = 0.5
"""Interval [s] at which publishers that keep their CameraInfo are looked for: as long as a picture
waits for it (world.waiting)."""


@dataclass(frozen=True)
class PictureQueueConfig(Config):
    """The queue depth of a node that publishes pictures or subscribes to them."""

    image_queue_depth: int = parameter(
        30,
        'Depth of the queue of each publisher and subscription of images.',
        limits=(1, 1000),
        audience=EXPERT,
        read_only=True,
    )


@dataclass(frozen=True)
class QueueConfig(Config):
    """The queue depth of any node."""

    queue_depth: int = parameter(
        100,
        'Depth of the queue of each other publisher and subscription.',
        limits=(1, 10000),
        audience=EXPERT,
        read_only=True,
    )


def topic_name(default: str, content: str) -> Any:
    """A field that names a topic; it may be empty only if the default is."""

    def valid(value: str) -> None:
        if value or default:
            _check_topic(value)

    return parameter(default, f'Topic of {content}.', read_only=True, valid=valid)


def require_namespace(name: str) -> None:
    """Refuse what cannot be the namespace of a camera.

    :raises ValueError: topics in it would have no name.
    """
    require_name(name)
    _check_topic(f'{name}/tracks')


def _check_topic(name: str) -> None:
    try:
        validate_full_topic_name(expand_topic_name(name, 'node', '/'))
    except (NameValidationException, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise ValueError(f'expected the name of a topic, got {name!r}: {reason}') from error


def publish_on(node: Node, kind: type, name: str) -> Publisher:
    """Create a reliable publisher, which matches every subscription."""
    with _explained(kind, name):
        return node.create_publisher(
            kind,
            name,
            QoSProfile(depth=_depth(node, kind), reliability=ReliabilityPolicy.RELIABLE),
            qos_overriding_options=QoSOverridingOptions(OVERRIDABLE),
        )


def subscribe_to(
    node: Node,
    kind: type,
    name: str,
    take: Callable[[bytes], object],
    refuse: Callable[[str], object],
    number: Callable[[int | None], object] = lambda _: None,
) -> Subscription:
    """Create a subscription to serialized bytes, so that the node can refuse invalid messages.

    For pictures, CameraInfo, odometry and boxes it is best effort, which matches all publishers:
    drivers send these as sensor data, and a late one is not worth resending. A CameraInfo that was
    sent before, by a publisher that keeps it for those who come later, is received as well.

    :param take: takes each message. refuse: takes the reason of a MessageError.
    :param number: takes the sequence number of each message; None if the middleware has none.
    """

    def receive(cdr: bytes, info: dict[str, int | None]) -> None:
        number(info.get('publication_sequence_number'))
        try:
            take(cdr)
        except MessageError as error:
            refuse(str(error))

    take_with_info: Any = receive  # rclpy's annotations know no MessageInfo
    reliability = ReliabilityPolicy.BEST_EFFORT if kind in LOSABLE else ReliabilityPolicy.RELIABLE
    with _explained(kind, name):
        subscription = node.create_subscription(
            kind,
            name,
            take_with_info,
            QoSProfile(depth=_depth(node, kind), reliability=reliability),
            qos_overriding_options=QoSOverridingOptions(OVERRIDABLE),
            raw=True,
        )
    if kind is CameraInfo:
        _receive_kept(node, kind, subscription.topic_name, receive)
    return subscription


def _receive_kept(node: Node, kind: type, name: str, take: Callable[..., None]) -> None:
    """Subscribe again, for what was sent before, once there is a publisher that keeps it.

    All publishers that do not would log a warning, so they are not asked.
    """

    def look() -> None:
        giving = node.get_publishers_info_by_topic(name)
        if any(end.qos_profile.durability == LATCHED.durability for end in giving):
            timer.cancel()
            node.create_subscription(kind, name, take, LATCHED, raw=True)

    timer = node.create_timer(LOOKED_EVERY, look, clock=STEADY)


@contextlib.contextmanager
def _explained(kind: type, name: str) -> Iterator[None]:
    """Name the topic in the error of rcl, which says ``invalid allocator``."""
    try:
        yield
    except RuntimeError as error:
        why = 'does the node have the same topic as another type, or do policies of SROS2 forbid it'
        raise RuntimeError(f'topic {name} as {kind.__name__}: {error}: {why}?') from error


def _depth(node: Node, kind: type) -> int:
    name = 'image_queue_depth' if kind in PICTURES else 'queue_depth'
    depth: int = node.get_parameter(name).value
    return depth
