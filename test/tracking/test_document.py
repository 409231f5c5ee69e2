"""Pegoretti's bank of filters: one filter by his equations, and what his method lacks."""

from hypothesis import example
from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

PEGORETTI = TrackerConfig(
    process_noise=1.0,
    measurement_noise=1.0,
    detection_covariance=False,
    centroid_bias=0.0,
    use_boxes=False,
    initial_speed=1.0,
    maneuvers=False,
    gating=False,
    confirm_hits=1,
    confirm_window=1,
    min_score=0.0,
)


def textbook(z, dt, sigma_s=1.0, sigma_w=1.0, speed=1.0):
    """Pegoretti 2021, (2.19)-(2.32), in the order (u, v, du, dv), in Joseph form.

    Q, however, is that of continuous white noise (Bar-Shalom et al. 2001, 6.2.2).
    """
    F = np.eye(4)
    F[0, 2] = F[1, 3] = dt
    H = np.eye(2, 4)
    Q = sigma_s**2 / 30 * np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], np.eye(2))
    x, P = H.T @ z[0], np.diag([sigma_w**2, sigma_w**2, speed**2, speed**2])
    for one in z[1:]:
        x, P = F @ x, F @ P @ F.T + Q
        if one is not None:
            K = P @ H.T @ np.linalg.inv(H @ P @ H.T + sigma_w**2 * np.eye(2))
            x = x + K @ (one - H @ x)
            A = np.eye(4) - K @ H
            P = A @ P @ A.T + sigma_w**2 * K @ K.T
    return x, P


@pytest.mark.slow
@given(seed=st.integers(0, 2**32 - 1), period=st.integers(1_000_000, 400_000_000))
@example(seed=109179, period=301595299)  # far from its track at last
@settings(max_examples=30, deadline=None)
def test_a_lone_track_is_the_textbook_filter(seed, period):
    rng = np.random.default_rng(seed)
    z = [*rng.normal(0, 3, (20, 2))]
    for k in rng.integers(1, 20, 3):
        z[k] = None
    tracker = Tracker(PEGORETTI)
    for k, one in enumerate(z):
        rows = tracker.update(points([] if one is None else one, k * period)).rows
    x, P = textbook(z, period / NANOSECONDS)
    np.testing.assert_allclose([rows['u'][0], rows['v'][0], rows['du'][0], rows['dv'][0]], x)
    np.testing.assert_allclose(rows['covariance'][0], P, atol=1e-12)


def test_as_in_the_document_a_false_detection_takes_somebodys_filter():
    """3.1.2 has neither a gate nor a cost of a miss; with both, the track coasts."""
    for config, ids in ((PEGORETTI, [1]), (TrackerConfig(), [1, 2])):
        tracker = Tracker(config)
        for k in range(5):
            tracker.update(points([(50, 50)], k * FRAME))
        rows = tracker.update(points([(400, 300)], 5 * FRAME)).rows
        assert rows['track_id'].tolist() == ids
