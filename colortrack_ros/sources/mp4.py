"""Boxes of MP4 and MOV files (ISO/IEC 14496-12)."""

from collections.abc import Iterator
import struct
from typing import BinaryIO

from colortrack_ros.files import open_file

LARGEST_INDEX = 1 << 26
"""Maximum number of bytes of an index to read: at 20 bytes per picture, 30 hours at 30 Hz."""

MOST_PICTURES = 1 << 22
"""Maximum number of pictures in an index, 38 hours at 30 Hz: twelve bytes can claim four
billion."""

HEADER, LONG_HEADER = 8, 16
"""Bytes before the content of a box: length and kind, without and with a 64-bit length."""


def index_of(file: BinaryIO) -> bytes:
    """The content of the moov box, empty if there is none."""
    size, at = file.seek(0, 2), 0
    while at + HEADER <= size:
        kind, header, length = box_at(file, at, size)
        if length < header:
            break
        if kind == b'moov':
            file.seek(at + header)
            return file.read(min(length - header, LARGEST_INDEX))
        at += length
    return b''


def box_at(file: BinaryIO, at: int, size: int) -> tuple[bytes, int, int]:
    """Kind of a box, length of its header, and length of all of it [bytes].

    :param size: of the file, to whose end a box of length 0 extends; what is missing there is 0.
    """
    file.seek(at)
    head = file.read(LONG_HEADER).ljust(LONG_HEADER, b'\0')
    length, kind, longer = struct.unpack('>I4sQ', head)
    if length == 1:
        return kind, LONG_HEADER, longer
    return kind, HEADER, length or size - at


def lacks_index(path: str) -> bool:
    """Whether a file of this format has no index at all, without which nothing can be read."""
    try:
        with open_file(path) as file:
            return file.read(HEADER)[4:] == b'ftyp' and not index_of(file)
    except (OSError, struct.error):
        return False


def boxes_of(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the kind and content of each box."""
    at = 0
    while at + HEADER <= len(content):
        length, kind = struct.unpack_from('>I4s', content, at)
        if length < HEADER:
            return
        yield kind, content[at + HEADER : at + length]
        at += length


def flat_track(track: bytes) -> dict[bytes, bytes]:
    """The boxes of a track, including those nested in container boxes."""
    found = dict(boxes_of(track))
    for holder in (b'edts', b'mdia', b'minf', b'stbl'):
        found = dict(boxes_of(found.get(holder, b''))) | found
    return found


def time_scale(header: bytes) -> int:
    """Time units per second, from an mvhd or mdhd box.

    :raises ValueError: if it is 0.
    """
    (scale,) = struct.unpack_from('>I', header, 20 if header[0] == 1 else 12)
    if not scale:
        raise ValueError('no time scale')
    return int(scale)
