"""What MP4 files with any lengths and numbers tell, written byte by byte."""

import struct

import pytest

from colortrack_ros.sources.edit_list import shown_pictures
from colortrack_ros.sources.fragments import damaged_fragments
from colortrack_ros.sources.mp4 import lacks_index

RATE, SCALE = 25.0, 1000


def box(kind, *content):
    content = b''.join(content)
    return struct.pack('>I4s', 8 + len(content), kind) + content


def numbers(kind, *values):
    """A box of version 0, without flags."""
    return box(kind, bytes(4), struct.pack(f'>{len(values)}I', *values))


def index(*others, scale=SCALE, scale_of_edits=SCALE):
    times = numbers(b'stts', 1, 10, SCALE // 25)
    edits = box(b'edts', numbers(b'elst', 1, 0, 0, 1 << 16))
    of_track = numbers(b'mdhd', 0, 0, scale, 0), box(b'hdlr', bytes(8), b'vide')
    media = box(b'mdia', *of_track, box(b'minf', box(b'stbl', times)))
    track = box(b'trak', numbers(b'tkhd', 0, 0, 1, 0), edits, media)
    return box(b'moov', numbers(b'mvhd', 0, 0, scale_of_edits, 0), track, *others)


FRAGMENTED = box(b'mvex')


def fragment(time, count):
    parts = numbers(b'tfhd', 1), numbers(b'tfdt', time), numbers(b'trun', count)
    return box(b'moof', box(b'traf', *parts))


@pytest.fixture
def file_of(tmp_path):
    def write(*content):
        path = tmp_path / 'film.mp4'
        path.write_bytes(box(b'ftyp', b'isom') + b''.join(content))
        return str(path)

    return write


@pytest.mark.parametrize(
    'head', [b'\0\0\0\2moov', b'\0\0\0\7moov', b'\0\0\0\1moov\0\0\0\0\0\0\0\5']
)
def test_an_index_that_is_shorter_than_its_head_is_none(file_of, head):
    assert lacks_index(file_of(head, bytes(40)))


def test_an_index_without_a_scale_of_its_times_counts_nothing(file_of):
    assert shown_pictures(file_of(index())) == 10
    assert shown_pictures(file_of(index(scale_of_edits=0))) is None
    damaged = fragment(0, 10), b'no box..', fragment(2000, 10)
    assert damaged_fragments(file_of(index(FRAGMENTED), *damaged), RATE) == 60
    assert damaged_fragments(file_of(index(FRAGMENTED, scale=0), *damaged), RATE) is None


def test_fragments_that_claim_billions_of_pictures_are_not_counted(file_of):
    damaged = fragment(0, 10), b'no box..', fragment(2000, 0xFFFFFFFF)
    assert damaged_fragments(file_of(index(FRAGMENTED), *damaged), RATE) is None


def test_a_damaged_file_without_fragments_is_not_searched_for_any(file_of):
    """A film of 10 GB that was cut off was read once more, for half a minute."""
    damaged = fragment(0, 10), b'no box..', fragment(2000, 10)
    assert damaged_fragments(file_of(index(), *damaged), RATE) is None
