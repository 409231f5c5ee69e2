import time

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from support.recorded import frames
from support.recorded import of_topic
from support.recorded import write_bag
from support.ros_domain import Process
from support.waiting import PATIENCE

from colortrack_ros.data import Frame
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import tracks_of_cloud
from colortrack_ros.replay.main import main

pytestmark = pytest.mark.slow

SCENE = 'scene:five?width=320&height=240&rate=30&duration={}'
LARGE = 'scene:five?width=640&height=480&rate=30&duration={}'
DEEP = 600
"""Pictures that can wait where a machine has no time for the detector: all of a test. So many of
SCENE take less memory than a node keeps for them; of LARGE it would skip some."""
ALL = ('-p', 'max_lag:=60.0', '-p', f'image_queue_depth:={DEEP}', '-p', 'queue_depth:=1000')
RELIABLE = 'qos_overrides./camera/image_raw.subscription.reliability:=reliable'
"""However busy the machine is, nothing is skipped."""


SIZE = ('-p', 'tracker:image_size:=[320, 240]')
"""Known from the first picture on, whichever topic is heard first."""


def start_two(ros, tracks: list, topic: str = 'tracks') -> list[Process]:
    """Tracker and detector, and a list of tracks that fills once they know each other.

    They do when tracks come of a black picture; it is of a time to come, so that whatever follows
    it starts afresh.
    """
    started = [
        ros.start('tracker', *ALL, *SIZE, tracks_topic=topic),
        ros.start('detector', *ALL, '-p', RELIABLE),
    ]
    publisher = ros.node.create_publisher(Image, 'camera/image_raw', 10)
    black = image_of_frame(Frame(np.zeros((240, 320, 3), np.uint8), stamp=2 * 10**18))
    end = time.monotonic() + PATIENCE
    while not tracks:
        assert time.monotonic() < end, ros.outputs()
        publisher.publish(black)
        ros.spin(lambda: bool(tracks), 2.0)
    ros.settle()
    ros.node.destroy_publisher(publisher)
    tracks.clear()
    return started


def start_three(ros, tracks: list, source: str, **camera: object) -> None:
    """The camera starts to play when the detector listens, so start it after the others."""
    start_two(ros, tracks)
    camera |= {'source': source, 'wait_for_subscribers': 1, 'image_queue_depth': DEEP}
    ros.start('camera', **camera)


def stamp(message) -> tuple[int, int]:
    return message.header.stamp.sec, message.header.stamp.nanosec


def test_no_frame_is_lost_between_camera_and_tracks_in_20_seconds(ros):
    infos, tracks = ros.listen(CameraInfo, 'camera/camera_info'), ros.listen(PointCloud2, 'tracks')
    start_two(ros, tracks)
    # The camera waits for the detector, not for us: it plays when it knows us as well.
    play = {'rate': 60.0, 'wait_for_subscribers': 1, 'image_queue_depth': DEEP}
    ros.start('camera', source=SCENE.format(20), autostart=False, **play)
    for number in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
        ros.settle()
        request = ChangeState.Request(transition=Transition(id=number))
        assert ros.call(ChangeState, 'camera/change_state', request).success
    assert ros.spin(lambda: len(tracks) == 600), f'{len(tracks)} of 600; {ros.outputs()}'
    times = [stamp(message)[0] * 10**9 + stamp(message)[1] for message in tracks]
    np.testing.assert_allclose(np.diff(times), 1e9 / 30, atol=1)
    assert [info.header for info in infos] == [t.header for t in tracks]
    assert max(t.width for t in tracks) == 5


@pytest.mark.alone
def test_by_best_effort_as_the_nodes_come_most_frames_arrive(ros):
    """Without our transport profile more than 80 % are lost."""
    answers = ros.listen(PointCloud2, 'detections')
    ros.start('detector')
    assert ros.spin(lambda: ros.node.count_publishers('detections') == 1), ros.outputs()
    ros.settle()
    camera = {'wait_for_subscribers': 1, 'exit_at_end': True}
    assert ros.start('camera', source=LARGE.format(3), **camera).end() == 0
    ros.spin(lambda: len(answers) == 90, 1.0)
    assert len(answers) > 60, ros.outputs()


def test_the_tracks_do_not_depend_on_how_fast_a_recording_is_played(ros):
    played = []
    for rate in (-1.0, 60.0):
        topic = f'tracks{len(played)}'
        tracks = ros.listen(PointCloud2, topic)
        nodes = start_two(ros, tracks, topic)
        waiting = {'wait_for_subscribers': 1, 'image_queue_depth': DEEP, 'exit_at_end': True}
        camera = ros.start('camera', source=SCENE.format(4), rate=rate, **waiting)
        assert ros.spin(lambda tracks=tracks: len(tracks) == 120), f'{len(tracks)} {ros.outputs()}'
        assert camera.end() == 0
        played.append([message.data.tobytes() for message in tracks])
        assert [node.stop() for node in nodes] == [0, 0]
        assert ros.spin(lambda: ros.node.count_publishers('detections') == 0)
    assert played[0] == played[1]


