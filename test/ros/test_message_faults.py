"""Messages that lie on every subscription of every node: nothing dies, and each is reported."""

import contextlib
import signal

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import parameter_pages
import pytest
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from support.forks import program_of
from support.mutations import mutations
from support.packed import packed
from support.packed import UNPACKING
from support.paths import DATA
from support.ros_domain import Ros

from colortrack_ros.bags import BagReader
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import cloud_of_outlines
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import compressed_of_frame
from colortrack_ros.messages import image_of_frame
from colortrack_ros.scenes import detections_of
from colortrack_ros.scenes import open_scene

pytestmark = pytest.mark.slow

COUNT, DEPTH, TOGETHER = 10_000, 900, 30
"""Mutated messages on each subscription, how many wait at once, and, but for the first of those,
how many come in one."""

SCENE = open_scene('five?width=320&height=240')
STAMP = (2**31 - 10) * 10**9
FRAME = Frame(SCENE.render(250)[100:130, 100:140].copy(), 'bgr8', STAMP)
TAKERS = [n for n, table in parameter_pages.NODES.items() if 'image_transport' in table.specs]
"""The nodes that take images, raw or compressed."""

OUTLINED = Tracks(np.ones(2, TRACK), STAMP, 'cam', outlines=np.ones((2, 4, 2)))

GOOD = {
    '/raw/camera/image_raw': image_of_frame(FRAME),
    '/jpeg/camera/image_raw/compressed': compressed_of_frame(FRAME, 90),
    '/clouds/detections': cloud_of_detections(Detections(detections_of(SCENE, 250).rows, STAMP)),
    '/raw/tracks': cloud_of_tracks(Tracks(np.zeros(3, TRACK), STAMP)),
    '/lines/outlines': cloud_of_outlines(OUTLINED),
}
"""What is right on each topic."""

NEWEST = GOOD['/raw/tracks'].header.stamp

HEARD = {
    **{f'/raw/{name}': ['/raw/camera/image_raw'] for name in TAKERS},
    **{f'/jpeg/{name}': ['/jpeg/camera/image_raw/compressed'] for name in TAKERS},
    '/raw/overlay': ['/raw/camera/image_raw', '/raw/tracks'],
    '/clouds/tracker': ['/clouds/detections'],
    '/clouds/window_tracker': ['/clouds/detections'],
    '/clouds/camera': ['/clouds/detections'],
    '/lines/overlay': ['/lines/outlines'],
}
"""The topics that each node hears."""


def parameters(node: str) -> dict[str, object]:
    """So that each subscription hears its topic alone, and all can be counted."""
    namespace, _, name = node[1:].partition('/')
    values: dict[str, object] = {
        f'qos_overrides.{topic}.subscription.reliability': 'reliable' for topic in HEARD[node]
    }
    # pictures that wait for detections are no leak
    depths = ('queue_depth', *(['image_queue_depth'] if namespace != 'clouds' else []))
    for depth in depths:
        if depth in parameter_pages.NODES[name].specs:
            values[depth] = 1000
    if 'max_lag' in parameter_pages.NODES[name].specs:
        values['max_lag'] = 60.0
    if name in TAKERS:
        values['image_transport'] = 'compressed' if namespace == 'jpeg' else 'raw'
    if name in TAKERS and name != 'detector':
        values['tracks_topic'] = f'{name}/tracks'  # not what the overlay hears
    if namespace == 'clouds' and name == 'window_tracker':
        values['detections_topic'] = 'detections'
    if namespace == 'lines':
        values['outlines_topic'] = 'outlines'
    if name == 'camera':
        values |= {'source': 'scene:single?width=64&height=48', 'rate': -1.0, 'loop': 'true'}
    return values


class Crowd:
    """All those nodes, each in its process, what they say, and publishers of what they hear.

    :ivar is_ended: whether a test has ended them.
    """

    def __init__(self, ros) -> None:
        self.ros, self.is_ended = ros, False
        self.taken = dict.fromkeys(HEARD, 0)
        self.refused = dict.fromkeys(HEARD, 0)
        self.skipped = dict.fromkeys(HEARD, 0)
        self.seen: set[str] = set()
        ros.node.create_subscription(DiagnosticArray, '/diagnostics', self._note, 1000)
        self.publishers = {
            topic: ros.node.create_publisher(type(good), topic, DEPTH)
            for topic, good in GOOD.items()
        }
        self.processes = {
            node: ros.start_code(
                UNPACKING + program_of(node.rpartition('/')[2]),
                *('-r', f'__ns:={node.rpartition("/")[0]}'),
                **parameters(node),
            )
            for node in HEARD
        }
        assert ros.spin(lambda: self.seen == set(HEARD)), ros.outputs()
        ros.settle()
        self.sent = dict.fromkeys(GOOD, 0)

    def _note(self, message: DiagnosticArray) -> None:
        (status,) = message.status
        values = {v.key: v.value for v in status.values}
        node = '/' + status.name.partition(':')[0]
        self.seen.add(node)
        self.taken[node] += round(float(values['rate in [Hz]']))
        self.refused[node] = int(values['refused'])
        self.skipped[node] = int(values.get('skipped', 0))

    def publish(self, messages: dict[str, list], together: int = 1) -> None:
        """Publish on each topic, and wait until all is worked on.

        :param together: how many come in one message.
        """
        for topic, some in messages.items():
            self.sent[topic] += len(some)
            for k in range(0, len(some), together):
                batch = some[k : k + together]
                self.publishers[topic].publish(packed(batch) if together > 1 else batch[0])
        assert self.ros.spin(self.all_heard), f'{self.sent} {self.taken} {self.refused}'

    def all_heard(self) -> bool:
        """Whether each node has taken, refused or skipped all that it has been sent.

        Not of those that count something else: the pictures that they work on, or outlines alone.
        """
        return all(
            self.taken[node] + self.refused[node] + self.skipped[node]
            >= sum(self.sent[t] for t in HEARD[node])
            for node in set(HEARD) - {'/clouds/camera', '/clouds/window_tracker', '/lines/overlay'}
        )

    def memory(self) -> dict[str, int]:
        """Resident memory of each node [bytes]."""
        return {name: process.memory() for name, process in self.processes.items()}


