"""Objects that come so close that the detector merges them into one detection."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import COASTING
from colortrack_ros.evaluation import Tally
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import tracker as tracker_module
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.resolution import Resolution

ROOM = np.array([800.0, 600.0])


def crowd(rng, count, frames, rate):
    """Return positions, (K, N, 2), of objects that bounce between the walls of a room [px]."""
    velocity = rng.uniform(-150, 150, (count, 2))
    t = np.arange(frames)[:, None, None] / rate
    way = (rng.uniform(0, ROOM, (count, 2)) + t * velocity) % (2 * ROOM)
    return ROOM - np.abs(way - ROOM)


def merged(z, touch):
    """Return the means of all that touch, directly or through others."""
    near = np.hypot(*(z[:, None] - z).T) < touch
    near = np.linalg.matrix_power(near.astype(float), len(z)) > 0
    group = near.argmax(axis=1)
    count = np.bincount(group)
    sums = np.stack([np.bincount(group, axis) for axis in z.T], axis=1)
    return sums[count > 0] / count[count > 0, None]


def frames_of(position, rng, rate, noise, touch, missed=0.0, clutter=0):
    """Yield the detections of each frame, without boxes or covariances."""
    for k, truth in enumerate(position):
        z = truth + rng.normal(0, noise, truth.shape)
        z = z[rng.random(len(z)) >= missed]
        z = merged(z, touch) if touch and len(z) else z
        z = np.concatenate([z, rng.uniform(0, ROOM, (rng.poisson(clutter), 2))])
        yield points(rng.permutation(z), round(k * 1e9 / rate), 0.0)


def play(position, rng, *, rate=30, noise=1.0, touch=30.0, **others):
    """Return the tracker and its score over the frames."""
    tracker, tally = Tracker(), Tally(25.0)
    for k, detections in enumerate(frames_of(position, rng, rate, noise, touch, **others)):
        rows = tracker.update(detections).rows
        rows = rows[rows['state'] > 0]
        found = np.stack([rows['track_id'], rows['u'], rows['v']], axis=1)
        tally.add(np.column_stack([np.arange(len(position[k])), position[k]]), found)
    return tracker, tally.score()


def pair(apart, slow=20.0, frames=150):
    """Return two objects that meet, pass each other at a distance, and part, (K, 2, 2) [px]."""
    t = (np.arange(frames) - frames / 2) / 30
    one = np.stack([400 + slow * t, 300 + 0 * t], axis=1)
    return np.stack([one, np.stack([400 - slow * t, 300 + apart + 0 * t], axis=1)], axis=1)


@pytest.mark.slow
@pytest.mark.parametrize('apart', [8.0, pytest.param(15.0, marks=pytest.mark.slow), 25.0])
def test_two_that_are_one_detection_for_seconds_come_out_as_whom_they_were(apart):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        _, score = play(pair(apart, slow=30.0, frames=240), rng, touch=28.0)
        assert score.switches == 0
        assert score.idf1 > 0.95


@pytest.mark.slow
def test_two_that_stay_together_longer_than_a_track_is_kept_are_still_two():
    position = pair(10.0, slow=6.0, frames=400)
    tracker, rng = Tracker(TrackerConfig(max_time_since_update=0.5)), np.random.default_rng(1)
    for detections in frames_of(position[60:340], rng, 30, 0.5, 14.0):
        rows = tracker.update(detections).rows
    assert rows['track_id'].tolist() == [1, 2]


def compare(monkeypatch, count, frames, rate, seeds=3, **detector):
    """Return the resolution, and mean IDF1 of crowds with and without shared detections."""
    both, reach = {True: [], False: []}, []
    for seed in range(seeds):
        position = crowd(np.random.default_rng(seed), count, frames, rate)
        for shares, scores in both.items():
            with monkeypatch.context() as patch:
                if not shares:
                    patch.setattr(
                        tracker_module, 'share_centroids', lambda *given: (given[2], None)
                    )
                rng = np.random.default_rng(seed + 100)
                tracker, score = play(position, rng, rate=rate, **detector)
            scores.append(score.idf1)
            reach.append(tracker._adaptation.resolution.reach)
    return max(reach[::2]), np.mean(both[True]), np.mean(both[False])


@pytest.mark.slow
@pytest.mark.parametrize(
    ('count', 'rate', 'noise', 'touch', 'seeds'),
    # Few are lost of the last: in most seeds sharing changes nothing, and fourteen may show 0.76
    # where forty show 0.70.
    # Of the others 1 - IDF1 is 0.06 to 0.28 of what it is without in each of six seeds.
    [(20, 20, 2.0, 25.0, 3), (12, 60, 0.5, 45.0, 3), (40, 15, 1.0, 12.0, 20)],
)
def test_a_crowd_that_merges_and_splits_keeps_its_ids(
    monkeypatch, count, rate, noise, touch, seeds
):
    _, idf1, before = compare(monkeypatch, count, 10 * rate, rate, seeds, noise=noise, touch=touch)
    assert idf1 > 0.93
    assert 1 - idf1 < 0.75 * (1 - before)


@pytest.mark.slow
def test_where_nothing_merges_misses_and_clutter_are_not_taken_for_it(monkeypatch):
    reach, idf1, before = compare(monkeypatch, 40, 240, 30, touch=0.0, missed=0.1, clutter=40)
    assert reach < 5.0
    assert idf1 > before - 0.01


def test_objects_of_two_colors_are_never_one_detection():
    tracker = Tracker()
    for k, position in enumerate(pair(6.0, slow=60.0, frames=120)):
        near = np.hypot(*(position[0] - position[1])) < 20.0
        z = position.mean(axis=0)[None] if near else position
        detections = points(z, round(k * 1e9 / 30), 1.0)
        detections.rows['color'] = [2] if near else [0, 1]
        tracker.update(detections)
        assert not tracker._tracks.records['shared'].any()


def test_tracks_that_share_say_that_they_coast_and_exist_for_certain():
    tracker, rng = Tracker(), np.random.default_rng(3)
    for k, detections in enumerate(frames_of(pair(10.0, slow=40.0), rng, 30, 0.5, 14.0)):
        rows = tracker.update(detections).rows
        if k > 40:
            assert len(rows) == 2
            assert rows['score'].min() > 0.95
        if len(detections.rows) == 1:
            assert (rows['state'] == COASTING).all()
            assert (np.linalg.eigvalsh(rows['covariance']) > 0).all()


def test_the_resolution_is_learned_from_what_is_resolved_and_what_is_not():
    rng, resolution = np.random.default_rng(4), Resolution()
    for _ in range(100):
        z = rng.uniform(0, 400, (20, 2))
        near = np.hypot(*(z[:, None] - z).T) + 1e3 * np.eye(20)
        resolution.learn(z[near.min(axis=1) > 30.0], rng.uniform(5, 30, 2))
    assert np.exp(resolution.log_chance(np.array([15.0]))) > 0.8
    assert np.exp(resolution.log_chance(np.array([60.0]))) < 0.05


@pytest.mark.parametrize('associator', ['jpda', 'nearest'])
def test_other_associators_run_where_objects_merge(associator):
    tracker, rng = Tracker(TrackerConfig(associator=associator)), np.random.default_rng(5)
    for detections in frames_of(crowd(rng, 15, 60, 30), rng, 30, 1.0, 40.0):
        rows = tracker.update(detections).rows
        assert np.isfinite(rows['covariance']).all()


def test_what_a_detector_finds_in_two_pieces_now_and_then_is_always_shown():
    tracker, rng = Tracker(), np.random.default_rng(2)
    for k in range(70):
        true = np.array([[100.0 + k, 200.0]])
        z = true + rng.normal(0, 1.0, true.shape)
        if rng.random() < 0.35:
            z = z + np.array([[-7.0, 0.0], [7.0, 0.0]])
        rows = tracker.update(points(z, round((1 + k / 30) * 1e9), 0.0)).rows
        assert k <= 5 or np.hypot(rows['u'] - true[0, 0], rows['v'] - 200).min(initial=99) < 15
