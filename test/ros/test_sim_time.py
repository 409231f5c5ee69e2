"""Playing a bag against the live nodes: what comes out is what replay gives, at any speed."""

from pathlib import Path
import threading

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2
from support.player import Player
from support.recorded import frames
from support.recorded import NAMES
from support.recorded import of_topic
from support.recorded import read_bag
from support.recorded import write_bag
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.bags import BagWriter
from colortrack_ros.bags import canonical
from colortrack_ros.data import TRACK
from colortrack_ros.messages import stamp_of
from colortrack_ros.replay.command import replay

SCENE = 'scene:five?width=320&height=240&rate=6&duration=8'
START = 1_600_000_000_123_456_789
TRACKERS = {'tracker': '/tracks', 'window_tracker': '/windows', 'contour_tracker': '/contours'}
"""The topic of each tracker's tracks; its markers are beneath."""
KINDS = {'': PointCloud2, '/markers': MarkerArray}
PARAMS = """/**:
  ros__parameters:
    use_sim_time: true
    queue_depth: 1000
    reorder_window: 0.4
""" + ''.join(
    f"""/**/{node}:
  ros__parameters:
    image_queue_depth: 1000
    max_lag: 60.0
    qos_overrides./camera/image_raw.subscription.reliability: reliable
"""
    for node in ('detector', 'window_tracker', 'contour_tracker')
)
PARAMS += """/**/tracker:
  ros__parameters:
    max_lag: 60.0
    image_size: [320, 240]
/**/window_tracker:
  ros__parameters:
    detections_topic: detections
    tracks_topic: windows
    markers_topic: windows/markers
/**/contour_tracker:
  ros__parameters:
    tracks_topic: contours
    markers_topic: contours/markers
"""
PAUSE = 30
"""The number of the image before which the bag is paused."""


def looped(bag: Path, path: Path) -> Path:
    """The bag of somebody who records three loops of a bag."""
    writer = BagWriter(path, {'/camera/image_raw': 'sensor_msgs/msg/Image'})
    for log_time, message in enumerate(read_bag(bag) * 3):
        writer.write('/camera/image_raw', log_time, message.cdr)
    writer.close()
    return path


def levels(messages: list) -> set:
    return {
        (f'/{s.name.partition(":")[0]}', s.level, s.message)
        for array in messages
        for s in array.status
    }


@pytest.fixture
def bag(tmp_path):
    """Images, of which some stand behind others, also where the bag will be paused."""
    images = frames(SCENE, START)
    for k in (10, 20, PAUSE - 1):
        images[k : k + 2] = images[k + 1], images[k]
    return write_bag(tmp_path / 'run', {'/camera/image_raw': images})


def assert_two_restarts(bag, topic):
    """Objects are tracked, and the tracks of each loop end with it."""
    after_first = of_topic(bag, f'{topic}/markers')[1:]
    markers = [m for a in after_first for m in a.content.markers]
    assert [m.action for m in markers].count(Marker.DELETEALL) == 2
    tracks = [np.frombuffer(m.content.data, TRACK) for m in of_topic(bag, topic)]
    assert max(len(rows) for rows in tracks) >= 3, topic
    assert max(rows['age'].max(initial=0.0) for rows in tracks) < 8.1


def nodes_that_wait(ros, options):
    """The processes, which have said that nobody publishes /clock, and their diagnostics."""
    processes = {name: ros.start(name, *options) for name in ('detector', *TRACKERS)}
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    what = 'use_sim_time is true, but nobody publishes /clock, as `ros2 bag play --clock` does'
    wanted = {(f'/{name}', DiagnosticStatus.WARN, what) for name in processes}
    assert ros.spin(lambda: wanted <= levels(diagnostics)), diagnostics
    return processes, diagnostics


def player_of(ros, bag, topics):
    """One whom all hear, once all topics are there."""
    player = Player(ros, bag)
    assert ros.spin(lambda: player.subscribers == 3), ros.outputs()
    assert ros.spin(lambda: all(ros.node.count_publishers(t) for t in topics)), ros.outputs()
    ros.spin(lambda: False, 1.0)
    return player


@pytest.mark.alone
@pytest.mark.slow
def test_pauses_and_speeds_change_nothing_and_a_loop_restarts_once(ros, bag, tmp_path):
    params = tmp_path / 'robot.yaml'
    params.write_text(PARAMS)
    options = ['--params-file', str(params)]
    kinds = {f'{t}{end}': kind for t in TRACKERS.values() for end, kind in KINDS.items()}
    live: dict[str, list] = {topic: [] for topic in kinds}
    for topic, kind in kinds.items():
        ros.node.create_subscription(kind, topic, live[topic].append, 1000, raw=True)
    processes, diagnostics = nodes_that_wait(ros, options)
    player = player_of(ros, bag, kinds)
    player.play(20.0)
    player.play(20.0, 0, PAUSE)
    while (before := len(live['/tracks'])) != (player.pause(1.0), len(live['/tracks']))[1]:
        pass  # what is still on its way
    diagnostics.clear()
    player.pause(2.2)
    assert len(live['/tracks']) == before
    last = levels(diagnostics[-4:])
    assert {level for _, level, _ in last} == {DiagnosticStatus.OK}, last
    assert max(stamp_of(message.header) for message in diagnostics) == player.now
    player.play(0.5, PAUSE, PAUSE + 3)
    player.play(20.0, PAUSE + 3)
    player.play(100.0)
    player.end()
    complete = ros.spin(lambda: all(len(m) == 3 * 48 for m in live.values()))
    assert complete, ({t: len(m) for t, m in live.items()}, ros.outputs())

    looped(bag, tmp_path / 'loops')
    for name, topic in TRACKERS.items():
        new = tmp_path / name
        arguments = [str(tmp_path / 'loops'), '--tracker', name, '--output', str(new), *options]
        assert replay(arguments, threading.Event()) == 0
        for end, kind in KINDS.items():
            sent = [canonical(cdr, NAMES[kind]) for cdr in live[topic + end]]
            assert [m.cdr for m in of_topic(new, topic + end)] == sent, topic + end
        assert_two_restarts(new, topic)
        assert processes[name].output.count('started afresh') == 2
    assert {name: p.stop() for name, p in processes.items()} == dict.fromkeys(processes, 0)
