"""replay on bags, videos and scenes; what it writes is what the nodes publish."""

import contextlib
import copy
import csv
import os
from pathlib import Path
import re
import shutil
import signal
import sys
import threading

import cv2
import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from support.claims import write_huge_png
from support.damaged import damaged_video
from support.full_disk import file_size_limit
from support.paths import DATA
from support.recorded import frames
from support.recorded import NAMES
from support.recorded import of_topic
from support.recorded import read_bag
from support.recorded import write_bag
from visualization_msgs.msg import MarkerArray

from colortrack_ros.bags import BagReader
from colortrack_ros.bags import BagWriter
from colortrack_ros.bags import canonical
from colortrack_ros.data import Frame
from colortrack_ros.data import TRACK
from colortrack_ros.messages import compressed_of_frame
from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import stamp_of
from colortrack_ros.replay import run
from colortrack_ros.replay.command import replay as replay_command
from colortrack_ros.replay.main import main
from colortrack_ros.replay.run import default_output
from colortrack_ros.sources import Source

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
SCENE = 'scene:five?width=320&height=240&rate=6&duration=12'
START = 1_700_000_000_123_456_789
TOPICS = {'/detections': PointCloud2, '/tracks': PointCloud2, '/tracks/markers': MarkerArray}


@pytest.fixture
def replay(tmp_path, monkeypatch, capfd):
    """Runs replay in a folder of its own: exit status, what it printed, and its errors."""
    monkeypatch.chdir(tmp_path)
    handlers = {number: signal.getsignal(number) for number in SIGNALS}

    def run(*arguments):
        status = main([str(argument) for argument in arguments])
        printed = capfd.readouterr()
        assert 'Traceback' not in printed.err
        return status, printed.out, printed.err

    yield run
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.fixture(scope='module')
def images():
    return frames(SCENE, START)


@pytest.fixture(scope='module')
def bag(images, tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp('in') / 'run', {'/camera/image_raw': images})


def contents(path):
    return [(m.topic, m.log_time, m.cdr) for m in read_bag(path)]


def tracks_of(path):
    return [np.frombuffer(m.content.data, TRACK) for m in of_topic(path, '/tracks')]


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
        '/**:\n  ros__parameters:\n    queue_depth: 200\n'
        '/**/camera:\n  ros__parameters:\n'
        f'    source: {SCENE}\n    rate: -1.0\n    frame_id: front\n'
        f'    wait_for_subscribers: {1 if together else 2}\n'
        '/**/detector:\n  ros__parameters:\n    max_lag: 60.0\n    red:\n      tolerance: 40\n'
        '/**/tracker:\n  ros__parameters:\n    process_noise: 300.0\n    marker_scale: 0.02\n'
        '    image_size: [320, 240]\n'
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


def mixed_up(images):
    """Frames 6 a second, some up to 0.33 s behind the newest, one 0.5 s."""
    mixed = [*images]
    mixed[10:16] = [mixed[k] for k in (12, 10, 11, 15, 14, 13)]
    mixed.insert(32, mixed.pop(29))
    return mixed


@pytest.mark.parametrize('kind', ['images', 'detections'])
def test_messages_are_put_in_the_order_of_their_stamps(replay, bag, images, kind):
    assert replay(bag, '--output', 'sorted')[0] == 0
    topic = {'images': '/camera/image_raw', 'detections': '/detections'}[kind]
    recorded = [m.content for m in of_topic('sorted', '/detections')]
    infos = [m.content for m in of_topic('sorted', '/camera/camera_info')]
    given = images if kind == 'images' else recorded
    write_bag(Path('run'), {topic: mixed_up(given), '/camera/camera_info': infos})
    for window, max_late, late in ((0.6, 0.0, 0), (0.3, 0.3, 1), (0.0, 0.6, 5)):
        options = ['-p', f'reorder_window:={window}', '-p', f'max_late:={max_late}']
        status, out, _ = replay('run', '--output', 'mixed', '--force', *options)
        assert status == 0
        assert f'dropped     {late} late\n' in out
        assert 'restarts    0' in out
        stamps = [stamp_of(m.content.header) for m in of_topic('mixed', '/tracks')]
        assert stamps == sorted(stamps)
        assert len(stamps) == len(images) - late
        if late == 0:
            for name in ('/tracks', '/tracks/markers'):
                new, old = of_topic('mixed', name), of_topic('sorted', name)
                assert [m.cdr for m in new] == [m.cdr for m in old], name


