"""What happens to nodes on a robot: sources that go, processes that die, messages that lie."""

import os
import random
import signal
import subprocess
import sys
import threading
import time

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from support.ros_domain import remove_orphans
from support.ros_domain import segments
from support.waiting import PATIENCE
from support.waiting import slowness
from support.waiting import wait_until

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import stamp_of

OUTPUTS = {'camera': 'camera/image_raw', 'detector': 'detections', 'tracker': 'tracks'}


@pytest.mark.slow
def test_tests_remove_the_shared_memory_of_killed_nodes_alone(ros):
    lives, killed = ros.start('detector'), ros.start('tracker')
    wait_until(lambda: segments(lives.popen.pid) and segments(killed.popen.pid))
    of_living, of_killed = segments(lives.popen.pid), segments(killed.popen.pid)
    killed.popen.kill()
    killed.end()
    wait_until(lambda: remove_orphans() or not any(path.exists() for path in of_killed))
    assert all(path.exists() for path in of_living)


@pytest.mark.slow
def test_any_node_can_be_killed_and_started_again(ros):
    """Tracks flow within 2 s after the new node is there; starting Python comes before that."""
    tracks = ros.listen(PointCloud2, 'tracks')
    source = 'scene:five?width=320&height=240'
    arguments = {'camera': {'source': source, 'loop': 'true'}, 'detector': {}, 'tracker': {}}
    running = {name: ros.start(name, **arguments[name]) for name in arguments}
    assert ros.spin(lambda: len(tracks) > 10), ros.outputs()
    starting, flowing = [], []

    def publishers(name: str) -> set[bytes]:
        infos = ros.node.get_publishers_info_by_topic(OUTPUTS[name])
        return {bytes(info.endpoint_gid) for info in infos}

    for name in random.Random(7).sample([*running] * 3, 9):
        running[name].popen.kill()
        running[name].popen.wait()
        others = [process for other, process in running.items() if other != name]
        ros.spin(lambda: False, 0.3)  # what was still on its way
        tracks.clear()
        dead, start = publishers(name), time.monotonic()
        running[name] = ros.start(name, **arguments[name])
        assert ros.spin(lambda n=name, d=dead: bool(publishers(n) - d)), ros.outputs()
        there = time.monotonic()
        assert ros.spin(lambda: len(tracks) > 0), f'{name} killed; {ros.outputs()}'
        starting.append(there - start)
        flowing.append(time.monotonic() - there)
        assert ros.spin(lambda: len(tracks) > 3), f'{name} killed; {ros.outputs()}'
        assert all(process.popen.poll() is None for process in others), ros.outputs()
    print('started [s]', np.round(starting, 2), 'tracks after [s]', np.round(flowing, 2))
    assert np.median(flowing) < 2.0 * slowness()
    assert [process.stop() for process in running.values()] == [0, 0, 0]
    assert all('Traceback' not in process.output for process in running.values())


def handles_signals(process) -> bool:
    """Whether our own code runs: Python itself leaves SIGTERM to the system."""
    with open(f'/proc/{process.popen.pid}/status') as file:
        caught = next(line for line in file if line.startswith('SigCgt:'))
    return bool(int(caught.split()[1], 16) >> signal.SIGTERM - 1 & 1)


SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
SOURCE = 'scene:single?width=320&height=240'


@pytest.mark.parametrize('name', ['camera', 'detector', 'tracker', 'overlay'])
def test_a_signal_during_the_start_ends_the_node_in_order(ros, name):
    chance = random.Random(name)
    for k, number in enumerate(chance.sample(SIGNALS, len(SIGNALS))):
        process = ros.start(name, '-p', f'camera:source:={SOURCE}')
        if k:
            wait_until(lambda p=process: handles_signals(p), what=ros.outputs)
        time.sleep(0.5 * chance.random())
        assert process.popen.poll() is None, process.output
        ours = handles_signals(process)
        status = process.stop(number)
        if ours:
            assert (status, 'Traceback' in process.output) == (0, False), process.output
        else:  # Python itself ends as it does for every program
            by_python = number == signal.SIGINT and 'KeyboardInterrupt' in process.output
            assert status in (0, -number) or by_python, process.output


