"""What is told of a node that nothing comes in to."""

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image

from colortrack_ros.node_kit.runtime import OF_EVERY_NODE

TYPES_OF_PICTURES = {'sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage'}


def unheard_by(node: Node) -> str:
    """On which of the topics that a node takes nobody publishes, and where pictures are instead;
    empty if somebody does on each. Nobody has to publish CameraInfo: nodes that need it say so.
    """
    own = f'{node.get_fully_qualified_name()}/'
    taken = {
        end.topic_name: end.msg_type for end in node.subscriptions if end.msg_type is not CameraInfo
    }
    unheard = [
        topic
        for topic in sorted(set(taken) - OF_EVERY_NODE)
        if not topic.startswith(own) and node.count_publishers(topic) == 0
    ]
    if not unheard:
        return ''
    text = f'nobody publishes on {", ".join(unheard)}'
    if not any(taken[topic] in (Image, CompressedImage) for topic in unheard):
        return text
    given = {end.topic_name for end in node.publishers}
    pictures = [
        topic
        for topic, kinds in node.get_topic_names_and_types()
        if TYPES_OF_PICTURES & set(kinds) and topic not in given and _is_published(node, topic)
    ]
    return f'{text}; pictures are on {", ".join(sorted(pictures))}' if pictures else text


def _is_published(node: Node, topic: str) -> bool:
    try:
        return bool(node.count_publishers(topic) > 0)
    except InvalidTopicNameException:  # as participants of DDS without ROS may have
        return False
