"""Centroids and their covariances against the truth of the rendered scenes."""

from functools import lru_cache

import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.scenes import open_scene

SCENES = ('single', 'enter_exit', 'five', 'crossing', 'occlusion')


@lru_cache(maxsize=16)
def errors(spec, step=12):
    """(N, 3) of the wholly visible balls: error in u and v [px], normalized squared error / 2."""
    scene, detector = open_scene(spec), Detector(DetectorConfig())
    found = []
    for k in range(0, len(scene), step):
        rows = detector.detect(Frame(scene.render(k))).rows
        truth = scene.truth(k)
        assert len(rows) <= len(truth), 'a false blob, or a ball in pieces'
        for ball in truth[truth['visible'] == 1]:
            error = np.array([rows['u'] - ball['u'], rows['v'] - ball['v']]).T
            nearest = np.linalg.norm(error, axis=1).argmin()
            row, error = rows[nearest], error[nearest]
            covariance = [[row['cov_uu'], row['cov_uv']], [row['cov_uv'], row['cov_vv']]]
            found.append((*error, error @ np.linalg.solve(covariance, error) / 2))
    return np.array(found)


@pytest.mark.parametrize(('spec', 'limit'), [('single?noise=0', 0.15), ('single', 0.3)])
def test_centroids_are_better_than_a_pixel(spec, limit):
    error = errors(spec)[:, :2]
    assert np.sqrt((error**2).sum(axis=1).mean()) < limit


def test_the_covariance_is_neither_bold_nor_shy():
    squared = np.concatenate([errors(name)[:, 2] for name in SCENES])
    assert 0.8 < squared.mean() < 1.25


def test_the_covariance_of_a_ball_that_leaves_the_picture_covers_its_hidden_part():
    scene, detector = open_scene('enter_exit'), Detector(DetectorConfig())
    squared = []
    for k in range(len(scene)):
        truth = scene.truth(k)
        cut = truth[(truth['visible'] > 0.2) & (truth['visible'] < 0.98)]
        for ball in cut:
            (row,) = detector.detect(Frame(scene.render(k))).rows
            squared.append((row['u'] - ball['u']) ** 2 / row['cov_uu'])
    assert len(squared) > 5
    assert 0.2 < np.mean(squared) < 1.25
