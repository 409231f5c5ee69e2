"""What the page shows of one frame, and how it goes over the wire."""

from dataclasses import dataclass
from functools import cached_property
import json
import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.drawing import Trails
from colortrack_ros.encodings import writable_bgr
from colortrack_ros.tuner.measures import blobs_before_limits

JPEG_QUALITY = 85
"""Of the pictures that are sent: edges of colors stay, at a tenth of the bytes."""

LENGTHS = struct.Struct('<III')
"""Before each message: bytes of its JSON, of its JPEG, and of the PNG of its mask."""


class Picture:
    """A frame, which stays as it is while settings change, and so does its JPEG."""

    def __init__(self, frame: Frame) -> None:
        self.frame = frame

    @cached_property
    def jpeg(self) -> bytes:
        """For the eye; made when it is first asked for."""
        return jpeg_of(writable_bgr(self.frame))


@dataclass(frozen=True)
class ShownFrame:
    """One frame, and what was found in it.

    :param number: of the frame.
    :param picture: of the frame.
    :param labels: (H, W), k + 1 where a blob of color k may be, 0 elsewhere.
    :param detections: in the frame.
    :param tracks: after the frame; None while they are not known.
    :param trails: of the tracks.
    :param milliseconds: that finding them took.
    :param trouble: advice of the detector, empty when all is well.
    :param revision: of the settings that it was found with.
    """

    number: int
    picture: Picture
    labels: NDArray[np.uint8]
    detections: Detections
    tracks: Tracks | None
    trails: dict[int, list[list[float]]]
    milliseconds: float
    trouble: str
    revision: int = 0

    @property
    def frame(self) -> Frame:
        """That was looked at."""
        return self.picture.frame

    def encoded(self) -> bytes:
        """Lengths, JSON, JPEG of the picture, and PNG of the labels."""
        text = self.found() | {
            'before_limits': blobs_before_limits(self.labels),
            'trails': self.trails,
            'milliseconds': round(self.milliseconds, 2),
            'revision': self.revision,
        }
        jpeg, png = self.picture.jpeg, png_of(self.labels)
        header = json.dumps(text, allow_nan=False).encode()
        return LENGTHS.pack(len(header), len(jpeg), len(png)) + header + jpeg + png

    def found(self) -> dict[str, Any]:
        """What was found where, as JSON has it."""
        height, width = self.labels.shape
        return {
            'number': self.number,
            'time': self.frame.stamp / NANOSECONDS,
            'size': [width, height],
            'blobs': _rows(self.detections.rows),
            'tracks': None if self.tracks is None else _rows(self.tracks.rows),
            'trouble': self.trouble,
        }


def trails_of(trails: Trails) -> dict[int, list[list[float]]]:
    """Where each track has been, oldest first, by ID [px]."""
    known = ~np.isnan(trails.points[:, :, 0])
    return {
        track: points[there].round(1).tolist()
        for track, points, there in zip(trails.ids.tolist(), trails.points, known, strict=True)
    }


def _rows(rows: NDArray[np.void]) -> list[dict[str, Any]]:
    """Rows as JSON has them: what is not finite, which JSON has not, is null."""
    names = rows.dtype.names or ()
    columns = [rows[name].astype(object) for name in names]
    for name, column in zip(names, columns, strict=True):
        column[~np.isfinite(rows[name])] = None
    values = (column.tolist() for column in columns)
    return [dict(zip(names, row, strict=True)) for row in zip(*values, strict=True)]


def jpeg_of(image: NDArray[np.uint8]) -> bytes:
    """A picture, BGR, for the eye; empty if it has no pixels."""
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    return cv2.imencode('.jpg', image, options)[1].tobytes() if image.size else b''


def png_of(image: NDArray[np.uint8]) -> bytes:
    """A picture, BGR or gray, as it is; empty if it has no pixels."""
    options = [cv2.IMWRITE_PNG_COMPRESSION, 1]
    return cv2.imencode('.png', image, options)[1].tobytes() if image.size else b''
