"""Counts the pictures that a Matroska or WebM file should have (RFC 9559).

The file gives no count, and its duration includes the sound. But every picture is a block with a
time of its own, and damage breaks the chain of elements, so it is known between which times blocks
are missing, at any rate.
"""

from dataclasses import dataclass
from dataclasses import field
import itertools
from typing import BinaryIO

import numpy as np

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.files import open_file
from colortrack_ros.sources.ebml import children
from colortrack_ros.sources.ebml import find
from colortrack_ros.sources.ebml import header
from colortrack_ros.sources.ebml import LONGEST_HEADER
from colortrack_ros.sources.ebml import number
from colortrack_ros.sources.ebml import real

EBML, SEGMENT, INFO, TRACK_LIST, TAGS = 0x1A45DFA3, 0x18538067, 0x1549A966, 0x1654AE6B, 0x1254C367
CLUSTER, CLUSTER_TIME, SIMPLE_BLOCK, GROUP, BLOCK = 0x1F43B675, 0xE7, 0xA3, 0xA0, 0xA1
TIME_SCALE, FILM_LENGTH = 0x2AD7B1, 0x4489
TRACK_ENTRY, TRACK_NUMBER, TRACK_KIND, TRACK_UID = 0xAE, 0xD7, 0x83, 0x73C5
TAG, TARGETS, TAG_TRACK, SIMPLE_TAG, TAG_NAME, TAG_TEXT = (
    0x7373, 0x63C0, 0x63C5, 0x67C8, 0x45A3, 0x4487,
)  # fmt: skip

ENTERED = (SEGMENT, CLUSTER, GROUP)
"""Elements whose content is walked through."""

AT_TOP = frozenset(
    (EBML, SEGMENT, INFO, TRACK_LIST, TAGS, CLUSTER, 0x114D9B74, 0x1C53BB6B, 0x1043A770, 0x1941A469)
)
IN_CLUSTER = frozenset((
    CLUSTER_TIME, SIMPLE_BLOCK, GROUP, BLOCK, 0xA7, 0xAB, 0xAF, 0xEC, 0xBF, 0x9B, 0xFA, 0xFB, 0xFD,
    0xA4, 0x75A1, 0x75A2, 0x8E,
))  # fmt: skip

BLOCK_HEADER = 12
"""Maximum size of a block's track, time and flags [bytes]."""

INVISIBLE = 0x08
"""Flag of a block that is decoded but not shown: an alternative reference of VP8."""

VIDEO_TRACK = 1
"""Kind of a video track."""

LARGEST_FACTS = 1 << 24
"""Maximum size of the tracks or tags to read [bytes]. Assumed: it only bounds the memory that a
damaged file takes."""

SPARE_PICTURES = 2
"""Number of periods by which a track may exceed the end of its last picture. Measured: of 72 whole
films of six codecs, a third of them at a varying rate, none does. Assumed: at a varying rate the
last picture may be shown as long as three."""


@dataclass
class Film:
    """What the walk has found. Times are in units of `scale`.

    :ivar scale: unit of time [ns].
    :ivar end: end of the longest track; 0 if unknown.
    :ivar tracks: number, kind and UID of each track.
    :ivar ends: end of tracks by UID [s].
    :ivar times: of the pictures, in the order of the file.
    :ivar breaks: number of pictures before each damaged place.
    """

    scale: int = 1_000_000
    end: float = 0.0
    tracks: list[tuple[int, int, int]] = field(default_factory=list)
    ends: dict[int, float] = field(default_factory=dict)
    times: list[int] = field(default_factory=list)
    breaks: list[int] = field(default_factory=list)

    @property
    def video(self) -> tuple[int, int, int]:
        """The first video track.

        :raises StopIteration: if there is none.
        """
        return next(track for track in self.tracks if track[1] == VIDEO_TRACK)


@dataclass
class Walk:
    """A place in the file.

    :ivar size: of the file [bytes].
    :ivar end: of what is to be visited [bytes].
    :ivar cluster_end: of the current cluster [bytes].
    :ivar time: of the current cluster [units].
    """

    file: BinaryIO
    size: int
    end: int = field(init=False)
    cluster_end: int = field(init=False)
    time: int = 0

    def __post_init__(self) -> None:
        self.end = self.cluster_end = self.size


def expected_pictures(path: str) -> int | None:
    """Count the pictures of the first video track, including those that damage has destroyed.

    The latter are estimated from the times before and after the damage and the mean rate.

    :returns: None if this is not a Matroska file, or no picture is left.
    """
    try:
        with open_file(path) as file:
            film = _walk(file)
        return len(film.times) + _destroyed(film) if film.times else None
    except (OSError, ValueError, IndexError, StopIteration):
        return None


