"""A node that nothing comes in to says why, as far as that can be seen."""

from diagnostic_msgs.msg import DiagnosticArray

FRONT = {'image_topic': '/front/image_raw', 'camera_info_topic': '/front/camera_info'}


def test_a_topic_that_nobody_publishes_on_is_told_and_where_the_pictures_are(ros):
    """Of a name that is misspelled the log said nothing at all."""
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    ros.start('camera', source='scene:single?width=80&height=60', loop=True, **FRONT)
    detector = ros.start('detector', warn_silence=0.5)
    tracker = ros.start('tracker', warn_silence=0.5, detections_topic='detektions')
    told = 'nobody publishes on /camera/image_raw; pictures are on /front/image_raw'
    detector.wait_for(f'nothing has come in: {told}')
    tracker.wait_for('nothing has come in: nobody publishes on /camera/camera_info, /detektions')
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
