"""Tracks of clutter that flickers in its place are doubted, those of objects are not."""

import numpy as np
import pytest
from support.silhouettes import jittering
from support.silhouettes import PLACES
from support.silhouettes import points

from colortrack_ros.data import COASTING
from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.flicker import flickering


def test_what_is_missed_more_often_than_others_is_clutter_rather_than_what_is_missed_as_often():
    hits, misses = np.array([60.0, 95.0, 60.0]), np.array([40.0, 5.0, 0.0])
    clutter, object_, never = flickering(hits, misses, 0.95, whole=True)
    assert clutter > 0.9
    assert object_ < 0.05
    assert never < object_
    assert flickering(hits[:1], misses[:1], 0.6, whole=True) < 0.25


@pytest.mark.slow
def test_clutter_of_a_network_that_flickers_is_not_shown_while_it_is_missed():
    """It is found in half of the frames in one place, where objects are found in all but a few."""
    rng, tracker, shown = np.random.default_rng(9), Tracker(TrackerConfig(image_size=(640, 400))), 0
    for k in range(200):
        chance = np.array([0.97, 0.97, 0.97, 0.97, 0.5])
        tracks = tracker.update(jittering(PLACES[rng.random(5) < chance], 0.15, k, rng)).rows
        clutter = np.hypot(tracks['u'] - PLACES[4, 0], tracks['v'] - PLACES[4, 1]) < 30
        shown += k >= 60 and bool((tracks['state'][clutter] == COASTING).any())
    assert shown < 10


@pytest.mark.slow
@pytest.mark.parametrize('jitter', [None, 0.15])
def test_what_flickers_in_its_place_is_not_shown_when_it_is_found_either(jitter):
    """Points of objects that are missed now and then, and boxes of a network."""
    rng, shown = np.random.default_rng(10), 0
    tracker = Tracker(TrackerConfig(image_size=(640, 400)))
    chance = np.array([0.95, 0.95, 0.95, 0.25, 0.25])
    for k in range(400):
        seen = PLACES[rng.random(5) < chance]
        found = (
            points(seen, round(k / 30 * 1e9)) if jitter is None else jittering(seen, jitter, k, rng)
        )
        tracks = tracker.update(found).rows
        tracks = tracks[tracks['state'] != TENTATIVE]
        at = np.stack([tracks['u'], tracks['v']], axis=1)
        near = (np.hypot(*(PLACES[:, None] - at).T) < 30).any(axis=0)
        shown += (k >= 200) * near
    assert (shown[:3] > 195).all()
    assert (shown[3:] < 10).all()


@pytest.mark.slow
def test_a_point_that_is_found_in_half_of_the_frames_is_shown():
    rng, shown = np.random.default_rng(12), 0
    tracker = Tracker(TrackerConfig(image_size=(640, 400)))
    for k in range(400):
        seen = PLACES[rng.random(5) < [0.95, 0.95, 0.95, 0.95, 0.5]]
        tracks = tracker.update(points(seen, round(k / 30 * 1e9))).rows
        measured = tracks[(tracks['state'] != TENTATIVE) & (tracks['time_since_update'] == 0)]
        shown += len(measured) == len(seen) and k >= 100
    assert shown > 290


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_what_is_covered_on_end_flickers_no_more_than_what_is_not():
    """A network finds all but a few; one is covered for 12 frames of 30, again and again."""
    rng, tracker, shown = (
        np.random.default_rng(15),
        Tracker(TrackerConfig(image_size=(640, 400))),
        0,
    )
    for k in range(300):
        found = rng.random(5) < 0.97
        found[4] = k % 30 < 18
        tracks = tracker.update(jittering(PLACES[found], 0.15, k, rng)).rows
        near = np.hypot(tracks['u'] - PLACES[4, 0], tracks['v'] - PLACES[4, 1]) < 30
        shown += k >= 90 and k % 30 == 18 and COASTING in tracks['state'][near]
    assert shown == 7


@pytest.mark.slow
@pytest.mark.parametrize(('rate', 'least', 'most'), [(0.6, 0.0, 0.2), (0.8, 0.9, 1.0)])
def test_what_a_network_seldom_finds_again_is_not_shown_at_all(rate, least, most):
    """It lies in its place, as four others do that are found in all frames but a few."""
    rng, tracker, shown = (
        np.random.default_rng(16),
        Tracker(TrackerConfig(image_size=(640, 400))),
        [],
    )
    for k in range(400):
        found = rng.random(5) < np.array([0.95, 0.95, 0.95, 0.95, rate])
        tracks = tracker.update(jittering(PLACES[found], 0.15, k, rng)).rows
        tracks = tracks[tracks['state'] != TENTATIVE]
        away = np.hypot(tracks['u'] - PLACES[4, 0], tracks['v'] - PLACES[4, 1])
        if k >= 100 and found[4]:
            shown.append((away < 30).any())
    assert least <= np.mean(shown) <= most


def shown_at_rest(chance, rate, size=None, frames=400):
    """Return how often what lies in its places is shown where it is found, and where it is missed.

    :param chance: how often each of three objects that move is found.
    :param rate: how often that in each of three places is.
    :param size: of boxes, whose sides jitter by 15 %; None for points.
    """
    rng, tracker = np.random.default_rng(14), Tracker(TrackerConfig(image_size=(640, 400)))
    z, v = PLACES[:3] + np.array([0, 60]), np.array([[90.0, 40], [-60, 80], [50, -90]])
    places = PLACES[2:]
    shown, count = np.zeros(2), np.zeros(2)
    for k in range(frames):
        z = z + v / 30
        v = np.where(z < 0, abs(v), np.where(z > [640, 400], -abs(v), v))
        found = rng.random(3) < rate
        seen = np.concatenate([z[rng.random(3) < chance], places[found]])
        sides = size and size * rng.lognormal(0, 0.15, seen.shape)
        blobs = points(seen + rng.normal(0, 1, seen.shape), round(k / 30 * 1e9), size=sides)
        rows = tracker.update(blobs).rows
        rows = rows[rows['state'] != TENTATIVE]
        away = np.hypot(rows['u'] - places[:, :1], rows['v'] - places[:, 1:])
        near = (away < 12).any(axis=1)
        if k >= frames / 2:
            shown += np.count_nonzero(near & found), np.count_nonzero(near & ~found)
            count += np.count_nonzero(found), np.count_nonzero(~found)
    return shown / count


@pytest.mark.slow
def test_what_flickers_where_it_lies_is_doubted_sooner_if_objects_move():
    """They are found in 70 % of the frames by a network, and that in a third."""
    assert shown_at_rest(0.7, 0.33, 30.0).max() < 0.3


@pytest.mark.slow
def test_what_lies_is_shown_among_what_moves_if_it_is_found_in_half_of_the_frames():
    assert shown_at_rest(0.95, 0.5).min() > 0.9
