"""Bags as others write them, and as damage and recorders that were killed leave them."""

import re
import shutil
import sqlite3
import struct
from urllib.parse import unquote

import pytest
from rclpy.serialization import deserialize_message
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import CompressionFormat
from rosbags.rosbag2 import CompressionMode
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore
from rosbags.typesys import Stores
from std_msgs.msg import String
import yaml

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagReader
from colortrack_ros.bags import BagWriter
from colortrack_ros.bags import is_bag
from colortrack_ros.bags import STORAGES

FOREVER = '\n    sec: 0\n    nsec: 0\n'
OTHER = (
    '- history: 3\n  depth: 0\n  reliability: 1\n  durability: 2\n'
    f'  deadline:{FOREVER}  lifespan:{FOREVER}'
    f'  liveliness: 1\n  liveliness_lease_duration:{FOREVER}'
    '  avoid_ros_namespace_conventions: false'
)
"""QoS as ROS 2 Foxy wrote it."""


RECORD = struct.Struct('<BQ')
CHECKSUM = 33
"""Offset in a chunk; 0 for none."""
SCHEMA, CHANNEL, CHUNK, STATISTICS, PRIVATE = 0x03, 0x04, 0x06, 0x0B, 0x80


def bag_of_talk(path, storage, times=range(10), more=''):
    """Five messages on each of two topics."""
    bag = BagWriter(path, {'/talk': 'std_msgs/msg/String', '/more': 'std_msgs/msg/String'}, storage)
    for k, time in enumerate(times):
        bag.write(('/talk', '/more')[k % 2], time, serialize_message(String(data=str(k) + more)))
    bag.close()
    return path


def only_file(bag):
    (file,) = (path for path in bag.iterdir() if path.name != 'metadata.yaml')
    return file


def records_of(content):
    """Offset and opcode of each record of an .mcap."""
    at = 8
    while at < len(content) - 8:
        code, length = RECORD.unpack_from(content, at)
        yield at, code
        at += RECORD.size + length


def times_of(path, name='/talk'):
    """Log times of the messages of a topic, and what is told after them."""
    reader, times = BagReader(path), []
    (topic,) = (topic for topic in reader.topics if topic.name == name)
    try:
        times.extend(time for time, _ in reader.messages(topic))
        told = ''
    except BagError as error:
        told = str(error)
    reader.close()
    return times, told


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize(
    ('key', 'value'),
    [
        ('offered_qos_profiles', []),
        ('offered_qos_profiles', OTHER),
        ('type_description_hash', 'RIHS01_' + 64 * '0'),
    ],
)
def test_metadata_that_differs_from_the_files_hides_no_message(tmp_path, storage, key, value):
    """As in the bags by which rosbag2 tests itself: of four in ten no message was read."""
    bag = bag_of_talk(tmp_path / 'bag', storage)
    told = yaml.safe_load((bag / 'metadata.yaml').read_text())
    for entry in told['rosbag2_bagfile_information']['topics_with_message_count']:
        entry['topic_metadata'][key] = value
    (bag / 'metadata.yaml').write_text(yaml.safe_dump(told))
    reader = BagReader(bag)
    assert [len(list(reader.messages(topic))) for topic in reader.topics] == [5, 5]
    reader.close()


@pytest.mark.parametrize('storage', STORAGES)
def test_fewer_messages_than_metadata_tells_of_are_an_error_after_those_that_are_there(
    tmp_path, storage
):
    bag = bag_of_talk(tmp_path / 'bag', storage)
    told = yaml.safe_load((bag / 'metadata.yaml').read_text())
    told['rosbag2_bagfile_information']['topics_with_message_count'][0]['message_count'] = 7
    (bag / 'metadata.yaml').write_text(yaml.safe_dump(told))
    reader = BagReader(bag)
    (topic,) = (topic for topic in reader.topics if topic.size == 7)
    read = []
    with pytest.raises(BagError, match=r'tells of 7 messages on /(talk|more), 5 were read'):
        read.extend(reader.messages(topic))
    reader.close()
    assert len(read) == 5


