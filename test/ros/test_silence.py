"""A node that nothing comes in to says why, as far as that can be seen."""

from types import SimpleNamespace

from diagnostic_msgs.msg import DiagnosticArray
import pytest
from rclpy.validate_full_topic_name import validate_full_topic_name
from sensor_msgs.msg import Image

from colortrack_ros.node_kit.silence import unheard_by

FRONT = {'image_topic': '/front/image_raw', 'camera_info_topic': '/front/camera_info'}


def test_a_topic_that_nobody_publishes_on_is_told_and_where_the_pictures_are(ros):
    """Of a name that is misspelled the log said nothing at all."""
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    ros.start('camera', source='scene:single?width=80&height=60', loop=True, **FRONT)
    detector = ros.start('detector', warn_silence=0.5)
    tracker = ros.start('tracker', warn_silence=0.5, detections_topic='detektions')
    told = 'nobody publishes on /camera/image_raw; pictures are on /front/image_raw'
    detector.wait_for(f'nothing has come in: {told}')
    tracker.wait_for('nothing has come in: nobody publishes on /detektions')
    assert ros.spin(lambda: any(told in s.message for m in diagnostics for s in m.status))
    assert detector.output.count('nothing has come in') == 1


def test_of_topics_that_have_publishers_nothing_is_told(ros):
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    ros.start('camera', source='scene:single?width=80&height=60', wait_for_subscribers=9)
    ros.start('detector', warn_silence=0.5)

    def silent():
        statuses = [s.message for m in diagnostics for s in m.status]
        return [text for text in statuses if 'nothing has come in' in text]

    assert ros.spin(lambda: len(silent()) > 2)
    assert not silent()[-1].endswith('image_raw')


def test_a_topic_of_others_whose_name_ros_does_not_allow_does_no_harm():
    """DDS does, and participants without ROS have such: the exception ended the node."""
    names = ['/front-left/image', '/rear/image']

    def count(topic):
        validate_full_topic_name(topic)
        return int(topic in names)

    node = SimpleNamespace(
        get_fully_qualified_name=lambda: '/detector',
        subscriptions=[SimpleNamespace(topic_name='/image', msg_type=Image)],
        publishers=[],
        count_publishers=count,
        get_topic_names_and_types=lambda: [(name, ['sensor_msgs/msg/Image']) for name in names],
    )
    assert unheard_by(node) == 'nobody publishes on /image; pictures are on /rear/image'


@pytest.mark.slow
def test_a_camera_that_is_started_a_little_later_is_not_told_in_the_log(ros):
    """A launch file starts all at once, and a driver needs seconds."""
    detector = ros.start('detector')
    ros.spin(lambda: False, 4.0)
    ros.start('camera', source='scene:single?width=80&height=60', loop=True)
    ros.spin(lambda: False, 4.0)
    assert 'nothing has come in' not in detector.output
