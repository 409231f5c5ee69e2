"""replay on recordings that are out of order, broken, or not what they should be."""

import contextlib
import copy
import os
from pathlib import Path
import re
import shutil
import sqlite3

import cv2
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from support.claims import write_huge_png
from support.damaged import damaged_video
from support.paths import DATA
from support.recorded import contents
from support.recorded import of_topic
from support.recorded import write_bag

from colortrack_ros.bags import BagWriter
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import stamp_of


def mixed_up(images):
    """Frames 6 a second, some up to 0.33 s behind the newest, one 0.5 s."""
    mixed = [*images]
    mixed[10:16] = [mixed[k] for k in (12, 10, 11, 15, 14, 13)]
    mixed.insert(32, mixed.pop(29))
    return mixed


@pytest.mark.parametrize('kind', ['images', 'detections'])
def test_messages_are_put_in_the_order_of_their_stamps(replay, bag, images, kind):
    assert replay(bag, '--output', 'sorted')[0] == 0
    topic = {'images': '/camera/image_raw', 'detections': '/detections'}[kind]
    recorded = [m.content for m in of_topic('sorted', '/detections')]
    infos = [m.content for m in of_topic('sorted', '/camera/camera_info')]
    given = images if kind == 'images' else recorded
    write_bag(Path('run'), {topic: mixed_up(given), '/camera/camera_info': infos})
    for window, max_late, late in ((0.6, 0.0, 0), (0.3, 0.3, 1), (0.0, 0.6, 5)):
        options = ['-p', f'reorder_window:={window}', '-p', f'max_late:={max_late}']
        status, out, _ = replay('run', '--output', 'mixed', '--force', *options)
        assert status == 0
        assert f'dropped     {late} late\n' in out
        assert 'restarts    0' in out
        stamps = [stamp_of(m.content.header) for m in of_topic('mixed', '/tracks')]
        assert stamps == sorted(stamps)
        assert len(stamps) == len(images) - late
        if late == 0:
            for name in ('/tracks', '/tracks/markers'):
                new, old = of_topic('mixed', name), of_topic('sorted', name)
                assert [m.cdr for m in new] == [m.cdr for m in old], name


def test_of_what_the_detector_lets_through_the_tracker_drops_what_is_late_for_it(replay, images):
    write_bag(Path('run'), {'/camera/image_raw': [*images[:20], *images[16:30]]})
    options = ['-p', 'detector:max_late:=0.1', '-p', 'tracker:max_late:=10.0']
    status, out, _ = replay('run', '--output', 'new', *options)
    assert status == 0
    assert 'dropped     3 late\n' in out
    assert len(of_topic('new', '/detections')) == 34
    assert len(of_topic('new', '/tracks')) == 31


@pytest.mark.parametrize(
    ('rgb', 'warned'),
    [
        ('[90, 110, 130]', 'red runs into other colors'),
        ('[205, 58, 34]', ''),
    ],
)
def test_what_the_detector_says_about_the_pictures_is_shown(replay, rgb, warned):
    scene = 'scene:single?width=160&height=120&duration=0.4'
    status, out, _ = replay(scene, '-p', f'detector:red.rgb:={rgb}', '-p', 'red.tolerance:=0.0')
    assert status == 0
    expected = (
        f'warnings    10 pictures, the last: {warned}' if warned else 'warnings    0 pictures'
    )
    assert expected in out


def test_a_loop_in_the_recording_restarts_the_tracker_once(replay, images):
    later = copy.deepcopy(images)
    for image in images:
        image = copy.deepcopy(image)
        image.header.stamp.sec -= 100
        later.append(image)
    write_bag(Path('run'), {'/camera/image_raw': later})
    status, out, _ = replay('run')
    assert status == 0
    assert 'restarts    1, the last: the stamp went back by 111.8' in out
    messages = of_topic('run_tracks', '/tracks')
    assert [stamp_of(m.content.header) for m in messages] == [stamp_of(i.header) for i in later]
    assert [m.log_time for m in messages] == sorted(m.log_time for m in messages)


@pytest.mark.parametrize('folder', ['test_bag_mcap', 'test_bag_sqlite3'])
@pytest.mark.parametrize('kind', ['image', 'compressed_image', 'point_cloud2'])
def test_malformed_messages_are_refused_and_counted(replay, folder, kind):
    path = DATA / 'malformed_bags' / folder
    if not path.exists():
        pytest.skip(f'{path} is not there')
    status, out, errors = replay(path, '--topic', f'/test/sensor_msgs/{kind}', '--output', 'new')
    assert (status, errors) == (1, '')
    assert 'frames      0\n' in out
    assert 'refused     2, the last: ' in out
    assert contents('new') == []