@pytest.mark.parametrize('storage', STORAGES)
def test_a_count_in_metadata_that_is_no_number_hides_no_message(tmp_path, storage):
    bag = bag_of_talk(tmp_path / 'bag', storage)
    metadata = bag / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace('message_count: 5', 'message_count: lots'))
    times, told = times_of(bag)
    assert len(times) == 5
    assert 'an unknown number of messages on /talk are lost, 5 were read' in told


@pytest.mark.parametrize('storage', STORAGES)
def test_a_bag_that_is_not_serialized_as_cdr_is_not_said_to_be_cut_short(tmp_path, storage):
    bag = bag_of_talk(tmp_path / 'bag', storage)
    metadata = bag / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace(': cdr', ': other'))
    with pytest.raises(BagError, match=r'this bag cannot be read: .*other'):
        BagReader(bag)


def test_the_metadata_of_a_damaged_bag_is_read_once(tmp_path, monkeypatch):
    """That of a bag of 100,000 files takes half a minute."""
    bag, read, given = bag_of_talk(tmp_path / 'bag', 'mcap'), [], yaml.safe_load
    (file,) = bag.glob('*.mcap')
    file.write_bytes(file.read_bytes()[:-100])
    monkeypatch.setattr(yaml, 'safe_load', lambda text: read.append(text) or given(text))
    BagReader(bag).close()
    assert len(read) == 1


@pytest.mark.parametrize('storage', STORAGES)
def test_metadata_that_nobody_understands_is_told_after_all_messages(tmp_path, storage):
    bag = bag_of_talk(tmp_path / 'bag', storage)
    told = yaml.safe_load((bag / 'metadata.yaml').read_text())
    for entry in told['rosbag2_bagfile_information']['topics_with_message_count']:
        entry['topic_metadata']['offered_qos_profiles'] = '- depth: 10'
    (bag / 'metadata.yaml').write_text(yaml.safe_dump(told))
    reader, read = BagReader(bag), []
    with pytest.raises(BagError, match=r'damaged .*all messages on /more were read'):
        read.extend(reader.messages(reader.topics[0]))
    reader.close()
    assert len(read) == 5


LONG = 400_000 * '.'
"""Three messages of it fill a chunk of an .mcap."""


@pytest.mark.parametrize('what', ['file', 'folder', 'file cut short', 'power lost'])
def test_messages_after_a_broken_chunk_are_read_and_those_in_it_counted(tmp_path, what):
    bag = bag_of_talk(tmp_path / 'bag', 'mcap', more=LONG)
    file = only_file(bag)
    content = bytearray(file.read_bytes())
    chunks = [at for at, code in records_of(content) if code == CHUNK]
    assert len(chunks) == 4  # of three messages, and of the last one
    content[chunks[1] + CHECKSUM] = 1
    if what == 'file cut short':
        content = content[:-100]
    elif what == 'power lost':  # the system knew the size already
        content[chunks[2] + 500_000 :] = bytes(len(content) - chunks[2] - 500_000)
    file.write_bytes(content)
    times, told = times_of(bag if what == 'folder' else file)
    left = [0, 2] if what == 'power lost' else [0, 2, 6, 8]
    assert times == left
    lost = 'an unknown number of' if what in ('file cut short', 'power lost') else '1 of 5'
    assert f'{lost} messages on /talk' in told
    assert f'{len(left)} were read' in told


def test_an_mcap_whose_index_leaves_out_the_topics_is_read_all_the_same(tmp_path):
    file = only_file(bag_of_talk(tmp_path / 'bag', 'mcap'))
    content = bytearray(file.read_bytes())
    for at, code in list(records_of(content)):
        if code in (SCHEMA, CHANNEL, STATISTICS):
            content[at] = PRIVATE
    file.write_bytes(content)
    assert times_of(file) == ([0, 2, 4, 6, 8], '')
    assert times_of(file.parent) == ([0, 2, 4, 6, 8], '')


