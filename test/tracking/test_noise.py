"""Measurement noise is learned from the detections, whatever covariance they claim."""

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.noise import MeasurementNoise
from colortrack_ros.tracking.noise import NOISE_FIELDS
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.recent import RECENT_FIELDS

LEARNED = 24
"""Frames at the start that are not evaluated: a second."""


def factor(noise, given, acceleration=0.0, count=8, frames=90, steps=None, seed=0):
    """Return the learned factors for detections with this noise that claim a variance given^2."""
    rng = np.random.default_rng(seed)
    records = np.zeros(count, [('color', 'u4'), *RECENT_FIELDS, *NOISE_FIELDS])
    learned, recent, track = MeasurementNoise(), Recent(), np.arange(count)
    x, v = np.zeros((count, 2)), rng.normal(0, 200, (count, 2))
    for k in range(frames):
        dt = 1 / 30 if steps is None else steps[k]
        a = rng.normal(0, acceleration, (count, 2))
        x, v = x + v * dt + a * dt**2 / 2, v + a * dt
        z = x + rng.normal(0, noise, x.shape)
        variance, steady = np.full(count, given**2), np.full(count, k > 0)
        by_axis, since = variance[:, None].repeat(2, axis=1), np.full(count, dt)
        size = np.ones_like(z)
        if recent.take(records, track, z, by_axis, variance, since, 0, steady, steady, size, dt):
            learned.learn(records, track, recent, variance)
    factors, _ = learned.factors(np.zeros(1, np.uint32), np.full(1, given**2))
    return np.sqrt(factors[0].prod()), 1 + records['own_factor']


@pytest.mark.parametrize('given', [0.3, 1.0, 3.0])
@pytest.mark.parametrize('noise', [0.5, 1.0, 5.0])
def test_a_factor_makes_given_variances_the_true_ones(noise, given):
    learned, own = factor(noise, given)
    assert learned * given**2 == pytest.approx(noise**2, rel=0.25)
    assert own * learned * given**2 == pytest.approx(np.full(8, noise**2), rel=0.6)


def test_uneven_frames_make_no_noise():
    """Divided differences: at 200 px/s, taking a frame as 10 ms late would be an error of 2 px."""
    steps = np.random.default_rng(3).uniform(0.023, 0.043, 90)
    assert factor(1.0, 1.0, steps=steps)[0] == pytest.approx(1.0, rel=0.25)


def test_accelerations_are_no_noise():
    assert factor(1.0, 1.0, acceleration=1000.0)[0] == pytest.approx(1.0, rel=0.3)


def test_where_motion_hides_the_noise_what_was_given_holds():
    assert 0.5 < factor(0.05, 0.05, acceleration=1000.0)[0] <= 1.0


def test_colors_do_not_tell_of_each_other():
    rng, tracker = np.random.default_rng(0), Tracker()
    noise = np.array([0.3, 0.3, 3.0, 3.0])[:, None]
    at = np.array([(100, 100), (400, 100), (100, 400), (400, 400)])
    for k in range(120):
        seen = points(at + noise * rng.normal(0, 1, (4, 2)), k * FRAME, 1.0)
        seen.rows['color'] = [1, 1, 2, 2]
        rows = tracker.update(seen).rows
    sigma = np.sqrt(rows['covariance'][:, 0, 0])
    assert sigma[2:].min() > 4 * sigma[:2].max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ('noise', 'given'),
    [(5.0, 0.0), (5.0, 0.3), (2.0, 1.0), (0.5, 3.0)],
)
def test_ellipses_hold_what_they_say_whatever_is_given(noise, given):
    """95 % ellipses of eight objects on straight lines, with three seeds."""
    inside, names = [], []
    for seed in range(3):
        rng, tracker = np.random.default_rng(seed), Tracker()
        x, v = np.arange(8)[:, None] * [0.0, 150.0], rng.uniform(-150, 150, (8, 2)) * [1, 0.1]
        for k in range(120):
            z = x + v * k / 24 + rng.normal(0, noise, x.shape)
            rows = tracker.update(points(z, k * FRAME, given**2)).rows
            if k >= LEARNED:
                inside += errors_squared(rows, x + v * k / 24)
        names.append(len(set(rows['track_id'])))
    assert 0.90 <= np.mean(np.array(inside) < 5.991) <= 0.995
    assert names == [8, 8, 8]


@pytest.mark.slow
@pytest.mark.parametrize(('noise', 'missed'), [(3.0, 0.3), (0.5, 0.5), (3.0, 0.65)])
def test_ellipses_hold_what_they_say_whatever_is_missed(noise, missed):
    """Objects that are hardly seen in six frames in a row; four seeds, from 2 s on."""
    inside, names = [], []
    for seed in range(4):
        rng, tracker = np.random.default_rng(seed), Tracker()
        x, v = np.arange(8)[:, None] * [0.0, 150.0], rng.uniform(-80, 80, (8, 2)) * [1, 0.1]
        for k in range(200):
            z = (x + v * k / 24 + rng.normal(0, noise, x.shape))[rng.random(8) >= missed * (k > 2)]
            rows = tracker.update(points(z, k * FRAME, 0.0)).rows
            if k >= 2 * LEARNED:
                inside += errors_squared(rows, x + v * k / 24)
        names.append(len(set(rows['track_id'])))
    assert 0.91 <= np.mean(np.array(inside) < 5.991) <= 0.995
    assert names == [8, 8, 8, 8]


