"""Who publishes what another node publishes, too, is told, but for what is of all nodes."""

from types import SimpleNamespace

import pytest
from sensor_msgs.msg import Image
from std_msgs.msg import String

from colortrack_ros.node_kit.rivals import crowd_of
from colortrack_ros.node_kit.rivals import mismatch_of
from colortrack_ros.node_kit.rivals import rival_of


class TFMessage:
    """Of tf2_msgs, which is in no wheel."""


def node_of(topic, kind):
    """A node that publishes on a topic, as another does."""
    return SimpleNamespace(
        get_name=lambda: 'locator',
        get_namespace=lambda: '/',
        get_node_names_and_namespaces=lambda: [('locator', '/'), ('other', '/')],
        publishers=[SimpleNamespace(topic_name=topic, msg_type=kind)],
        count_publishers=lambda _: 2,
    )


def test_transforms_are_published_by_everybody_on_a_robot():
    assert 'others publish on /tracks' in rival_of(node_of('/tracks', String))
    for topic in ('/tf', '/tf_static', '/robot1/tf'):
        assert rival_of(node_of(topic, TFMessage)) == ''


def end_of(name, kind='sensor_msgs/msg/Image'):
    return SimpleNamespace(node_name=name, node_namespace='/', topic_type=kind)


@pytest.mark.parametrize('name', ['other', '_NODE_NAME_UNKNOWN_'])
def test_a_node_is_told_of_once_its_name_is_known(name):
    node = node_of('/tracks', String)
    node.subscriptions = [SimpleNamespace(topic_name='/image', msg_type=Image)]
    node.get_publishers_info_by_topic = lambda _: [end_of('camera'), end_of(name)]
    node.get_subscriptions_info_by_topic = lambda _: []
    assert ('/camera and /other publish' in crowd_of(node)) == (name == 'other')
    node.subscriptions = []
    node.get_publishers_info_by_topic = lambda _: [end_of('locator')]
    node.get_subscriptions_info_by_topic = lambda _: [end_of(name, 'a/msg/B')]
    told = 'other gets nothing from locator on /tracks: it takes a/msg/B, not sensor_msgs/msg/Image'
    assert mismatch_of(node) == (told if name == 'other' else '')
