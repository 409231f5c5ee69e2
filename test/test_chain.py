"""Detector and tracker without ROS, as a Python user joins them."""

import doctest

import cv2
import numpy as np
import pytest

from colortrack_ros import chain
from colortrack_ros.chain import ColorChain
from colortrack_ros.chain import ColorTracker
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
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

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
