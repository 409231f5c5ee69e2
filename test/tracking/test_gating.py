from unittest import mock

from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np

from colortrack_ros.tracking import rectangles as rectangles_module
from colortrack_ros.tracking.rectangles import points_inside as candidates


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
