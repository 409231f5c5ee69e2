"""Films that were cut without encoding them again: what is before the cut is in the file."""

import struct

import cv2
import numpy as np
import pytest
from support.damaged import number_of
from support.damaged import numbered

from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.sources.edit_list import shown_pictures

COUNT, FIRST, LAST = 40, 5, 33


@pytest.fixture
def film(tmp_path):
    """A film of 40 pictures of which 5 to 33 are shown, and the place of its edit list."""
    path = tmp_path / 'film.mp4'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'mp4v'), 25.0, (160, 96))
    for k in range(COUNT):
        writer.write(numbered(k))
    writer.release()
    content = bytearray(path.read_bytes())
    at = content.index(b'elst')
    duration, _ = struct.unpack_from('>Ii', content, at + 12)
    scale = struct.unpack_from('>I', content, content.index(b'mdhd') + 16)[0]
    shown = LAST + 1 - FIRST
    struct.pack_into('>Ii', content, at + 12, duration * shown // COUNT, FIRST * scale // 25)
    path.write_bytes(content)
    return path, at


def test_what_is_cut_off_is_not_lost(film):
    path, _ = film
    source = open_source(str(path))
    numbers = [number_of(frame) for frame in iter(source.read, None)]
    assert numbers == list(range(FIRST, LAST + 1))
    assert source.lost == 0
    assert source.total == len(numbers) == shown_pictures(str(path))


def test_pictures_that_are_missing_of_what_is_shown_are_told(film):
    path, _ = film
    content = bytearray(path.read_bytes())
    first, last = content.index(b'mdat'), content.index(b'moov') - 8
    middle = (first + last) // 2
    content[middle:last] = bytes(last - middle)
    path.write_bytes(content)
    source = open_source(str(path))
    given, told = 0, []
    for _ in range(COUNT):
        try:
            given += source.read() is not None
        except SourceError as error:
            told.append(str(error))
    assert 0 < given < LAST + 1 - FIRST
    assert source.lost == LAST + 1 - FIRST - given
    assert told


@pytest.mark.parametrize('name', ['a.avi', 'a.mkv', 'nothing.mp4'])
def test_other_formats_have_no_edit_list(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b'\x1aE\xdf\xa3' + bytes(100))
    assert shown_pictures(str(path)) is None
    assert shown_pictures(str(tmp_path / 'is not there')) is None


@pytest.mark.parametrize('box', [b'moov', b'trak', b'elst', b'stts', b'mdhd', b'hdlr', b'mvhd'])
def test_an_index_that_claims_anything_does_no_harm(film, box):
    path, _ = film
    content = path.read_bytes()
    at, rng = content.index(box), np.random.default_rng(0)
    for size in (1, 4, 8, 40):
        for offset in (-4, 0, 4, 8, 12):
            broken = bytearray(content)
            broken[at + offset : at + offset + size] = rng.bytes(size)
            path.write_bytes(broken)
            shown = shown_pictures(str(path))
            assert shown is None or 0 <= shown <= COUNT
    for value in (b'\0\0\0\0', b'\xff\xff\xff\xff', b'\0\0\0\1'):
        path.write_bytes(content[: at - 4] + value + content[at:])
        shown_pictures(str(path))
        path.write_bytes(content[: at + 4])
        shown_pictures(str(path))


def test_an_index_of_four_billion_pictures_is_not_counted(film):
    path, _ = film
    content = bytearray(path.read_bytes())
    struct.pack_into('>I', content, content.index(b'stts') + 12, 0xFFFFFFFF)
    path.write_bytes(content)
    assert shown_pictures(str(path)) is None
