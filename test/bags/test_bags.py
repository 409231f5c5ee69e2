import contextlib
import re
import sqlite3
import subprocess
import sys

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import CompressionFormat
from rosbags.rosbag2 import CompressionMode
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore
from rosbags.typesys import Stores
from std_msgs.msg import String
from support import rosbag2_py
from support.full_disk import file_size_limit
from support.open_files import nothing_left_open
from support.paths import ROOT
import yaml

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagReader
from colortrack_ros.bags import BagWriteError
from colortrack_ros.bags import BagWriter
from colortrack_ros.bags import is_bag
from colortrack_ros.bags import is_own_bag
from colortrack_ros.bags import STORAGES
from colortrack_ros.bags import Topic

TOPICS = {'/talk': 'std_msgs/msg/String', '/more/talk': 'std_msgs/msg/String'}
START = 1_700_000_000_000_000_000
PLUGINS = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}


@pytest.fixture(params=['rosbags', 'rosbag2_py'])
def library(request, monkeypatch):
    """What reads and writes bags: as without ROS, and as with it."""
    if request.param == 'rosbag2_py':
        monkeypatch.setitem(sys.modules, 'rosbag2_py', rosbag2_py)
    else:
        monkeypatch.setitem(sys.modules, 'rosbag2_py', None)
    return request.param


def write(path, storage='mcap', count=5):
    bag = BagWriter(path, TOPICS, storage)
    for k in range(count):
        for topic in TOPICS:
            bag.write(topic, START + k, serialize_message(String(data=f'{topic} {k}')))
    bag.close()
    return path


def only_file(path):
    (file,) = (p for p in path.iterdir() if p.name != 'metadata.yaml')
    return file


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('single', [False, True], ids=['folder', 'file'])
def test_what_is_written_is_read_again(library, tmp_path, storage, single):
    path = write(tmp_path / 'bag', storage)
    path = only_file(path) if single else path
    assert is_bag(path)
    reader = BagReader(path)
    assert reader.topics == [Topic(name, TOPICS[name], 5) for name in sorted(TOPICS)]
    assert reader.duration in (4, 5)
    messages = list(reader.messages(reader.topics[1]))
    reader.close()
    assert messages == [(START + k, serialize_message(String(data=f'/talk {k}'))) for k in range(5)]


@pytest.mark.parametrize('storage', STORAGES)
def test_the_same_messages_give_the_same_bytes(tmp_path, storage):
    one, other = (write(tmp_path / name / 'bag', storage) for name in 'ab')
    contents = [{file.name: file.read_bytes() for file in bag.iterdir()} for bag in (one, other)]
    assert len(contents[0]) == 2
    assert contents[0] == contents[1]