@pytest.mark.slow
def test_a_slow_detector_works_on_new_frames_and_counts_what_it_skips(ros):
    code = (
        'import time, colortrack_ros.detection as d\n'
        'class Slow(d.Detector):\n'
        '    def detect(self, frame):\n'
        '        time.sleep(0.1)\n'
        '        return super().detect(frame)\n'
        'd.Detector = Slow\n'
        'from colortrack_ros.nodes.detector import main\n'
        'raise SystemExit(main())\n'
    )
    env = dict(os.environ, ROS_DOMAIN_ID=str(ros.domain))
    slow = subprocess.Popen([sys.executable, '-c', code], env=env)
    try:
        ages: list[float] = []
        ros.node.create_subscription(
            PointCloud2,
            'detections',
            lambda m: ages.append(time.time() - 0.1 - stamp_of(m.header) * 1e-9),
            10,
        )
        ros.start('camera', source='scene:five?width=320&height=240&rate=30', loop='true')
        assert ros.spin(lambda: len(ages) > 40), ros.outputs()
        # of the frame when the work on it began; the median, since machines are shared
        assert np.median(ages[10:]) < 0.15 * slowness()
    finally:
        slow.send_signal(signal.SIGINT)
        assert slow.wait(timeout=PATIENCE) == 0


FAULTY = """
import sys
from colortrack_ros.nodes import {node}

made, calls = {node}.{what}, []

def fail_once(*given, **options):
    calls.append(given)
    return made(*given, **options) if len(calls) != 10 else 1 // 0

{node}.{what} = fail_once
sys.exit({node}.main())
"""


@pytest.mark.parametrize(
    ('node', 'what', 'topic', 'restarts'),
    [
        ('tracker', 'Tracker.update', 'detections', True),
        ('contour_tracker', 'ContourTracker.update', 'camera/image_raw', True),
        ('overlay', 'tracks_of_serialized_cloud', 'tracks', False),
    ],
)
def test_what_fails_on_a_message_is_refused_and_told_and_the_next_is_worked_on(
    ros, node, what, topic, restarts
):
    process = ros.start_code(FAULTY.format(node=node, what=what))
    picture = image_of_frame(Frame(np.zeros((48, 64, 3), np.uint8)))
    cloud = {'detections': cloud_of_detections(Detections()), 'tracks': cloud_of_tracks(Tracks())}
    message = cloud.get(topic, picture)
    publisher = ros.node.create_publisher(type(message), topic, 10)
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')

    def taken() -> float:
        values = (v for d in diagnostics for v in d.status[0].values)
        return sum(float(v.value) for v in values if v.key == 'rate in [Hz]')  # each second

    end = time.monotonic() + PATIENCE
    while taken() < 20:
        assert time.monotonic() < end, f'{taken()} taken; {ros.outputs()}'
        message.header.stamp.nanosec += 1_000_000
        publisher.publish(message)
        ros.spin(lambda: False, 0.05)
    assert process.output.count('please report it: ZeroDivisionError') == 1
    assert ('started afresh: ZeroDivisionError in an update' in process.output) == restarts
    assert process.stop() == 0


FAULTS_BESIDE_MESSAGES = """
import sys
from colortrack_ros.node_kit import diagnostics
from colortrack_ros.nodes import tracker

def fail(*given):
    return {}['beside']

judge, calls = diagnostics.Health._judge, []

def fail_once(*given):
    calls.append(given)
    return judge(*given) if len(calls) > 1 else fail()

tracker.Tracker.reset = fail
diagnostics.Health._judge = fail_once
sys.exit(tracker.main())
"""


def test_what_fails_in_a_timer_or_a_service_ends_no_node(ros):
    process = ros.start_code(FAULTS_BESIDE_MESSAGES)
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    assert ros.spin(lambda: diagnostics), ros.outputs()  # those of the next second
    assert not ros.call(Trigger, 'tracker/reset', Trigger.Request()).success

    def refused() -> set[str]:
        values = diagnostics[-1].status[0].values
        return {v.value for v in values if v.key == 'refused'}

    assert ros.spin(lambda: refused() == {'2'}), (refused(), ros.outputs())
    assert "please report it: KeyError: 'beside'" in process.output
    assert process.stop() == 0


@pytest.mark.slow
def test_threads_files_and_memory_stay(ros):
    path = ros.folder / 'pipeline.yaml'
    path.write_text(
        '/**/camera:\n  ros__parameters:\n'
        '    source: scene:five?width=160&height=120\n    loop: true\n    rate: -1.0\n'
    )
    pipeline = ros.start('pipeline', '--params-file', str(path))
    tracks = ros.listen(PointCloud2, 'tracks')
    assert ros.spin(lambda: len(tracks) > 1000, 5 * PATIENCE), ros.outputs()

    def held() -> tuple[int, int]:
        folder = f'/proc/{pipeline.popen.pid}'
        return len(os.listdir(f'{folder}/task')), len(os.listdir(f'{folder}/fd'))

    before, own = held(), pipeline.memory()
    tracks.clear()
    assert ros.spin(lambda: len(tracks) > 2000, 5 * PATIENCE), ros.outputs()
    assert held() == before
    assert pipeline.memory() < own + 2**20
    assert threading.active_count() < 20