def test_of_what_the_detector_lets_through_the_tracker_drops_what_is_late_for_it(replay, images):
    write_bag(Path('run'), {'/camera/image_raw': [*images[:20], *images[16:30]]})
    options = ['-p', 'detector:max_late:=0.1', '-p', 'tracker:max_late:=10.0']
    status, out, _ = replay('run', '--output', 'new', *options)
    assert status == 0
    assert 'dropped     3 late\n' in out
    assert len(of_topic('new', '/detections')) == 34
    assert len(of_topic('new', '/tracks')) == 31


@pytest.mark.parametrize(
    ('rgb', 'warned'),
    [
        ('[90, 110, 130]', 'red runs into other colors'),
        ('[205, 58, 34]', ''),
    ],
)
def test_what_the_detector_says_about_the_pictures_is_shown(replay, rgb, warned):
    scene = 'scene:single?width=160&height=120&duration=0.4'
    status, out, _ = replay(scene, '-p', f'detector:red.rgb:={rgb}', '-p', 'red.tolerance:=0.0')
    assert status == 0
    expected = (
        f'warnings    10 pictures, the last: {warned}' if warned else 'warnings    0 pictures'
    )
    assert expected in out


def test_a_loop_in_the_recording_restarts_the_tracker_once(replay, images):
    later = copy.deepcopy(images)
    for image in images:
        image = copy.deepcopy(image)
        image.header.stamp.sec -= 100
        later.append(image)
    write_bag(Path('run'), {'/camera/image_raw': later})
    status, out, _ = replay('run')
    assert status == 0
    assert 'restarts    1, the last: the stamp went back by 111.8' in out
    messages = of_topic('run_tracks', '/tracks')
    assert [stamp_of(m.content.header) for m in messages] == [stamp_of(i.header) for i in later]
    assert [m.log_time for m in messages] == sorted(m.log_time for m in messages)


@pytest.mark.parametrize('folder', ['test_bag_mcap', 'test_bag_sqlite3'])
@pytest.mark.parametrize('kind', ['image', 'compressed_image', 'point_cloud2'])
def test_malformed_messages_are_refused_and_counted(replay, folder, kind):
    path = DATA / 'malformed_bags' / folder
    if not path.exists():
        pytest.skip(f'{path} is not there')
    status, out, errors = replay(path, '--topic', f'/test/sensor_msgs/{kind}', '--output', 'new')
    assert (status, errors) == (1, '')
    assert 'frames      0\n' in out
    assert 'refused     2, the last: ' in out
    assert contents('new') == []


def test_bad_messages_between_good_ones_change_nothing(replay, bag, images):
    rng = np.random.default_rng(1)
    assert replay(bag, '--output', 'good')[0] == 0
    writer = BagWriter(Path('run'), {'/camera/image_raw': 'sensor_msgs/msg/Image'})
    for k, image in enumerate(images):
        stamp = stamp_of(image.header)
        cdr = serialize_message(image)
        writer.write('/camera/image_raw', stamp, cdr)
        cut = cdr[: rng.integers(0, len(cdr))]  # some with a stamp, some without
        writer.write('/camera/image_raw', stamp + 1, cut if k % 2 else cdr[:2] + bytes(k))
    writer.close()
    status, out, _ = replay('run', '--output', 'new')
    assert status == 0
    assert [m.cdr for m in of_topic('new', '/tracks')] == [
        m.cdr for m in of_topic('good', '/tracks')
    ]
    assert 'frames      72\n' in out


def test_a_broken_bag_gives_what_can_be_read_and_an_error(replay, bag):
    shutil.copytree(bag, 'run')
    (file,) = Path('run').glob('*.mcap')
    content = bytearray(file.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 300_000] = bytes(300_000)
    file.write_bytes(content)
    status, out, errors = replay('run')
    assert (status, errors.count('\n')) == (1, 1)
    assert 'this bag cannot be read' in errors
    frames = int(re.search(r'frames +(\d+)', out)[1])
    assert 10 < frames < 72
    assert len(contents('run_tracks')) == 3 * frames + 1, 'and one CameraInfo'


def topics_of(path):
    reader = BagReader(Path(path))
    names = {topic.name for topic in reader.topics}
    reader.close()
    return names


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
        ('detector:colors:=[green]', 'green: expected one of green.lab'),
        ('detector:min_area:=.nan', 'min_area: expected int, 1..1e+09 px, got nan'),
        ('min_area', 'expected name:=value'),
    ],
)
def test_a_refused_parameter_is_an_error(replay, bag, given, reason):
    status, _, errors = replay(bag, '--output', 'new', '-p', given)
    assert status == 1
    assert reason in errors
    assert os.listdir('.') == []


