"""The speed by two frames, against the plain version: density integrated, one object at a time."""

from functools import cache
import math

from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.integrate import quad

from colortrack_ros.tracking.first_speed import ASSUMED_COUNT
from colortrack_ros.tracking.first_speed import FAST
from colortrack_ros.tracking.first_speed import LOG_SPREAD
from colortrack_ros.tracking.first_speed import SEEN_NEXT
from colortrack_ros.tracking.first_speed import share_enough
from colortrack_ros.tracking.first_speed import share_of_speed
from colortrack_ros.tracking.first_speed import SHARES
from colortrack_ros.tracking.first_speed import two_nearest


def whose(r1, r2, s, density):
    """Densities of the two nearest detections: one of them is the object's own; neither is."""
    others = 2 * math.pi * density * math.exp(-math.pi * density * r2**2)
    way1, way2 = (r / s**2 * math.exp(-(r**2) / (2 * s**2)) for r in (r1, r2))
    either = SEEN_NEXT * others * (way1 * r2 + way2 * r1)
    farther = 1 - SEEN_NEXT + SEEN_NEXT * math.exp(-(r2**2) / (2 * s**2))
    return either, others * 2 * math.pi * density * r1 * r2 * farther


@cache
def integrated(r1, r2, s):
    """Both, integrated over densities with the prior 1 / density."""
    return [
        quad(lambda x, i=i: whose(r1, r2, s, math.exp(x) / r2**2)[i], -30, 5, epsabs=0)[0]
        for i in (0, 1)
    ]


def plainly(near, way):
    """The same as share_of_speed() by distances (N, 2)."""
    log_weight, squares = [], []
    for share in SHARES:
        for fast in FAST:
            log_posterior = -0.5 * (math.log(share) / LOG_SPREAD) ** 2
            moved, crept = ASSUMED_COUNT, 0.0
            for r1, r2 in near:
                own, other = np.array([integrated(r1, r2, s * way) for s in (1.0, share)]).T
                total = fast * (own[0] + other[0]) + (1 - fast) * (own[1] + other[1])
                log_posterior += math.log(total)
                moved += fast * own[0] / total
                crept += (1 - fast) * own[1] / total
            log_weight.append(log_posterior)
            squares.append((moved + crept * share**2) / (moved + crept))
    weight = np.exp(np.array(log_weight) - max(log_weight))
    return math.sqrt(weight @ squares / weight.sum())


@pytest.mark.slow
@settings(max_examples=3, deadline=None)
@given(st.integers(0, 1000), st.floats(0.05, 2.0), st.integers(2, 3))
def test_it_is_what_the_plain_version_says(seed, way, count):
    rng = np.random.default_rng(seed)
    before, after = rng.uniform(0, 3, (count, 2)), rng.uniform(0, 3, (4, 2))
    after[0] = before[0] + 0.05
    near = np.sort(np.hypot(*(before[:, None] - after).T).T, axis=1)[:, :2]
    assert share_of_speed(two_nearest(before, after) / way) == pytest.approx(
        plainly(near, way), rel=1e-3
    )


@pytest.mark.parametrize('count', [2, 5, 100])
def test_nobody_near_again_and_nobody_moved_are_finite(count):
    before = np.random.default_rng(0).uniform(0, 100, (count, 2))
    assert share_of_speed(two_nearest(before, before + 1e6)) == pytest.approx(1.0, abs=1e-3)
    assert share_of_speed(two_nearest(before, before)) < 1.1 / math.sqrt(count + 1) + 0.01


def test_neighbors_say_how_fast_all_may_be_and_still_be_told_apart():
    """Thirty pixels are three standard deviations of ten."""
    before = 30.0 * np.stack(np.meshgrid(range(4), range(4)), axis=-1).reshape(-1, 2)
    near = two_nearest(before, before + 0.1)
    assert share_enough(near / 20.0) == pytest.approx(0.5, abs=0.01)
    assert share_enough(near / 5.0) == 1.0
