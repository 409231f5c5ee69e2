"""Detections of other detectors: errors differ by axis, last, are rounded, or change."""

import numpy as np
import pytest
from scipy.optimize import brentq
from support.silhouettes import lasting
from support.silhouettes import points

from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking.lasting_errors import passed_on
from colortrack_ros.tracking.lasting_errors import RHO

RATE, COUNT, FRAMES = 30, 8, 240
FORMED = 45
"""Frames at the start that are not evaluated: a second and a half, in which noise is learned."""


def lines(rng):
    """Return positions of objects that move straight, (FRAMES, COUNT, 2) [px]."""
    t = np.arange(FRAMES)[:, None, None] / RATE
    start = np.stack([rng.uniform(300, 900, COUNT), 100 + 110.0 * np.arange(COUNT)], axis=1)
    return start + t * np.stack([rng.uniform(-60, 120, COUNT), rng.uniform(-4, 4, COUNT)], axis=1)


def circles(rng):
    """Return positions of objects that move in circles, (FRAMES, COUNT, 2) [px]."""
    t, place = np.arange(FRAMES)[:, None] / RATE, np.arange(COUNT)
    angle = rng.uniform(0, 6.28, COUNT) + rng.uniform(0.8, 1.6, COUNT) * t
    middle = np.stack([200 + place % 4 * 400.0, 250 + place // 4 * 450.0], axis=1)
    return middle + 100 * np.stack([np.cos(angle), np.sin(angle)], axis=2)


def white(rng, sigma):
    return rng.normal(0, 1, (FRAMES, COUNT, 2)) * sigma


def rows_of(z, size=None):
    return points(z, size=size).rows


def score(x, z, size=None, judged=range(FORMED, FRAMES)):
    """Return the coverage of the 95 % ellipses, the RMS error [px], and the IDs per object."""
    tracker, inside, squares, names = Tracker(), [], [], set()
    for k in range(FRAMES):
        rows = rows_of(z[k], None if size is None else size[k])
        detections = Detections(rows, k * NANOSECONDS // RATE, 'camera', image_size=(1920, 1080))
        tracks = tracker.update(detections).rows
        if k not in judged:
            continue
        at = np.stack([tracks['u'], tracks['v']], axis=1)
        own = ((x[k][:, None] - at) ** 2).sum(axis=2).argmin(axis=1)
        e, P = x[k] - at[own], tracks['covariance'][own][:, :2, :2]
        inside += list((e * np.linalg.solve(P, e[..., None])[..., 0]).sum(axis=1) < 5.991)
        squares += list((e**2).sum(axis=1) / 2)
        names |= set(tracks['track_id'][own])
    return np.mean(inside), np.sqrt(np.mean(squares)), len(names) / COUNT


@pytest.mark.slow
@pytest.mark.parametrize('motion', [lines, circles])
@pytest.mark.parametrize('sigma', [(0.5, 5.0), (4.0, 1.0)])
def test_noise_that_differs_by_axis_is_learned_by_axis(motion, sigma):
    rng = np.random.default_rng(0)
    x = motion(rng)
    inside, error, names = score(x, x + white(rng, sigma))
    assert 0.90 < inside < 0.995
    assert error < 0.65 * np.hypot(*sigma) / np.sqrt(2)
    assert names == 1


@pytest.mark.slow
@pytest.mark.parametrize('motion', [lines, circles])
@pytest.mark.parametrize(('side', 'size'), [(1.0, 20.0), (2.0, 40.0), (5.0, 60.0)])
def test_boxes_that_jitter_are_believed_no_more_than_their_centers(motion, side, size):
    """Both sides of a box err alike, so its size jitters, and its center errs half as much."""
    rng = np.random.default_rng(1)
    x = motion(rng)
    low = x - size / 2 + white(rng, side)
    high = x + size / 2 + white(rng, side)
    inside, error, names = score(x, (low + high) / 2, high - low)
    assert 0.90 < inside < 0.995
    assert error < 0.8 * side / np.sqrt(2)
    assert names == 1


@pytest.mark.slow
@pytest.mark.parametrize('step', [1.0, 4.0])
@pytest.mark.parametrize('motion', [lines, circles])
def test_positions_that_are_rounded_are_not_taken_for_exact(motion, step):
    rng = np.random.default_rng(2)
    x = motion(rng)
    z = np.round((x + white(rng, 0.1)) / step) * step
    inside, error, names = score(x, z)
    assert inside > 0.90
    assert error < 0.3 * step
    assert names == 1


@pytest.mark.slow
@pytest.mark.parametrize('motion', [lines, circles])
@pytest.mark.parametrize(('rho', 'least'), [(0.3, 0.9), (0.5, 0.9), (0.7, 0.9), (0.9, 0.75)])
def test_errors_that_last_are_doubted(motion, rho, least):
    """With rho 0.9, half a second can hardly show all of it: coverage was once 10 %."""
    rng = np.random.default_rng(3)
    x = motion(rng)
    inside, _, names = score(x, x + 2.0 * lasting(rng, x.shape, rho))
    assert least < inside < 0.995
    assert names == 1


@pytest.mark.parametrize('gain', [0.1, 0.3, 0.8])
def test_what_a_filter_passes_on_of_errors_that_last_is_computed(gain):
    """Against a simulated alpha-beta filter, with beta of the steady state (Riccati equation)."""
    F, Q = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]])

    def gains(q):
        P = np.eye(2)
        for _ in range(1000):
            K = P[:, 0] / (P[0, 0] + 1)
            P = F @ (P - np.outer(K, P[0])) @ F.T + q * Q
        return K

    K = gains(brentq(lambda q: gains(q)[0] - gain, 1e-5, 1e3))
    rng, squares = np.random.default_rng(0), []
    white = rng.normal(0, 1, (400, 2000))
    for rho in RHO:
        e, state = white[0], np.zeros((2, 2000))
        for new in white:
            e = rho * e + np.sqrt(1 - rho**2) * new
            state = F @ state
            state += K[:, None] * (e - state[0])
        squares.append(np.mean(state[0] ** 2))
    np.testing.assert_allclose(passed_on(np.array([gain]))[0], squares / squares[0], rtol=0.15)


