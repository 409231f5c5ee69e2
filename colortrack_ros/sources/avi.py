"""Counts the pictures of an AVI file by its index.

Its header counts the places of pictures, some of which a varying rate leaves empty.
"""

from typing import BinaryIO

import numpy as np

from colortrack_ros.files import open_file
from colortrack_ros.sources.ebml import find
from colortrack_ros.sources.mp4 import LARGEST_INDEX

RIFF_HEADER, CHUNK_HEADER = 12, 8
"""Bytes before the content of the file and of each chunk."""

INDEX_ENTRY = np.dtype([('stream', 'S2'), ('kind', 'S2'), ('rest', '<u8'), ('size', '<u4')])
"""A chunk in the index."""


def indexed_pictures(path: str) -> int | None:
    """Count the pictures of the first video stream.

    :returns: None if it is another format, the index is missing, or it is one of several.
    """
    try:
        with open_file(path) as file:
            index = np.frombuffer(_index(file), INDEX_ENTRY)
    except (OSError, ValueError):
        return None
    pictures = index[np.isin(index['kind'], [b'dc', b'db'])]
    if not len(pictures):
        return None
    first = pictures['stream'] == np.unique(pictures['stream'])[0]
    return int(np.count_nonzero(first & (pictures['size'] > 0)))


def _index(file: BinaryIO) -> bytes:
    """The content of the index.

    :raises ValueError: if there is none, or the file goes on in a second part with its own.
    """
    size, at = file.seek(0, 2), RIFF_HEADER
    file.seek(0)
    head = file.read(RIFF_HEADER)
    end = CHUNK_HEADER + int.from_bytes(head[4:8], 'little')
    file.seek(end)
    if head[:4] + head[8:] != b'RIFFAVI ' or file.read(4) == b'RIFF':
        raise ValueError('no AVI file of one part')
    kind = b''
    while at + CHUNK_HEADER <= size and kind != b'idx1':
        file.seek(at)
        kind, length = file.read(4), int.from_bytes(file.read(4), 'little')
        at += CHUNK_HEADER + length + length % 2
    if kind != b'idx1':  # bytes are missing or were inserted
        at = find(file, b'idx1', RIFF_HEADER)
        if at < 0:
            raise ValueError('no index')
        file.seek(at + 4)
        length = int.from_bytes(file.read(4), 'little')
    content = file.read(min(length, LARGEST_INDEX))
    return content[: len(content) // INDEX_ENTRY.itemsize * INDEX_ENTRY.itemsize]
