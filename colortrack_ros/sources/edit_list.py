"""Counts the pictures of an MP4 or MOV file that its edit list shows (ISO/IEC 14496-12, 8.6).

A video that was cut without reencoding starts at a key frame before the cut. The pictures before
the cut stay in the file: they are decoded but not shown, and the file's picture count includes
them.
"""

import struct

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.files import open_file
from colortrack_ros.sources.mp4 import boxes_of
from colortrack_ros.sources.mp4 import flat_track
from colortrack_ros.sources.mp4 import index_of
from colortrack_ros.sources.mp4 import MOST_PICTURES
from colortrack_ros.sources.mp4 import time_scale


def shown_pictures(path: str) -> int | None:
    """Count the pictures of the first video track that lie within its edits.

    :returns: None if there is no edit list that can be parsed, as in other formats.
    """
    try:
        with open_file(path) as file:
            boxes = list(boxes_of(index_of(file)))
        tracks = [flat_track(content) for kind, content in boxes if kind == b'trak']
        track = next(track for track in tracks if track[b'hdlr'][8:12] == b'vide')
        shown = _is_shown(track, time_scale(dict(boxes)[b'mvhd']))
    except (OSError, ValueError, KeyError, IndexError, StopIteration, struct.error):
        return None
    return int(np.count_nonzero(shown))


def _is_shown(track: dict[bytes, bytes], scale: int) -> NDArray[np.bool_]:
    """(N,) whether the time of each picture lies within an edit.

    :param scale: time units per second for the durations of edits.
    """
    steps = _run_lengths(track[b'stts'], '>u4')
    time = np.cumsum(steps) - steps
    if b'ctts' in track:
        time = time + _run_lengths(track[b'ctts'], '>i4')
    edits = track[b'elst']
    (count,) = struct.unpack_from('>I', edits, 4)
    entry = np.dtype('>u8, >i8, >u4' if edits[0] == 1 else '>u4, >i4, >u4')
    shown = np.zeros(len(time), bool)
    for duration, start, _ in np.frombuffer(edits, entry, count, 8).tolist():
        end = start + duration * time_scale(track[b'mdhd']) / scale if duration else np.inf
        shown |= (start >= 0) & (time >= start) & (time < end)
    return shown


def _run_lengths(content: bytes, kind: str) -> NDArray[np.int64]:
    """(N,) value for each picture, from an stts or ctts box.

    :raises ValueError: if there are more than MOST_PICTURES pictures.
    """
    (count,) = struct.unpack_from('>I', content, 4)
    runs = np.frombuffer(content, np.dtype(f'>u4, {kind}'), count, 8)
    length = runs['f0'].astype(np.int64)
    if length.sum() > MOST_PICTURES:
        raise ValueError(f'{length.sum()} pictures')
    return np.repeat(runs['f1'].astype(np.int64), length)
