"""Identities, at default parameters, in scenes where other trackers lose them."""

import itertools

import numpy as np
import pytest
from support.paths import DATA

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.evaluation import Tally
from colortrack_ros.scenes import BLACKOUT
from colortrack_ros.scenes import detections_of
from colortrack_ros.scenes import open_scene
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

SEEN = 0.25
"""Least visible part of an object that needs a track; with less it counts as hidden."""

HALF = '?width=640&height=360'
"""A quarter of the pixels, which are no easier: objects are half as large in them."""

JUGGLING = DATA / 'juggling_centroids'


def detector_of(scene, tolerance=25.0, **parameters):
    colors = [ReferenceColor.from_rgb(name, rgb, tolerance) for name, rgb in scene.colors.items()]
    return Detector(DetectorConfig(colors=tuple(colors), **parameters))


def frames_of(scene):
    for k in range(len(scene)):
        yield Frame(scene.render(k), 'bgr8', round(k * NANOSECONDS / scene.rate))


def live(tracker, detections):
    rows = tracker.update(detections).rows
    rows = rows[rows['state'] != TENTATIVE]
    return np.stack([rows['track_id'], rows['u'], rows['v']], axis=1)


def played(scene, *detections):
    """Return a score for each series of detections; each picture is rendered only once."""
    games = [(Tracker(TrackerConfig(image_size=(scene.width, scene.height))), Tally(20.0))
             for _ in detections]  # fmt: skip
    for k, ones in enumerate(zip(*detections, strict=True)):
        rows = scene.truth(k)
        seen = rows[rows['visible'] >= SEEN]
        truth = np.stack([seen['id'], seen['u'], seen['v']], axis=1)
        for (tracker, tally), one in zip(games, ones, strict=True):
            tally.add(truth, live(tracker, one), hidden=len(rows) - len(seen))
    return [tally.score() for _, tally in games]


@pytest.mark.slow
@pytest.mark.parametrize(
    ('name', 'idf1'), [('collision', 0.98), ('swarm', 0.97), ('juggle', 0.97), ('turns', 0.95)]
)
def test_objects_keep_their_tracks(name, idf1):
    scene = open_scene(name + HALF)
    (score,) = played(scene, map(detector_of(scene).detect, frames_of(scene)))
    assert score.idf1 >= idf1


@pytest.mark.slow
@pytest.mark.parametrize(
    ('name', 'worse', 'idf1'),
    [
        ('blackout' + HALF, BLACKOUT, 0.8),
        ('flicker' + HALF, {}, 0.97),
        ('vanish', {}, 0.95),
        ('collision' + HALF, {}, 0.99),
    ],
)
def test_objects_keep_their_tracks_as_a_perfect_detector_or_a_bad_one_sees_them(name, worse, idf1):
    """The flickering balls fade below the detector's threshold; what it then finds is no ball."""
    scene = open_scene(name)
    found = (detections_of(scene, k, **worse) for k in range(len(scene)))
    (score,) = played(scene, found)
    assert score.idf1 >= idf1


@pytest.mark.slow
def test_tracks_go_on_while_the_light_falls_to_a_third_and_turns_yellow():
    scene = open_scene('light' + HALF + '&rate=15')  # more changes from frame to frame than at 24
    detectors = [
        detector_of(scene, 25.0, white_balance='gray_world'),
        detector_of(scene, 50.0, white_balance='gray_world'),
        detector_of(scene, 25.0, follow_light=60.0),
        detector_of(scene, 35.0, follow_light=60.0),
    ]
    pictures = itertools.tee(frames_of(scene), len(detectors))
    found = [map(one.detect, some) for one, some in zip(detectors, pictures, strict=True)]
    for score in played(scene, *found):
        assert score.idf1 >= 0.99
        assert score.switches == 0


@pytest.mark.slow
@pytest.mark.skipif(not JUGGLING.is_dir(), reason=f'no {JUGGLING}; set COLORTRACK_DATA')
@pytest.mark.parametrize(('drop', 'idf1'), [(0.0, 0.985), (0.1, 0.96)])
def test_juggled_balls_keep_their_tracks(drop, idf1):
    scores = []
    for path in sorted(JUGGLING.glob('*.csv')):
        rng = np.random.default_rng(0)
        tracker, tally = Tracker(), Tally(max_distance=30.0)
        table = np.loadtxt(path, delimiter=',', skiprows=1)
        for k in range(int(table[0, 0]), int(table[-1, 0]) + 1):
            truth = table[table[:, 0] == k, 1:]
            seen = rng.permutation(truth[rng.random(len(truth)) >= drop, 1:])
            rows = np.zeros(len(seen), DETECTION)
            rows['u'], rows['v'] = seen.T
            rows['cov_uu'] = rows['cov_vv'] = 4.0
            tally.add(truth, live(tracker, Detections(rows, k * NANOSECONDS // 30)))
        scores.append(tally.score().idf1)
    assert np.mean(scores) >= idf1
