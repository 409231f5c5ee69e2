"""Films that strangers bring, in the formats of ffmpeg, whole and damaged."""

import struct
import time

import cv2
import numpy as np
import pytest
from support.damaged import number_of
from support.films import copied
from support.films import encode
from support.films import H264
from support.films import needs_ffmpeg
from support.films import overwritten
from support.films import watch

from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.sources import video
from colortrack_ros.sources.picture_size import SizeWatch

pytestmark = [needs_ffmpeg, pytest.mark.slow]


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


def test_a_film_of_which_no_picture_can_be_decoded_names_its_codec(tmp_path):
    film = encode(tmp_path / 'film.mp4', '-c:v libx264 -movflags +faststart')
    content = bytearray(film.read_bytes())
    pictures = content.index(b'mdat') + 4
    content[pictures:] = bytes(len(content) - pictures)
    film.write_bytes(content)
    with pytest.raises(SourceError, match=r'codec (h264|avc1).*ffmpeg -i OLD'):
        open_source(str(film))


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


HELD_BACK = 2 if cv2.__version__.startswith('4.6.') else 0
"""The last pictures, which the decoder has held back to put them in order: OpenCV 4.6 gives no time
for them."""


@pytest.mark.parametrize('name', ['film.mp4', 'film.mkv', 'film.ts', 'film.flv'])
@pytest.mark.parametrize('kept', [r'gt(random(1)\,0.5)', r'lt(n\,40)+not(mod(n\,7))'])
def test_every_picture_of_a_varying_rate_comes_at_its_time(tmp_path, name, kept):
    film = encode(tmp_path / name, f'-vf select={kept} -vsync vfr {B_FRAMES} -pix_fmt yuv420p')
    frames, told, source = watch(film)
    numbers = np.array([number_of(frame) for frame in frames])
    stamps = np.array([frame.stamp for frame in frames]) / 4e7
    assert 30 < len(frames) < 70
    timed = slice(len(frames) - HELD_BACK)
    np.testing.assert_allclose(stamps[timed], (numbers - numbers[0])[timed], atol=0.02)
    assert (np.diff(stamps) > 0).all()
    assert (told, source.lost) == ([], 0)


def joined(path, options, widths, extension):
    """A film of parts of different widths, each of which begins with a header."""
    parts = [path.with_name(f'{k}.{extension}') for k in range(len(widths))]
    for part, width in zip(parts, widths, strict=True):
        encode(part, f'-vf scale={width}:-2 {options}', count=20)
    if path.suffix in ('.ts', '.h264', '.hevc', '.m2v'):
        path.write_bytes(b''.join(part.read_bytes() for part in parts))
        return path
    parts_list = path.with_name('parts.txt')
    parts_list.write_text(''.join(f'file {part}\n' for part in parts))
    return copied(path, parts_list, before='-f concat -safe 0')


VP9 = '-c:v libvpx-vp9 -deadline realtime -cpu-used 8'
H265 = '-c:v libx265 -preset ultrafast -x265-params log-level=none'

SIZES = [
    ('film.avi', '-c:v mjpeg -q:v 3', 'avi'),
    ('film.ts', f'{B_FRAMES} -pix_fmt yuv420p', 'ts'),
    ('film.h264', f'{B_FRAMES} -pix_fmt yuv444p', 'h264'),
    ('film.mp4', f'{H264} -bsf:v dump_extra', 'mp4'),
    ('film.m2v', '-c:v mpeg2video -q:v 3', 'm2v'),
    ('film.webm', '-c:v libvpx -b:v 2M', 'webm'),
    ('film9.webm', f'{VP9} -b:v 2M', 'webm'),
    ('film.hevc', f'{H265} -pix_fmt yuv420p', 'hevc'),
]


@pytest.mark.parametrize(('name', 'options', 'part'), SIZES, ids=[name for name, *_ in SIZES])
def test_a_change_of_the_size_of_the_pictures_is_told(tmp_path, name, options, part):
    film = joined(tmp_path / name, options, (160, 80, 160), part)
    frames, told, source = watch(film)
    assert {frame.image.shape for frame in frames} == {(96, 160, 3)}
    assert len(frames) >= 56
    assert len(told) == 2
    assert '160x96 to 80x48' in told[0]
    assert 'first size again' in told[1]
    assert source.lost == pytest.approx(20, abs=2)


