"""Bags as others write them, whose metadata.yaml does not say what is in their files."""

import pytest
from rclpy.serialization import serialize_message
from std_msgs.msg import String
import yaml

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagReader
from colortrack_ros.bags import BagWriter
from colortrack_ros.bags import STORAGES

FOREVER = '\n    sec: 0\n    nsec: 0\n'
OTHER = (
    '- history: 3\n  depth: 0\n  reliability: 1\n  durability: 2\n'
    f'  deadline:{FOREVER}  lifespan:{FOREVER}'
    f'  liveliness: 1\n  liveliness_lease_duration:{FOREVER}'
    '  avoid_ros_namespace_conventions: false'
)
"""QoS as ROS 2 Foxy wrote it."""


def bag_of_talk(path, storage):
    """Five messages on each of two topics."""
    bag = BagWriter(path, {'/talk': 'std_msgs/msg/String', '/more': 'std_msgs/msg/String'}, storage)
    for k in range(10):
        bag.write(('/talk', '/more')[k % 2], k, serialize_message(String(data=str(k))))
    bag.close()
    return path


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
def test_a_bag_that_is_not_serialized_as_cdr_is_not_said_to_be_cut_short(tmp_path, storage):
    bag = bag_of_talk(tmp_path / 'bag', storage)
    metadata = bag / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace(': cdr', ': other'))
    with pytest.raises(BagError, match=r'this bag cannot be read: .*other'):
        BagReader(bag)


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
