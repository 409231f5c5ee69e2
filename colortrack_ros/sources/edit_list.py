"""Counts the pictures of an MP4 or MOV file that its edit list shows (ISO/IEC 14496-12, 8.6).

A video that was cut without reencoding starts at a key frame before the cut. The pictures before
the cut stay in the file: they are decoded but not shown, and the file's picture count includes
them.
"""

from collections.abc import Iterator
import struct
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.files import open_file

LARGEST_INDEX = 1 << 26
"""Maximum number of bytes of an index to read: at 20 bytes per picture, 30 hours at 30 Hz."""

MOST_PICTURES = 1 << 22
"""Maximum number of pictures in an index, 38 hours at 30 Hz: twelve bytes can claim four
billion."""

HEADER, LONG_HEADER = 8, 16
"""Bytes before the content of a box: length and kind, without and with a 64-bit length."""


def shown_pictures(path: str) -> int | None:
    """Count the pictures of the first video track that lie within its edits.

    :returns: None if there is no edit list that can be parsed, as in other formats.
    """
    try:
        with open_file(path) as file:
            boxes = list(_boxes(_index(file)))
        tracks = [_flat(content) for kind, content in boxes if kind == b'trak']
        track = next(track for track in tracks if track[b'hdlr'][8:12] == b'vide')
        shown = _is_shown(track, _scale(dict(boxes)[b'mvhd']))
    except (OSError, ValueError, KeyError, IndexError, StopIteration, struct.error):
        return None
    return int(np.count_nonzero(shown))


def _index(file: BinaryIO) -> bytes:
    """The content of the moov box, empty if there is none."""
    size, at = file.seek(0, 2), 0
    while at + HEADER <= size:
        file.seek(at)
        length, kind = struct.unpack('>I4s', file.read(HEADER))
        header = HEADER
        if length == 1:
            (length,) = struct.unpack('>Q', file.read(LONG_HEADER - HEADER))
            header = LONG_HEADER
        if kind == b'moov':
            return file.read(min(length - header, LARGEST_INDEX) if length else LARGEST_INDEX)
        if length < header:
            break
        at += length
    return b''


def _boxes(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the kind and content of each box."""
    at = 0
    while at + HEADER <= len(content):
        length, kind = struct.unpack_from('>I4s', content, at)
        if length < HEADER:
            return
        yield kind, content[at + HEADER : at + length]
        at += length


def _flat(track: bytes) -> dict[bytes, bytes]:
    """The boxes of a track, including those nested in container boxes."""
    found = dict(_boxes(track))
    for holder in (b'edts', b'mdia', b'minf', b'stbl'):
        found = dict(_boxes(found.get(holder, b''))) | found
    return found


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
        end = start + duration * _scale(track[b'mdhd']) / scale if duration else np.inf
        shown |= (start >= 0) & (time >= start) & (time < end)
    return shown


def _scale(header: bytes) -> int:
    """Time units per second, from an mvhd or mdhd box."""
    (scale,) = struct.unpack_from('>I', header, 20 if header[0] == 1 else 12)
    return int(scale)


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
