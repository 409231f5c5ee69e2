"""The detection rate is learned, and decides how long missed objects are believed to exist."""

import numpy as np
import pytest
from support.silhouettes import jittering
from support.silhouettes import PLACES

from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.detection_rate import DetectionRate
from colortrack_ros.tracking.update import _missed
from colortrack_ros.tracking.update import DIM
from colortrack_ros.tracking.update import OUTAGE


@pytest.mark.parametrize('chance', [0.5, 0.7, 0.85, 0.95])
def test_gaps_between_detections_tell_how_often_there_are_any(chance):
    rate, rng = DetectionRate(), np.random.default_rng(3)
    for _ in range(300):
        rate.learn(rng.geometric(chance, 10).astype(float))
    assert rate.estimate(0.95) == pytest.approx(chance, abs=0.06)


def test_it_is_no_more_than_is_given():
    rate = DetectionRate()
    assert rate.estimate(0.9) == 0.9
    rate.learn(np.ones(1000))
    rate.learn(np.full(3, 2.0))
    assert rate.estimate(0.9) == 0.9


def test_what_was_hidden_for_long_does_not_count():
    rate = DetectionRate()
    rate.learn(np.array([1.0] * 100 + [40.0] * 100))
    assert rate.estimate(0.95) == 0.95


@pytest.mark.slow
@pytest.mark.parametrize('jitter', [0.0, 0.15])
@pytest.mark.parametrize('chance', [0.6, 0.8])
def test_what_is_often_missed_is_shown_all_the_same(chance, jitter):
    rng, tracker, found = np.random.default_rng(7), Tracker(TrackerConfig(image_size=(640, 400))), 0
    for k in range(300):
        seen = PLACES[rng.random(len(PLACES)) < chance]
        tracks = tracker.update(jittering(seen, jitter, k, rng)).rows
        tracks = tracks[tracks['state'] != TENTATIVE]
        away = np.hypot(*(PLACES[:, None] - np.stack([tracks['u'], tracks['v']], 1)).T)
        found += int((away < 20).any(axis=0).sum()) * (k >= 100)
    assert found > 0.97 * len(PLACES) * 200


@pytest.mark.parametrize(('jitter', 'least', 'most'), [(0.0, 20, 40), (0.15, 1, 6)])
def test_what_a_network_loses_is_shown_for_a_few_frames_only(jitter, least, most):
    """Objects that vanish from outlines are mostly hidden; from boxes of networks, mostly gone."""
    rng, tracker, shown = np.random.default_rng(8), Tracker(TrackerConfig(image_size=(640, 400))), 0
    for k in range(120):
        seen = PLACES[: 5 if k < 80 else 4]
        tracks = tracker.update(jittering(seen, jitter, k, rng)).rows
        shown += k >= 80 and len(tracks) == 5
    assert least <= shown <= most


@pytest.mark.parametrize(('hits', 'misses'), [(0, 0), (9, 0), (0, 1), (0, 3), (9, 1), (3, 3)])
@pytest.mark.parametrize('p', [0.6, 0.95])
def test_a_miss_says_the_less_the_more_others_are_missed(hits, misses, p):
    """By Bayes's rule: in an outage each is seen with the probability DIM, else with p."""
    bright = p**hits * (1 - p) ** misses * (1 - OUTAGE)
    dim = DIM**hits * (1 - DIM) ** misses * OUTAGE
    measured = np.array([False] + hits * [True] + misses * [False] + [False, True])
    visible = np.append(np.ones(hits + misses + 1), [0.5, 0.5])  # the last are not known well
    expected = (bright * (1 - p) + dim * (1 - DIM)) / (bright + dim)
    assert _missed(visible, measured, p) == pytest.approx(expected)
