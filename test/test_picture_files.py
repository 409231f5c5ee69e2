import struct
import threading
import zlib

import cv2
from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros import picture_files
from colortrack_ros import sources
from colortrack_ros.picture_files import claimed_size
from colortrack_ros.picture_files import read_picture
from colortrack_ros.sources.pictures import PICTURE_SUFFIXES

WIDTH, HEIGHT = 37, 23
LOSSLESS = [cv2.IMWRITE_WEBP_QUALITY, 101]
WRITTEN = [(suffix, []) for suffix in PICTURE_SUFFIXES] + [('.webp', LOSSLESS)]


def encoded(suffix, options=()):
    gray = np.random.default_rng(0).integers(0, 256, (HEIGHT, WIDTH), np.uint8)
    picture = gray if suffix == '.pgm' else cv2.merge([gray, gray, gray])
    return cv2.imencode(suffix, picture, list(options))[1].tobytes()


EXTENDED_WEBP = b'RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0' + struct.pack('<HBHB', 36, 0, 22, 0)
TAGS = struct.pack('>HHII', 256, 4, 1, WIDTH) + struct.pack('>HHIHH', 257, 3, 1, HEIGHT, 0)
BIG_ENDIAN_TIFF = b'MM\0*\0\0\0\x08\0\x02' + TAGS
COMMENTED_PGM = b'P5 # made by\n# somebody\n37\n23 255\n'


@pytest.mark.parametrize(
    'data',
    [encoded(*written) for written in WRITTEN] + [EXTENDED_WEBP, BIG_ENDIAN_TIFF, COMMENTED_PGM],
)
def test_the_size_that_a_picture_claims_is_read_from_its_header(data):
    assert claimed_size(data) == (WIDTH, HEIGHT)


@pytest.mark.parametrize('suffix', PICTURE_SUFFIXES)
def test_a_picture_that_claims_too_much_is_refused_before_it_is_decoded(
    suffix, tmp_path, monkeypatch
):
    path = tmp_path / f'large{suffix}'
    path.write_bytes(encoded(suffix))
    assert read_picture(path, cv2.IMREAD_COLOR).shape == (HEIGHT, WIDTH, 3)
    monkeypatch.setattr(picture_files, 'MAX_PIXELS', WIDTH * HEIGHT - 1)
    monkeypatch.delattr(cv2, 'imdecode')
    with pytest.raises(ValueError, match='expected at most 850 pixels, got 37x23'):
        read_picture(path, cv2.IMREAD_COLOR)


def tiff_with_second(kind):
    """A TIFF with a second picture, without pixels, of this NewSubfileType."""
    whole = encoded('.tiff')
    start = int.from_bytes(whole[4:8], 'little')
    end = start + 2 + 12 * int.from_bytes(whole[start : start + 2], 'little')
    assert whole[:2] == b'II'
    assert whole[end : end + 4] == bytes(4)
    second = struct.pack('<HHHIII', 1, 254, 4, 1, kind, 0)
    return whole[:end] + struct.pack('<I', len(whole)) + whole[end + 4 :] + second


def moving_png():
    whole = encoded('.png')
    control = b'acTL' + struct.pack('>II', 2, 0)
    at = whole.index(b'IDAT') - 4
    checked = struct.pack('>I', 8) + control + struct.pack('>I', zlib.crc32(control))
    return whole[:at] + checked + whole[at:]


@pytest.mark.parametrize(
    ('name', 'data'),
    [
        ('WebP', EXTENDED_WEBP[:20] + b'\x02' + EXTENDED_WEBP[21:]),
        ('PNG', moving_png()),
        ('TIFF', tiff_with_second(0)),
    ],
)
def test_pictures_that_move_are_not_taken_for_one(tmp_path, name, data):
    path = tmp_path / f'moves.{name.lower()}'
    path.write_bytes(data)
    with pytest.raises(ValueError, match=f'this {name} has several: make a video of it'):
        read_picture(path, cv2.IMREAD_COLOR)


def test_a_picture_with_a_thumbnail_is_one(tmp_path):
    path = tmp_path / 'with_thumbnail.tiff'
    path.write_bytes(tiff_with_second(1))
    assert read_picture(path, cv2.IMREAD_COLOR).shape == (HEIGHT, WIDTH, 3)


@pytest.mark.slow
@settings(deadline=None, max_examples=200)
@given(data=st.data(), suffix=st.sampled_from(PICTURE_SUFFIXES))
def test_a_broken_header_is_no_picture_or_one_of_some_size(data, suffix):
    broken = bytearray(encoded(suffix))
    for place in data.draw(st.lists(st.integers(2, min(len(broken), 200) - 1), max_size=8)):
        broken[place] = data.draw(st.integers(0, 255))
    size = claimed_size(bytes(broken[: data.draw(st.integers(0, len(broken)))]))
    assert size is None or min(size) >= 0


@pytest.mark.parametrize('name', ['clip.mp4', 'shots/*.png'])
def test_opening_a_file_that_never_comes_ends_with_a_reason(name, tmp_path, monkeypatch):
    (tmp_path / 'clip.mp4').touch()
    never = threading.Event()
    monkeypatch.setattr(sources, 'TIME_TO_OPEN', 0.1)
    monkeypatch.setattr(cv2, 'VideoCapture', lambda *_: never.wait())
    monkeypatch.setattr('glob.glob', lambda *_: never.wait())
    with pytest.raises(sources.SourceError, match=r"clip\.mp4|shots.*': could not be .* 0\.1 s"):
        sources.open_source(str(tmp_path / name))
    never.set()
