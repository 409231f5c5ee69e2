"""Detector and tracker without ROS, as a Python user joins them."""

import copy
import doctest
from functools import partial
import math
from pathlib import Path
import pickle

import cv2
import numpy as np
import pytest

from colortrack_ros import chain
from colortrack_ros.chain import ColorChain
from colortrack_ros.chain import ColorTracker
from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.flow.stage import Stage
from colortrack_ros.scenes import open_scene
from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker

SCENE = 'scene:five?width=320&height=240&rate=6&duration=12'


def test_the_example_of_the_documentation_works():
    assert doctest.testmod(chain) == (0, 5)


def test_every_frame_gives_its_tracks_and_the_balls_are_found():
    track = ColorTracker()
    frames = list(open_source(SCENE))
    for frame in frames:
        tracks = track(frame)
        assert (tracks.stamp, track.detections.stamp) == (frame.stamp, frame.stamp)
    truth = open_scene(SCENE.removeprefix('scene:')).truth(len(frames) - 1)
    confirmed = tracks.rows[tracks.rows['state'] != TENTATIVE]
    assert len(truth) == 4
    for ball in truth:
        distances = np.hypot(confirmed['u'] - ball['u'], confirmed['v'] - ball['v'])
        assert distances.min() < 0.5


def test_the_box_of_what_is_not_symmetric_fits():
    track = ColorTracker(DetectorConfig(colors=(ReferenceColor.from_rgb('red', (220, 20, 20)),)))
    for k in range(20):
        picture = np.full((200, 300, 3), 90, np.uint8)
        u, v = 100 + 4 * k, 80 + k
        cv2.ellipse(picture, (u, v), (40, 40), 0, 180, 360, (20, 20, 220), cv2.FILLED)  # a cap,
        cv2.rectangle(picture, (u, v), (u + 80, v + 8), (20, 20, 220), cv2.FILLED)  # and its peak
        (row,) = track(Frame(picture, stamp=round(k * NANOSECONDS / 30))).rows
    found = [row[name] for name in ('box_u', 'box_v', 'box_w', 'box_h')]
    assert found == pytest.approx([u - 40, v - 40, 121, 49], abs=1.5)
    assert np.hypot(row['u'] - u - 20, row['v'] - v + 16) > 10  # where its middle would be


def test_configurations_are_those_of_the_nodes():
    picture = np.zeros((100, 100, 3), np.uint8)
    picture[40:60, 40:60] = 0, 0, 255
    track = ColorTracker(DetectorConfig(min_area=1000), TrackerConfig())
    assert len(track(Frame(picture)).rows) == 0
    assert len(ColorTracker()(Frame(picture)).rows) == 1


def test_a_recording_that_starts_again_starts_the_tracker_again():
    track = ColorTracker()
    frames = list(open_source(SCENE))[:10]
    restarted = [bool(track(frame).restarted) for frame in frames * 2]
    assert [k for k, again in enumerate(restarted) if again] == [10]


@pytest.mark.slow
def test_detections_made_elsewhere_give_the_same_tracks():
    done = []
    for detects in (True, False):
        detector, tracks = Detector(DetectorConfig()), []
        detection = Stage(Detector(DetectorConfig()).detect, print)
        tracking = Stage(Tracker(TrackerConfig()).update, print)
        tracking.then(lambda some, _, tracks=tracks: tracks.append(some.rows.tobytes()))
        both = ColorChain(detection, tracking)
        for frame in open_source(SCENE):
            item: Frame | Detections = frame if detects else detector.detect(frame)
            both.put(item)
        done.append(tracks)
    assert done[0] == done[1]


def test_the_tracker_is_told_how_large_the_pictures_are():
    track = ColorTracker()
    track(next(iter(open_source(SCENE))))
    assert track.detections.image_size == (320, 240)


PICTURE = np.zeros((100, 100, 3), np.uint8)
CONTOURS = ContourTracker(ContourConfig())
BALL = ReferenceColor.from_rgb('ball', (205, 58, 34))


