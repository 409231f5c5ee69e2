"""Playing a bag against the live nodes: what comes out is what replay gives, at any speed."""

from pathlib import Path
import threading

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
from player import Player
import pytest
from recorded import frames
from recorded import NAMES
from recorded import of_topic
from recorded import read_bag
from recorded import write_bag
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.bags import BagWriter
from colortrack_ros.bags import canonical
from colortrack_ros.data import TRACK
from colortrack_ros.messages import stamp_of
from colortrack_ros.nodes.replay_run import replay

SCENE = 'scene:five?width=320&height=240&rate=6&duration=8'
START = 1_600_000_000_123_456_789
TOPICS = {'/tracks': PointCloud2, '/tracks/markers': MarkerArray}
PARAMS = """/**:
  ros__parameters:
    use_sim_time: true
    queue_depth: 1000
    image_queue_depth: 1000
    reorder_window: 0.4
    max_lag: 60.0
    qos_overrides./camera/image_raw.subscription.reliability: reliable
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
    return {(s.name, s.level, s.message) for array in messages for s in array.status}


@pytest.fixture
def bag(tmp_path):
    """Images, of which some stand behind others, also where the bag will be paused."""
    images = frames(SCENE, START)
    for k in (10, 20, PAUSE - 1):
        images[k : k + 2] = images[k + 1], images[k]
    return write_bag(tmp_path / 'run', {'/camera/image_raw': images})


def test_pauses_and_speeds_change_nothing_and_a_loop_restarts_once(ros, bag, tmp_path):
    params = tmp_path / 'robot.yaml'
    params.write_text(PARAMS)
    options = ['--params-file', str(params)]
    live: dict[str, list] = {topic: [] for topic in TOPICS}
    for topic, kind in TOPICS.items():
        ros.node.create_subscription(kind, topic, live[topic].append, 1000, raw=True)
    detector, tracker = (ros.start(name, *options) for name in ('detector', 'tracker'))
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    what = 'use_sim_time is true, but nobody publishes /clock, as `ros2 bag play --clock` does'
    for name in ('/detector', '/tracker'):
        wanted = name, DiagnosticStatus.WARN, what
        assert ros.spin(lambda wanted=wanted: wanted in levels(diagnostics)), diagnostics
    player = Player(ros, bag)
    assert ros.spin(lambda: player.heard), ros.outputs()
    assert ros.spin(lambda: all(ros.node.count_publishers(t) for t in TOPICS)), ros.outputs()
    ros.spin(lambda: False, 1.0)

    player.play(20.0)
    player.play(20.0, 0, PAUSE)
    player.pause(1.0)  # for what is on its way
    before = len(live['/tracks'])
    diagnostics.clear()
    player.pause(2.2)
    assert len(live['/tracks']) == before
    assert {level for _, level, _ in levels(diagnostics[-2:])} == {DiagnosticStatus.OK}
    stamps = [stamp_of(message.header) for message in diagnostics]
    assert max(stamps) == player.now
    player.play(0.5, PAUSE, PAUSE + 3)
    player.play(20.0, PAUSE + 3)
    player.play(100.0)
    player.end()
    assert ros.spin(lambda: all(len(m) == 3 * 48 for m in live.values())), ros.outputs()

    looped(bag, tmp_path / 'loops')
    new = tmp_path / 'new'
    assert replay([str(tmp_path / 'loops'), '--output', str(new), *options], threading.Event()) == 0
    for topic, kind in TOPICS.items():
        sent = [canonical(cdr, NAMES[kind]) for cdr in live[topic]]
        assert [m.cdr for m in of_topic(new, topic)] == sent, topic
    markers = [m for array in of_topic(new, '/tracks/markers') for m in array.content.markers]
    assert [m.action for m in markers].count(Marker.DELETEALL) == 2
    assert tracker.output.count('started afresh') == 2
    tracks = [np.frombuffer(m.content.data, TRACK) for m in of_topic(new, '/tracks')]
    assert max(len(rows) for rows in tracks) == 4
    assert max(rows['age'].max(initial=0.0) for rows in tracks) < 8.1
    assert [process.stop() for process in (detector, tracker)] == [0, 0]
