from unittest import mock

from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.tracking import rectangles as rectangles_module
from colortrack_ros.tracking.rectangles import nearest_points
from colortrack_ros.tracking.rectangles import points_inside as candidates


@pytest.mark.slow
@given(
    seed=st.integers(0, 2**32 - 1),
    rectangles=st.integers(0, 60),
    points=st.integers(0, 60),
    spread=st.sampled_from([1e-3, 1.0, 30.0, 5000.0]),
    dense=st.sampled_from([0, rectangles_module.DENSE]),
)
@settings(max_examples=200, deadline=None)
def test_the_points_inside_each_rectangle_are_found(seed, rectangles, points, spread, dense):
    rng = np.random.default_rng(seed)
    center = rng.integers(-5, 6, (rectangles, 2)) * spread
    half = rng.choice([-30.0, -0.2, 0.0, 0.5, 1.0, 3.0, 100.0, np.inf], (rectangles, 2)) * spread
    z = rng.integers(-5, 6, (points, 2)) * spread
    inside = (np.abs(z - center[:, None]) <= half[:, None]).all(axis=2)
    with mock.patch.object(rectangles_module, 'DENSE', dense):
        found = candidates(center, half, z)
    assert (np.diff(found[0]) >= 0).all()
    assert sorted(zip(*found, strict=True)) == list(zip(*np.nonzero(inside), strict=True))


@given(st.integers(0, 1000), st.integers(0, 40), st.integers(1, 40))
def test_the_nearest_point_is_the_same_with_a_tree(seed, centers, points):
    rng = np.random.default_rng(seed)
    center, points = rng.uniform(0, 100, (centers, 2)), rng.uniform(0, 100, (points, 2))
    by_pairs = nearest_points(points, center)
    with mock.patch.object(rectangles_module, 'DENSE', -1):
        by_tree = nearest_points(points, center)
    np.testing.assert_array_equal(by_pairs, by_tree)
    away = np.hypot(*(points[by_pairs] - center).T)
    assert (away[:, None] <= np.hypot(*(points - center[:, None]).T).T + 1e-9).all()
