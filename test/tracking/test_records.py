"""Lines through the detections of rivals, and how camera motion changes all that is recorded."""

from types import SimpleNamespace

import numpy as np
import pytest

from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion.constant_velocity import ConstantVelocity
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import COMMON
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.camera import Camera
from colortrack_ros.tracking.crossings import _ready
from colortrack_ros.tracking.lines import add_to_lines
from colortrack_ros.tracking.lines import fit_lines
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.recent import RING
from colortrack_ros.tracking.recent import Z
from colortrack_ros.tracking.records import FIELDS

SECOND = 1_000_000_000
PERIOD = 0.05


def summed_up(records, rng):
    """Sum up six measurements of two rivals within a second.

    Returns their stamps, positions and standard deviations.
    """
    records['rival'] = 2, 1
    stamps = np.sort(rng.integers(1, SECOND, 6))
    z, sigma = rng.normal(0, 100, (6, 2, 2)), rng.uniform(0.5, 3, (6, 2))
    for stamp, measured, s in zip(stamps, z, sigma, strict=True):
        R = s[:, None, None] ** 2 * np.eye(2)
        add_to_lines(records, SimpleNamespace(track=np.arange(2), z=measured, R=R), stamp)
    return stamps, z, sigma


def test_states_and_covariances_are_those_of_the_normal_equations():
    records = np.zeros(2, np.dtype(FIELDS))
    stamps, z, sigma = summed_up(records, np.random.default_rng(3))
    now = 2 * SECOND
    mean, cov = fit_lines(records, np.arange(2), now)
    for track in range(2):
        ages = (stamps - now) / SECOND
        H = np.stack([np.ones(6), ages], axis=1) / sigma[:, track, None]
        expected_cov = np.linalg.inv(H.T @ H)
        expected = expected_cov @ H.T @ (z[:, track] / sigma[:, track, None])
        np.testing.assert_allclose(mean[track].reshape(2, 2), expected, rtol=1e-6)
        np.testing.assert_allclose(cov[track], np.kron(expected_cov, np.eye(2)), rtol=1e-6)
    assert records['scans'].tolist() == [6, 6]


def test_a_motion_that_stays_becomes_the_tracks_own_and_leaves_them_where_they_are():
    rng, now = np.random.default_rng(5), 2 * SECOND
    tracks = TrackTable(Bank(ConstantVelocity()), FIELDS)
    x = rng.uniform(100, 500, (2, 2))
    tracks.initiate(tracks.filters.at_rest(x, np.stack([np.eye(2)] * 2), np.full(4, 50.0)), now)
    records, recent = tracks.records, Recent()
    summed_up(records, rng)
    for _ in range(RING + 2):
        kept = *(np.zeros(2) for _ in range(4)), np.zeros(2, bool), np.zeros(2, bool)
        recent.take(records, np.arange(2), rng.normal(0, 9, (2, 2)), *kept, np.eye(2), PERIOD)
    for name in ('before', 'anchor', 'probe'):
        records[name] = rng.normal(0, 10, records[name].shape)
    records['met'], records['anchored'] = now - SECOND // 2, now - SECOND // 4
    before, states = records.copy(), tracks.filters.estimate()[0].copy()
    lines, _ = fit_lines(records, np.arange(2), now)
    many = rng.uniform(0, 500, (8, 2))
    camera = Camera()
    camera.follow(many, np.ones((8, 2)), many + np.array([6.0, -2.0]), PERIOD)
    way = camera._motion.shift / PERIOD
    camera.give(tracks, recent, now)
    assert way == pytest.approx([120, -40], abs=1)
    moved = [0, 0, *way]
    np.testing.assert_allclose(tracks.filters.estimate()[0], states + moved)
    np.testing.assert_allclose(fit_lines(records, np.arange(2), now)[0], lines + moved, rtol=1e-6)
    for name, age in (('before', 0.5), ('anchor', 0.25)):
        np.testing.assert_allclose(records[name][:, :2], before[name][:, :2] - age * way)
        np.testing.assert_allclose(records[name][:, 2:], before[name][:, 2:] + way)
    # the eighteenth frame is in the second slot, and the last look was three frames earlier
    ages = PERIOD * (1 + (1 - np.arange(RING)) % RING)
    expected = before['measured'][..., Z] - ages[:, None] * way
    np.testing.assert_allclose(records['measured'][..., Z], expected)
    place, speed = (records['probe'] - before['probe'])[:, :, :, 0].swapaxes(0, 1)
    np.testing.assert_allclose(speed, [way, way])
    np.testing.assert_allclose(place, -4 * PERIOD * speed)


def test_a_track_whose_rival_is_gone_is_not_compared_with_its_rival_before_that():
    records = Records([*COMMON, *FIELDS], 2)
    records['track_id'], records['rival'], records['scans'] = [1, 3], [2, 1], 6
    one, other = _ready(records, 0, 1.0)
    assert len(one) == len(other) == 0
