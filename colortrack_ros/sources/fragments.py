"""Counts the pictures of a damaged MP4 file of fragments (ISO/IEC 14496-12, 8.8).

Its index counts none. Each fragment has its time and the number of its pictures, though, and FFmpeg
reads none of those behind a broken one.
"""

import itertools
import struct
from typing import BinaryIO

from colortrack_ros.files import open_file
from colortrack_ros.sources.ebml import find
from colortrack_ros.sources.mp4 import box_at
from colortrack_ros.sources.mp4 import boxes_of
from colortrack_ros.sources.mp4 import flat_track
from colortrack_ros.sources.mp4 import HEADER
from colortrack_ros.sources.mp4 import index_of
from colortrack_ros.sources.mp4 import MOST_PICTURES
from colortrack_ros.sources.mp4 import time_scale

FRAGMENT, MAY_BE_FRAGMENTED = b'moof', b'mvex'
"""Kinds of the box that describes a fragment, and of the one in the index of files that have
some: all of another file that is damaged would be searched for them, 3 s a GB."""

TOP_BOXES = frozenset((
    FRAGMENT, b'ftyp', b'styp', b'moov', b'mdat', b'mfra', b'sidx', b'ssix', b'free', b'skip',
    b'wide', b'uuid', b'meta', b'emsg', b'prft', b'pdin',
))  # fmt: skip
"""Boxes that are in no other."""

LARGEST_FRAGMENT = 1 << 20
"""Maximum number of bytes of a fragment's box to read: at 16 bytes per picture, 36 minutes at
30 Hz. Where it is damaged, what begins like one may claim any length."""

LENGTH = 4
"""Bytes before the kind of a box."""

Fragment = tuple[int, int, bool]
"""Time of the first picture [units], number of pictures, and whether damage precedes it."""


def damaged_fragments(path: str, rate: float) -> int | None:
    """Count the pictures of the first video track, including those of lost fragments in between.

    The latter are estimated from the times before and after the damage.

    :param rate: of the pictures [Hz].
    :returns: None if it is another format, there is no damage, or what is left claims too many.
    """
    try:
        with open_file(path) as file:
            boxes = list(boxes_of(index_of(file)))
            if MAY_BE_FRAGMENTED not in dict(boxes):
                return None
            tracks = [flat_track(box) for kind, box in boxes if kind == b'trak']
            track = next(track for track in tracks if track[b'hdlr'][8:12] == b'vide')
            header = track[b'tkhd']
            (number,) = struct.unpack_from('>I', header, 20 if header[0] == 1 else 12)
            fragments, is_broken = _walk(file, number)
        period = time_scale(track[b'mdhd']) / rate
    except (OSError, ValueError, KeyError, IndexError, StopIteration, struct.error):
        return None
    if not is_broken or not fragments:
        return None
    lost = (
        max(round((after[0] - before[0]) / period) - before[1], 0)
        for before, after in itertools.pairwise(fragments)
        if after[2]
    )
    total = sum(fragment[1] for fragment in fragments) + sum(lost)
    return total if total <= MOST_PICTURES else None


def _walk(file: BinaryIO, track: int) -> tuple[list[Fragment], bool]:
    """Visit all boxes; after damage, continue at the next fragment.

    :returns: the fragments of a track, and whether any box is broken.
    """
    size, at, last_good = file.seek(0, 2), 0, 0
    fragments, is_broken, is_next_broken = list[Fragment](), False, False
    while 0 <= at < size:
        kind, header, length = box_at(file, at, size)
        last_good = at if kind in TOP_BOXES else last_good
        try:
            if kind not in TOP_BOXES or not header <= length <= size - at:
                raise ValueError('no box')
            if kind == FRAGMENT:
                file.seek(at + header)
                content = file.read(min(length - header, LARGEST_FRAGMENT))
                found = [(*part, is_next_broken) for part in _of_track(content, track)]
                fragments += found
                is_next_broken &= not found
            at += length
        except (ValueError, KeyError, IndexError, struct.error):
            is_broken = is_next_broken = True
            at = find(file, FRAGMENT, last_good + HEADER) - LENGTH
    return fragments, is_broken


def _of_track(fragment: bytes, track: int) -> list[tuple[int, int]]:
    """Time and number of the pictures in the parts of a fragment that are of a track."""
    found = []
    for part in (content for kind, content in boxes_of(fragment) if kind == b'traf'):
        boxes = dict(boxes_of(part))
        if struct.unpack_from('>I', boxes[b'tfhd'], 4) == (track,):
            start = boxes[b'tfdt']
            (time,) = struct.unpack_from('>Q' if start[0] == 1 else '>I', start, 4)
            runs = (content for kind, content in boxes_of(part) if kind == b'trun')
            found.append((time, sum(struct.unpack_from('>I', run, 4)[0] for run in runs)))
    return found