@pytest.mark.parametrize('storage', STORAGES)
def test_players_find_definitions_hashes_and_quality_of_service(tmp_path, storage):
    path = write(tmp_path / 'bag', storage)
    with AnyReader([path]) as reader:  # compares the hash with that of the definition
        assert {c.msgdef.data for c in reader.connections} == {'string data\n'}
        texts = [reader.deserialize(cdr, c.msgtype).data for c, _, cdr in reader.messages()]
    assert texts[:2] == ['/talk 0', '/more/talk 0']
    info = yaml.safe_load((path / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    assert (info['version'], info['storage_identifier']) == (9, storage)
    assert info['starting_time']['nanoseconds_since_epoch'] == START
    for topic in info['topics_with_message_count']:
        described = topic['topic_metadata']
        # as `ros2 topic info --verbose` shows it for std_msgs/msg/String
        assert described['type_description_hash'] == (
            'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
        )
        (qos,) = described['offered_qos_profiles']
        assert (qos['reliability'], qos['durability'], qos['history']) == (
            'reliable', 'volatile', 'keep_last',
        )  # fmt: skip
    if storage == 'mcap':
        assert b'ros2msg' in only_file(path).read_bytes()
    else:
        with sqlite3.connect(only_file(path)) as file:
            (count,) = file.execute('SELECT COUNT(*) FROM messages').fetchone()
        assert count == 10


def test_an_empty_bag_is_a_bag(library, tmp_path):
    reader = BagReader(write(tmp_path / 'bag', count=0))
    assert reader.topics == []
    reader.close()


def test_a_bag_that_is_there_is_not_overwritten(library, tmp_path):
    path = write(tmp_path / 'bag')
    with pytest.raises(BagError, match='is there already'):
        BagWriter(path, TOPICS)
    assert is_own_bag(path)
    (path / 'notes.txt').write_text('mine')
    assert not is_own_bag(path)
    assert not is_own_bag(path / 'notes.txt')
    (path / 'notes.txt').unlink()
    assert is_own_bag(path)
    metadata = path / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace('colortrack_ros', 'somebody'))
    assert not is_own_bag(path)
    metadata.unlink()
    assert not is_own_bag(path)


@pytest.mark.parametrize('storage', STORAGES)
def test_a_bag_that_cannot_be_written_is_an_error(library, tmp_path, storage):
    message = serialize_message(String(data='much ' * 10_000))

    def fill():  # not pytest.raises, which keeps what is left open
        try:
            with contextlib.closing(BagWriter(tmp_path / 'bag', TOPICS, storage)) as bag:
                for k in range(50):
                    bag.write('/talk', START + k, message)
        except BagWriteError as error:
            return str(error)

    with file_size_limit(200_000), nothing_left_open():
        assert 'cannot be written' in fill()


def broken(path, how):
    file = only_file(path)
    content = bytearray(file.read_bytes())
    if how == 'cut':
        content = content[: len(content) // 2]
    elif how == 'empty':
        content = bytearray()
    elif how == 'noise':
        content[10:] = bytes(len(content) - 10)
    file.write_bytes(content)
    return path


def read_all(path):
    reader = BagReader(path)
    return [list(reader.messages(topic)) for topic in reader.topics]


@pytest.mark.slow
@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('how', ['cut', 'empty', 'noise'])
def test_a_broken_file_is_an_error_in_one_line(library, tmp_path, storage, how):
    path = broken(write(tmp_path / 'bag', storage, 2000), how)
    for part in (path, only_file(path)):
        with pytest.raises(BagError, match=re.escape(str(part))) as caught:
            read_all(part)
        assert '\n' not in str(caught.value)


def test_a_folder_without_its_metadata_says_what_to_do(library, tmp_path):
    path = write(tmp_path / 'bag')
    (path / 'metadata.yaml').unlink()
    assert is_bag(path)
    with pytest.raises(BagError, match='ros2 bag reindex'):
        BagReader(path)


def recorded(folder, storage, compressed=False):
    """A bag of 200 messages of up to 20 kB on two topics, by another recorder."""
    types = get_typestore(Stores.ROS2_JAZZY)
    bag = Writer(folder, version=9, storage_plugin=PLUGINS[storage])
    if compressed:
        bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    random = np.random.default_rng(1)
    with bag:
        made = [bag.add_connection(name, kind, typestore=types) for name, kind in TOPICS.items()]
        for k in range(200):
            text = random.bytes(int(random.integers(10_000))).hex()
            bag.write(made[k % 2], START + k, serialize_message(String(data=text)))
    return folder


def missing_of(topic, found, has_metadata):
    """What is told of a topic of 100 messages of which so many were found."""
    if found == 100 and has_metadata:
        return f'all messages on {topic.name} were read'
    some = f'{100 - found} of 100' if has_metadata else 'an unknown number of'
    return f'{some} messages on {topic.name} are lost'


@pytest.mark.slow
@pytest.mark.parametrize(
    ('storage', 'compressed'), [('mcap', False), ('mcap', True), ('sqlite3', False)]
)
def test_a_bag_cut_anywhere_gives_what_is_there_and_tells_what_is_lost(
    tmp_path, storage, compressed
):
    bag = recorded(tmp_path / 'bag', storage, compressed)
    reader = BagReader(bag)
    whole = {topic.name: list(reader.messages(topic)) for topic in reader.topics}
    reader.close()
    file = only_file(bag)
    content = file.read_bytes()
    lost = []
    for percent in range(1, 100):
        file.write_bytes(content[: len(content) * percent // 100])
        lost.append(200)
        for path in (bag, file) if percent % 10 == 9 else (bag,):
            try:
                reader = BagReader(path)
            except BagError as error:
                assert 'this bag cannot be read: ' in str(error)  # noqa: PT017
                continue
            read = 0
            for topic in reader.topics:
                found = []
                with pytest.raises(BagError) as told:
                    found.extend(reader.messages(topic))
                assert found == whole[topic.name][: len(found)]
                assert len(found) == topic.size
                assert missing_of(topic, len(found), path == bag) in str(told.value)
                read += len(found)
            reader.close()
            lost[-1] = 200 - read
    assert sorted(lost, reverse=True) == lost
    # At most a chunk of 1 MiB, or the pages of a leaf, is missing beside what was cut.
    share = {('mcap', False): 0.02, ('mcap', True): 0.75, ('sqlite3', False): 0.12}
    excess = np.array(lost) / 200 - (1 - np.arange(1, 100) / 100)
    assert excess.max() < share[storage, compressed]


@pytest.mark.parametrize('storage', STORAGES)
def test_a_file_of_which_only_the_beginning_was_written_is_an_error(library, tmp_path, storage):
    file = only_file(recorded(tmp_path / 'bag', storage))
    with nothing_left_open():
        for size in (100, 60, 17, 9, 8, 1, 0):
            file.write_bytes(file.read_bytes()[:size])
            with pytest.raises(BagError, match='cannot be read'):
                BagReader(file)


def test_both_libraries_read_what_the_other_has_written(tmp_path, monkeypatch):
    bags = {}
    for name, module in (('rosbags', None), ('rosbag2_py', rosbag2_py)):
        monkeypatch.setitem(sys.modules, 'rosbag2_py', module)
        bags[name] = write(tmp_path / name)
    written = read_all(bags['rosbag2_py'])
    monkeypatch.setitem(sys.modules, 'rosbag2_py', rosbag2_py)
    assert read_all(bags['rosbags']) == written
    assert is_own_bag(bags['rosbag2_py'])


def test_ros_reads_what_a_recorder_has_compressed(tmp_path, monkeypatch):
    bag = recorded(tmp_path / 'bag', 'mcap', compressed=True)
    plain = read_all(bag)
    monkeypatch.setitem(sys.modules, 'rosbag2_py', rosbag2_py)
    assert read_all(bag) == plain
    assert len(plain[0]) == 100


@pytest.mark.parametrize('gone', [('rosbags', 'apsw'), ('rosbags.rosbag2.storage_mcap',)])
def test_a_robot_replays_bags_with_nothing_but_what_ros_has(tmp_path, gone):
    bag = write(tmp_path / 'bag')
    code = f"""
import sys
from support import rosbag2_py
sys.modules['rosbag2_py'] = rosbag2_py
for name in [*sys.modules, *{gone}]:
    if name in {gone} or name.partition('.')[0] in {gone}:
        sys.modules[name] = None
import contextlib
from pathlib import Path
import colortrack_ros.replay
from colortrack_ros.bags import BagReader, canonical
reader = BagReader(Path({str(bag)!r}))
assert [len(list(reader.messages(topic))) for topic in reader.topics] == [5, 5]
assert canonical(b'any', 'std_msgs/msg/String') == b'any'
"""
    subprocess.run([sys.executable, '-c', code], check=True, cwd=ROOT / 'test')