@pytest.mark.parametrize('size', ['158x90', '162x98', '1918x1078', '16x16'])
@pytest.mark.parametrize(
    ('name', 'options'),
    [
        ('film.h264', f'{H264} -preset veryfast'),
        ('film.h264', '-c:v libx264 -pix_fmt yuv422p -flags +ildct'),
        ('film.mp4', H265),
        ('film.webm', f'{VP9} -pix_fmt yuv444p'),
        ('film.avi', '-c:v mjpeg'),
    ],
)
def test_the_size_is_what_the_reader_gives(tmp_path, name, options, size):
    width, height = (int(part) for part in size.split('x'))
    film = encode(tmp_path / name, f'-vf scale={width}:{height} {options}', count=1)
    sizes = SizeWatch(str(film))
    sizes.step()
    assert sizes.now == (width, height)


def test_other_versions_of_opencv_end_where_the_size_changes(tmp_path, monkeypatch):
    monkeypatch.setattr(video, 'CUTS', True)
    film = joined(tmp_path / 'film.avi', '-c:v mjpeg', (160, 80, 160), 'avi')
    frames, told, source = watch(film)
    assert (len(frames), len(told), source.lost) == (20, 1, 40)
    assert '160x96 to 80x48' in told[0]


@pytest.mark.parametrize('name', ['film.ts', 'film.m2ts', 'film.mpg', 'film.flv', 'film.mp4'])
@pytest.mark.parametrize('late', [0, 2])
def test_sound_that_begins_earlier_or_ends_later_is_no_loss(tmp_path, name, late):
    options = f'{H264} -c:a mp2' if name[-3:] in ('.ts', 'mpg', '2ts') else f'{H264} -ar 44100'
    film = encode(tmp_path / name, options, sound=9.0, late=late)
    frames, told, source = watch(film)
    assert (len(frames), told, source.lost) == (100, [], 0)


@pytest.mark.parametrize('name', ['film.ts', 'film.flv'])
def test_pictures_that_are_missing_of_a_film_with_sound_are_told(tmp_path, name):
    film = encode(tmp_path / name, f'{H264} -c:a mp3 -ar 44100', sound=9.0)
    overwritten(film, 0.2, 0.3, np.random.default_rng(0))
    frames, told, source = watch(film)
    assert told
    assert source.lost == pytest.approx(100 - len(frames), abs=1)


@pytest.mark.parametrize('place', [None, 0.3, 0.6])
def test_damage_to_an_avi_file_of_varying_rate_is_told_and_empty_places_are_not(tmp_path, place):
    film = encode(tmp_path / 'film.avi', r'-vf select=gt(random(1)\,0.2) -vsync vfr -c:v mjpeg')
    whole = watch(film)
    assert (whole[1], whole[2].lost, whole[2].total) == ([], 0, len(whole[0]))
    if place:
        frames, told, source = watch(
            overwritten(film, place, place + 0.1, np.random.default_rng(0))
        )
        assert source.lost == len(whole[0]) - len(frames) > 0
        assert told


def test_bytes_that_are_missing_of_an_avi_file_leave_its_index(tmp_path):
    film = encode(tmp_path / 'film.avi', r'-vf select=gt(random(1)\,0.4) -vsync vfr -c:v mjpeg')
    content, total = film.read_bytes(), len(watch(film)[0])
    film.write_bytes(content[:50_000] + content[90_000:])
    frames, told, source = watch(film)
    assert told
    assert source.total == total
    assert source.lost == total - len(frames) > 0


@pytest.mark.parametrize('place', [0.35, 0.5])
def test_fragments_behind_bytes_that_are_missing_are_counted(tmp_path, place):
    whole = encode(tmp_path / 'whole.mp4', f'{H264} -movflags frag_keyframe+empty_moov')
    assert watch(whole)[2].lost == 0
    content = whole.read_bytes()
    film, size = tmp_path / 'film.mp4', len(content)
    film.write_bytes(content[: int(place * size)] + content[int((place + 0.1) * size) :])
    frames, told, source = watch(film)
    assert told
    assert (source.total, source.lost) == (100, 100 - len(frames))


@pytest.mark.parametrize('name', ['film.ts', 'film.m2ts'])
def test_a_stream_that_ends_within_a_packet_is_cut_off(tmp_path, name):
    film = encode(tmp_path / name)
    assert watch(film)[1:][0] == []
    film.write_bytes(film.read_bytes()[:10_001])
    told, source = watch(film)[1:]
    assert 'cut off' in told[0]
    assert source.lost == 1


def test_a_film_that_was_cut_off_before_its_index_says_so(tmp_path):
    film = encode(tmp_path / 'film.mp4')
    film.write_bytes(film.read_bytes()[:10_001])
    with pytest.raises(SourceError, match='index'):
        watch(film)
