import itertools
import resource
import signal
import time

import pytest
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from support.ros_domain import executable

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
SOURCE = 'scene:single?width=320&height=240'
APART = ('camera', 'detector', 'tracker', 'overlay', 'window_tracker', 'contour_tracker', 'locator',
         'follower', 'simulator')  # fmt: skip


def test_a_signal_ends_a_node_in_order_with_status_0_and_no_traceback(ros):
    """A node that takes longer than it may ends with status 124, as the test below tells."""
    source = ('-p', f'camera:source:={SOURCE}', '-p', 'camera:loop:=true')
    arguments = dict.fromkeys(APART, source) | {'pipeline': (*source, '-r', '__ns:=/one')}
    processes = [
        ros.start_command(name, [executable(name), '--ros-args', *words])
        for name, words in arguments.items()
    ]
    names = {(name, '/') for name in APART} | {(n, '/one') for n in ('camera', 'tracker')}
    there = ros.spin(lambda: names <= set(ros.node.get_node_names_and_namespaces()))
    assert there, ros.outputs()
    for process in processes:
        process.wait_for('gives ')
    ros.spin(lambda: False, 0.5)
    for process, number in zip(processes, itertools.cycle(SIGNALS)):
        used = process.work(), of_children()
        assert process.stop(number) == 0, (number.name, process.output)
        assert of_children() - used[1] - used[0] < 1.0, process.log.name
        assert 'Traceback' not in process.output
        assert 'rror' not in process.output


def of_children() -> float:
    """Processor time [s] of all that this process has started and that has ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def test_a_node_that_cannot_write_logs_says_what_to_set(ros, monkeypatch):
    """As a service without HOME, or on a read-only disk."""
    monkeypatch.setenv('ROS_LOG_DIR', '/dev/null/log')
    process = ros.start_command('tracker', [executable('tracker')])
    assert process.end() == 1
    (line,) = process.output.strip().splitlines()
    assert line.startswith('colortrack_ros: failed to initialize logging')
    assert line.endswith('; set ROS_LOG_DIR to a folder that can be written to')


BUSY = """
import gc
from rclpy.node import Node
from colortrack_ros.node_kit.runtime import run

class Busy(Node):
    def __init__(self, finish):
        super().__init__('busy')
        self.calls, self.finish = 0, finish
        self.create_timer(1e-4, self.call)

    def call(self):
        self.calls += 1
        if self.calls == 500:
            self.held = len(gc.get_objects())
        if self.calls == 2500:
            print(len(gc.get_objects()) - self.held, 'kept of 2000 callbacks', flush=True)
            self.finish(0)

raise SystemExit(run(lambda finish: [Busy(finish)]))
"""


def test_a_node_keeps_nothing_of_the_callbacks_that_it_has_done(ros):
    process = ros.start_code(BUSY)
    assert process.end() == 0, process.output
    assert int(process.output.split(' kept of')[0]) < 200


HANGING = """
import time
from rclpy.node import Node
from colortrack_ros.node_kit.runtime import run

class Hanging(Node):
    def close(self):
        time.sleep(60.0)

raise SystemExit(run(lambda _: [Hanging('hanging', namespace='robot1')]))
"""


def test_a_node_that_does_not_end_is_named_and_tells_by_its_status(ros):
    process = ros.start_code(HANGING, patient=False)
    assert ros.spin(lambda: 'hanging' in ros.node.get_node_names()), ros.outputs()
    start_of_end = time.monotonic()
    assert process.stop(signal.SIGTERM) == 124, process.output
    assert 1.5 < time.monotonic() - start_of_end < 50.0, 'it would sleep for 60 s'
    told = 'close() of /robot1/hanging has not ended 1.5 s after a signal: the process ends now'
    assert process.output.splitlines()[-1] == f'colortrack_ros: {told}'


def test_more_signals_while_a_node_ends_do_not_make_a_death_of_its_end(ros):
    """Such as a second Ctrl-C, or SIGTERM from who waits no longer."""
    process = ros.start('tracker')
    process.wait_for('gives ')
    for number in itertools.cycle(SIGNALS):
        process.popen.send_signal(number)
        if process.popen.poll() is not None:
            break
        time.sleep(0.02)
    assert process.end() == 0, process.output
    assert 'Traceback' not in process.output


LINGERING = """
from pathlib import Path
import time
from colortrack_ros.nodes.tracker import TrackerNode
from colortrack_ros.node_kit.runtime import run

def make(finish):
    node = TrackerNode()
    node.create_timer(1.0, lambda: finish(0) if {by_itself} else None)
    return [node]

run(make)
threads = sorted(path.read_text().strip() for path in Path('/proc/self/task').glob('*/comm'))
print('left with', *[name for name in threads if 'dds.udp' in name], flush=True)
time.sleep(60.0)
"""


@pytest.mark.parametrize('by_itself', [False, True])
def test_a_process_whose_python_does_not_end_has_left_ros_and_is_ended_by_the_system(
    ros, by_itself
):
    process = ros.start_code(LINGERING.format(by_itself=by_itself), patient=False)
    process.wait_for('gives ')
    start_of_end = time.monotonic()
    if not by_itself:
        process.popen.send_signal(signal.SIGTERM)
    process.wait_for('left with')
    assert 'left with\n' in process.output
    assert process.stop(signal.SIGTERM) == -signal.SIGALRM, process.output
    assert 4.0 < time.monotonic() - start_of_end < 50.0, 'it would sleep for 60 s'


def test_other_topic_names_a_params_file_and_a_namespace(ros):
    path = ros.folder / 'robot.yaml'
    path.write_text(
        '/**:\n'
        '  ros__parameters:\n'
        '    image_topic: eye/picture\n'
        '    detections_topic: eye/blobs\n'
        '    tracks_topic: /all/tracks\n'
        '/**/camera:\n'
        '  ros__parameters:\n'
        '    source: scene:single?width=320&height=240\n'
        '    loop: true\n'
        '    camera_info_topic: eye/info\n'
    )
    tracks = ros.listen(PointCloud2, '/all/tracks')
    pictures = ros.listen(Image, '/robot1/eye/remapped', reliable=False)
    for name in ('tracker', 'detector', 'camera', 'overlay'):
        arguments = ['--params-file', str(path), '-r', '__ns:=/robot1']
        if name == 'overlay':
            arguments += ['-r', 'overlay/image_raw:=eye/remapped']
        ros.start(name, *arguments)
    assert ros.spin(lambda: len(tracks) > 20 and len(pictures) > 5), ros.outputs()
    assert any(message.width == 1 for message in tracks)

    def names() -> set[str]:
        return {topic for topic, _ in ros.node.get_topic_names_and_types()}

    own = {'/robot1/eye/picture', '/robot1/eye/blobs', '/robot1/eye/info'}
    assert ros.spin(lambda: own <= names()), names()
    assert not {'/camera/image_raw', '/detections', '/tracks'} & names()


def test_a_node_says_at_its_start_what_it_will_do(ros):
    source = 'scene:single'
    told = {
        'camera': [f'source {source}; rate 0.0; ', 'gives /camera/camera_info, /camera/image_raw'],
        'detector': [
            "colors ['",
            'takes /camera/camera_info, /camera/image_raw; gives /detections',
        ],
        'tracker': ['takes /camera/camera_info, /detections; gives /tracks, /tracks/markers'],
    }
    for name, texts in told.items():
        process = ros.start(name, source=source) if name == 'camera' else ros.start(name)
        process.wait_for('gives ')
        (line,) = (line for line in process.output.splitlines() if 'gives ' in line)
        assert '[INFO]' in line
        assert all(text in line for text in texts), line
