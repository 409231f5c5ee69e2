"""How many pictures of an MP4 or MOV file its edit list shows (ISO/IEC 14496-12, 8.6).

A film that was cut without encoding it again begins at a key frame before the cut. What is before
the cut stays in the file, to be decoded and not shown, and the file's number of pictures counts it.
"""

from collections.abc import Iterator
import struct
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.files import open_file

LARGEST_INDEX = 1 << 26
"""Bytes of an index that are read at most: 20 for each picture are 30 hours at 30 Hz."""

MOST_PICTURES = 1 << 22
"""Pictures of an index at most, 38 hours at 30 Hz: twelve bytes can claim four billion."""

HEADER, LONG_HEADER = 8, 16
"""Bytes before the content of a box: its length and kind, and a length of 64 bits."""


def shown_pictures(path: str) -> int | None:
    """The pictures of the first video track that are within its edits.

    :returns: None where there is no edit list that can be understood, as in other formats.
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
    """The content of the box moov, empty if there is none."""
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
    """Kind and content of each box."""
    at = 0
    while at + HEADER <= len(content):
        length, kind = struct.unpack_from('>I4s', content, at)
        if length < HEADER:
            return
        yield kind, content[at + HEADER : at + length]
        at += length


def _flat(track: bytes) -> dict[bytes, bytes]:
    """The boxes of a track, and those within the ones that only hold others."""
    found = dict(_boxes(track))
    for holder in (b'edts', b'mdia', b'minf', b'stbl'):
        found = dict(_boxes(found.get(holder, b''))) | found
    return found


def _is_shown(track: dict[bytes, bytes], scale: int) -> NDArray[np.bool_]:
    """(N,) whether the time of each picture is within an edit.

    :param scale: units of the edits' durations in a second.
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
    """Units of time in a second, of the boxes mvhd and mdhd."""
    (scale,) = struct.unpack_from('>I', header, 20 if header[0] == 1 else 12)
    return int(scale)


def _run_lengths(content: bytes, kind: str) -> NDArray[np.int64]:
    """(N,) a value for each picture, of the boxes stts and ctts.

    :raises ValueError: they are of more than MOST_PICTURES.
    """
    (count,) = struct.unpack_from('>I', content, 4)
    runs = np.frombuffer(content, np.dtype(f'>u4, {kind}'), count, 8)
    length = runs['f0'].astype(np.int64)
    if length.sum() > MOST_PICTURES:
        raise ValueError(f'{length.sum()} pictures')
    return np.repeat(runs['f1'].astype(np.int64), length)