def _walk(file: BinaryIO) -> Film:
    """Visit all elements; after damage, continue at the next cluster.

    :raises ValueError: if this is not a Matroska file.
    :raises StopIteration: if there is no video before the first block.
    """
    if file.read(4) != EBML.to_bytes(4, 'big'):
        raise ValueError('no Matroska')
    film, walk = Film(), Walk(file, file.seek(0, 2))
    at = 0
    while 0 <= at < walk.end:
        try:
            at = _visit(film, walk, at)
        except ValueError:
            if film.times[film.breaks[-1] if film.breaks else 0 :]:
                film.times.pop()  # its length is wrong, and maybe its time
            film.breaks.append(len(film.times))
            at = find(file, CLUSTER.to_bytes(4, 'big'), at + 1)
    return film


def _visit(film: Film, walk: Walk, at: int) -> int:
    """Take in one element.

    :returns: where the next one begins [bytes].
    :raises ValueError: if it is broken.
    """
    walk.file.seek(at)
    kind, length, skip = header(walk.file.read(LONGEST_HEADER))
    first = at + skip
    last = walk.size if length is None else first + length
    limit = walk.cluster_end if kind in IN_CLUSTER else walk.size
    if kind not in IN_CLUSTER | AT_TOP or (last > limit and kind not in ENTERED):
        raise ValueError('no Matroska element')
    walk.file.seek(first)
    if kind == SEGMENT:
        walk.end = min(last, walk.size)
    elif kind == CLUSTER:
        walk.cluster_end = min(last, walk.size)
    elif kind == CLUSTER_TIME:
        walk.time = int.from_bytes(walk.file.read(min(last - first, 8)), 'big')
    elif kind in (SIMPLE_BLOCK, BLOCK):
        _add_block(film, walk.time, walk.file.read(min(last - first, BLOCK_HEADER)))
    elif kind in (INFO, TRACK_LIST, TAGS):
        _add_facts(film, kind, walk.file.read(min(last - first, LARGEST_FACTS)))
    return first if kind in ENTERED else last


def _add_block(film: Film, time: int, head: bytes) -> None:
    """Take in a block that begins with these bytes, of a cluster with a time.

    :raises ValueError: if it is broken.
    """
    track, size = number(head)
    if len(head) < size + 3 or track not in (known[0] for known in film.tracks):
        raise ValueError('no block of a known track')
    if track == film.video[0] and not head[size + 2] & INVISIBLE:
        film.times.append(time + int.from_bytes(head[size : size + 2], 'big', signed=True))


def _add_facts(film: Film, kind: int, content: bytes) -> None:
    """Take in what the file says about itself, its tracks, or their ends."""
    facts = list(children(content))
    if kind == INFO:
        film.scale = int.from_bytes(dict(facts).get(TIME_SCALE, b''), 'big') or film.scale
        film.end = real(dict(facts).get(FILM_LENGTH, b''))
    for part, inner in facts:
        values = dict(children(inner))
        if (kind, part) == (TRACK_LIST, TRACK_ENTRY):
            track_number, track_kind, uid = (
                int.from_bytes(values.get(key, b''), 'big')
                for key in (TRACK_NUMBER, TRACK_KIND, TRACK_UID)
            )
            film.tracks.append((track_number, track_kind, uid))
        elif (kind, part) == (TAGS, TAG):
            track = dict(children(values.get(TARGETS, b''))).get(TAG_TRACK, b'')
            for _, tag in children(inner):
                texts = dict(children(tag))
                if texts.get(TAG_NAME) == b'DURATION':
                    film.ends[int.from_bytes(track, 'big')] = _seconds(texts.get(TAG_TEXT, b''))


def _seconds(text: bytes) -> float:
    """Time [s] from hours:minutes:seconds.

    :raises ValueError: if it is none.
    """
    hours, minutes, seconds = text.rstrip(b'\0').split(b':')
    return 3600 * int(hours) + 60 * int(minutes) + float(seconds)


def _destroyed(film: Film) -> int:
    """Estimate how many pictures damage has destroyed."""
    times, edges = np.array(film.times), sorted({0, *film.breaks, len(film.times)})
    runs = [times[a:b] for a, b in itertools.pairwise(edges)]
    steps = sum(len(run) - 1 for run in runs)
    period = sum(int(np.ptp(run)) for run in runs) / max(steps, 1)
    if period <= 0:
        return 0
    gaps = [int(after[0] - before.max()) for before, after in itertools.pairwise(runs)]
    if 0 in film.breaks:
        gaps.append(int(times[0] + period))
    rest = _end(film) - float(times.max())
    if rest > (SPARE_PICTURES + 1) * period:
        gaps.append(int(rest))
    return sum(max(round(gap / period) - 1, 0) for gap in gaps)


def _end(film: Film) -> float:
    """Where the pictures should end; 0 if unknown.

    The end of the file may be that of the sound, unless damage hides what follows the pictures.
    """
    end = film.ends.get(film.video[2], 0.0) * NANOSECONDS / film.scale
    if not end and (len(film.tracks) == 1 or len(film.times) in film.breaks):
        return film.end
    return end