def test_detections_that_are_not_finite_are_told(replay):
    rows = np.zeros(2, DETECTION)
    rows['u'] = 50, np.nan
    found = [cloud_of_detections(Detections(rows, k * 40_000_000)) for k in range(3)]
    write_bag(Path('run'), {'/detections': found})
    status, out, _ = replay('run')
    assert status == 0
    assert 'warnings    3 pictures, the last: detections: expected up to 1e6 px' in out


def test_bad_messages_between_good_ones_change_nothing(replay, bag, images):
    rng = np.random.default_rng(1)
    assert replay(bag, '--output', 'good')[0] == 0
    writer = BagWriter(Path('run'), {'/camera/image_raw': 'sensor_msgs/msg/Image'})
    for k, image in enumerate(images):
        stamp = stamp_of(image.header)
        cdr = serialize_message(image)
        writer.write('/camera/image_raw', stamp, cdr)
        cut = cdr[: rng.integers(0, len(cdr))]  # some with a stamp, some without
        writer.write('/camera/image_raw', stamp + 1, cut if k % 2 else cdr[:2] + bytes(k))
    writer.close()
    status, out, _ = replay('run', '--output', 'new')
    assert status == 0
    assert [m.cdr for m in of_topic('new', '/tracks')] == [
        m.cdr for m in of_topic('good', '/tracks')
    ]
    assert 'frames      72\n' in out


def test_a_broken_bag_gives_what_can_be_read_and_an_error(replay, bag):
    shutil.copytree(bag, 'run')
    (file,) = Path('run').glob('*.mcap')
    content = bytearray(file.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 300_000] = bytes(300_000)
    file.write_bytes(content)
    status, out, errors = replay('run')
    assert (status, errors.count('\n')) == (1, 1)
    frames = int(re.search(r'frames +(\d+)', out)[1])
    assert f'{72 - frames} of 72 messages on /camera/image_raw cannot be read: ' in errors
    assert 40 < frames < 72, 'also those behind it'
    assert len(contents('run_tracks')) == 3 * frames + 1, 'and one CameraInfo'


def test_detections_whose_camera_info_is_lost_are_tracked_and_it_is_told(replay, bag):
    assert replay(bag, '--output', 'seen')[0] == 0
    clouds = [m.content for m in of_topic('seen', '/detections')]
    infos = [m.content for m in of_topic('seen', '/camera/camera_info')]
    path = write_bag(Path('run'), {'/detections': clouds, '/camera/camera_info': infos}, 'sqlite3')
    (database,) = path.glob('*.db3')
    with contextlib.closing(sqlite3.connect(database)) as rows:
        (number,) = rows.execute("SELECT id FROM topics WHERE name LIKE '%info'").fetchone()
        rows.execute('DELETE FROM messages WHERE topic_id = ?', (number,))
        rows.commit()
    status, _, errors = replay('run', '--output', 'tracked')
    assert f'{len(infos)} messages on /camera/camera_info, 0 were read' in errors
    assert len(of_topic('tracked', '/tracks')) == len(clouds)
    assert status == 1


def test_pictures_that_cannot_be_are_lost_and_the_others_tracked(replay, images):
    Path('shots').mkdir()
    for k, image in enumerate(images[:10]):
        cv2.imwrite(f'shots/{k}.png', frame_of_image(image).image)
    write_huge_png(Path('shots/5.png'))
    os.mkfifo('shots/5b.png')
    status, out, errors = replay('shots')
    assert (status, 'frames      9\n' in out) == (1, True)
    assert '1 pictures are lost' in errors


def test_a_damaged_video_is_replayed_to_its_end_with_a_status_that_says_so(replay, tmp_path):
    video = damaged_video(tmp_path / 'a.mp4', 'mp4v')
    status, out, errors = replay(video, '--output', 'new')
    assert status == 1
    lost = int(re.search(r'a\.mp4: (\d+) pictures are lost', errors)[1])
    assert f'frames      {200 - lost}' in out
    assert of_topic('new', '/tracks')[-1].log_time == 199 * 10**9 // 25


def test_stamps_that_nobody_fills_in_are_told(replay, images):
    """No track was ever confirmed, and nobody said why."""
    still = [copy.deepcopy(image) for image in images[:12]]
    for image in still:
        image.header.stamp.sec = image.header.stamp.nanosec = 0
    status, out, errors = replay(write_bag(Path('in/still'), {'/camera/image_raw': still}))
    told = 'the stamps stand still at 0.000 s'
    assert f'warnings    2 pictures, the last: {told}' in out
    assert (status, told in errors) == (1, True)  # or a nightly run takes it for good


def test_stamps_that_stand_still_for_a_while_are_told_and_the_recording_is_good(replay, images):
    still = [copy.deepcopy(image) for image in images[:30]]
    for image in still[:12]:
        image.header.stamp = still[0].header.stamp
    status, out, _ = replay(write_bag(Path('in/still'), {'/camera/image_raw': still}))
    assert 'warnings    2 pictures, the last: the stamps stand still at' in out
    assert status == 0