@pytest.mark.slow
@pytest.mark.parametrize('motion', [lines, circles])
@pytest.mark.parametrize('change', [(1.0, 3.0), (1.0, 5.0), (0.5, 4.0), (5.0, 1.0)])
def test_noise_that_changes_at_once_is_learned_anew(motion, change):
    """Evaluated from a second after the change on; no track breaks."""
    rng = np.random.default_rng(4)
    x = motion(rng)
    sigma = np.repeat(change, FRAMES // 2)[:, None, None]
    after = range(FRAMES // 2 + RATE, FRAMES)
    inside, _, names = score(x, x + white(rng, sigma), judged=after)
    assert 0.85 < inside < 0.995
    assert names == 1


@pytest.mark.slow
def test_detections_that_stray_break_no_track():
    """One in 20 is 10 px off: too far for its noise, but no other track's either."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        x = lines(rng)
        far = rng.random((FRAMES, COUNT, 1)) < 0.05
        inside, error, names = score(x, x + white(rng, 1.0) * np.where(far, 10.0, 1.0))
        assert inside > 0.93
        assert error < 1.2
        assert names == 1


def test_what_strays_is_taken_by_the_track_alone_that_has_nothing():
    """Not if the object is seen as well, and not by a track that has long been unseen."""
    x, tracker = lines(np.random.default_rng(6)), Tracker()
    for k in range(60):
        far = x[k][:1] + np.array([0.0, 10.0])
        z = np.concatenate([x[k], far]) if k == 59 else x[k]
        tracks = tracker.update(Detections(rows_of(z), k * NANOSECONDS // RATE, 'camera')).rows
    assert len(tracks) == COUNT + 1
    assert (tracks['time_since_update'] == 0).all()


@pytest.mark.slow
def test_things_whose_noise_differs_by_twenty_have_their_own():
    inside = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        x = lines(rng)
        share, _, names = score(x, x + white(rng, np.geomspace(0.4, 8.0, COUNT)[:, None]))
        inside.append(share)
        assert names == 1
    assert np.mean(inside) > 0.885


def falls(rng):
    """Return positions of balls that bounce on the floor, in columns, (FRAMES, COUNT, 2) [px]."""
    speed, t = rng.uniform(600, 1000, COUNT), np.arange(FRAMES)[:, None] / RATE
    s = (t + rng.uniform(0, 1, COUNT)) % (2 * speed / 1500)
    u = 80 + 160.0 * np.arange(COUNT) + 0 * s
    return np.stack([u, 680 - speed * s + 750 * s**2], axis=2)


@pytest.mark.slow
def test_bounces_are_not_taken_for_errors_that_last():
    """Like a lasting error, a bounce shows more in differences that span more frames."""
    for seed in range(6):
        rng, tracker, most = np.random.default_rng(seed), Tracker(), 0.0
        z = falls(rng) + white(rng, 1.0)
        for k in range(200):
            stamp = round(k * NANOSECONDS / RATE)
            rows = tracker.update(Detections(rows_of(z[k]), stamp, 'camera')).rows
            if k > FORMED:
                most = max(most, float(np.median(rows['covariance'][:, 0, 0])))
        assert most < 2.0


@pytest.mark.slow
def test_what_stands_still_to_the_bit_is_not_taken_for_rounded():
    """Nor is one that then moves equally smoothly: no coordinate changes alone."""
    x = np.repeat(lines(np.random.default_rng(5))[:1], FRAMES, axis=0)
    x[FRAMES // 2 :] += 2.0 * np.arange(FRAMES - FRAMES // 2)[:, None, None]
    tracker = Tracker()
    for k in range(FRAMES):
        tracks = tracker.update(Detections(rows_of(x[k]), k * NANOSECONDS // RATE, 'camera')).rows
    assert np.sqrt(tracks['covariance'][:, 0, 0]).max() < 0.5


@pytest.mark.parametrize('side', [20, 96])
def test_a_box_that_goes_with_its_center_makes_it_no_surer(side):
    """An uncertain fit says so in its covariance, and its box is off by as much."""
    rng, tracker, still = np.random.default_rng(0), Tracker(), np.array([[300.4, 200.2]])
    for k in range(91):
        unsure = k == 90
        z = still + unsure * np.array([8.0, -6.0]) + rng.normal(0, 0.3, (1, 2))
        rows = rows_of(z, np.full((1, 2), float(side)))
        rows['box_u'], rows['box_v'] = np.round(rows['box_u']), np.round(rows['box_v'])
        rows['cov_uu'] = rows['cov_vv'] = 64.0 if unsure else 0.09
        (row,) = tracker.update(Detections(rows, k * NANOSECONDS // 30)).rows
    assert np.hypot(row['du'], row['dv']) < 30
    assert np.hypot(row['u'] - 300.4, row['v'] - 200.2) < 2
