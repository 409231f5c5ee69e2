import struct
import zlib

import cv2
from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage

from colortrack_ros.data import Frame
from colortrack_ros.encodings import plain
from colortrack_ros.messages import compressed_of_frame
from colortrack_ros.messages import frame_of_serialized_compressed_image
from colortrack_ros.messages import MessageError

PICTURE = np.dstack(
    [*np.meshgrid(np.arange(0, 240, 6), np.arange(0, 240, 8)), np.full((30, 40), 70)]
)
PICTURE = PICTURE.astype(np.uint8)
FILES = {name: cv2.imencode(name, PICTURE)[1].tobytes() for name in ('.jpg', '.png')}


def read(data, **options):
    message = CompressedImage(format='jpeg', data=data)
    return frame_of_serialized_compressed_image(serialize_message(message), **options)


def test_a_compressed_frame_comes_back_nearly_as_it_was():
    frame = Frame(np.full((16, 24, 3), (40, 90, 200), np.uint8), 'bgr8', 5, 'cam')
    message = serialize_message(compressed_of_frame(frame, 95))
    back = frame_of_serialized_compressed_image(message)
    assert (back.encoding, back.stamp, back.frame_id) == ('bgr8', 5, 'cam')
    np.testing.assert_allclose(back.image, frame.image, atol=4)


@pytest.mark.parametrize('kind', ['bayer_rggb8; png compressed ', 'bayer_rggb16; jpeg compressed'])
def test_a_bayer_pattern_that_is_compressed_as_it_is_keeps_its_colors(kind):
    mosaic = np.tile(np.array([[200, 60], [60, 20]], np.uint8), (8, 12))
    file = cv2.imencode('.png' if 'png' in kind else '.jpg', mosaic)[1].tobytes()
    message = serialize_message(CompressedImage(format=kind, data=file))
    frame = plain(frame_of_serialized_compressed_image(message))
    np.testing.assert_allclose(frame.image[4, 4], (20, 60, 200), atol=8)


def test_a_bayer_pattern_that_was_converted_before_it_was_compressed_is_what_it_shows():
    kind = 'bayer_rggb8; jpeg compressed bgr8'
    message = serialize_message(CompressedImage(format=kind, data=FILES['.jpg']))
    frame = frame_of_serialized_compressed_image(message)
    assert (frame.encoding, frame.image.shape) == ('bgr8', (30, 40, 3))


@pytest.mark.parametrize('size', [(8, 65536), (65536, 8), (0, 0)])
def test_a_picture_that_no_jpeg_can_hold_is_refused(size):
    with pytest.raises(MessageError, match=f'JPEG: .* got {size[1]}x{size[0]}'):
        compressed_of_frame(Frame(np.zeros((*size, 3), np.uint8)), 90)


def test_quality_buys_likeness_with_bytes_and_the_format_is_that_of_image_transport():
    frame = Frame(PICTURE, 'bgr8', 5, 'cam')
    poor, good = (compressed_of_frame(frame, quality) for quality in (20, 95))
    assert len(poor.data) < 0.9 * len(good.data)
    assert good.format == 'bgr8; jpeg compressed bgr8'


@pytest.mark.parametrize('data', [b'', b'no picture'])
def test_a_compressed_image_of_no_picture_is_refused(data):
    message = serialize_message(CompressedImage(format='jpeg', data=data))
    with pytest.raises(MessageError, match=f"of {len(data)} bytes, format 'jpeg': expected a JPEG"):
        frame_of_serialized_compressed_image(message)


@pytest.mark.parametrize('cut', [1, 2, 20, 300])
def test_a_jpeg_that_is_cut_short_is_refused(cut):
    assert read(FILES['.jpg']).image.shape == (30, 40, 3)
    with pytest.raises(MessageError, match='expected a whole JPEG'):
        read(FILES['.jpg'][:-cut])


@pytest.mark.parametrize('cut', [1, 20, 300])
def test_a_png_that_is_cut_short_is_refused(cut):
    with pytest.raises(MessageError, match='expected a JPEG or PNG that can be decoded'):
        read(FILES['.png'][:-cut])


def test_a_thumbnail_in_a_jpeg_that_is_cut_short_is_not_its_end():
    exif = b'Exif\0\0' + FILES['.jpg']
    marker = b'\xff\xe1' + struct.pack('>H', len(exif) + 2) + exif
    whole = FILES['.jpg'][:2] + marker + FILES['.jpg'][2:]
    assert read(whole).image.shape == (30, 40, 3)
    with pytest.raises(MessageError, match='cut short'):
        read(whole[:-2])


def test_zeros_after_the_end_of_a_jpeg_do_not_matter():
    np.testing.assert_array_equal(read(FILES['.jpg'] + bytes(9)).image, read(FILES['.jpg']).image)


@pytest.mark.parametrize('orientation', range(1, 9))
def test_an_orientation_in_exif_does_not_turn_the_picture(orientation):
    entry = struct.pack('>HHIHH', 0x0112, 3, 1, orientation, 0)
    exif = b'Exif\0\0MM\0*' + struct.pack('>IH', 8, 1) + entry + bytes(4)
    marker = b'\xff\xe1' + struct.pack('>H', len(exif) + 2) + exif
    turned = FILES['.jpg'][:2] + marker + FILES['.jpg'][2:]
    np.testing.assert_array_equal(read(turned).image, read(FILES['.jpg']).image)


def claiming(name, width, height):
    """A small file that says that it is a large picture."""
    data = bytearray(FILES[name])
    if name == '.png':
        data[16:24] = struct.pack('>II', width, height)
        data[29:33] = struct.pack('>I', zlib.crc32(data[12:29]))
    else:
        at = data.index(b'\xff\xc0')
        data[at + 5 : at + 9] = struct.pack('>HH', height, width)
    return bytes(data)


@pytest.mark.parametrize('name', FILES)
def test_a_picture_that_claims_too_many_pixels_is_not_decoded(name, monkeypatch):
    monkeypatch.setattr(cv2, 'imdecode', lambda *_: pytest.fail('it was decoded'))
    with pytest.raises(MessageError, match='at most max_pixels, 67108864, got 30000x20000'):
        read(claiming(name, 30_000, 20_000))
    with pytest.raises(MessageError, match='at most max_pixels, 1199, got 40x30'):
        read(FILES[name], max_pixels=1199)


@pytest.mark.parametrize('name', FILES)
def test_as_many_pixels_as_are_allowed_are_decoded(name):
    assert read(FILES[name], max_pixels=1200).image.shape == (30, 40, 3)


@pytest.mark.slow
@settings(deadline=None)
@given(st.data())
def test_mutated_files_are_refused_or_read_but_never_raise_anything_else(data):
    content = bytearray(FILES[data.draw(st.sampled_from(sorted(FILES)))])
    for _ in range(data.draw(st.integers(1, 6))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    try:
        frame = read(bytes(content), max_pixels=10_000)
    except MessageError:
        return
    assert frame.image.size <= 30_000