@pytest.fixture(scope='module')
def crowds():
    with contextlib.ExitStack() as opened:
        yield opened, []


@pytest.fixture
def crowd(crowds, tmp_path_factory):
    """That of the test before, but for a test that is run again once it has ended the nodes."""
    opened, made = crowds
    if not made or made[-1].is_ended:
        ros = Ros(tmp_path_factory.mktemp('crowd'))
        opened.callback(ros.close)
        made.append(Crowd(ros))
    return made[-1]


def leaks(held: list[dict[str, int]]) -> dict[str, float]:
    """Of the nodes that leak, how much by COUNT messages [bytes].

    :param held: memory of each node after each DEPTH messages [bytes].

    A leak grows with every message, also with the later ones; what Python, C and DDS keep to use it
    again is there by then. The largest picture of all that pass for one leaves a step.
    """
    growth = np.diff([list(each.values()) for each in held], axis=0)
    late = np.median(growth[len(growth) // 2 : -1], axis=0) * COUNT / DEPTH
    return {name: leak for name, leak in zip(held[0], late, strict=True) if leak > 2 * 2**20}


def test_ten_thousand_mutated_messages_on_each_subscription_do_no_harm(crowd):
    wrong = {topic: mutations(good, COUNT, seed) for seed, (topic, good) in enumerate(GOOD.items())}
    held: list[dict[str, int]] = []
    starts = range(0, COUNT, DEPTH)
    # What is kept for use again comes in pieces as large as a message of 30 pictures, 108 kB, and
    # where others hold up a node, still so in the later batches. That ends; a leak does not.
    for start in (*starts, *starts, *starts):
        if len(held) >= len(starts) and not leaks(held):
            break
        some = {topic: all_of_it[start : start + DEPTH] for topic, all_of_it in wrong.items()}
        crowd.publish(some, together=TOGETHER if held else 1)
        held.append(crowd.memory())
    assert leaks(held) == {}
    steps = {name: held[-1][name] - before for name, before in held[0].items()}
    assert {name: step for name, step in steps.items() if step > 32 * 2**20} == {}
    for name, process in crowd.processes.items():
        assert process.popen.poll() is None, name
        assert 'Traceback' not in process.output, process.output
        lines = [line for line in process.output.splitlines() if line.startswith('[')]
        assert 2 < len(lines) < 100, process.output  # of which one a second of a new start
        assert min(crowd.refused[name], COUNT - 1) > COUNT / 2, name


@pytest.mark.parametrize('folder', ['test_bag_mcap', 'test_bag_sqlite3'])
def test_what_malformed_bags_hold_is_refused_by_every_node(crowd, folder):
    path = DATA / 'malformed_bags' / folder
    if not path.exists():
        pytest.skip(f'{path} is not there')
    reader = BagReader(path)
    held = {t.kind: [cdr for _, cdr in reader.messages(t)] for t in reader.topics}
    reader.close()
    bad = {t: held.get(f'sensor_msgs/msg/{type(g).__name__}', []) for t, g in GOOD.items()}
    crowd.ros.spin(lambda: False, 2.0)  # for the nodes of which not all is counted
    before = dict(crowd.refused)
    crowd.publish(bad)
    expected = {n: before[n] + sum(len(bad[t]) for t in topics) for n, topics in HEARD.items()}
    assert crowd.ros.spin(lambda: crowd.refused == expected), (expected, crowd.refused)
    # and what is not even of the type
    others = [cdr for cdrs in held.values() for cdr in cdrs]
    crowd.publish(dict.fromkeys(GOOD, others))
    for name, process in crowd.processes.items():
        assert process.popen.poll() is None, name
        assert 'Traceback' not in process.output, process.output


def test_the_next_good_message_is_answered_and_the_end_is_in_order(crowd):
    topics = ['detections', *(f'{name}/tracks' for name in TAKERS if name != 'detector')]
    outputs: dict[str, type] = {f'/{ns}/{t}': PointCloud2 for ns in ('raw', 'jpeg') for t in topics}
    outputs |= {'/raw/overlay/image_raw': Image, '/clouds/tracks': PointCloud2}
    answers = {topic: crowd.ros.listen(kind, topic) for topic, kind in outputs.items()}
    assert crowd.ros.spin(lambda: all(crowd.ros.node.count_publishers(t) for t in outputs))
    crowd.ros.settle()
    for topic, good in GOOD.items():
        crowd.publishers[topic].publish(good)

    def answered() -> list[str]:
        return [t for t, some in answers.items() if any(m.header.stamp == NEWEST for m in some)]

    assert crowd.ros.spin(lambda: len(answered()) == len(outputs)), answered()
    crowd.is_ended = True
    for process in crowd.processes.values():
        process.popen.send_signal(signal.SIGINT)
    statuses = {name: process.end() for name, process in crowd.processes.items()}
    assert statuses == dict.fromkeys(HEARD, 0)
