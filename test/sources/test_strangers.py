"""Films that strangers bring, in the formats of ffmpeg, whole and damaged."""

import struct
import time

import numpy as np
import pytest
from support.damaged import number_of
from support.films import encode
from support.films import H264
from support.films import needs_ffmpeg
from support.films import watch

pytestmark = needs_ffmpeg


@pytest.mark.parametrize('name', ['film.mp4', 'film.mkv'])
def test_a_film_whose_first_pictures_are_broken_is_read_from_the_next_key_on(tmp_path, name):
    film = encode(tmp_path / name, H264 + ' -flags +cgop')
    content = bytearray(film.read_bytes())
    first = content.index(b'\x06\x05\xff')  # the encoder's name begins the first picture
    content[first - 4 : first + 40] = b'\xff' * 44  # its length is broken, too
    film.write_bytes(content)
    frames, told, source = watch(film)
    assert 'cannot be read' in told[0]
    assert number_of(frames[-1]) == 99
    assert source.lost == 100 - len(frames) > 0


def test_an_index_that_promises_millions_of_pictures_does_not_hold_up_the_end(tmp_path):
    film = encode(tmp_path / 'film.mp4')
    content = bytearray(film.read_bytes())
    struct.pack_into('>I', content, content.index(b'stts') + 12, 16_000_000)
    film.write_bytes(content)
    began = time.monotonic()
    frames, told, source = watch(film)
    assert time.monotonic() - began < 20
    assert frames
    assert told
    assert source.lost


B_FRAMES = '-c:v libx264 -preset veryfast -bf 2 -g 25'


@pytest.mark.parametrize(
    ('name', 'options'),
    [
        ('film.mp4', f'{B_FRAMES} -pix_fmt yuv420p'),
        ('film.mov', f'{B_FRAMES} -pix_fmt yuv420p10le'),
        ('film.flv', f'{B_FRAMES} -pix_fmt yuv420p'),
        ('film.mkv', f'{B_FRAMES} -pix_fmt gray'),
        ('film.ts', '-c:v mpeg2video -q:v 3 -bf 2'),
        ('film.webm', '-c:v libvpx -auto-alt-ref 1 -lag-in-frames 16 -b:v 2M'),
        ('film.avi', '-c:v mjpeg -q:v 3'),
        ('film.mp4', f'{B_FRAMES} -pix_fmt yuv420p -movflags frag_keyframe+empty_moov'),
        ('film.h264', f'{B_FRAMES} -pix_fmt yuv420p'),
    ],
)
def test_every_picture_of_a_whole_film_comes_at_its_time(tmp_path, name, options):
    frames, told, source = watch(encode(tmp_path / name, options))
    assert [number_of(frame) for frame in frames] == list(range(100))
    assert [round(frame.stamp / 4e7, 3) for frame in frames] == list(range(100))
    assert (told, source.lost) == ([], 0)


@pytest.mark.parametrize('name', ['film.mp4', 'film.mkv', 'film.ts', 'film.flv'])
@pytest.mark.parametrize('kept', [r'gt(random(1)\,0.5)', r'lt(n\,50)+not(mod(n\,7))'])
def test_every_picture_of_a_varying_rate_comes_at_its_time(tmp_path, name, kept):
    film = encode(tmp_path / name, f'-vf select={kept} -vsync vfr {B_FRAMES} -pix_fmt yuv420p')
    frames, told, source = watch(film)
    numbers = np.array([number_of(frame) for frame in frames])
    stamps = np.array([frame.stamp for frame in frames]) / 4e7
    assert 30 < len(frames) < 70
    np.testing.assert_allclose(stamps, numbers - numbers[0], atol=0.02)
    assert (told, source.lost) == ([], 0)
