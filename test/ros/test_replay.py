"""replay on bags, videos and scenes; what it writes is what the nodes publish."""

import copy
import csv
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Image
from support.recorded import contents
from support.recorded import frames
from support.recorded import NAMES
from support.recorded import of_topic
from support.recorded import SCENE
from support.recorded import TOPICS
from support.recorded import topics_of
from support.recorded import tracks_of
from support.recorded import write_bag

from colortrack_ros.bags import canonical
from colortrack_ros.bags import Topic
from colortrack_ros.data import TRACK
from colortrack_ros.messages import compressed_of_frame
from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import stamp_of
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.replay.recordings import choose
from colortrack_ros.replay.recordings import COMPRESSED
from colortrack_ros.replay.recordings import IMAGE
from colortrack_ros.replay.run import default_output


def test_one_message_of_each_kind_for_each_image_with_its_header(replay, bag, images):
    status, out, _ = replay(bag, '--output', 'new')
    assert status == 0
    for topic in ('/detections', '/tracks'):
        messages = of_topic('new', topic)
        assert [m.content.header for m in messages] == [image.header for image in images]
        assert [m.log_time for m in messages] == [stamp_of(image.header) for image in images]
    assert len(of_topic('new', '/tracks/markers')) == len(images)
    assert max(len(rows) for rows in tracks_of('new')) == 5
    assert f'frames      {len(images)}\n' in out
    assert 'refused     0\n' in out
    assert os.listdir('.') == ['new']


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_every_run_gives_the_same_bytes(replay, bag, storage):
    for folder in ('a', 'b'):
        options = ['--storage', storage, '--csv', f'{folder}/csv', '--mot', f'{folder}/mot']
        Path(folder).mkdir()
        assert replay(bag, '--output', f'{folder}/new', *options)[0] == 0
    files = sorted(p.relative_to('a') for p in Path('a').rglob('*') if p.is_file())
    assert len(files) == 4
    for file in files:
        assert (Path('a') / file).read_bytes() == (Path('b') / file).read_bytes(), file


def listen(ros, kind, topic):
    """The bytes of all messages on a topic from now on."""
    messages = []
    ros.node.create_subscription(kind, topic, messages.append, 200, raw=True)
    return messages


@pytest.mark.parametrize('together', [False, True], ids=['three nodes', 'pipeline'])
def test_it_is_what_the_live_nodes_publish_to_the_byte(ros, replay, together):
    # A CameraInfo may come later than the first picture: the tracker is told how large they are.
    Path('robot.yaml').write_text(
        '/**:\n  ros__parameters:\n    queue_depth: 200\n    image_queue_depth: 200\n'
        '/**/camera:\n  ros__parameters:\n'
        f'    source: {SCENE}\n    rate: -1.0\n    frame_id: front\n'
        f'    wait_for_subscribers: {1 if together else 2}\n'
        '/**/detector:\n  ros__parameters:\n    max_lag: 60.0\n    red:\n      tolerance: 40\n'
        '    qos_overrides./camera/image_raw.subscription.reliability: reliable\n'
        '/**/tracker:\n  ros__parameters:\n    max_lag: 60.0\n    process_noise: 300.0\n'
        '    marker_scale: 0.02\n    image_size: [320, 240]\n'
    )
    options = ['--params-file', str(Path('robot.yaml').resolve())]
    live = {topic: listen(ros, kind, topic) for topic, kind in TOPICS.items()}
    for name in ['pipeline'] if together else ['tracker', 'detector']:
        ros.start(name, *options)
    there = ros.spin(lambda: all(ros.node.count_publishers(topic) == 1 for topic in TOPICS))
    assert there, ros.outputs()
    ros.settle()
    images = listen(ros, Image, '/camera/image_raw')
    if not together:
        ros.start('camera', *options)
    done = ros.spin(lambda: len(images) == len(live['/tracks/markers']) == 72)
    assert done, f'{len(images)} images; {ros.outputs()}'

    sent = [deserialize_message(cdr, Image) for cdr in images]
    write_bag(Path('run'), {'/camera/image_raw': sent})
    assert replay('run', '--output', 'new', '--ros-args', *options)[0] == 0
    for topic, kind in TOPICS.items():
        sent = [canonical(cdr, NAMES[kind]) for cdr in live[topic]]
        assert [m.cdr for m in of_topic('new', topic)] == sent, topic
    assert max(len(rows) for rows in tracks_of('new')) == 5


