"""The outputs of ``replay``: a bag, tables of the tracks, a video."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Iterator
import csv
import itertools
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import PointCloud2

from colortrack_ros.bags import BagWriter
from colortrack_ros.bags import canonical
from colortrack_ros.data import CORNER
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.drawing import draw_tracks
from colortrack_ros.drawing import Trails
from colortrack_ros.drawing import VideoFile
from colortrack_ros.encodings import writable_bgr
from colortrack_ros.files import named_in_errors
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import cloud_of_outlines
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import header_of
from colortrack_ros.messages import MarkerWriter
from colortrack_ros.node_kit.detections_intake import CLOUD
from colortrack_ros.replay.recordings import CAMERA_INFO
from colortrack_ros.replay.recordings import Item
from colortrack_ros.replay.setup import Setup

MESSAGE_TYPES = {
    'camera_info': CAMERA_INFO,
    'detections': CLOUD,
    'tracks': CLOUD,
    'outlines': CLOUD,
    'markers': 'visualization_msgs/msg/MarkerArray',
}

STATE = ('u', 'v', 'du', 'dv')
BEFORE = ('track_id', 'color', 'state')
AFTER = ('age', 'time_since_update', 'hits', 'area', 'box_w', 'box_h', 'score', *CORNER)
UPPER = np.triu_indices(len(STATE))
COLUMNS = (
    'stamp',
    'frame',
    *BEFORE,
    *STATE,
    *(f'cov_{a}_{b}' for a, b in itertools.combinations_with_replacement(STATE, 2)),
    *AFTER,
)
"""Columns of the CSV: stamp [ns], number of the frame from 1, and the fields of a track, including
the upper triangle of the covariance."""


class Output(ABC):
    """One output file or folder."""

    def write_detections(self, item: Item, detections: Detections) -> None:  # noqa: B027
        """Add the detections of a frame, if this output has them."""

    @abstractmethod
    def write(self, number: int, item: Item, tracks: Tracks) -> None:
        """Add the tracks after a frame.

        :param number: of the frame, from 1; refused frames count.
        """

    @abstractmethod
    def close(self) -> None:
        """Finish the file."""


class BagOutput(Output):
    """A bag of detections, tracks, outlines, and markers as the nodes publish them.

    A CameraInfo before the first detections gives the picture size, which the tracker needs to
    reproduce the tracks.

    :raises BagError: the folder exists or cannot be created.
    """

    def __init__(self, path: Path, storage: str, setup: Setup) -> None:
        self._topics = setup.topics
        self._scale = setup.tracker.output.marker_scale
        topics = {
            self._topics[name]: kind for name, kind in MESSAGE_TYPES.items() if self._topics[name]
        }
        self._bag = BagWriter(path, topics, storage)
        self._last = dict.fromkeys(MESSAGE_TYPES, 0)
        self._markers = MarkerWriter()
        self._image_size = 0, 0

    def write_detections(self, item: Item, detections: Detections) -> None:
        """Write one message; recorded detections are copied."""
        if self._topics['camera_info'] and detections.image_size != self._image_size:
            width, height = self._image_size = detections.image_size
            header = header_of(detections.stamp, detections.frame_id)
            self._add('camera_info', item, CameraInfo(header=header, width=width, height=height))
        recorded = item.cdr and isinstance(item.content, Detections)
        self._add('detections', item, None if recorded else cloud_of_detections(detections))

    def write(self, number: int, item: Item, tracks: Tracks) -> None:
        """Write one message of tracks, one of outlines if the tracker has them, and one of
        markers.
        """
        self._add('tracks', item, cloud_of_tracks(tracks))
        if self._topics['outlines']:
            self._add('outlines', item, cloud_of_outlines(tracks))
        self._put('markers', item, self._markers.write(tracks, self._scale))

    def _add(self, name: str, item: Item, message: CameraInfo | PointCloud2 | None) -> None:
        """Write a message; None: the recorded one."""
        recorded = message is None
        self._put(name, item, item.cdr if recorded else _serialized(message, MESSAGE_TYPES[name]))

    def _put(self, name: str, item: Item, cdr: bytes) -> None:
        # A reordered message may have been recorded after its successors.
        self._last[name] = max(self._last[name], item.log_time)
        self._bag.write(self._topics[name], self._last[name], cdr)

    def close(self) -> None:
        """Write the index and the metadata."""
        self._bag.close()


def _serialized(message: object, kind: str) -> bytes:
    return canonical(serialize_message(message), kind)


class TextOutput(Output):
    """A file of text."""

    def __init__(self, path: Path) -> None:
        self._path, self._file = path, path.open('w', newline='')

    def close(self) -> None:
        """Finish the file."""
        with named_in_errors(self._path):
            self._file.close()


class CsvOutput(TextOutput):
    """A CSV file: one line for each track in each frame, with all digits."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._table = csv.writer(self._file, lineterminator='\n')
        self._table.writerow(COLUMNS)

    def write(self, number: int, item: Item, tracks: Tracks) -> None:
        """The tracks."""
        with named_in_errors(self._path):
            self._table.writerows(lines_of(number, tracks))


def lines_of(number: int, tracks: Tracks) -> Iterator[list[Any]]:
    """The values of COLUMNS, for each track."""
    for row in tracks.rows:
        values = [row[name].item() for name in (*BEFORE, *STATE)]
        values += row['covariance'][UPPER].tolist()
        values += [row[name] for name in AFTER]
        yield [tracks.stamp, number, *values]


class MotOutput(TextOutput):
    """A file in MOTChallenge format: frame, id, left, top, width, height, score, -1, -1, -1.

    Frames count from 1, and so do pixels: the center of the top left one is (1, 1). Only confirmed
    and coasting tracks are written; the box is that of the last detection, moved with the estimate.
    """

    def write(self, number: int, item: Item, tracks: Tracks) -> None:
        """The tracks."""
        for row in tracks.rows[tracks.rows['state'] != TENTATIVE]:
            width, height = float(row['box_w']), float(row['box_h'])
            left, top = float(row['box_u']) + 1, float(row['box_v']) + 1
            with named_in_errors(self._path):
                self._file.write(
                    f'{number},{row["track_id"]},{left:.3f},{top:.3f},{width:.3f},{height:.3f},'
                    f'{row["score"]:.4f},-1,-1,-1\n'
                )


class VideoOutput(Output):
    """An MPEG-4 video of the pictures with the tracks drawn on them.

    :param rate: frames a second [Hz].
    """

    def __init__(self, path: Path, rate: float) -> None:
        self._path, self._rate = path, rate
        self._trails = Trails()
        self._video: VideoFile | None = None

    def write(self, number: int, item: Item, tracks: Tracks) -> None:
        """Write the picture, scaled to the size of the first one."""
        assert isinstance(item.content, Frame)
        image = writable_bgr(item.content)
        self._trails.update(tracks)
        draw_tracks(image, tracks, self._trails)
        if self._video is None:
            self._video = VideoFile(self._path, self._rate, (image.shape[1], image.shape[0]))
        self._video.write(image)

    def close(self) -> None:
        """Finish the file."""
        if self._video is not None:
            self._video.close()
