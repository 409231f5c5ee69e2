"""How likely one track continues another."""

import numpy as np
import pytest

from colortrack_ros.tracking.stitching import log_likelihood_ratio


@pytest.mark.parametrize('more', [1, 2])
def test_positions_and_velocities_are_compared_whatever_else_states_hold(more):
    """As the acceleration of a model that has one."""
    rng = np.random.default_rng(0)
    mean = rng.normal(0, 10, (2, 4 + more))
    root = rng.normal(0, 3, (2, 4 + more, 4 + more))
    cov = root @ root.swapaxes(1, 2) + np.eye(4 + more)
    lost, found = np.array([0]), np.array([1])
    others = lost, found, np.array([0.2]), np.array([0.5]), np.array([300.0, 200.0])
    with_more = log_likelihood_ratio(mean, cov, *others)
    assert with_more == pytest.approx(log_likelihood_ratio(mean[:, :4], cov[:, :4, :4], *others))
