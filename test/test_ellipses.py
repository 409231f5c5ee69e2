"""Ellipses of covariances."""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.special import chdtri

from colortrack_ros.ellipses import ELLIPSE_95
from colortrack_ros.ellipses import ellipses
from colortrack_ros.ellipses import outlines


def covariance_of(major, minor, angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return turn @ np.diag([major**2, minor**2]) @ turn.T


def test_95_percent_is_what_the_chi_squared_distribution_says():
    assert pytest.approx(chdtri(2, 0.05)) == ELLIPSE_95


@pytest.mark.slow
@given(
    st.floats(1e-2, 1e3),
    st.floats(0.01, 0.99),
    st.floats(-np.pi / 2, np.pi / 2),
    st.integers(5, 70),
)
def test_an_outline_is_where_the_mahalanobis_distance_is_that_of_95_percent(
    major, share, angle, points
):
    cov = covariance_of(major, major * share, angle)
    center = np.array([3.0, -4.0])
    line = outlines(center[None], cov[None], points)[0] - center
    distances = np.einsum('ni,ij,nj->n', line, np.linalg.inv(cov), line)
    assert distances == pytest.approx(np.full(points, ELLIPSE_95), rel=1e-6)
    assert line[0] == pytest.approx(line[-1], abs=1e-9 * major)
    (found,), (long,), (short,) = ellipses(cov[None])
    assert (long, short) == pytest.approx((major, major * share), rel=1e-5)
    assert np.cos(found - angle) ** 2 == pytest.approx(1, abs=1e-6)


def test_a_variance_below_zero_counts_as_zero():
    assert ellipses(np.diag([4.0, -1e-9])[None])[2] == [0]