def test_what_was_recorded_out_of_order_and_cut_short_is_read_to_its_end(tmp_path):
    times = [1, 0, 7, 2, 5, 4, 3, 6, 9, 8]
    file = only_file(bag_of_talk(tmp_path / 'bag', 'mcap', times))
    assert times_of(file) == (sorted(times[::2]), '')
    file.write_bytes(file.read_bytes()[:-100])
    found, told = times_of(file)
    assert found == times[::2]
    assert 'an unknown number of messages on /talk are lost, 5 were read' in told


@pytest.mark.parametrize('has_metadata', [True, False])
def test_messages_that_a_killed_recorder_left_beside_the_database_are_read(tmp_path, has_metadata):
    bag = bag_of_talk(tmp_path / 'bag', 'sqlite3')
    recording = sqlite3.connect(only_file(bag))
    recording.execute('PRAGMA journal_mode=WAL')
    recording.execute('UPDATE messages SET timestamp = timestamp + 100')
    recording.commit()
    left = shutil.copytree(bag, tmp_path / 'left')
    recording.close()
    path = left if has_metadata else left / 'bag.db3'
    times, told = times_of(path)
    assert times == [100, 102, 104, 106, 108]
    assert ('bag.db3-wal is there' if has_metadata else 'an unknown number') in told


@pytest.mark.parametrize('name', ['50%25', 'run%20a', 'run#1', 'what?', "it's", 'file:a'])
@pytest.mark.parametrize('storage', STORAGES)
def test_a_bag_of_any_name_is_written_and_read_and_no_other_one(tmp_path, storage, name):
    """As parts of a URI, 50%25 is 50%, and a name ends at # and ?."""
    like_it = re.split('[#?]', unquote(name))[0]
    if like_it != name:
        bag_of_talk(tmp_path / like_it, storage)
    bag = bag_of_talk(tmp_path / name, storage, range(100, 110))
    assert {path.name for path in tmp_path.iterdir()} == {name, like_it}
    for path in (bag, only_file(bag)):
        assert times_of(path) == ([100, 102, 104, 106, 108], '')


@pytest.mark.parametrize('storage', STORAGES)
def test_files_that_metadata_does_not_name_are_told(tmp_path, storage):
    bag = bag_of_talk(tmp_path / 'bag', storage)
    (bag / 'notes.txt').write_text('mine')
    assert times_of(bag) == ([0, 2, 4, 6, 8], '')
    (bag / 'notes.txt').unlink()
    more = bag / f'more{only_file(bag).suffix}'
    shutil.copy(only_file(bag), more)
    times, told = times_of(bag)
    assert times == [0, 2, 4, 6, 8]
    assert f'does not tell of {more.name}, ' in told
    assert 'ros2 bag reindex' in told


@pytest.mark.parametrize('mode', [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_files_of_compressed_bags_are_read_alone_or_it_is_told_how(tmp_path, mode):
    types, bag = get_typestore(Stores.ROS2_JAZZY), tmp_path / 'bag'
    writer = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        talk = writer.add_connection('/talk', 'std_msgs/msg/String', typestore=types)
        for k in range(5):
            writer.write(talk, k, serialize_message(String(data=str(k))))
    assert times_of(bag) == ([0, 1, 2, 3, 4], '')
    if mode is CompressionMode.MESSAGE:
        reader = BagReader(only_file(bag))
        texts = [deserialize_message(cdr, String) for _, cdr in reader.messages(*reader.topics)]
        reader.close()
        assert [message.data for message in texts] == list('01234')
        return
    (bag / 'metadata.yaml').unlink()
    for path in (bag, *bag.iterdir()):
        assert is_bag(path)
        with pytest.raises(BagError, match='zstd -d'):
            BagReader(path)


def test_an_mcap_of_other_messages_is_told(tmp_path):
    file = only_file(bag_of_talk(tmp_path / 'bag', 'mcap'))
    file.write_bytes(file.read_bytes().replace(b'ros2', b'ros1', 1))
    with pytest.raises(BagError, match='expected messages of ROS 2, with profile: ros2'):
        BagReader(file)