def test_nothing_is_overwritten_unless_asked_for(replay, bag):
    assert replay(bag, '--output', 'new')[0] == 0
    before = contents('new')
    for options in (['--output', 'new'], ['--csv', 'new/metadata.yaml', '--output', 'x']):
        status, _, errors = replay(bag, *options)
        assert status == 1
        assert 'is there already; --force overwrites it' in errors
    Path('new', 'notes.txt').write_text('mine')
    status, _, errors = replay(bag, '--output', 'new', '--force')
    assert (status, 'not only; it is not overwritten' in errors) == (1, True)
    Path('new', 'notes.txt').unlink()
    assert replay(bag, '--output', 'new', '--force')[0] == 0
    assert contents('new') == before
    shutil.copytree(bag, 'in/run')
    for output in ('in/run', 'in', 'in/run/run.mcap'):
        status, _, errors = replay('in/run', '--output', output, '--force')
        assert status == 1
        assert 'is not overwritten' in errors
    assert len(contents('in/run')) == 72


@pytest.mark.parametrize(
    'name', ['nothing', 'nothing.mcap', 'rtsp://nowhere', 'notes.txt', 'empty']
)
def test_what_is_no_recording_is_an_error_in_one_line(replay, name, monkeypatch):
    monkeypatch.setattr('colortrack_ros.sources.stream.TIMEOUT_MS', 100)
    Path('notes.txt').write_text('mine')
    Path('empty').mkdir()
    status, _, errors = replay(name)
    assert (status, errors.count('\n')) == (1, 1)
    assert errors.startswith('replay: ')
    assert sorted(os.listdir('.')) == ['empty', 'notes.txt']


def snapshot(folder):
    return {path: path.read_bytes() for path in Path(folder).rglob('*') if path.is_file()}


@pytest.mark.parametrize(
    'options',
    [
        '--csv in/run/run.mcap',
        '--mot in/run/metadata.yaml',
        '--video in/run/run.mcap',
        '--csv linked',
        '--csv hard',
        '--output in/run/new/../../run',
        '--output old --expect typo.csv',
        '--output old --csv nowhere/x.csv',
        '--output old --csv old/x.csv',
        '--output old --csv same --mot same',
        '--output old -p tracker:max_time_since_update:=-1',
        '--output old --params-file robot.yaml --csv robot.yaml',
        '--output old --csv pipe',
        '--output mine',
        '--output recorded',
    ],
)
def test_force_never_destroys_what_is_read_or_is_not_of_replay(replay, bag, options):
    shutil.copytree(bag, 'in/run')
    Path('linked').symlink_to('in/run/run.mcap')
    Path('hard').hardlink_to('in/run/run.mcap')
    Path('robot.yaml').write_text('tracker:\n  ros__parameters:\n    min_score: 0.1\n')
    os.mkfifo('pipe')
    shutil.copytree(bag, 'old')
    shutil.copytree(bag, 'mine')
    Path('mine/metadata.yaml').unlink()
    shutil.copytree(bag, 'recorded')
    metadata = Path('recorded/metadata.yaml')
    metadata.write_text(metadata.read_text().replace('written_by', 'recorded_by'))
    before = snapshot('.')
    status, _, errors = replay('in/run', '--force', *options.split())
    assert (status, errors.count('\n')) == (1, 1), errors
    assert snapshot('.') == before
    assert not list(Path().glob('.replay-*'))


@contextlib.contextmanager
def full_disk(size, monkeypatch):
    """A disk that is full once replay has its files open; ROS has its shared memory before."""
    with contextlib.ExitStack() as stack:
        work = run.run_through

        def work_on_a_full_disk(*arguments):
            stack.enter_context(file_size_limit(size))
            work(*arguments)

        monkeypatch.setattr(run, 'run_through', work_on_a_full_disk)
        yield


@pytest.mark.parametrize(
    'options', ['', '--storage sqlite3', '--csv t.csv', '--mot t.mot', '--video t.mp4']
)
def test_what_cannot_be_written_is_an_error_and_leaves_what_was_there(replay, options, monkeypatch):
    scene, options = 'scene:five?width=160&height=120&rate=6&duration=12', options.split()
    assert replay(scene, '--output', 'new', *options)[0] == 0
    before = snapshot('.')
    limit = 3000 if options[:1] != ['--storage'] else 50_000
    with full_disk(limit, monkeypatch):
        status, out, errors = replay(scene, '--output', 'new', '--force', *options)
    assert (status, out) == (1, '')
    assert errors.startswith('replay: ')
    assert snapshot('.') == before
    assert not list(Path().glob('.replay-*'))


@pytest.mark.parametrize('option', ['--output', '--csv', '--mot', '--video'])
def test_an_output_that_is_a_link_to_itself_is_an_error_in_one_line(replay, option):
    Path('loop').symlink_to('loop')
    status, out, errors = replay('scene:single', option, 'loop', '--force')
    assert (status, out, errors) == (1, '', 'replay: loop: Too many levels of symbolic links\n')
    assert os.listdir() == ['loop']


