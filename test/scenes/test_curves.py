from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.scenes.curves import arcs
from colortrack_ros.scenes.curves import constant
from colortrack_ros.scenes.curves import polyline
from colortrack_ros.scenes.curves import spline

TIMES = np.array([0.0, 1.0, 1.5, 4.0])
POINTS = np.array([(0.0, 10.0), (5.0, -3.0), (6.0, 2.0), (1.0, 1.0)])

KINDS = {
    'polyline': polyline(TIMES, POINTS),
    'arcs': arcs(TIMES, POINTS, [0.0, 9.81]),
    'spline': spline(TIMES, POINTS),
}


@pytest.mark.parametrize('curve', KINDS.values(), ids=KINDS)
def test_a_curve_goes_through_its_points(curve):
    np.testing.assert_allclose(curve.value(TIMES), POINTS, atol=1e-12)


@pytest.mark.parametrize('curve', KINDS.values(), ids=KINDS)
@given(t=st.floats(-1, 5))
def test_the_slope_is_the_derivative(curve, t):
    if np.abs(TIMES - t).min() < 1e-4:
        return
    h = 1e-5
    ends = curve.value(np.array([t - h, t + h]))
    np.testing.assert_allclose(
        curve.slope(np.array([t]))[0], (ends[1] - ends[0]) / (2 * h), atol=1e-3
    )


def test_arcs_fall_with_the_acceleration():
    t = np.array([1.1, 1.2, 1.3])
    second = np.diff(KINDS['arcs'].value(t), n=2, axis=0)[0] / 0.01
    np.testing.assert_allclose(second, [0, 9.81], atol=1e-6)


def test_a_spline_does_not_jump_in_slope():
    before, after = KINDS['spline'].slope(np.array([1.5 - 1e-9, 1.5]))
    np.testing.assert_allclose(before, after, atol=1e-5)


def test_a_constant_stays():
    np.testing.assert_array_equal(constant(1.0, 2.0).value(np.array([-5.0, 9.0])), [[1, 2], [1, 2]])
