"""Where the pictures of a file end, in formats whose duration includes the sound."""

from typing import BinaryIO

from colortrack_ros.files import open_file

TS_PACKETS, TS_SYNC = ((188, 0), (192, 4), (204, 0)), 0x47
"""Sizes of the packets of transport streams, and the place of a packet's first byte (ISO/IEC
13818-1, 2.4.3): plain, after a time (M2TS), and before a code against errors (DVB)."""

PACK = b'\0\0\1\xba'
"""Beginning of a program stream."""

FLV_START, TAG_HEADER = 13, 11
"""Size of the header of an FLV file, and of each tag [bytes]."""

PICTURE_TAG = 9
"""Kind of a tag with a picture."""

AVC, PICTURE_DATA = 7, 1
"""H.264 in FLV, and its packets that are pictures, not headers or the end."""


def last_picture(path: str) -> float | None:
    """Time of the last picture [s], from the first; 0 if the format does not tell.

    :returns: None if it is the duration that tells: another format, or an FLV file that is cut off.
    """
    try:
        with open_file(path) as file:
            if _packet(file):
                return 0.0
            file.seek(0)
            head = file.read(len(PACK))
            if head == PACK:
                return 0.0
            if head[:3] == b'FLV':
                return _last_of_flv(file)
    except (OSError, ValueError, IndexError):
        pass
    return None


def is_cut_off(path: str) -> bool:
    """Whether a transport stream, which has neither index nor end, ends within a packet."""
    try:
        with open_file(path) as file:
            packet = _packet(file)
            return packet > 0 and file.seek(0, 2) % packet > 0
    except (OSError, IndexError):
        return False


def _packet(file: BinaryIO) -> int:
    """Size of the packets of a transport stream [bytes]; 0 for others.

    :raises IndexError: if the file is shorter than three.
    """
    head = file.read(3 * max(TS_PACKETS)[0])
    for size, first in TS_PACKETS:
        if {head[first + k * size] for k in range(3)} == {TS_SYNC}:
            return size
    return 0


def _last_of_flv(file: BinaryIO) -> float:
    """Time from the first picture to the last [s]: each tag is followed by its size.

    :raises ValueError: if the file does not begin and end with whole tags.
    """
    size, at, first = file.seek(0, 2), FLV_START, None
    while first is None:
        first, length = _tag(file, at)
        at += length + 4
    last = None
    while last is None:
        file.seek(size - 4)
        length = int.from_bytes(file.read(4), 'big')
        last, same = _tag(file, size - 4 - length)
        if same != length:
            raise ValueError('no whole tag')
        size -= length + 4
    return last - first


def _tag(file: BinaryIO, at: int) -> tuple[float | None, int]:
    """Time of a picture [s], None if it is another tag, and the tag's size [bytes].

    :raises ValueError: if there is no tag.
    """
    file.seek(at)
    head = file.read(TAG_HEADER + 2)
    if len(head) < TAG_HEADER or at < FLV_START:
        raise ValueError('no tag')
    length = TAG_HEADER + int.from_bytes(head[1:4], 'big')
    is_header = head[TAG_HEADER] & 15 == AVC and head[TAG_HEADER + 1] != PICTURE_DATA
    if head[0] & 31 != PICTURE_TAG or is_header:
        return None, length
    return (head[7] << 24 | int.from_bytes(head[4:7], 'big')) / 1000, length
