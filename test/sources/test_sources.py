import os
from pathlib import Path
import shutil

import cv2
import numpy as np
import pytest
from support.claims import write_huge_png
from support.damaged import damaged_video
from support.damaged import number_of
from support.films import watch
from support.paths import DATA

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.scenes import open_scene
from colortrack_ros.sources import Grabber
from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError

SCENE = 'scene:five?width=64&height=48&duration=0.5'


def picture(value, height=24, width=32):
    return np.full((height, width, 3), value, np.uint8)


def write_video(path, count=10, rate=20.0):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*'MJPG'), rate, (32, 24))
    for k in range(count):
        writer.write(picture(20 * k))
    writer.release()
    return str(path)


def read_all(source):
    frames = []
    while (frame := source.read()) is not None:
        frames.append(frame)
    return frames


@pytest.fixture
def recordings(tmp_path):
    """A video, a folder of pictures and a scene, with the number of frames and the rate."""
    folder = tmp_path / 'shots'
    folder.mkdir()
    for k in range(12):
        cv2.imwrite(str(folder / f'shot{k}.png'), picture(10 * k))
    return {
        'video': (write_video(tmp_path / 'clip.avi'), 10, 20.0),
        'pictures': (str(folder), 12, 30.0),
        'scene': (SCENE, 12, 24.0),
    }


@pytest.mark.parametrize('kind', ['video', 'pictures', 'scene'])
def test_a_recording_steps_by_its_own_period_and_counts_on_when_rewound(recordings, kind):
    spec, count, rate = recordings[kind]
    source = open_source(spec)
    assert not source.live
    assert source.period == round(NANOSECONDS / rate)
    first, second = read_all(source), (source.rewind(), read_all(source))[1]
    assert len(first) == len(second) == count
    stamps = [frame.stamp for frame in first + second]
    assert stamps == [round(k * NANOSECONDS / rate) for k in range(2 * count)]
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.image, b.image)
    assert source.read() is None
    source.close()


@pytest.mark.parametrize('kind', ['video', 'pictures', 'scene'])
def test_every_frame_is_bgr8_and_owns_its_picture(recordings, kind):
    source = open_source(recordings[kind][0])
    frame = source.read()
    before = frame.image.copy()
    source.read()
    assert frame.encoding == 'bgr8'
    assert frame.image.dtype == np.uint8
    assert frame.image.flags.c_contiguous
    np.testing.assert_array_equal(frame.image, before)


def test_pictures_come_in_natural_order_and_at_the_given_rate(recordings):
    source = open_source(recordings['pictures'][0], rate=5.0)
    frames = read_all(source)
    assert source.period == NANOSECONDS // 5
    assert [int(frame.image[0, 0, 0]) for frame in frames] == [10 * k for k in range(12)]


def test_a_pattern_or_one_file_picks_pictures(recordings):
    folder = recordings['pictures'][0]
    assert len(read_all(open_source(f'{folder}/shot1*.png'))) == 3
    assert len(read_all(open_source(f'{folder}/shot1.png'))) == 1


def test_names_with_brackets_and_spaces_are_files_too(tmp_path):
    folder = tmp_path / 'take [1]'
    folder.mkdir()
    cv2.imwrite(str(folder / 'a.png'), picture(1))
    write_video(folder / 'b [2].avi')
    assert len(read_all(open_source(str(folder)))) == 1
    assert len(read_all(open_source(str(folder / 'b [2].avi')))) == 10