@pytest.mark.parametrize(
    ('beginner', 'told'),
    [
        (lambda: ColorTracker()(Frame(PICTURE, stamp=0.04)), 'whole nanoseconds (int), got 0.04'),
        (lambda: ColorTracker()(Frame(PICTURE, stamp=math.nan)), 'nanoseconds (int), got nan'),
        (lambda: ColorTracker()(Frame(PICTURE, stamp=None)), 'whole nanoseconds (int), got None'),
        (lambda: ColorTracker()(Frame(cv2.imread('not there'))), 'cv2.imread gives it for a file'),
        (lambda: ColorTracker()(Frame(PICTURE.tolist())), 'expected an array of uint8, got list'),
        (lambda: CONTOURS.update(Frame(PICTURE, stamp=0.04)), 'whole nanoseconds (int), got 0.04'),
        (lambda: ColorTracker()(PICTURE), 'expected a Frame, got ndarray'),
        (lambda: Detector(DetectorConfig()).detect(PICTURE), 'expected a Frame, got ndarray'),
        (lambda: ColorTracker()(Frame(PICTURE / 255)), 'expected uint8, got float64'),
        (lambda: ColorTracker(BALL), 'expected a DetectorConfig, got a ReferenceColor'),
        (lambda: ColorTracker(TrackerConfig()), 'expected a DetectorConfig, got a TrackerConfig'),
        (lambda: DetectorConfig(colors=BALL), 'colors: expected a tuple of ReferenceColor'),
        (lambda: DetectorConfig(colors=((205, 58, 34),)), 'expected a tuple of ReferenceColor'),
        (lambda: Tracker().update(Detections([])), 'dtype DETECTION, got list of shape (0,)'),
        (
            lambda: Tracker().update(Detections(np.array([[50.0, 40.0]]))),
            'got ndarray of shape (1, 2)',
        ),
        (
            lambda: Tracker().update(Detections(stamp=0.04)),
            'whole nanoseconds (int), got 0.04; of seconds they are round(',
        ),
        (lambda: Tracker().update(Detections().rows), 'got ndarray; of boxes it is Detections.fr'),
        (lambda: Detections.from_boxes([1, 2, 3, 4]), 'array (N, 4): left, top, right, bottom, '),
        (lambda: Detections.from_boxes(np.ones((2, 6))), 'bottom, got shape (2, 6)'),
        (lambda: Detections.from_boxes([[300, 40, 20, 60]]), 'is it width and height?'),
        (lambda: Detections.from_boxes([[0.1, 0.2, 0.3, 0.4]]), 'multiply by width and height'),
        (lambda: Detections.from_boxes([[1, 2, 3, 4]], colors='red'), 'colors: expected numbers'),
        (lambda: Detections.from_boxes([[1, 2, 3, 4]], colors=-1), 'colors: expected numbers'),
        (lambda: Detections.from_boxes([[1, 2, 3, 4]], scores=[1, 1]), 'one for each of 1, got'),
        (lambda: Detections.from_points([[1, 2, 3]]), 'array (N, 2): u, v, got shape (1, 3)'),
        (lambda: Detections.from_boxes([[1, 2, 3, 4], [5]]), 'bottom, got [[1, 2, 3, 4], [5]]'),
        (lambda: Detections.from_points([[3, 4]], scores=[1, [1]]), 'scores: expected numbers, go'),
        (lambda: Detections.from_points([[3, 4]], image_size=None), '(width, height), got None'),
        (lambda: Detections.from_points([], image_size=(640, 'b')), 'image_size: expected numbers'),
        (lambda: Detections.from_points([], image_size=(640.5, 3)), 'image_size: expected whole'),
        (lambda: Detections.from_points([], image_size=np.array(640)), '(width, height), got 640'),
        (lambda: Detections.from_points([], scores=-np.ones((9, 9))), 'scores: expected numbers'),
        (lambda: Detections.from_points([[1, 2]] * 30, colors=np.full(30, 0.5)), 'below 2^32, got'),
        (lambda: WindowTracker(WindowConfig(), [[1, 2, 30]]), 'boxes: expected (N, 4)'),
        (lambda: WindowTracker(WindowConfig(), ['box']), 'boxes: expected (N, 4)'),
    ],
)
def test_what_beginners_get_wrong_is_told_where_they_wrote_it(beginner, told):
    with pytest.raises(ValueError) as error:  # noqa: PT011
        beginner()
    assert told in str(error.value)
    assert '\n' not in str(error.value)


def test_frames_without_a_time_are_told():
    track = ColorTracker()
    frames = [Frame(PICTURE)] * 20
    with pytest.warns(UserWarning, match=r'stamps stand still.*round\(seconds') as warned:
        list(map(track, frames))
    ours = [warning for warning in warned if warning.category is UserWarning]
    assert all(warning.filename == __file__ for warning in ours)


def test_sources_are_opened_by_paths_and_numbers_too(tmp_path):
    cv2.imwrite(str(tmp_path / 'one.png'), PICTURE)
    assert next(iter(open_source(tmp_path / 'one.png'))).image.shape == PICTURE.shape
    with pytest.raises(SourceError, match='source None: expected a text, a Path or the number'):
        open_source(None)
    with pytest.raises(SourceError, match="source '99'"):
        open_source(99)
    with pytest.raises(SourceError, match=r"source 'not\.mp4': there is no such file"):
        open_source(Path('not.mp4'))


@pytest.mark.parametrize('copied', [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
@pytest.mark.parametrize(
    'make',
    [
        ColorTracker,
        lambda: partial(WindowTracker.update, WindowTracker(WindowConfig(), [[60, 60, 30, 30]])),
        lambda: partial(ContourTracker.update, ContourTracker(ContourConfig())),
    ],
    ids=['color', 'windows', 'contours'],
)
def test_copies_go_on_with_the_same_tracks_also_in_other_processes(make, copied):
    track, frames = make(), list(open_source(SCENE))[:20]
    for frame in frames[:12]:
        track(frame)
    other = copied(track)
    for frame in frames[12:]:
        assert np.array_equal(track(frame).rows, other(frame).rows)
