"""Publishers and subscriptions with the package's quality of service, open to overrides."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos import ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

from colortrack_ros.nodes.parameters import Spec

DEPTH = Spec(
    'queue_depth',
    5,
    'Messages that wait in the queue of each publisher and subscription.',
    minimum=1,
    maximum=1000,
    read_only=True,
)


def topic(name: str, default: str, content: str) -> Spec:
    """The row of a topic's name in a parameter table."""
    return Spec(name, default, f'Topic of {content}.', read_only=True)


def publish_on(node: Node, kind: type, parameter: str) -> Publisher:
    """A reliable publisher on the topic that a parameter names; every subscriber can hear it."""
    return node.create_publisher(
        kind,
        node.get_parameter(parameter).value,
        _profile(node, ReliabilityPolicy.RELIABLE),
        qos_overriding_options=QoSOverridingOptions.with_default_policies(),
    )


def subscribe_to(
    node: Node, kind: type, parameter: str, callback: Callable[[Any], None], *, pictures: bool
) -> Subscription:
    """A subscription to the topic that a parameter names.

    :param pictures: take them best effort, as serialized bytes: what is late is not sent again.
    """
    reliability = ReliabilityPolicy.BEST_EFFORT if pictures else ReliabilityPolicy.RELIABLE
    return node.create_subscription(
        kind,
        node.get_parameter(parameter).value,
        callback,
        _profile(node, reliability),
        qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        raw=pictures,
    )


def _profile(node: Node, reliability: ReliabilityPolicy) -> QoSProfile:
    return QoSProfile(depth=node.get_parameter(DEPTH.name).value, reliability=reliability)
