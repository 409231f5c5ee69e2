import numpy as np
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import PointCloud2

from colortrack_ros.messages import tracks_of_cloud

SCENE = 'scene:five?width=640&height=480&rate=30&duration={}'


def start_three(ros, source: str) -> None:
    """The camera starts to play when the detector listens, so start it after the others."""
    ros.start('tracker')
    ros.start('detector')
    assert ros.spin(
        lambda: ros.node.count_subscribers('detections') == ros.node.count_publishers('tracks') == 1
    ), ros.outputs()
    ros.settle()
    ros.start('camera', source=source, wait_for_subscribers=1)


def stamp(message) -> tuple[int, int]:
    return message.header.stamp.sec, message.header.stamp.nanosec


def test_no_frame_is_lost_between_camera_and_tracks_in_20_seconds(ros):
    infos, tracks = ros.listen(CameraInfo, 'camera/camera_info'), ros.listen(PointCloud2, 'tracks')
    start_three(ros, SCENE.format(20))
    assert ros.spin(lambda: len(tracks) == 600, 60.0), f'{len(tracks)} of 600; {ros.outputs()}'
    times = [stamp(message)[0] * 10**9 + stamp(message)[1] for message in tracks]
    np.testing.assert_allclose(np.diff(times), 1e9 / 30, atol=1)
    # the camera does not wait for us, so we may have missed its first messages, but no others
    assert [info.header for info in infos] == [t.header for t in tracks][-len(infos) :]
    assert len(infos) > 500
    assert max(t.width for t in tracks) == 5


def test_the_tracks_do_not_depend_on_how_fast_a_recording_is_played(ros):
    played = []
    for rate in (-1.0, 60.0):
        topic = f'tracks{len(played)}'
        tracks = ros.listen(PointCloud2, topic)
        nodes = [ros.start('tracker', tracks_topic=topic), ros.start('detector', max_lag=10.0)]
        assert ros.spin(lambda topic=topic: ros.node.count_publishers(topic) == 1), ros.outputs()
        assert ros.spin(lambda: ros.node.count_publishers('detections') == 1), ros.outputs()
        ros.settle()
        camera = ros.start(
            'camera', source=SCENE.format(4), wait_for_subscribers=1, rate=rate, exit_at_end='true'
        )
        assert ros.spin(lambda tracks=tracks: len(tracks) == 120), f'{len(tracks)} {ros.outputs()}'
        assert camera.popen.wait(timeout=10.0) == 0
        played.append([message.data.tobytes() for message in tracks])
        assert [node.stop() for node in nodes] == [0, 0]
        assert ros.spin(lambda: ros.node.count_publishers('detections') == 0)
    assert played[0] == played[1]


def test_the_pipeline_gives_what_the_three_nodes_give(ros):
    source = SCENE.format(6)
    apart = ros.listen(PointCloud2, 'tracks')
    start_three(ros, source)
    assert ros.spin(lambda: len(apart) == 180), ros.outputs()
    for process in ros.processes:
        process.stop()
    together = ros.listen(PointCloud2, 'one/tracks')
    detections = ros.listen(PointCloud2, 'one/detections')
    path = ros.folder / 'pipeline.yaml'
    path.write_text(
        '/**/camera:\n  ros__parameters:\n'
        f'    source: {source}\n    wait_for_subscribers: 1\n    exit_at_end: true\n'
    )
    pipeline = ros.start('pipeline', '-r', '__ns:=/one', '--params-file', str(path))
    assert ros.spin(lambda: ros.node.count_publishers('one/tracks') == 1), ros.outputs()
    assert ros.spin(lambda: {'camera', 'detector', 'tracker'} <= set(ros.node.get_node_names()))
    ros.settle()
    ros.start('overlay', '-r', '__ns:=/one')
    assert ros.spin(lambda: len(together) == len(detections) == 180), ros.outputs()
    assert pipeline.popen.wait(timeout=10.0) == 0, pipeline.output
    assert [stamp(m) for m in detections] == [stamp(m) for m in together]
    for one, other in zip(apart, together, strict=True):
        np.testing.assert_array_equal(tracks_of_cloud(one).rows, tracks_of_cloud(other).rows)
