"""What happens to nodes on a robot: sources that go, processes that die, messages that lie."""

import http.server
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time

import cv2
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import compressed_of_frame
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import stamp_of
from colortrack_ros.scenes import detections_of
from colortrack_ros.scenes import open_scene

SCENE = open_scene('five?width=320&height=240')


class Stream(http.server.BaseHTTPRequestHandler):
    """An MJPEG stream of 25 frames a second, as network cameras have."""

    def do_GET(self):
        self.send_response(200)
        self.send_header('Content-Type', 'multipart/x-mixed-replace; boundary=next')
        self.end_headers()
        try:
            for k in range(100_000):
                jpeg = cv2.imencode('.jpg', SCENE.render(k % len(SCENE)))[1].tobytes()
                head = f'--next\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n'
                self.wfile.write(head.encode() + jpeg + b'\r\n')
                time.sleep(0.04)
        except OSError:
            pass

    def log_message(self, *_):
        pass


def serve(port: int) -> subprocess.Popen:
    """The stream from a process of its own, so that killing it cuts the connections."""
    code = (
        'import sys, http.server; sys.path[:0] = sys.argv[2:]\n'
        'from test_faults import Stream\n'
        "http.server.ThreadingHTTPServer(('127.0.0.1', int(sys.argv[1])), Stream).serve_forever()"
    )
    folders = [os.path.dirname(__file__)]
    return subprocess.Popen([sys.executable, '-c', code, str(port), *folders])


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(('127.0.0.1', 0))
        return listener.getsockname()[1]


def test_a_stream_that_goes_and_comes_back_is_taken_up_again(ros):
    port = free_port()
    server = serve(port)
    try:
        images = ros.listen(Image, 'camera/image_raw', reliable=False)
        events = ros.listen(ParameterEvent, '/parameter_events')
        diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
        time.sleep(2.0)
        camera = ros.start('camera', source=f'http://me:secret@127.0.0.1:{port}/stream.mjpg')
        assert ros.spin(lambda: len(images) > 10, 30.0), ros.outputs()
        server.kill()
        server.wait()
        assert ros.spin(lambda: 'Next try in' in camera.output, 20.0), ros.outputs()
        ros.spin(lambda: False, 2.0)
        count = len(images)
        server = serve(port)
        assert ros.spin(lambda: len(images) > count + 10, 30.0), ros.outputs()
        stamps = np.array([stamp_of(image.header) for image in images])
        assert (np.diff(stamps) > 0).all()
        assert abs(time.time_ns() - stamps[-1]) < 3e9
        assert any('failed' in str(message) for message in diagnostics)
        request = GetParameters.Request(names=['source'])
        shown = ros.call(GetParameters, 'camera/get_parameters', request).values[0].string_value
        assert shown == f'http://me:***@127.0.0.1:{port}/stream.mjpg'
        assert 'secret' not in camera.output + str(events) + str(diagnostics)
        assert camera.stop() == 0
    finally:
        server.kill()


def test_any_node_can_be_killed_and_started_again(ros):
    tracks = ros.listen(PointCloud2, 'tracks')
    source = 'scene:five?width=320&height=240'
    arguments = {'camera': {'source': source, 'loop': 'true'}, 'detector': {}, 'tracker': {}}
    running = {name: ros.start(name, **arguments[name]) for name in arguments}
    assert ros.spin(lambda: len(tracks) > 10), ros.outputs()
    chance = random.Random(7)
    for _ in range(20):
        name = chance.choice(list(running))
        running[name].popen.kill()
        running[name].popen.wait()
        others = [process for other, process in running.items() if other != name]
        ros.spin(lambda: False, 0.3)  # what was still on its way
        tracks.clear()
        running[name] = ros.start(name, **arguments[name])
        assert ros.spin(lambda: len(tracks) > 3), f'{name} killed; {ros.outputs()}'
        assert all(process.popen.poll() is None for process in others), ros.outputs()
    assert [process.stop() for process in running.values()] == [0, 0, 0]
    assert all('Traceback' not in process.output for process in running.values())


def mutations(messages: list, count: int, seed: int) -> list[bytes]:
    """Serialized messages with bytes changed, cut out and put in."""
    chance = random.Random(seed)
    originals = [bytes(serialize_message(message)) for message in messages]
    mutated = []
    for _ in range(count):
        cdr = bytearray(chance.choice(originals))
        for _ in range(chance.randint(1, 6)):
            at = chance.randrange(4, min(len(cdr), 900))
            kind = chance.random()
            if kind < 0.7:
                cdr[at] = chance.choice([0, 1, 127, 255, chance.randrange(256)])
            elif kind < 0.85:
                del cdr[at : at + chance.randint(1, 40)]
            else:
                cdr[at:at] = chance.randbytes(chance.randint(1, 40))
            if len(cdr) < 20:
                break
        mutated.append(bytes(cdr))
    return mutated


def lies(good, changes: dict) -> list:
    """Copies of a message, each with one field changed."""
    copies = []
    for name, values in changes.items():
        for value in values:
            copy = type(good)(**{f: getattr(good, f) for f in good.get_fields_and_field_types()})
            if name == 'stamp':
                copy.header = type(good.header)(frame_id='x')
                copy.header.stamp.sec = value
            else:
                setattr(copy, name, value)
            copies.append(copy)
    return copies


