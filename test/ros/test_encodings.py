"""Images in every encoding that a message can have, through real nodes and through replay."""

import array
from functools import cache

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from support.cameras import encode
from support.recorded import of_topic
from support.recorded import write_bag

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.encodings import writable_bgr
from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import header_of
from colortrack_ros.messages import stamp_of
from colortrack_ros.messages.images import KNOWN
from colortrack_ros.messages.images import OTHER_NAMES
from colortrack_ros.messages.images import SIXTEEN_BIT
from colortrack_ros.replay.main import main
from colortrack_ros.scenes import open_scene

START, STEP = 1_700_000_000 * 10**9, 40_000_000
SCENE = open_scene('five?width=320&height=240&noise=0')


def message_of(picture, name, stamp, *, big_endian=False, padding=0):
    """The Image of a picture as a driver would fill it."""
    frame = encode(picture, SIXTEEN_BIT.get(name) or OTHER_NAMES.get(name, name))
    rows = frame.image.reshape(len(frame.image), -1)
    if name in SIXTEEN_BIT:
        wide = rows.astype(np.uint16) << 8
        rows = wide.astype('>u2' if big_endian else '<u2').view(np.uint8)
    rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=170)
    height, width = picture.shape[:2]
    return Image(
        header=header_of(stamp, 'cam'), height=height, width=width, encoding=name,
        is_bigendian=big_endian, step=rows.shape[1], data=array.array('B', rows.tobytes()),
    )  # fmt: skip


VARIANTS = [(name, end, pad) for name in KNOWN for end in (False, True) for pad in (0, 24)]


@cache
def messages():
    """The same picture in all variants."""
    picture = SCENE.render(250)
    return [
        message_of(picture, name, START + k * STEP, big_endian=end, padding=pad)
        for k, (name, end, pad) in enumerate(VARIANTS)
    ]


@cache
def expected():
    """What the detector finds in that picture."""
    return Detector(DetectorConfig()).detect(Frame(SCENE.render(250))).rows


def assert_found(clouds):
    """The balls are where they are in every picture that has colors."""
    found = {stamp_of(cloud.header): np.frombuffer(cloud.data, DETECTION) for cloud in clouds}
    for message, variant in zip(messages(), VARIANTS, strict=True):
        rows = found[stamp_of(message.header)]
        if 'mono' in message.encoding or message.encoding == '8UC1':
            assert not len(rows), variant
            continue
        assert len(rows) == len(expected()), variant
        away = np.hypot(*(rows[axis][:, None] - expected()[axis] for axis in 'uv'))
        assert away.min(axis=0).max() < 1, variant


def test_real_nodes_take_every_encoding_and_draw_on_it(ros):
    topic = '/camera/image_raw'
    reliable = {f'qos_overrides.{topic}.subscription.reliability': 'reliable', 'max_lag': 60.0}
    ros.start('detector', **reliable)
    ros.start('tracker', max_lag=60.0)
    ros.start('overlay', **reliable)
    detections = ros.listen(PointCloud2, 'detections')
    drawn = ros.listen(Image, 'overlay/image_raw')
    publisher = ros.node.create_publisher(Image, 'camera/image_raw', 100)
    assert ros.spin(lambda: publisher.get_subscription_count() == 2), ros.outputs()
    assert ros.spin(lambda: ros.node.count_subscribers('tracks') == 1), ros.outputs()
    assert ros.spin(lambda: ros.node.count_subscribers('detections') == 2), ros.outputs()
    early = message_of(SCENE.render(0), 'bgr8', START - STEP)
    while not drawn:  # until the nodes have found each other
        publisher.publish(early)
        ros.spin(lambda: bool(drawn), 2.0)
    ros.settle()

    def answers(some: list) -> list:
        """Not those to the early picture, whenever they come."""
        return [answer for answer in some if stamp_of(answer.header) >= START]

    for count, message in enumerate(messages(), start=1):
        publisher.publish(message)
        there = ros.spin(lambda count=count: len(answers(drawn)) == count)
        assert there, (message.encoding, ros.outputs())
    assert len(answers(detections)) == len(messages())
    assert_found(answers(detections))
    for message, picture in zip(messages(), answers(drawn), strict=True):
        bgr = frame_of_image(picture).image.astype(int)
        expected = writable_bgr(frame_of_image(message))
        assert np.median(np.abs(bgr - expected)) == 0, message.encoding