def test_pictures_come_compressed_as_well(replay, bag, images):
    jpegs = [compressed_of_frame(frame_of_image(image), 95) for image in images]
    write_bag(Path('run'), {'/camera/image_raw/compressed': jpegs}, 'sqlite3')
    assert replay('run')[0] == 0
    assert replay(bag, '--output', 'raw')[0] == 0
    for one, other in zip(tracks_of('run_tracks'), tracks_of('raw'), strict=True):
        one, other = (rows[rows['time_since_update'] == 0] for rows in (one, other))
        assert one['track_id'].tolist() == other['track_id'].tolist()
        np.testing.assert_allclose(one['u'], other['u'], atol=2.0)


def test_recorded_detections_give_the_tracks_of_their_pictures(replay, bag):
    assert replay(bag, '--output', 'first')[0] == 0
    assert replay('first', '--topic', 'detections', '--output', 'again')[0] == 0
    assert contents('again') == contents('first')
    detections = [m.content for m in of_topic('first', '/detections')]
    (info,) = [m.content for m in of_topic('first', '/camera/camera_info')]
    assert (info.width, info.height) == (320, 240)
    write_bag(Path('only'), {'/blobs': detections, '/camera/camera_info': [info]})
    assert replay('only')[0] == 0
    assert [m.cdr for m in of_topic('only_tracks', '/tracks')] == [
        m.cdr for m in of_topic('first', '/tracks')
    ]
    status, _, errors = replay('only', '--video', 'x.mp4', '--force')
    assert (status, errors.strip()) == (1, 'replay: --video: there are no pictures in only, /blobs')


def test_a_scene_gives_what_a_bag_of_its_images_gives(replay):
    write_bag(Path('run'), {'/camera/image_raw': frames(SCENE)})
    assert replay('run', '-p', 'camera:frame_id:=cam')[0] == 0
    assert replay(SCENE, '-p', 'camera:frame_id:=cam')[0] == 0
    assert contents('five_tracks') == contents('run_tracks')


def test_the_topic_is_that_of_the_parameters_or_the_only_one(replay, images):
    few = images[:3]
    back = [copy.deepcopy(image) for image in few]
    for image in back:
        image.header.frame_id = 'back'
    write_bag(Path('two'), {'/front/image': few, '/back/image': back})

    def seen(*options):
        status, _, errors = replay('two', '--output', 'new', '--force', *options)
        return errors if status else of_topic('new', '/tracks')[0].content.header.frame_id

    errors = seen()
    assert 'two: no topic /camera/image_raw there' in errors
    assert (
        '/back/image (sensor_msgs/msg/Image, 3), /front/image (sensor_msgs/msg/Image, 3)' in errors
    )
    assert 'no topic side there' in seen('--topic', 'side')
    assert seen('--topic', 'back/image') == 'back'
    assert seen('-p', 'image_topic:=front/image') == 'cam'
    assert seen('-r', 'camera/image_raw:=/back/image') == 'back'


def test_names_come_from_the_file_its_namespace_and_remappings(replay, bag):
    Path('robot.yaml').write_text(
        '/**:\n  ros__parameters:\n    detections_topic: blobs\n    use_sim_time: true\n'
        '    source: 0\n/robot1/tracker:\n  ros__parameters:\n    tracks_topic: ~/all\n'
    )
    options = ('--params-file', 'robot.yaml', '-r', 'tracker:tracks/markers:=/shown')
    Path('short.yaml').write_text('tracker:\n  ros__parameters:\n    queue_depth: 1\n')
    status, _, errors = replay(bag, '--output', 'new', '--ros-args', *options)
    assert status == 0, errors
    names = {'/robot1/camera/camera_info', '/robot1/blobs', '/robot1/tracker/all', '/shown'}
    assert topics_of('new') == names
    status, _, errors = replay(bag, '--output', 'x', *options, '--params-file', 'short.yaml')
    assert status == 1
    assert 'several namespaces, /, /robot1: choose one, such as by -r __ns:=/robot1' in errors
    for choice in ('__ns:=/robot1', '__ns:=/'):
        chosen = (*options, '--params-file', 'short.yaml', '-r', choice)
        assert replay(bag, '--output', 'x', '--force', *chosen)[0] == 0
    assert names & topics_of('x') == {'/shown'}


@pytest.mark.parametrize(
    ('given', 'reason'),
    [
        ('tracker:max_time_since_update:=-3.0', 'max_time_since_update: expected 0..3600 s'),
        ('tracker:min_area:=3', 'min_area: no such parameter; the nearest is'),
        ('max_tme:=3', 'max_tme: no such parameter; the nearest is'),
        ('detector:colors:=[lawn]', 'lawn: expected one of lawn.lab'),
        ('detector:min_area:=.nan', 'min_area: expected int, 1..1e+09 px, got nan'),
        ('min_area', 'expected name:=value'),
    ],
)
def test_a_refused_parameter_is_an_error(replay, bag, given, reason):
    status, _, errors = replay(bag, '--output', 'new', '-p', given)
    assert status == 1
    assert reason in errors
    assert os.listdir('.') == []