def test_the_pipeline_gives_what_the_three_nodes_give(ros):
    source = SCENE.format(4)
    apart = ros.listen(PointCloud2, 'tracks')
    start_three(ros, apart, source)
    assert ros.spin(lambda: len(apart) == 120), ros.outputs()
    for process in ros.processes:
        process.stop()
    together = ros.listen(PointCloud2, 'one/tracks')
    detections = ros.listen(PointCloud2, 'one/detections')
    path = ros.folder / 'pipeline.yaml'
    path.write_text(
        '/**/camera:\n  ros__parameters:\n'
        f'    source: {source}\n    wait_for_subscribers: 1\n    exit_at_end: true\n'
    )
    pipeline = ros.start('pipeline', '-r', '__ns:=/one', '--params-file', str(path), *ALL, *SIZE)
    assert ros.spin(lambda: ros.node.count_publishers('one/tracks') == 1), ros.outputs()
    assert ros.spin(lambda: {'camera', 'detector', 'tracker'} <= set(ros.node.get_node_names()))
    ros.settle()
    ros.start('overlay', '-r', '__ns:=/one')
    assert ros.spin(lambda: len(together) == len(detections) == 120), ros.outputs()
    assert pipeline.end() == 0, pipeline.output
    assert [stamp(m) for m in detections] == [stamp(m) for m in together]
    for one, other in zip(apart, together, strict=True):
        np.testing.assert_array_equal(tracks_of_cloud(one).rows, tracks_of_cloud(other).rows)


FIVE = 'scene:five?width=320&height=240&rate=30&duration=4'
ARRIVING = (*range(100), 100, 101, 103, 102, 104, *range(105, 120))
DISORDERED = f"""
import sys
import rclpy
from colortrack_ros.nodes import camera, pipeline
from colortrack_ros.sources import open_source

class Disordered:
    live, period, lost = False, 33_333_333, 0

    def __init__(self, *_):
        frames = list(open_source({FIVE!r}))
        self.frames = iter([frames[k] for k in {ARRIVING!r}])

    def read(self):
        return next(self.frames, None)

    def close(self):
        pass

camera.open_source = Disordered
sys.exit(pipeline.main())
"""
"""The pipeline, with a source that gives pictures in the order ARRIVING."""


def rows(messages) -> list[bytes]:
    return [message.data.tobytes() for message in messages]


@pytest.mark.parametrize(('window', 'count'), [(0.0, 119), (2.0, 120)])
def test_late_frames_give_the_same_tracks_in_pipeline_nodes_and_replay(
    ros, tmp_path, window, count
):
    # there is no CameraInfo here that tells the size
    options = ['-p', f'reorder_window:={window}', *ALL, '-p', 'image_size:=[320, 240]']
    images = frames(FIVE, 100 * 10**9)
    bag = write_bag(tmp_path / 'run', {'/camera/image_raw': [images[k] for k in ARRIVING]})
    assert main([str(bag), '--output', str(tmp_path / 'new'), *options]) == 0
    replayed = [m.content for m in of_topic(tmp_path / 'new', '/tracks')]
    assert len(replayed) == count
    assert max(message.width for message in replayed) >= 2

    together = ros.listen(PointCloud2, 'one/tracks')
    waiting = ['-p', 'wait_for_subscribers:=1', '-r', '__ns:=/one']
    pipeline = ros.start_code(DISORDERED, *options, *waiting)
    assert ros.spin(lambda: ros.node.count_publishers('one/tracks') == 1), ros.outputs()
    ros.settle()
    ros.listen(Image, 'one/camera/image_raw')
    assert ros.spin(lambda: len(together) == count), f'{len(together)}; {ros.outputs()}'
    assert 'afresh' not in pipeline.output
    assert rows(together) == rows(replayed)

    apart = ros.listen(PointCloud2, 'tracks')
    ros.start('tracker', *options)
    ros.start('detector', *options, '-p', RELIABLE)
    publisher = ros.node.create_publisher(Image, 'camera/image_raw', 200)
    black = image_of_frame(Frame(np.zeros((240, 320, 3), np.uint8)))
    while not apart:  # what is sent before the nodes have found each other is lost
        publisher.publish(black)
        ros.spin(lambda: bool(apart), 2.0)
    ros.settle()
    for k in ARRIVING:
        publisher.publish(images[k])

    def answers() -> list:
        return [message for message in apart if message.header.stamp.sec]  # not those to the black

    assert ros.spin(lambda: len(answers()) == count), f'{len(answers())}; {ros.outputs()}'
    assert rows(answers()) == rows(replayed)


def test_a_recording_that_ends_within_the_window_loses_no_frame(ros):
    tracks = ros.listen(PointCloud2, 'tracks')
    options = ['-p', 'reorder_window:=2.0', '-p', 'camera:exit_at_end:=true']
    options += ['-p', 'camera:wait_for_subscribers:=1', '-p', f'source:={FIVE}']
    pipeline = ros.start('pipeline', *options, *ALL)
    assert ros.spin(lambda: ros.node.count_publishers('tracks') == 1), ros.outputs()
    ros.settle()
    ros.listen(Image, 'camera/image_raw')
    assert ros.spin(lambda: len(tracks) == 120), f'{len(tracks)}; {ros.outputs()}'
    assert pipeline.end() == 0, pipeline.output


def test_a_pipeline_tells_what_has_no_effect_in_it_and_nothing_of_what_other_nodes_take(ros):
    given = ('image_transport:=compressed', 'red.tolerance:=20.0', 'process_noise:=9.0', 'typo:=1')
    pipeline = ros.start('pipeline', *(word for text in given for word in ('-p', text)))
    pipeline.wait_for('image_transport is compressed, which has no effect in the pipeline')
    pipeline.wait_for('gives /camera')
    refused = [line for line in pipeline.output.splitlines() if 'refused' in line]
    assert [': typo: no such' in line for line in refused] == [True] * 3, pipeline.output
    assert 'camera]: Parameters of other nodes: image_transport, process_noise, red.tolerance.' in (
        pipeline.output
    )