@pytest.mark.parametrize('option', ['--csv', '--mot', '--video'])
def test_each_file_that_is_written_is_checked(replay, option, monkeypatch):
    monkeypatch.setattr('colortrack_ros.replay.outputs.BagWriter', NoBag)
    scene = 'scene:five?width=160&height=120&rate=6&duration=12'
    with full_disk(3000, monkeypatch):
        status, out, errors = replay(scene, '--output', 'new', option, 'table.mp4')
    assert (status, out) == (1, '')
    assert errors.startswith('replay: ')
    assert os.listdir('.') == []


class NoBag:
    """A bag that takes no place."""

    def __init__(self, *_):
        pass

    def write(self, *_):
        pass

    def close(self):
        pass


def test_pictures_that_cannot_be_are_lost_and_the_others_tracked(replay, images):
    Path('shots').mkdir()
    for k, image in enumerate(images[:10]):
        cv2.imwrite(f'shots/{k}.png', frame_of_image(image).image)
    write_huge_png(Path('shots/5.png'))
    os.mkfifo('shots/5b.png')
    status, out, errors = replay('shots')
    assert (status, 'frames      9\n' in out) == (1, True)
    assert '1 pictures are lost' in errors


class Silent(Source):
    """Gives one picture, and then no answer."""

    live, period = False, 10

    def __init__(self):
        self.frames = [Frame(np.zeros((8, 8, 3), np.uint8), 'bgr8', 0)]

    @staticmethod
    def accepts(spec):
        return False

    def read(self):
        return self.frames.pop() if self.frames else threading.Event().wait()

    def rewind(self):
        pass

    def close(self):
        pass


def test_a_signal_ends_a_replay_that_waits_for_a_picture(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr('colortrack_ros.replay.recordings.open_source', lambda *_: Silent())
    stop = threading.Event()
    add = run.Answers.add

    def add_and_stop(tally, *arguments):
        add(tally, *arguments)
        threading.Timer(0.5, stop.set).start()  # when it waits for the next one

    monkeypatch.setattr(run.Answers, 'add', add_and_stop)
    assert replay_command(['shots'], stop) == 0
    assert 'frames      1, interrupted' in capfd.readouterr().out
    assert len(of_topic('shots_tracks', '/tracks')) == 1


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
    # the middle of the box, with the center of the top left pixel at (1, 1)
    np.testing.assert_allclose(
        mot[:, 2] + (mot[:, 4] - 1) / 2, [row['u'] + 1 for row in confirmed], atol=0.001
    )


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


def test_a_missing_library_is_named(replay, bag, monkeypatch):
    monkeypatch.setitem(sys.modules, 'colortrack_ros.replay.command', None)
    status, _, errors = replay(bag)
    assert (status, 'pip install rosbags rich' in errors) == (1, True)
    missing = ModuleNotFoundError("No module named 'rclpy'", name='rclpy')

    class WithoutRos:
        def __getattr__(self, _):
            raise missing

    monkeypatch.setitem(sys.modules, 'colortrack_ros.replay.command', WithoutRos())
    status, _, errors = replay(bag)
    assert (status, 'without ROS, colortrack_ros.chain' in errors) == (1, True)


@pytest.mark.parametrize('number', SIGNALS, ids=lambda s: s.name)
@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_signal_finishes_the_bag(ros, number, storage):
    new = ros.folder / 'new'
    process = ros.start(
        'replay',
        'scene:occlusion?width=1280&height=960',
        *('--output', str(new), '--storage', storage),
    )
    assert ros.spin(lambda: list(ros.folder.glob('.replay-*/new'))), process.output
    began = process.work()
    assert ros.spin(lambda: process.work() > began + 0.3), process.output
    assert process.stop(number) == 0, process.output
    frames = int(re.search(r'frames +(\d+), interrupted', process.output)[1])
    assert frames > 0
    assert 'Traceback' not in process.output
    assert [len(of_topic(new, topic)) for topic in TOPICS] == [frames] * 3


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


def test_a_damaged_video_is_replayed_to_its_end_with_a_status_that_says_so(replay, tmp_path):
    video = damaged_video(tmp_path / 'a.mp4', 'mp4v')
    status, out, errors = replay(video, '--output', 'new')
    assert status == 1
    lost = int(re.search(r'a\.mp4: (\d+) pictures are lost', errors)[1])
    assert f'frames      {200 - lost}' in out
    assert of_topic('new', '/tracks')[-1].log_time == 199 * 10**9 // 25
