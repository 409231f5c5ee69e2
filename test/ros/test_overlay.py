"""The overlay, where pictures and tracks do not meet."""

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import image_of_frame


@pytest.mark.slow
@pytest.mark.parametrize('late', [None, 3.0])
def test_pictures_and_tracks_that_never_meet_are_told_until_they_do(ros, late):
    """Such as with a wrong tracks_topic, or a driver that stamps pictures anew."""
    process = ros.start('overlay', '-r', 'tracks:=/eye/tracks')
    pictures = ros.node.create_publisher(Image, 'camera/image_raw', 1000)
    tracks = ros.node.create_publisher(PointCloud2, 'eye/tracks', 1000)
    drawn, said = (
        ros.listen(Image, 'overlay/image_raw'),
        ros.listen(DiagnosticArray, '/diagnostics'),
    )
    there = ros.spin(lambda: pictures.get_subscription_count() and tracks.get_subscription_count())
    assert there, ros.outputs()
    ros.settle()

    def give(numbers, late):
        for k in numbers:
            stamp = 10**12 + k * 10**7
            pictures.publish(image_of_frame(Frame(np.zeros((12, 16, 3), np.uint8), stamp=stamp)))
            if late is not None:
                cloud = cloud_of_tracks(Tracks(stamp=stamp + round(late * 1e9)))
                tracks.publish(cloud)
            ros.spin(lambda: False, 0.01)

    give(range(200), late)
    if late is None:
        told = 'the last on /camera/image_raw at 1001.990 s, on /eye/tracks nothing'
    else:
        told = 'the last on /camera/image_raw at 1001.990 s, on /eye/tracks at 1004.990 s'

    def is_told():
        return any(told in m.status[0].message for m in said)

    assert ros.spin(is_told), (said[-1:], ros.outputs())
    assert process.output.count('nothing is drawn: pictures and tracks have no stamps') == 1
    assert drawn == []
    give(range(600, 610), 0.0)
    said.clear()
    assert ros.spin(lambda: len(drawn) == 10 and said and not is_told()), ros.outputs()
    assert process.stop() == 0
