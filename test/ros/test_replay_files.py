"""What replay writes, what it never destroys, and how it ends."""

import contextlib
import os
from pathlib import Path
import re
import shutil
import signal
import threading

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from std_msgs.msg import String
from support.full_disk import file_size_limit
from support.recorded import contents
from support.recorded import of_topic
from support.recorded import TOPICS

from colortrack_ros.bags import BagWriter
from colortrack_ros.data import Frame
from colortrack_ros.replay import run
from colortrack_ros.replay.command import replay as replay_command
from colortrack_ros.sources import Source

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


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


def test_a_bag_without_pictures_says_what_is_there_and_one_of_ros_1_what_to_do(replay):
    bag = BagWriter(Path('in/talk'), {'/talk': 'std_msgs/msg/String'}, 'mcap')
    bag.write('/talk', 0, serialize_message(String(data='x')))
    bag.close()
    status, _, errors = replay('in/talk')
    assert (status, 'there is /talk (std_msgs/msg/String)' in errors) == (1, True)
    Path('in/one.bag').write_bytes(b'#ROSBAG V2.0\n')
    status, _, errors = replay('in/one.bag')
    assert (status, 'rosbags-convert' in errors, errors.count('\n')) == (1, True, 1)


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


@pytest.mark.parametrize(
    ('option', 'why'),
    [
        ('--csv', 'File too large'),
        ('--mot', 'File too large'),
        ('--video', '0 of 72 frames have been written; is the disk full?'),
    ],
)
def test_each_file_that_is_written_is_checked(replay, option, why, monkeypatch):
    monkeypatch.setattr('colortrack_ros.replay.outputs.BagWriter', NoBag)
    scene = 'scene:five?width=160&height=120&rate=6&duration=12'
    with full_disk(3000, monkeypatch):
        status, out, errors = replay(scene, '--output', 'new', option, 'table.mp4')
    assert (status, out) == (1, '')
    assert errors == f'replay: {Path("table.mp4").resolve()}: {why}\n'
    assert os.listdir('.') == []


@pytest.mark.parametrize('option', ['--csv', '--mot', '--video', '--output'])
def test_a_folder_that_vanishes_while_it_is_written_to_is_an_error(replay, option, monkeypatch):
    work, scene = run.run_through, 'scene:five?width=160&height=120&rate=6&duration=2'
    Path('away').mkdir()

    def vanish(*arguments):
        work(*arguments)
        shutil.rmtree('away')

    monkeypatch.setattr(run, 'run_through', vanish)
    place = Path('away', 'here.mp4')
    given = [option, place] if option == '--output' else ['--output', 'new', option, place]
    status, out, errors = replay(scene, *given)
    assert (status, out, errors.count('\n')) == (1, '', 1)
    assert 'away/' in errors
    assert os.listdir('.') == []


class NoBag:
    """A bag that takes no place."""

    def __init__(self, *_):
        pass

    def write(self, *_):
        pass

    def close(self):
        pass


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
