"""What is told of a node and of others whose names, topics, or QoS are in each other's way."""

from collections import Counter
import itertools

from rclpy.node import Node
from rclpy.qos import qos_check_compatible
from rclpy.qos import QoSCompatibility
from rclpy.topic_endpoint_info import TopicEndpointInfo

from colortrack_ros.messages import BOXES
from colortrack_ros.node_kit.runtime import OF_EVERY_NODE
from colortrack_ros.node_kit.topics import SENSED

UNNAMED = '_NODE_NAME_UNKNOWN_'
"""What rmw calls the node of a topic's end before it has heard of that node."""


def rival_of(node: Node) -> str:
    """A warning if another node has this node's name or publishes its topics; otherwise empty."""
    name = node.get_name(), node.get_namespace()
    if node.get_node_names_and_namespaces().count(name) > 1:
        return (
            f'several nodes are called {node.get_fully_qualified_name()}, and any of them answers '
            'for it; give one another name, -r __node:=NAME'
        )
    # transforms are of all nodes, and wheels have no tf2_msgs to compare types with
    own = Counter(
        publisher.topic_name
        for publisher in node.publishers
        if getattr(publisher.msg_type, '__name__', '') != 'TFMessage'
    )
    for topic in sorted(set(own) - OF_EVERY_NODE):
        if node.count_publishers(topic) > own[topic]:
            return f'others publish on {topic} as well, and subscribers get both; remap one of them'
    return ''


def crowd_of(node: Node) -> str:
    """A warning if several publish what this node takes from one camera or robot; otherwise empty.

    Detections may be of several detectors.
    """
    for end in node.subscriptions:
        topic = end.topic_name
        if end.msg_type in SENSED and node.count_publishers(topic) > 1:
            giving = _of_known(node.get_publishers_info_by_topic(topic))
            names = sorted({f'{g.node_namespace.rstrip("/")}/{g.node_name}' for g in giving})
            if len(names) > 1:  # one that was killed and started again is known twice for a while
                return (
                    f'{" and ".join(names)} publish on {topic}, and their messages take turns: '
                    'expected one; remap the others'
                )
    return ''


def mismatch_of(node: Node) -> str:
    """A warning if QoS, or another type, keeps messages from this node, or its own from others;
    otherwise empty.
    """
    name = node.get_name(), node.get_namespace()
    topics = {end.topic_name for end in node.publishers}
    topics |= {end.topic_name for end in node.subscriptions}
    for topic in sorted(topics - OF_EVERY_NODE):
        giving = _of_known(node.get_publishers_info_by_topic(topic))
        taking = _of_known(node.get_subscriptions_info_by_topic(topic))
        for giver, taker in itertools.product(giving, taking):
            if name not in [(end.node_name, end.node_namespace) for end in (giver, taker)]:
                continue
            ends = f'{taker.node_name} gets nothing from {giver.node_name} on {topic}'
            if giver.topic_type != taker.topic_type:
                hint = ', see detections_type' * (giver.topic_type == BOXES)
                return f'{ends}: it takes {taker.topic_type}, not {giver.topic_type}{hint}'
            match, why = qos_check_compatible(giver.qos_profile, taker.qos_profile)
            if match == QoSCompatibility.ERROR and not _gets(taker, giver, taking):
                reasons = str(why).replace('ERROR: ', '').lower().strip('; ')
                return f'{ends}: {reasons}; see qos_overrides in doc/robot.md'
    return ''


def _of_known(ends: list[TopicEndpointInfo]) -> list[TopicEndpointInfo]:
    """Return the ends of nodes whose names have come."""
    return [end for end in ends if end.node_name != UNNAMED]


def _gets(
    taker: TopicEndpointInfo, giver: TopicEndpointInfo, taking: list[TopicEndpointInfo]
) -> bool:
    """Whether another subscription of the same node matches the publisher."""
    return any(
        qos_check_compatible(giver.qos_profile, end.qos_profile)[0] != QoSCompatibility.ERROR
        for end in taking
        if (end.node_name, end.node_namespace) == (taker.node_name, taker.node_namespace)
    )
