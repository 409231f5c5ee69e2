"""The view of one frame on the page, and its encoding for transmission."""

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
"""JPEG quality of the pictures that are sent: edges of colors stay, at a tenth of the bytes."""

LENGTHS = struct.Struct('<III')
"""Header of each message: sizes of its JSON, of its JPEG, and of the PNG of its mask [bytes]."""

AS_BEFORE = 0xFFFFFFFF
"""In place of the size of the JPEG: none is sent, the picture is that of the view before. 0 is the
size of a picture without pixels."""


class Picture:
    """A frame and its JPEG, which do not change with the settings."""

    def __init__(self, frame: Frame) -> None:
        self.frame = frame

    @cached_property
    def jpeg(self) -> bytes:
        """The JPEG, encoded when it is first needed."""
        return jpeg_of(writable_bgr(self.frame))


@dataclass(frozen=True)
class ShownFrame:
    """One frame and its results.

    :param number: of the frame.
    :param picture: of the frame.
    :param labels: (H, W), k + 1 where a blob of color k may be, 0 elsewhere.
    :param detections: in the frame.
    :param tracks: after the frame; None while unknown.
    :param trails: of the tracks.
    :param milliseconds: computation time.
    :param trouble: advice of the detector, empty if all is well.
    :param revision: of the settings used.
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
        """The frame."""
        return self.picture.frame

    @cached_property
    def results(self) -> tuple[bytes, bytes]:
        """JSON, and PNG of the labels, encoded when they are first needed."""
        text = self.found() | {
            'before_limits': blobs_before_limits(self.labels),
            'trails': self.trails,
            'milliseconds': round(self.milliseconds, 2),
            'revision': self.revision,
        }
        return json.dumps(text, allow_nan=False).encode(), png_of(self.labels)

    def encoded(self, *, has_picture: bool = False) -> bytes:
        """Lengths, JSON, JPEG of the picture, and PNG of the labels.

        :param has_picture: whether the browser has the picture from another view of the frame; then
            there is no JPEG.
        """
        text, png = self.results
        jpeg = b'' if has_picture else self.picture.jpeg
        lengths = LENGTHS.pack(len(text), AS_BEFORE if has_picture else len(jpeg), len(png))
        return lengths + text + jpeg + png

    def found(self) -> dict[str, Any]:
        """The results in JSON."""
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
    """The trail of each track by ID, oldest position first [px]."""
    known = ~np.isnan(trails.points[:, :, 0])
    return {
        track: points[there].round(1).tolist()
        for track, points, there in zip(trails.ids.tolist(), trails.points, known, strict=True)
    }


def _rows(rows: NDArray[np.void]) -> list[dict[str, Any]]:
    """Rows in JSON; values that are not finite, which JSON lacks, are null."""
    names = rows.dtype.names or ()
    columns = [rows[name].astype(object) for name in names]
    for name, column in zip(names, columns, strict=True):
        column[~np.isfinite(rows[name])] = None
    values = (column.tolist() for column in columns)
    return [dict(zip(names, row, strict=True)) for row in zip(*values, strict=True)]


def jpeg_of(image: NDArray[np.uint8]) -> bytes:
    """A BGR picture as JPEG; empty if it has no pixels."""
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    return cv2.imencode('.jpg', image, options)[1].tobytes() if image.size else b''


def png_of(image: NDArray[np.uint8]) -> bytes:
    """A BGR or gray picture as PNG, lossless; empty if it has no pixels."""
    options = [cv2.IMWRITE_PNG_COMPRESSION, 1]
    return cv2.imencode('.png', image, options)[1].tobytes() if image.size else b''
