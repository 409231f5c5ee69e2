"""What may have turned is followed both ways: noise is forgotten at once, turns are not missed."""

from dataclasses import replace

import numpy as np
import pytest
from support.silhouettes import points
from support.silhouettes import RATE

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker

FRAMES, TURN = 90, 60
SECONDS = [slice(6, 30), slice(30, FRAMES)]
"""Frames from 0.2 to 1 s, and to 3 s."""


def follow(velocity, seed, noise, variance):
    """Errors of the velocity, (FRAMES, 2), of one object alone; velocity: (FRAMES, 2) [px/s]."""
    way = np.cumsum(velocity[:-1], axis=0) / RATE
    z = np.concatenate([np.zeros((1, 2)), way])
    z += np.random.default_rng(seed).normal(0, noise, z.shape)
    tracker, error = Tracker(), np.full(z.shape, np.nan)
    for k, here in enumerate(z):
        rows = tracker.update(points(here, round(k * NANOSECONDS / RATE), variance)).rows
        if len(rows):
            error[k] = rows['du'][0] - velocity[k, 0], rows['dv'][0] - velocity[k, 1]
    return error


def off(errors):
    """Root mean square of errors, (S, frames, 2) [px/s]."""
    return np.sqrt(np.square(errors).sum(axis=2).mean())


@pytest.mark.slow
@pytest.mark.parametrize(
    ('noise', 'variance', 'most'), [(1.5, 2.25, (30, 8)), (3, 9.0, (55, 18)), (3, 0.0, (100, 28))]
)
def test_one_object_alone_has_its_velocity_soon(noise, variance, most):
    straight = np.tile([120.0, -30.0], (FRAMES, 1))
    errors = np.array([follow(straight, seed, noise, variance) for seed in range(10)])
    for some, limit in zip(SECONDS, most, strict=True):
        assert off(errors[:, some]) < limit


@pytest.mark.slow
def test_a_turn_is_followed_as_soon_as_it_shows():
    velocity = np.tile([150.0, 0.0], (FRAMES, 1))
    velocity[TURN:] = 0.0, 150.0
    errors = np.array([follow(velocity, seed, 1.0, 1.0) for seed in range(10)])
    assert off(errors[:, TURN + 4 : TURN + 10]) < 18


def test_what_may_have_turned_and_is_gone_is_forgotten():
    tracker = Tracker()
    for k in range(4 * RATE):
        z = [100.0 + 4 * k + 8 * (k == RATE), 200.0] if k <= RATE else []
        tracks = tracker.update(points(z, round(k * NANOSECONDS / RATE), 1.0))
    assert not len(tracks.rows)


@pytest.mark.slow
@pytest.mark.parametrize('seed', [3, 4, 6])
def test_what_bounces_amid_heavy_tails_keeps_its_id(seed):
    """A turn is no stray: its next detections are further and further aside."""
    rate, size, rng = 120, np.array([640, 480]), np.random.default_rng(seed)
    z, angle = rng.uniform(0.1, 0.9, (6, 2)) * size, rng.uniform(0, 2 * np.pi, 6)
    v = 300 * rng.uniform(0.5, 1, (6, 1)) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    tracker, names = Tracker(), set()
    for k in range(10 * rate):
        z = z + v / rate
        v = np.where(z < 0, np.abs(v), np.where(z > size, -np.abs(v), v))
        z = z.clip(0, size)
        error = rng.normal(0, 2.5, z.shape) * rng.standard_t(3, (6, 1)).clip(-10, 10)
        seen = rng.random(6) > 0.02
        detections = points((z + error)[seen], round(k * NANOSECONDS / rate), 2.5**2)
        rows = tracker.update(replace(detections, image_size=tuple(size))).rows
        names.update(rows['track_id'][rows['state'] > 0].tolist())
    assert len(names) == 6
