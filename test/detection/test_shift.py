"""The shift of a centroid by the blur of an outline."""

import numpy as np
import pytest

from colortrack_ros.detection.covariance import shift_squared


def test_a_disc_shifts_by_the_integral_of_the_shift_of_its_outline():
    way = np.random.default_rng(0).normal(0, 5, 2)
    angle = np.linspace(0, 2 * np.pi, 3600, endpoint=False)
    normal = np.array([np.cos(angle), np.sin(angle)])
    width = np.abs(way @ normal)
    # The outline at n shifts by its width times n g, for g along u and along v.
    shift = np.einsum('k,ik,jk->ij', width, normal, normal) * (2 * np.pi / 3600) / np.pi
    (squared,) = shift_squared(np.outer(way, way)[None])
    assert squared == pytest.approx(shift @ shift, rel=1e-4)
