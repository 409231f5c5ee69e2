"""Who publishes what another node publishes, too, is told, but for what is of all nodes."""

from types import SimpleNamespace

from std_msgs.msg import String

from colortrack_ros.node_kit.diagnostics import rival_of


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