def test_a_time_in_a_relative_name_is_no_protocol(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_video(tmp_path / 'ball.avi')
    (tmp_path / 'ball.avi').rename('2026-11-30T12:30:00.avi')
    assert len(read_all(open_source('2026-11-30T12:30:00.avi'))) == 10


def test_gray_and_transparent_pictures_become_bgr(tmp_path):
    cv2.imwrite(str(tmp_path / '1.png'), np.full((4, 5), 7, np.uint8))
    cv2.imwrite(str(tmp_path / '2.png'), np.full((4, 5, 4), 8, np.uint8))
    cv2.imwrite(str(tmp_path / '3.png'), np.full((4, 5, 3), 9 * 257, np.uint16))
    images = [frame.image for frame in read_all(open_source(str(tmp_path)))]
    assert [image.shape for image in images] == [(4, 5, 3)] * 3
    assert [image.dtype for image in images] == [np.uint8] * 3
    assert [int(image[0, 0, 0]) for image in images] == [7, 8, 9]


def test_a_broken_picture_is_named_and_the_next_one_follows(recordings):
    folder = Path(recordings['pictures'][0])
    (folder / 'shot1.png').write_text('no picture')
    source = open_source(str(folder))
    source.read()
    with pytest.raises(SourceError, match=r'shot1\.png'):
        source.read()
    assert source.read().image[0, 0, 0] == 20


def test_a_folder_that_goes_while_it_plays_is_told_picture_by_picture_and_ends(recordings):
    folder, count, _ = recordings['pictures']
    grabber = Grabber(open_source(folder), loop=lambda: True)
    assert grabber.read() is not None
    shutil.rmtree(folder)
    refusals, frames = [], 1
    while True:
        try:
            if grabber.read() is None:
                break
            frames += 1
        except SourceError as error:
            refusals.append(str(error))
    grabber.close()
    assert frames <= 4  # what had been read ahead
    assert len(refusals) == grabber.lost == 2 * count - frames  # it looks again when it loops
    assert all('No such file' in refusal for refusal in refusals)


def test_a_picture_that_claims_to_be_huge_is_lost_and_the_next_one_follows(recordings):
    folder = Path(recordings['pictures'][0])
    write_huge_png(folder / 'shot1.png')
    os.mkfifo(folder / 'shot1b.png')
    source = open_source(str(folder))
    source.read()
    with pytest.raises(SourceError, match=r'shot1\.png'):
        source.read()
    assert source.read().image[0, 0, 0] == 20
    assert source.lost == 1


def test_a_scene_is_the_rendered_scene():
    frames = read_all(open_source(SCENE))
    scene = open_scene(SCENE.removeprefix('scene:'))
    np.testing.assert_array_equal(frames[7].image, scene.render(7))


@pytest.mark.parametrize('name', ['text.mp4', 'empty.mp4', 'missing.mp4', 'nothing', '*.png', ''])
def test_what_is_no_video_or_picture_is_refused_in_one_line(tmp_path, name, capfd):
    (tmp_path / 'text.mp4').write_text('this is no video\n' * 100)
    (tmp_path / 'empty.mp4').touch()
    (tmp_path / 'nothing').mkdir()
    spec = str(tmp_path / name) if name else ''
    with pytest.raises(SourceError) as caught:
        open_source(spec)
    message = str(caught.value)
    assert repr(spec) in message
    assert '\n' not in message
    assert 'expected' in message or 'a source is a device' in message
    assert capfd.readouterr() == ('', '')


def test_a_folder_whose_first_picture_is_broken_is_refused(tmp_path, capfd):
    (tmp_path / 'a.png').write_text('no picture')
    with pytest.raises(SourceError, match=r'a\.png'):
        open_source(str(tmp_path))
    assert capfd.readouterr() == ('', '')


@pytest.mark.parametrize(
    ('spec', 'words'),
    [('scene:fife', ['fife', 'five', 'occlusion']), ('scene:five?rate=x', ['rate=x', 'number'])],
)
def test_an_unknown_scene_or_option_is_refused_with_what_there_is(spec, words):
    with pytest.raises(SourceError) as caught:
        open_source(spec)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize('spec', ['97', '/dev/video97', '/dev/null'])
def test_a_device_that_is_not_there_or_no_camera_is_refused(spec, capfd):
    with pytest.raises(SourceError, match='there is') as caught:
        open_source(spec)
    assert repr(spec) in str(caught.value)
    assert '\n' not in str(caught.value)
    assert capfd.readouterr() == ('', '')


@pytest.mark.parametrize(
    ('name', 'count', 'period'),
    [
        ('ball.mp4', 60, 33555555),
        pytest.param('ball2.mp4', 1004, 41708333, marks=pytest.mark.slow),
        pytest.param('ball4.mp4', 492, 33444444, marks=pytest.mark.slow),
    ],
)
def test_real_videos_are_read_to_their_end(name, count, period):
    path = DATA / 'ball_toss' / name
    if not path.exists():
        pytest.skip(f'{path} is not there')
    source = open_source(str(path))
    assert source.period == pytest.approx(period, abs=2e5)
    assert sum(1 for _ in iter(source.read, None)) == count


@pytest.mark.parametrize(
    ('name', 'codec', 'has_times'),
    [('a.mp4', 'mp4v', True), ('a.mkv', 'mp4v', True), ('a.avi', 'MJPG', False)],
)
def test_a_damaged_video_is_read_on_and_what_is_lost_is_told(tmp_path, name, codec, has_times):
    frames, told, source = watch(damaged_video(tmp_path / name, codec))
    assert 150 <= len(frames) < 200
    assert number_of(frames[-1]) == 199
    assert source.lost == 200 - len(frames)
    assert 1 <= len(told) <= 3
    assert all(str(tmp_path / name) in text for text in told)
    stamps = [frame.stamp for frame in frames]
    assert stamps == sorted(set(stamps))
    if has_times:  # numbers of pictures beside the damage cannot be trusted
        for frame in frames[:70] + frames[-40:]:
            assert frame.stamp == number_of(frame) * NANOSECONDS // 25
    source.rewind()
    source.read()
    assert source.read().stamp - frames[-1].stamp == 2 * NANOSECONDS // 25


def test_a_video_without_damage_loses_nothing(recordings):
    source = open_source(recordings['video'][0])
    read_all(source)
    assert source.lost == 0
