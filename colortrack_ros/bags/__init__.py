"""bags: recordings of messages (rosbag2, in mcap or sqlite3), as bytes with log times."""

from colortrack_ros.bags.bag_file import STORAGES
from colortrack_ros.bags.bag_file import Topic
from colortrack_ros.bags.errors import BagError
from colortrack_ros.bags.errors import BagWriteError
from colortrack_ros.bags.library import canonical
from colortrack_ros.bags.reader import BagReader
from colortrack_ros.bags.reader import is_bag
from colortrack_ros.bags.writer import BagWriter
from colortrack_ros.bags.writer import is_own_bag

__all__ = [
    'STORAGES',
    'BagError',
    'BagReader',
    'BagWriteError',
    'BagWriter',
    'Topic',
    'canonical',
    'is_bag',
    'is_own_bag',
]