@pytest.mark.slow
@pytest.mark.parametrize(('given', 'least'), [(0.0, 0.85), (3.0, 0.935)])
def test_the_noise_of_one_object_alone_is_known_within_a_second(given, least):
    """The few differences of one object hardly tell noise from motion; forty seeds, 3 px."""
    inside = []
    for seed in range(40):
        rng, tracker = np.random.default_rng(seed), Tracker()
        x, v = np.full((1, 2), 300.0), rng.normal(0, 60, (1, 2))
        for k in range(48):
            z = x + v * k / 24 + rng.normal(0, 3.0, (1, 2))
            rows = tracker.update(points(z, k * FRAME, given**2)).rows
            if k >= LEARNED / 2:
                inside += errors_squared(rows, x + v * k / 24)
    assert least < np.mean(np.array(inside) < 5.991) <= 0.99


def errors_squared(rows, truth):
    """Return squared errors of the nearest tracks, normalized by their position covariances."""
    at = np.stack([rows['u'], rows['v']], axis=1)
    e = truth - at[((truth[:, None] - at) ** 2).sum(-1).argmin(axis=1)]
    P = rows['covariance'][((truth[:, None] - at) ** 2).sum(-1).argmin(axis=1), :2, :2]
    return list((e * np.linalg.solve(P, e[..., None])[..., 0]).sum(axis=1))


def boxed(shift, noise, given, seed=0):
    """Return the coverage of the 95 % ellipses of eight shifted, noisy boxes of 40 px."""
    rng, tracker, inside = np.random.default_rng(seed), Tracker(), []
    x, v = np.arange(8)[:, None] * [0.0, 150.0], rng.uniform(-80, 80, (8, 2)) * [1, 0.1]
    for k in range(120):
        z = x + v * k / 24 + shift + rng.normal(0, noise, x.shape)
        rows = tracker.update(points(z, k * FRAME, given**2, size=(40.0, 40.0))).rows
        if k >= LEARNED:
            inside += errors_squared(rows, x + v * k / 24)
    return np.mean(np.array(inside) < 5.991)


def test_what_is_given_and_does_not_show_is_alike_in_every_frame():
    """Shading shifts centroids permanently, and a detector that knows this claims it."""
    assert boxed(shift=0.25, noise=0.05, given=0.3) > 0.9


def test_what_is_given_is_believed_no_further_than_shading_shifts():
    """Given: ten times the true variance, three times that of the largest shift of 40 px."""
    assert 0.9 < boxed(shift=0.0, noise=1.0, given=10**0.5) < 0.997


def test_what_is_said_to_be_known_is_not_learned():
    """Without detection_covariance a track has the variance of measurement_noise."""
    rng, sigmas = np.random.default_rng(0), np.zeros((2, 60))
    for told in (True, False):
        tracker = Tracker(TrackerConfig(detection_covariance=told, process_noise=100.0))
        for k in range(60):
            z = np.array([[100.0, 100.0]]) + rng.normal(0, 5, (1, 2))
            tracks = tracker.update(points(z, k * FRAME, 1.0))
            sigmas[int(told), k] = np.sqrt(tracks.rows['covariance'][0, 0, 0])
    not_learned, learned = np.median(sigmas[:, 30:], axis=1)
    assert learned > 2 * not_learned


def test_the_noise_that_nobody_states_is_doubted_until_it_shows():
    """One object, noise of 3 px where 1 px is assumed; differences tell from the tenth frame on."""
    inside, off = [], []
    for seed in range(16):
        rng, tracker = np.random.default_rng(seed), Tracker()
        x, v = rng.uniform(200, 400, 2), rng.uniform(-100, 100, 2)
        for k in range(14):
            z = x + v * k / 24 + rng.normal(0, 3, 2)
            rows = tracker.update(points(z, k * FRAME)).rows
            if len(rows):
                inside += errors_squared(rows, x[None] + v * k / 24)
                off.append(np.hypot(rows['du'][0] - v[0], rows['dv'][0] - v[1]))
    assert len(off) > 16 * 8
    assert np.mean(np.array(inside) < 5.991) > 0.75
    assert np.sqrt(np.mean(np.square(off))) < 100


def test_colors_that_are_seen_once_are_not_kept():
    """Of whom nothing is learned nothing is remembered, however many there are."""
    rng, tracker, told = np.random.default_rng(0), Tracker(), []
    tracker.screening.refuse = told.append
    for k in range(20):
        detections = points(rng.uniform(0, 1000, (50, 2)), k * FRAME)
        detections.rows['color'] = np.arange(50) + 50 * k
        tracker.update(detections)
    assert len(tracker._adaptation.noisiness.guessed) <= 50
    assert len(told) == 1  # see test_screening.py


@pytest.mark.slow
def test_unusual_detections_leave_it_finite():
    """One object is exactly at rest, another jumps across the picture."""
    tracker = Tracker()
    for k in range(200):
        z = [(100.0, 100.0), (500.0 + 200 * (k % 7 == 0), 300.0)]
        tracks = tracker.update(points(z, k * FRAME, 1.0))
        assert np.isfinite(tracks.rows['covariance']).all()
        assert (np.linalg.eigvalsh(tracks.rows['covariance']) > 0).all()
