"""Distances of what leaves the picture, by how a camera that drives has moved it."""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from support.robot_that_drives import driving
from support.robot_that_drives import ids_of_things
from support.robot_that_drives import of_a_robot_that_drives

from colortrack_ros.tracking.parallax import OFF_GROUND
from colortrack_ros.tracking.parallax import off_nearness

speeds = st.floats(-300, 300)
sigmas = st.floats(1, 50)


@given(st.tuples(speeds, speeds), st.tuples(sigmas, sigmas), st.tuples(speeds, speeds))
def test_it_is_the_mean_of_the_textbook_after_a_prior(velocity, sigma, slope):
    """A ridge regression of one unknown: the velocity is the slope times it."""
    v, h, P = np.array([velocity]), np.array([slope]), np.diag(np.square(sigma))[None]
    (off,) = off_nearness(np.array([5.0]), v, P, h)
    A = np.append(h[0] / sigma, 1 / OFF_GROUND)
    expected = np.linalg.lstsq(A[:, None], np.append(v[0] / sigma, 0.0), rcond=None)[0]
    assert off == 0 or off == pytest.approx(expected[0], rel=1e-6)


@pytest.mark.parametrize(
    ('near', 'velocity', 'off'),
    [
        pytest.param(0.1, (80, 8), 0.4, id='stands nearer'),
        pytest.param(0.4, (-60, -6), -0.3, id='stands farther away'),
        pytest.param(0.4, (3, 1), 0, id='is where it was expected'),
        pytest.param(0.1, (8, 80), 0, id='moves across'),
        pytest.param(0.1, (-80, -8), 0, id='would be behind the camera'),
        pytest.param(0.1, (4000, 400), 0, id='would be inside the camera'),
    ],
)
def test_a_thing_is_nearer_or_farther_if_that_explains_how_it_seems_to_move(near, velocity, off):
    P, slope = 25.0 * np.eye(2)[None], np.array([[200.0, 20.0]])
    found = off_nearness(np.array([near]), np.array([velocity], float), P, slope)
    assert found == pytest.approx(off, abs=0.02)


def test_a_camera_that_turns_alone_tells_no_distance():
    none = off_nearness(np.ones(1), np.array([[50.0, 0.0]]), np.eye(2)[None], np.zeros((1, 2)))
    assert none == 0


@pytest.mark.slow
@pytest.mark.parametrize(('height', 'seed'), [(0.5, 3), (0.7, 7), (0.7, 9), (0.9, 10)])
def test_what_stands_on_a_table_keeps_its_id_while_a_robot_drives_and_swings(height, seed):
    """The lower edges of boxes say that it is farther away, or beyond the horizon."""
    rng = np.random.default_rng(seed)
    angle, away = rng.uniform(-1.4, 1.4, 4), rng.uniform(1.2, 4, 4)
    balls = np.stack([away * np.cos(angle), away * np.sin(angle), np.full(4, height)], axis=1)
    frames = of_a_robot_that_drives(driving(16), lambda k: balls, ego_motion='odometry')
    ids = ids_of_things(frames)
    assert {len(names) for names in ids.values()} == {1}