@pytest.mark.parametrize(
    ('name', 'output'),
    [
        ('runs/one', 'runs/one_tracks'),
        ('runs/one/', 'runs/one_tracks'),
        ('runs/one.mcap', 'runs/one_tracks'),
        ('ball.mp4', 'ball_tracks'),
        ('shots/*.png', 'shots_tracks'),
        ('scene:five?rate=25', 'five_tracks'),
    ],
)
def test_the_new_bag_stands_beside_the_input(name, output):
    assert default_output(name) == Path(output)


@pytest.mark.parametrize('name', ['[left].mp4', 'what?.mp4'])
def test_a_file_with_the_name_of_a_pattern_is_no_pattern(name, tmp_path):
    (tmp_path / name).touch()
    assert default_output(str(tmp_path / name)) == tmp_path / f'{name[:-4]}_tracks'


def test_images_and_the_same_compressed_are_those_of_one_camera():
    left, right = ('/left/image_raw', IMAGE, 9), ('/right/image_raw', IMAGE, 9)
    again = ('/left/image_raw/compressed', COMPRESSED, 9)
    topics = [Topic(*each) for each in (left, again, right)]
    assert choose(topics[:2], '', '/camera/image_raw', '') == topics[0]
    assert choose(topics[1:2], '', '/camera/image_raw', '') == topics[1]
    assert choose(topics, '/left/image_raw/compressed', '', '') == topics[1]
    with pytest.raises(StartError, match='--topic may choose'):
        choose(topics, '', '/camera/image_raw', '')


def test_the_tables_hold_the_tracks(replay, bag):
    assert replay(bag, '--csv', 'tracks.csv', '--mot', 'mot.txt', '--output', 'new')[0] == 0
    messages = of_topic('new', '/tracks')
    rows = [(m, row) for m in messages for row in np.frombuffer(m.content.data, TRACK)]
    with Path('tracks.csv').open() as file:
        table = list(csv.DictReader(file))
    assert len(table) == len(rows) > 100
    for line, (message, row) in zip(table, rows, strict=True):
        assert int(line['stamp']) == stamp_of(message.content.header)
        assert float(line['cov_v_du']) == row['covariance'][1, 2]
        for name in sorted(set(TRACK.names) - {'covariance'}):
            assert row[name].dtype.type(line[name]) == row[name]
    mot = np.loadtxt('mot.txt', delimiter=',')
    confirmed = [row for _, row in rows if row['state'] > 0]
    assert mot.shape == (len(confirmed), 10)
    assert set(mot[:, 0]) <= set(range(1, 73))
    # with the center of the top left pixel at (1, 1)
    corners = [(row['box_u'] + 1, row['box_v'] + 1) for row in confirmed]
    np.testing.assert_allclose(mot[:, 2:4], corners, atol=0.001)


def test_the_video_shows_every_frame_with_its_tracks(replay, bag, images):
    assert replay(bag, '--video', 'out.mp4', '--output', 'new')[0] == 0
    video = cv2.VideoCapture('out.mp4')
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(6.0, abs=0.01)
    shown = [video.read()[1] for _ in images]
    assert not video.read()[0]
    given = frame_of_image(images[-1]).image
    rows = tracks_of('new')[-1]
    rows = rows[(rows['u'] > 0) & (rows['u'] < given.shape[1])]
    changed = np.abs(shown[-1].astype(int) - given).max(axis=2) > 60
    assert len(rows) >= 4
    for row in rows:
        u, v = round(float(row['u'])), round(float(row['v']))
        reach = round(float(row['box_h']))
        assert changed[max(v - reach, 0) : v + reach, max(u - reach, 0) : u + reach].any()


def test_a_tracker_of_pictures_takes_its_own_parameters_and_no_detections(replay, bag):
    options = ['--tracker', 'window_tracker', '-p', 'targets:=[40.0, 40.0, 20.0, 20.0]']
    options += ['--output', 'new']
    status, _, errors = replay(bag, *options, '-p', 'tracks_topic:=windows')
    assert status == 0, errors
    assert topics_of('new') == {'/windows', '/tracks/markers'}
    first = np.frombuffer(of_topic('new', '/windows')[0].content.data, TRACK)
    assert [(row['u'], row['v'], row['track_id']) for row in first] == [(49.5, 49.5, 1)]
    assert replay(bag, '--output', 'color')[0] == 0
    status, _, errors = replay('color', '--tracker', 'contour_tracker', '--output', 'x')
    assert status == 1
    assert 'color: no topic /camera/image_raw there' in errors
    refused = ['-p', 'window_tracker:window:=4']
    status, _, errors = replay(bag, *options, '--force', *refused)
    assert (status, 'window: expected an odd number' in errors) == (1, True)
