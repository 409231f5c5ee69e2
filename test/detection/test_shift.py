"""The shift of a centroid by the blur of an outline."""

import numpy as np
import pytest

from colortrack_ros.detection.covariance import shift_squared
from colortrack_ros.detection.covariance import square_root


def ways(count):
    """(N, 2) random ways, and (N + 1, 2, 2) blur along each, and blur alike in all directions."""
    way = np.random.default_rng(0).normal(0, 5, (count, 2))
    blur = way[:, :, None] * way[:, None, :] + np.eye(2)
    return way, np.concatenate([blur, 9 * np.eye(2)[None]])


def test_the_square_root_of_a_matrix_is_symmetric_and_squared_the_matrix():
    _, matrix = ways(20)
    root = square_root(matrix)
    assert np.matmul(root, root) == pytest.approx(matrix)
    assert root == pytest.approx(root.transpose(0, 2, 1))
    assert (np.linalg.eigvalsh(root) > 0).all()


def test_a_disc_shifts_by_the_integral_of_the_shift_of_its_outline():
    (way,), _ = ways(1)
    angle = np.linspace(0, 2 * np.pi, 3600, endpoint=False)
    normal = np.array([np.cos(angle), np.sin(angle)])
    width = np.abs(way @ normal)
    # The outline at n shifts by its width times n g, for g along u and along v.
    shift = np.einsum('k,ik,jk->ij', width, normal, normal) * (2 * np.pi / 3600) / np.pi
    (squared,) = shift_squared(np.outer(way, way)[None])
    assert squared == pytest.approx(shift @ shift, rel=1e-4)
