"""Stands in for rosbag2_py, which needs ROS: what is used of it, by its names, with rosbags."""

import contextlib
from pathlib import Path
from types import SimpleNamespace

from rclpy.duration import Duration
from rosbags.rosbag2 import Reader
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore
from rosbags.typesys import Stores


def ConverterOptions(input_serialization_format='', output_serialization_format=''):
    return input_serialization_format, output_serialization_format


def StorageOptions(*, uri, storage_id='', custom_data=None):
    assert isinstance(uri, str)
    return SimpleNamespace(uri=uri, storage_id=storage_id, custom_data=custom_data or {})


def StorageFilter(*, topics=()):
    return list(topics)


def TopicMetadata(*, id, name, type, serialization_format):
    return SimpleNamespace(id=id, name=name, type=type, serialization_format=serialization_format)


class Info:
    def read_metadata(self, uri, storage_id):
        assert storage_id in ('', 'mcap', 'sqlite3')
        metadata = Path(uri) / 'metadata.yaml'
        text = metadata.read_text() if metadata.exists() else ''
        with _opened(uri) as bag:
            topics = [
                SimpleNamespace(
                    topic_metadata=TopicMetadata(
                        id=c.id, name=c.topic, type=c.msgtype, serialization_format='cdr'
                    ),
                    message_count=c.msgcount,
                )
                for c in bag.connections
            ]
            return SimpleNamespace(
                duration=Duration(nanoseconds=bag.duration),
                topics_with_message_count=topics,
                compression_format='zstd' if 'compression_format: zstd' in text else '',
            )


def _opened(uri):
    try:
        return Reader(Path(uri))
    except Exception as error:
        raise RuntimeError(f'No storage could be initialized from the inputs: {error}') from error


class SequentialReader:
    compressed = False

    def open(self, storage_options, converter_options):
        assert converter_options == ('cdr', 'cdr')
        self._bag = _opened(storage_options.uri)
        self._bag.open()
        assert bool(Info().read_metadata(storage_options.uri, '').compression_format) is (
            self.compressed
        )
        self._pending = None
        self._topics = None

    def __del__(self):
        if hasattr(self, '_bag') and self._bag.is_open:
            self._bag.close()

    def set_filter(self, storage_filter):
        self._topics = storage_filter

    def _look(self):
        if self._pending is None:
            chosen = [c for c in self._bag.connections if c.topic in self._topics]
            self._pending = list(self._bag.messages(chosen))[::-1]

    def has_next(self):
        self._look()
        return bool(self._pending)

    def read_next(self):
        self._look()
        connection, time, cdr = self._pending.pop()
        return connection.topic, bytes(cdr), time


class SequentialCompressionReader(SequentialReader):
    compressed = True


class SequentialWriter:
    def open(self, storage_options, converter_options):
        assert converter_options == ('cdr', 'cdr')
        plugin = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}
        try:
            self._writer = Writer(
                Path(storage_options.uri),
                version=Writer.VERSION_LATEST,
                storage_plugin=plugin[storage_options.storage_id],
            )
            for key, value in storage_options.custom_data.items():
                self._writer.set_custom_data(key, value)
            self._writer.open()
        except OSError as error:
            raise RuntimeError(f'Failed to create bag directory: {error}') from error
        self._topics = {}

    def create_topic(self, topic):
        self._topics[topic.name] = self._writer.add_connection(
            topic.name, topic.type, typestore=get_typestore(Stores.ROS2_JAZZY)
        )

    def write(self, topic_name, message, time):
        assert isinstance(message, bytes)
        self._writer.write(self._topics[topic_name], time, message)

    def close(self):
        try:
            self._writer.close()
        except Exception:  # a destructor closes the file in any case
            with contextlib.suppress(Exception):
                self._writer.abort()
            raise
