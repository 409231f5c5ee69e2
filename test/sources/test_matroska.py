"""What a Matroska file tells of its pictures, written byte by byte."""

import struct

import numpy as np
import pytest
from support.films import copied
from support.films import encode
from support.films import needs_ffmpeg
from support.films import overwritten
from support.films import RATE
from support.films import watch

from colortrack_ros.sources.matroska import expected_pictures

VIDEO, SOUND = 1, 2
PER_CLUSTER = 10


def element(kind, content=b''):
    return bytes.fromhex(kind) + struct.pack('>Q', 1 << 56 | len(content)) + content


def facts(tracks, end, ends):
    yield element(
        '1549A966', element('2AD7B1', b'\x0fB@') + element('4489', struct.pack('>d', end))
    )
    entries = (
        element(
            'AE',
            element('D7', bytes([t])) + element('73C5', bytes([t])) + element('83', bytes([t])),
        )
        for t in tracks
    )
    yield element('1654AE6B', b''.join(entries))
    for track, text in ends.items():
        tag = element('45A3', b'DURATION') + element('4487', text.encode() + b'\0')
        target = element('63C0', element('63C5', bytes([track])))
        yield element('1254C367', element('7373', target + element('67C8', tag)))


def clusters(times, sound, rng):
    """Clusters of ten pictures each, with a sound block after every picture."""
    for first in range(0, len(times), PER_CLUSTER):
        start = int(times[first])
        blocks = element('E7', struct.pack('>I', start))
        for time in times[first : first + PER_CLUSTER]:
            for track in (VIDEO, SOUND) if sound else (VIDEO,):
                head = struct.pack('>BhB', 0x80 | track, int(time) - start, 0)
                blocks += element('A3', head + rng.bytes(200))
        yield element('1F43B675', blocks)


def write(path, times, end=None, sound=False, ends=None):
    """A file of pictures at these times [ms], which ends at a time [ms]."""
    rng = np.random.default_rng(0)
    end = times[-1] + 40 if end is None else end
    tracks = (VIDEO, SOUND) if sound else (VIDEO,)
    parts = [*facts(tracks, end, ends or {}), *clusters(times, sound, rng)]
    path.write_bytes(element('1A45DFA3') + element('18538067', b''.join(parts)))
    return path


@pytest.fixture
def path(tmp_path):
    return tmp_path / 'film.mkv'


EVEN = 40 * np.arange(100)
UNEVEN = 40 * np.flatnonzero(np.random.default_rng(0).random(250) < 0.4)


@pytest.mark.parametrize('times', [EVEN, UNEVEN, EVEN + 5000, EVEN[:1]])
@pytest.mark.parametrize('sound', [False, True])
def test_a_whole_film_has_its_blocks_whatever_their_times(path, times, sound):
    assert expected_pictures(str(write(path, times, sound=sound))) == len(times)


@pytest.mark.parametrize('ends', [{}, {VIDEO: '00:00:04.000000000', SOUND: '00:00:09.5'}])
def test_sound_that_is_longer_promises_no_pictures(path, ends):
    assert expected_pictures(str(write(path, EVEN, 9500.0, True, ends))) == len(EVEN)


@pytest.mark.parametrize('sound', [False, True])
@pytest.mark.parametrize('ends', [{}, {VIDEO: '00:00:04.000000000'}])
def test_what_is_cut_off_is_missing(path, sound, ends):
    content = write(path, EVEN, sound=sound, ends=ends).read_bytes()
    path.write_bytes(content[: int(0.7 * len(content))])
    assert expected_pictures(str(path)) == len(EVEN)


@pytest.mark.parametrize('times', [EVEN, UNEVEN], ids=['even', 'uneven'])
@pytest.mark.parametrize('place', [0.1, 0.45, 0.8])
def test_what_damage_destroys_is_estimated_from_the_times_around_it(path, times, place):
    overwritten(write(path, times), place, place + 0.05, np.random.default_rng(1))
    spread = 0 if times is EVEN else 5
    assert expected_pictures(str(path)) == pytest.approx(len(times), abs=spread)


