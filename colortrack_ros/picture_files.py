"""Reads untrusted picture files; checks the size that a file claims before decoding it."""

from pathlib import Path
import re
import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.files import read_file

MAX_PIXELS = 1 << 26
"""Maximum number of pixels: 8192x8192, more than industrial cameras have, and half a second of
decoding. A file of 120 kB can claim ten times as many."""

MAX_PICTURE_BYTES = 1 << 28
"""Maximum size of a picture file [bytes]: MAX_PIXELS at four bytes each."""

PNG_START, PNG_SIZE = b'\x89PNG\r\n\x1a\n', struct.Struct('>16xII')
"""PNG signature; width and height in the first chunk, IHDR (ISO/IEC 15948)."""

JPEG_START, JPEG_END = b'\xff\xd8', b'\xff\xd9'
"""JPEG markers SOI and EOI (ITU-T T.81, B.1.1.3)."""

PNM_SIZE = re.compile(rb'P[1-6](?:\s|#[^\n]*\n)+(\d+)(?:\s|#[^\n]*\n)+(\d+)')
"""PNM magic number, width and height, with comments between them (netpbm)."""

TIFF_WIDTH, TIFF_HEIGHT, TIFF_SHORT = 256, 257, 3
"""Tags ImageWidth and ImageLength, and the type SHORT, 16 bits; otherwise LONG, 32 bits (TIFF
6.0)."""

TIFF_KIND, TIFF_REDUCED = 254, 1
"""Tag NewSubfileType, and its bit for a reduced version of another picture (TIFF 6.0)."""

TIFF_ENTRY = 12
"""Size of a directory entry [bytes] (TIFF 6.0)."""

FLAGS, ANIMATED = 20, 0x02
"""Offset of the flags of an extended WebP, and the animation flag (RFC 9649, 2.7)."""

_NO_LENGTH = {0x01, *range(0xD0, 0xD9)}
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
_SCAN = 0xDA
"""Second bytes of markers: TEM, RST and SOI, which have no parameters; SOF; SOS."""


def read_picture(path: str | Path, flags: int) -> NDArray[np.uint8]:
    """Read a picture file: PNG, JPEG, BMP, TIFF, WebP, PGM or PPM.

    :param flags: of cv2.imdecode.
    :raises ValueError: if there is no such file, it cannot be read in time, claims more than
        MAX_PIXELS, or cannot be decoded; the reason says which.
    """
    content = read_file(path, MAX_PICTURE_BYTES)
    size = claimed_size(content)
    if size is None:
        raise ValueError('expected a whole PNG, JPEG, BMP, TIFF, WebP, PGM or PPM')
    if kind := moving_kind(content):
        raise ValueError(f'expected one picture, this {kind} has several: make a video of it')
    width, height = size
    if width * height > MAX_PIXELS:
        raise ValueError(f'expected at most {MAX_PIXELS} pixels, got {width}x{height}')
    picture: Any  # cv2's type allows None and any dtype
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    except (cv2.error, MemoryError):
        picture = None
    if picture is None:
        raise ValueError('expected a picture that can be decoded')
    return np.asarray(picture, np.uint8)


def claimed_size(data: bytes) -> tuple[int, int] | None:
    """Width and height that a picture claims [px]; None if it is not a picture, or truncated."""
    try:
        if data.startswith(PNG_START):
            width, height = PNG_SIZE.unpack_from(data)
            return width, height
        if data.startswith(JPEG_START):
            return read_jpeg_header(data)[0]
        if data.startswith(b'BM'):
            width, height = struct.unpack_from('<ii', data, 18)
            return abs(width), abs(height)
        if data[:4] in (b'II*\0', b'MM\0*'):
            return _tiff_size(data)
        if data.startswith(b'RIFF') and data[8:12] == b'WEBP':
            return _webp_size(data)
    except struct.error:
        return None
    size = PNM_SIZE.match(data)
    return (int(size[1]), int(size[2])) if size else None


def read_jpeg_header(data: bytes) -> tuple[tuple[int, int] | None, int]:
    """Width and height in the frame header, None without one, and the offset of the first scan."""
    size, at = None, len(JPEG_START)
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == _SCAN:
            break
        if marker in _NO_LENGTH or marker == 0xFF:  # a marker may be preceded by any number of FF
            at += 1 if marker == 0xFF else 2
            continue
        if marker in _FRAMES:
            height, width = struct.unpack_from('>HH', data, at + 5)
            size = width, height
        at += 2 + int.from_bytes(data[at + 2 : at + 4], 'big')
    return size, at


def _tiff_size(data: bytes) -> tuple[int, int] | None:
    """The size in the first directory of a TIFF."""
    tags, _ = _tiff_directory(data, _tiff_start(data))
    has_size = {TIFF_WIDTH, TIFF_HEIGHT} <= tags.keys()
    return (tags[TIFF_WIDTH], tags[TIFF_HEIGHT]) if has_size else None


def _tiff_start(data: bytes) -> int:
    """Offset of the first directory of a TIFF."""
    return int.from_bytes(data[4:8], 'little' if data.startswith(b'II') else 'big')


def _tiff_directory(data: bytes, start: int) -> tuple[dict[int, int], int]:
    """The first value of each tag in a TIFF directory, and the offset of the next, 0 if none."""
    order = '<' if data.startswith(b'II') else '>'
    (count,) = struct.unpack_from(f'{order}H', data, start)
    tags, at = {}, start + 2
    for _ in range(count):
        tag, kind = struct.unpack_from(f'{order}HH', data, at)
        form = 'H' if kind == TIFF_SHORT else 'I'
        (tags[tag],) = struct.unpack_from(f'{order}{form}', data, at + 8)
        at += TIFF_ENTRY
    return tags, int.from_bytes(data[at : at + 4], 'little' if order == '<' else 'big')


def _has_pages(data: bytes) -> bool:
    """Whether a TIFF has a second picture that is not a reduced version of the first."""
    try:
        _, second = _tiff_directory(data, _tiff_start(data))
        return second > 0 and not _tiff_directory(data, second)[0].get(TIFF_KIND, 0) & TIFF_REDUCED
    except struct.error:
        return False


def moving_kind(data: bytes) -> str:
    """The format of a file with several pictures, of which OpenCV reads one; otherwise empty.

    PNG marks it with an acTL chunk before the first data chunk (PNG, 3rd edition, 11.3.6.1), TIFF
    with a second directory (TIFF 6.0, section 2), and WebP with a flag (RFC 9649, 2.7).
    """
    if data.startswith(PNG_START):
        return 'PNG' if b'acTL' in data[: data.find(b'IDAT')] else ''
    if data[:4] in (b'II*\0', b'MM\0*'):
        return 'TIFF' if _has_pages(data) else ''
    is_extended = data.startswith(b'RIFF') and data[8:16] == b'WEBPVP8X'
    return 'WebP' if is_extended and len(data) > FLAGS and data[FLAGS] & ANIMATED else ''


def _webp_size(data: bytes) -> tuple[int, int] | None:
    """The size in the first chunk of a WebP (RFC 9649, 2.5 to 2.7)."""
    kind = data[12:16]
    if kind == b'VP8X':
        low, middle, wide, high = struct.unpack_from('<HBHB', data, 24)
        return 1 + low + (middle << 16), 1 + wide + (high << 16)
    if kind == b'VP8 ':
        width, height = struct.unpack_from('<HH', data, 26)
        return width & 0x3FFF, height & 0x3FFF
    if kind == b'VP8L':
        (both,) = struct.unpack_from('<I', data, 21)
        return 1 + (both & 0x3FFF), 1 + (both >> 14 & 0x3FFF)
    return None