FRAME = Frame(SCENE.render(250)[100:130, 100:140].copy(), 'bgr8', 10**18)
WRONG_IMAGE = {
    'width': [0, 1, 2**31],
    'height': [0, 1, 2**31],
    'step': [0, 1, 2**31],
    'encoding': ['', 'mono16', 'bgr8x'],
    'data': [b'', b'12'],
    'stamp': [-(2**31), -62135596800 % 2**31, 4102444800 - 2**31],
}
WRONG_CLOUD = {
    'width': [0, 1, 2**31],
    'height': [0, 2, 2**31],
    'point_step': [0, 1, 73],
    'row_step': [0, 1],
    'fields': [[]],
    'data': [b'', b'12'],
    'is_bigendian': [True],
    'stamp': [-(2**31), 4102444800 - 2**31],
}
ROWS = detections_of(SCENE, 250)


def subscription(node: str):
    """Topic, type, good message, what comes out, and lies, of each subscription of a node."""
    image = image_of_frame(FRAME)
    cloud = cloud_of_detections(Detections(ROWS.rows, 10**18))
    return {
        'detector': ('camera/image_raw', Image, image, 'detections', lies(image, WRONG_IMAGE)),
        'tracker': ('detections', PointCloud2, cloud, 'tracks', lies(cloud, WRONG_CLOUD)),
        'compressed': (
            'camera/image_raw/compressed',
            CompressedImage,
            compressed_of_frame(FRAME, 90),
            'detections',
            lies(
                compressed_of_frame(FRAME, 90), {'data': [b'', b'1234'], 'stamp': [-1, 2**31 - 1]}
            ),
        ),
    }[node]


def memory(process) -> int:
    """Resident memory [bytes]."""
    with open(f'/proc/{process.popen.pid}/statm') as file:
        return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')


@pytest.mark.parametrize('node', ['detector', 'tracker', 'compressed'])
def test_ten_thousand_mutated_messages_do_no_harm(ros, node):
    topic, kind, good, out, wrong = subscription(node)
    transport = {'image_transport': 'compressed'} if node == 'compressed' else {}
    process = ros.start('tracker' if node == 'tracker' else 'detector', **transport)
    answers = ros.listen(PointCloud2, out)
    publisher = ros.node.create_publisher(kind, topic, 1000)
    assert ros.spin(lambda: publisher.get_subscription_count() == 1), ros.outputs()
    ros.settle()
    mutated = [bytes(serialize_message(message)) for message in wrong]
    mutated += mutations([good, *wrong], 10_000, seed=3)
    before = 0
    for number, cdr in enumerate(mutated):
        publisher.publish(cdr)
        if number % 50 == 0:
            ros.executor.spin_once(timeout_sec=0.0)
            time.sleep(0.005)
        if number == 2000:
            before = memory(process)
    ros.spin(lambda: False, 1.0)
    assert process.popen.poll() is None, process.output
    assert memory(process) < before + 64 * 2**20
    answers.clear()
    good.header.stamp.sec = 2**31 - 10
    publisher.publish(good)
    assert ros.spin(lambda: any(m.header == good.header for m in answers)), process.output[-3000:]
    assert process.output.count('Traceback') == 0, process.output
    own = [line for line in process.output.splitlines() if line.startswith('[')]
    assert len(own) < 30, process.output
    assert process.stop() == 0


@pytest.mark.parametrize('name', ['camera', 'detector', 'tracker', 'overlay'])
def test_a_signal_during_the_start_ends_the_node_in_order(ros, name):
    chance = random.Random(name)
    for _ in range(6):
        process = ros.start(name, source='scene:single?width=320&height=240')
        time.sleep(0.25 + chance.random())
        start = time.monotonic()
        status = process.stop(chance.choice([signal.SIGINT, signal.SIGTERM]))
        assert time.monotonic() - start < 4.0
        # Before our own code runs, Python itself ends as it does for every program.
        started = 'Traceback' not in process.output
        assert status == 0 or not started or status in (-signal.SIGINT, -signal.SIGTERM)


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
        assert ros.spin(lambda: len(ages) > 40, 30.0), ros.outputs()
        # of the frame when the work on it began; the median, since machines are shared
        assert np.median(ages[10:]) < 0.15
    finally:
        slow.send_signal(signal.SIGINT)
        assert slow.wait(timeout=10.0) == 0


def test_threads_files_and_memory_stay(ros):
    path = ros.folder / 'pipeline.yaml'
    path.write_text(
        '/**/camera:\n  ros__parameters:\n'
        '    source: scene:five?width=160&height=120\n    loop: true\n    rate: -1.0\n'
    )
    pipeline = ros.start('pipeline', '--params-file', str(path))
    tracks = ros.listen(PointCloud2, 'tracks')
    assert ros.spin(lambda: len(tracks) > 2000, 60.0), ros.outputs()

    def held() -> tuple[int, int]:
        folder = f'/proc/{pipeline.popen.pid}'
        return len(os.listdir(f'{folder}/task')), len(os.listdir(f'{folder}/fd'))

    before, resident = held(), memory(pipeline)
    tracks.clear()
    assert ros.spin(lambda: len(tracks) > 6000, 120.0), ros.outputs()
    assert held() == before
    assert memory(pipeline) < resident + 2 * 2**20
    assert threading.active_count() < 20