@pytest.mark.parametrize('time', [30000, -30000])
def test_the_time_of_a_block_in_front_of_damage_is_not_believed(path, time):
    head, tail = write(path, EVEN, 4000.0).read_bytes().rsplit(b'\x1f\x43\xb6\x75', 1)
    block = element('A3', struct.pack('>BhB', 0x80 | VIDEO, time, 0))
    path.write_bytes(head + b'\x1f\x43\xb6\x75' + tail[:21] + block + bytes(3000))
    assert expected_pictures(str(path)) == len(EVEN)


def test_what_is_appended_is_no_damage(path):
    rng = np.random.default_rng(0)
    path.write_bytes(write(path, EVEN, 9500.0, True).read_bytes() + rng.bytes(5000))
    assert expected_pictures(str(path)) == len(EVEN)


def test_a_live_film_without_lengths_is_walked_through(path):
    content = write(path, EVEN).read_bytes()
    for kind in ('18538067', '1F43B675'):
        at = -1
        while (at := content.find(bytes.fromhex(kind), at + 1)) >= 0:
            content = content[: at + 4] + b'\x01' + 7 * b'\xff' + content[at + 12 :]
    path.write_bytes(content)
    assert expected_pictures(str(path)) == len(EVEN)


def test_references_that_are_not_shown_are_no_pictures(path):
    content = write(path, EVEN).read_bytes()
    shown = b'\x81' + struct.pack('>hB', 80, 0)
    path.write_bytes(content.replace(shown, shown[:-1] + b'\x08'))
    assert expected_pictures(str(path)) == len(EVEN) - len(EVEN) // PER_CLUSTER


def test_broken_files_do_no_harm(path):
    content, rng = (
        write(path, EVEN[:20], ends={VIDEO: '00:00:00.8'}).read_bytes(),
        np.random.default_rng(0),
    )
    for _ in range(500):
        broken = bytearray(content)
        for at in rng.integers(0, len(content) if rng.random() < 0.5 else 400, 5):
            broken[at] = rng.integers(256)
        path.write_bytes(broken[: rng.integers(1, len(content))])
        count = expected_pictures(str(path))
        assert count is None or count >= 0
    for content in (b'', b'\x1aE\xdf\xa3', b'RIFF' + bytes(100)):
        path.write_bytes(content)
        assert expected_pictures(str(path)) is None


@needs_ffmpeg
@pytest.mark.slow
@pytest.mark.parametrize('name', ['film.mkv', 'film.webm'])
def test_pictures_that_end_before_the_sound_are_not_lost(tmp_path, name):
    codec = '-c:v libvpx -deadline realtime' if name.endswith('webm') else '-c:v mpeg4'
    frames, told, source = watch(encode(tmp_path / name, codec, sound=7.0))
    assert (len(frames), told, source.lost, source.total) == (100, [], 0, 100)


@needs_ffmpeg
@pytest.mark.slow
def test_a_film_that_begins_late_has_lost_nothing(tmp_path):
    film = copied(tmp_path / 'late.mkv', encode(tmp_path / 'film.mp4'), before='-itsoffset 5')
    frames, told, source = watch(film)
    assert (len(frames), told, source.lost) == (100, [], 0)


@needs_ffmpeg
@pytest.mark.slow
@pytest.mark.parametrize('place', [0.3, 0.6])
def test_damage_to_a_film_of_varying_rate_is_told(tmp_path, place):
    film = encode(tmp_path / 'film.mkv', r'-vf select=gt(random(1)\,0.5) -c:v mjpeg -q:v 3')
    whole = watch(film)
    assert (whole[1], whole[2].lost) == ([], 0)
    overwritten(film, place, place + 0.1, np.random.default_rng(0))
    frames, told, source = watch(film)
    missing = len(whole[0]) - len(frames)
    assert missing >= 4
    assert source.lost == pytest.approx(missing, abs=3)
    assert told
    stamps = {round(frame.stamp * RATE / 1e9) for frame in whole[0]}
    assert {round(frame.stamp * RATE / 1e9) for frame in frames} <= stamps
