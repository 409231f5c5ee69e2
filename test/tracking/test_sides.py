"""A blob that is cut or merged: the center that its sides and the prediction give together."""

from types import SimpleNamespace

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.tracking.centers import CHOSEN
from colortrack_ros.tracking.centers import LASTING
from colortrack_ros.tracking.centers import measure_centers
from colortrack_ros.tracking.merged import EDGE_VARIANCE
from colortrack_ros.tracking.sizes import OTHER_SIZE
from colortrack_ros.tracking.sizes import TOLERANCE
from colortrack_ros.tracking.sizes import TOLERANCE_SHARE

HALF = np.array([20.0, 12.0])
"""From the center of the object to its sides [px]."""

MANEUVER, SPEED, RATE = 0.03, 150.0, 30
"""Probability of a maneuver in a frame, standard deviation of a new velocity [px/s], frames/s."""

FINE = 0.01
"""Variance of a centroid [px^2]."""


def measured(box, expected, variance, *, whole=False, outside=(0, 0)):
    """Return the center (2,) and its covariance by one blob whose centroid is its box's middle."""
    box = np.array(box, float)
    extent = np.array([(tuple(np.array([HALF, HALF])), False)],
                      [('extent', float, (2, 2)), ('partial', bool)])  # fmt: skip
    prediction = SimpleNamespace(
        sized=True, finds_whole=whole, records=extent, size=2 * HALF[None],
        sizes=SimpleNamespace(are_steady=True),
        center=np.array([expected], float), variance=np.array([variance], float),
        step=SimpleNamespace(period=1 / RATE), unmeasured=np.array([1 / RATE]),
        maneuvered=np.array([MANEUVER]),
        turn_speed=lambda _: np.full((1, 2), SPEED))  # fmt: skip
    usual = np.full((1, 2), FINE)
    blobs = SimpleNamespace(
        z=box.mean(axis=0)[None], R=FINE * np.eye(2)[None], box=box[None],
        size=np.ptp(box, axis=0)[None], cut=np.full((1, 2), whole),
        mixed=np.zeros(1, bool), usual=usual, variance=usual,
        outside=np.array([outside]),
        reach=lambda _: np.stack([box.mean(axis=0) - box[0], box[1] - box.mean(axis=0)])[None],
    )  # fmt: skip
    z, R = measure_centers(prediction, blobs, np.array([0]), np.array([0]), None)
    return z[0], R[0]


def looks_alike(width, height):
    """Return by how much the log of a box's aspect may change by its rounded sides."""
    return TOLERANCE * np.hypot(1 / width, 1 / height) / np.sqrt(2)


@given(
    low=st.floats(-30, 30),
    width=st.floats(5, 80),
    expected=st.floats(-40, 60),
    variance=st.floats(0.1, 400),
)
def test_three_centers_are_averaged_where_that_is_better(low, width, expected, variance):
    """Each counts as far as the prediction, or a maneuver, makes it probable, and precise."""
    z, R = measured([[low, 88], [low + width, 112]], [expected, 100], [variance, 1.0])
    centers = np.array([low + HALF[0], low + width / 2, low + width - HALF[0]])
    S = np.full(3, EDGE_VARIANCE + (TOLERANCE_SHARE * 2 * HALF[0]) ** 2)
    S[1] += (width - 2 * HALF[0]) ** 2 / 12  # anywhere between those of the sides
    weight = np.zeros(3)
    for chance, turned in ((1 - MANEUVER, 0.0), (MANEUVER, (SPEED / RATE) ** 2 / 3)):
        wide = variance + S + turned
        weight += chance * np.exp(-((centers - expected) ** 2) / (2 * wide)) / np.sqrt(wide)
    weight[1] *= OTHER_SIZE
    if weight.sum() < 1e-200:
        return
    share = weight / weight.sum() / S
    mean = share @ centers / share.sum()
    mixed = (1 + CHOSEN * RATE * share @ (centers - mean) ** 2) / share.sum()
    nearest = abs(centers - expected).argmin() == 1
    if nearest and abs(np.log(width / (2 * HALF[0]))) <= looks_alike(width, 2 * HALF[1]):
        assert z == pytest.approx([centers[1], 100])
        assert pytest.approx(FINE * np.eye(2)) == R
        return
    alone = FINE + LASTING * max(abs(width - 2 * HALF[0]) - 1, 0) ** 2 / 4
    tied = np.ptp(centers) <= 0.75
    better = alone > EDGE_VARIANCE and mixed < alone and not tied
    assert z == pytest.approx([mean if better else low + width / 2, 100])
    assert R[0, 0] == pytest.approx(mixed if better else alone)
    assert R[1, 1] == pytest.approx(FINE)
    assert R[0, 1] == R[1, 0] == 0


@pytest.mark.parametrize(('outside', 'center'), [(1, 20.0), (-1, 10.0)])
def test_of_a_box_that_ends_at_the_border_the_other_side_counts(outside, center):
    """Of 30 px that are seen of 40; however sure the prediction is of something else."""
    z, R = measured([[0, 88], [30, 112]], [15, 100], [0.1, 1.0], whole=True, outside=(outside, 0))
    assert z == pytest.approx([center, 100])
    assert R[0, 0] == pytest.approx(EDGE_VARIANCE)