BAD = {
    'yuyv of an odd width': {'encoding': 'yuyv', 'width': 319},
    'old name, odd width': {'encoding': 'yuv422', 'width': 319},
    'nv12 of an odd height': {'encoding': 'nv12', 'height': 239},
    'nv21 of an odd width': {'encoding': 'nv21', 'width': 319},
    'a step too small': {'step': 959},
    'a step too large': {'step': 961},
    'data too short': {'data': array.array('B', bytes(960 * 240 - 1))},
    'data too long': {'data': array.array('B', bytes(960 * 240 + 1))},
    'no data': {'data': array.array('B')},
    'data of no picture': {'width': 0, 'step': 0},
    'no encoding': {'encoding': ''},
    'an encoding that is not taken': {'encoding': 'nv24'},
    'depth': {'encoding': '16UC1'},
}
EMPTY = [
    Image(encoding=name, height=height, width=width, step=width)
    for name, height, width in (('bgr8', 0, 0), ('nv12', 0, 320), ('yuyv', 240, 0))
]


def test_what_no_camera_should_send_is_refused_counted_and_told_and_what_may_come_is_taken(ros):
    topic = '/camera/image_raw'
    reliable = {f'qos_overrides.{topic}.subscription.reliability': 'reliable', 'max_lag': 60.0}
    ros.start('detector', **reliable)
    detections = ros.listen(PointCloud2, 'detections')
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    publisher = ros.node.create_publisher(Image, 'camera/image_raw', 100)
    assert ros.spin(lambda: publisher.get_subscription_count() == 1), ros.outputs()
    ros.settle()
    odd = message_of(SCENE.render(250)[1:, 1:], 'bayer_rggb8', START, padding=3)
    good = [*EMPTY, odd]
    for k, changes in enumerate(BAD.values()):
        bad, next_one = message_of(SCENE.render(250), 'bgr8', START), good[k % len(good)]
        for field, value in changes.items():
            setattr(bad, field, value)
        next_one.header = header_of(START + k * STEP, 'cam')
        publisher.publish(bad)
        publisher.publish(next_one)
        assert ros.spin(lambda k=k: len(detections) == k + 1), (k, ros.outputs())
        assert stamp_of(detections[-1].header) == START + k * STEP
        assert detections[-1].width == (len(expected()) if next_one is odd else 0)

    def told():
        """The detector's diagnostics."""
        return [s for array in diagnostics for s in array.status if 'detector' in s.name]

    def refused():
        values = {pair.key: pair.value for pair in told()[-1].values} if told() else {}
        return int(values.get('refused', 0))

    assert ros.spin(lambda: refused() == len(BAD)), (refused(), ros.outputs())
    counts = [int(s.message.split()[0]) for s in told() if ' refused: ' in s.message]
    assert sum(counts) == len(BAD)  # each tells of its second
    assert 'Refused: image of 319x240 yuyv: expected a width' in ros.outputs()


@pytest.mark.parametrize('tracker', ['tracker', 'window_tracker', 'contour_tracker'])
def test_replay_takes_every_encoding(tmp_path, tracker):
    bag = write_bag(tmp_path / 'in', {'/camera/image_raw': messages()})
    new = tmp_path / 'new'
    arguments = ['--output', str(new), '--tracker', tracker, '--video', str(tmp_path / 'new.mp4')]
    assert main([str(bag), *arguments]) == 0
    assert len(of_topic(new, '/tracks')) == len(messages())
    if tracker == 'tracker':
        assert_found([message.content for message in of_topic(new, '/detections')])


def test_full_range_is_a_parameter_of_the_nodes_that_take_pictures(ros, tmp_path):
    picture = np.full((64, 64, 3), 128, np.uint8)
    picture[20:40, 20:40] = (34, 58, 205)
    frame = encode(picture, 'yuyv', full_range=True)
    message = message_of(picture, 'yuyv', START)
    message.data = array.array('B', frame.image.tobytes())
    lab = '[47.0, 57.0, 48.0]'
    colors = {'colors': '[ball]', 'ball.lab': lab, 'ball.tolerance': 3.0}
    ros.start('detector', yuv_full_range=True, **colors)
    ros.start('detector', '-r', '__node:=other', '-r', 'detections:=limited', **colors)
    full, limited = ros.listen(PointCloud2, 'detections'), ros.listen(PointCloud2, 'limited')
    publisher = ros.node.create_publisher(Image, 'camera/image_raw', 100)
    assert ros.spin(lambda: publisher.get_subscription_count() == 2), ros.outputs()
    ros.settle()
    publisher.publish(message)
    assert ros.spin(lambda: full and limited), ros.outputs()
    assert (full[0].width, limited[0].width) == (1, 0)
    bag = write_bag(tmp_path / 'in', {'/camera/image_raw': [message]})
    given = [word for name, value in colors.items() for word in ('-p', f'detector:{name}:={value}')]
    for value, count in (('true', 1), ('false', 0)):
        new = tmp_path / value
        full_range = ['-p', f'detector:yuv_full_range:={value}']
        assert main([str(bag), '--output', str(new), *given, *full_range]) == 0
        assert of_topic(new, '/detections')[0].content.width == count
