"""The detection rate is learned, and decides how long missed objects are believed to exist."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import COASTING
from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.detection_rate import DetectionRate
from colortrack_ros.tracking.detection_rate import flickering

PLACES = np.array([[100.0, 100.0], [300.0, 110.0], [500.0, 105.0], [200.0, 300.0], [450.0, 310.0]])


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


def test_what_is_missed_more_often_than_others_is_clutter_rather_than_what_is_missed_as_often():
    hits, misses = np.array([60.0, 95.0, 60.0]), np.array([40.0, 5.0, 0.0])
    clutter, object_, never = flickering(hits, misses, 0.95, whole=True)
    assert clutter > 0.9
    assert object_ < 0.05
    assert never < object_
    assert flickering(hits[:1], misses[:1], 0.6, whole=True) < 0.25


def boxes(seen, jitter, k, rng):
    """Return the boxes of frame k around the places seen; the sides jitter by a share."""
    z, size = seen + rng.normal(0, 1, seen.shape), 60 * rng.lognormal(0, jitter, seen.shape)
    return points(z, round(k / 30 * 1e9), size=size)


@pytest.mark.slow
@pytest.mark.parametrize('jitter', [0.0, 0.15])
@pytest.mark.parametrize('chance', [0.6, 0.8])
def test_what_is_often_missed_is_shown_all_the_same(chance, jitter):
    rng, tracker, found = np.random.default_rng(7), Tracker(TrackerConfig(image_size=(640, 400))), 0
    for k in range(300):
        seen = PLACES[rng.random(len(PLACES)) < chance]
        tracks = tracker.update(boxes(seen, jitter, k, rng)).rows
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
        tracks = tracker.update(boxes(seen, jitter, k, rng)).rows
        shown += k >= 80 and len(tracks) == 5
    assert least <= shown <= most


def test_clutter_of_a_network_that_flickers_is_not_shown_while_it_is_missed():
    """It is found in half of the frames in one place, where objects are found in all but a few."""
    rng, tracker, shown = np.random.default_rng(9), Tracker(TrackerConfig(image_size=(640, 400))), 0
    for k in range(200):
        chance = np.array([0.97, 0.97, 0.97, 0.97, 0.5])
        tracks = tracker.update(boxes(PLACES[rng.random(5) < chance], 0.15, k, rng)).rows
        clutter = np.hypot(tracks['u'] - PLACES[4, 0], tracks['v'] - PLACES[4, 1]) < 30
        shown += k >= 60 and bool((tracks['state'][clutter] == COASTING).any())
    assert shown < 10


@pytest.mark.parametrize('jitter', [None, 0.15])
def test_what_flickers_in_its_place_is_not_shown_when_it_is_found_either(jitter):
    """Points of objects that are missed now and then, and boxes of a network."""
    rng, shown = np.random.default_rng(10), 0
    tracker = Tracker(TrackerConfig(image_size=(640, 400)))
    chance = np.array([0.95, 0.95, 0.95, 0.25, 0.25])
    for k in range(400):
        seen = PLACES[rng.random(5) < chance]
        found = points(seen, round(k / 30 * 1e9)) if jitter is None else boxes(seen, jitter, k, rng)
        tracks = tracker.update(found).rows
        tracks = tracks[tracks['state'] != TENTATIVE]
        at = np.stack([tracks['u'], tracks['v']], axis=1)
        near = (np.hypot(*(PLACES[:, None] - at).T) < 30).any(axis=0)
        shown += (k >= 200) * near
    assert (shown[:3] > 195).all()
    assert (shown[3:] < 10).all()


def test_a_point_that_is_found_in_half_of_the_frames_is_shown():
    rng, shown = np.random.default_rng(12), 0
    tracker = Tracker(TrackerConfig(image_size=(640, 400)))
    for k in range(400):
        seen = PLACES[rng.random(5) < [0.95, 0.95, 0.95, 0.95, 0.5]]
        tracks = tracker.update(points(seen, round(k / 30 * 1e9))).rows
        measured = tracks[(tracks['state'] != TENTATIVE) & (tracks['time_since_update'] == 0)]
        shown += len(measured) == len(seen) and k >= 100
    assert shown > 290


@pytest.mark.parametrize('count', [1, 5])
def test_what_is_found_in_a_quarter_of_the_frames_is_shown_if_nothing_is_found_more_often(count):
    rng, shown, found = np.random.default_rng(13), 0, 0
    tracker = Tracker(TrackerConfig(image_size=(640, 400)))
    for k in range(600):
        seen = PLACES[:count][rng.random(count) < 0.25]
        tracks = tracker.update(points(seen, round(k / 30 * 1e9))).rows
        measured = tracks[(tracks['state'] != TENTATIVE) & (tracks['time_since_update'] == 0)]
        shown += len(measured) * (k >= 300)
        found += len(seen) * (k >= 300)
    assert shown > 0.9 * found


@pytest.mark.parametrize(('others', 'most'), [(0.7, 0.15), (0.98, 0.02)])
def test_points_that_flicker_in_their_places_are_not_shown_while_they_are_missed(others, most):
    """Four of seven are found in a quarter of the frames; one is out of sight half of the time."""
    rng, shown, hidden = np.random.default_rng(11), 0, 0
    tracker = Tracker(TrackerConfig(image_size=(640, 400)))
    places = np.concatenate([PLACES, [[560.0, 200.0], [80.0, 220.0]]])
    chance = np.array([others, others, others, 0.25, 0.25, 0.25, 0.25])
    for k in range(400):
        found = rng.random(7) < chance
        found[0] &= k % 30 < 15
        z = places[found] + rng.normal(0, 1, (found.sum(), 2))
        tracks = tracker.update(points(z, round(k / 30 * 1e9))).rows
        coasting = tracks[tracks['state'] == COASTING]
        at = np.stack([coasting['u'], coasting['v']], axis=1)
        away = np.hypot(*np.moveaxis(places[:, None] - at, 2, 0))
        near = (away < 30).any(axis=1)
        shown += k >= 200 and int(near[3:].sum())
        hidden += k >= 200 and near[0] and k % 30 >= 15
    assert shown < most * 4 * 200
    assert hidden > 0.9 * 100
