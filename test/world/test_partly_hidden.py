"""Balls that something covers by degrees: their centers and sizes are off, and stay off."""

from dataclasses import replace
import sys

import numpy as np
import pytest
from scipy.special import chdtri
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world_scene

from colortrack_ros.world import Locator
from colortrack_ros.world.config import Kind
from colortrack_ros.world.matching import measured_of
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import LASTS
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

VIEW = View(world_scene.CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), world_scene.MOUNT)
COVERED = 1
"""The ball that is covered."""


def picture(seconds, method, rng=None):
    """Four balls that stand; a post hides more and more of the left of one, 0.05 in each second.

    All else is known: the camera, and how large the balls are.
    """
    config = world_scene.config_of(method, 'stands')
    kind = replace(config.colors[0].config, height_sigma=1e-4, diameter_sigma=1e-4)
    config = replace(
        config, colors=(Kind('red', kind),), camera_pose_sigma=(0.0,) * 6, size_sigma=0.0
    )
    truth = np.zeros((4, 16))
    truth[:, :3] = [[2, 0.2, 0.1], [2.5, -0.5, 0.1], [3.2, 0.6, 0.1], [4.0, 0.0, 0.1]]
    z, _ = expected(VIEW, truth, np.full(4, 0.2), np.full(4, 0.1))
    if rng is not None:
        z[:, :2] += 0.5 * rng.normal(size=(4, 2))
    shown = world_scene.as_seen(z, np.ones(4, bool), config, round(1e9 * seconds))
    share = 0.05 * seconds
    tracks, rows = shown[0].rows, shown[1].rows
    for row in (tracks[COVERED], rows[COVERED]):
        # of a disc cut at x: the area that is left, and its center
        x = 2 * share - 1
        half = np.sqrt(1 - x * x)
        left = (np.arccos(x) - x * half) / np.pi
        row['u'] += 2 / 3 * half**3 / (left * np.pi) * row['box_w'] / 2
        row['area'] *= left
        row['box_w'] *= 1 - share
    rows[COVERED]['box_u'] += share / (1 - share) * rows[COVERED]['box_w']
    return config, truth, shown


@pytest.mark.parametrize('method', ['ground', 'size', 'fused'])
def test_no_object_is_surely_elsewhere_because_one_is_covered_by_degrees(method):
    rng, lines = np.random.default_rng(4), []
    config, truth, _ = picture(0, method)
    locator = Locator(config, lines.append)
    for k in range(90):
        shown = picture(k / 30 + 1 / 30, method, rng)[2]
        rows = locator.update(*shown, VIEW).rows
        off = np.stack([rows[name] for name in 'xyz'], axis=1) - truth[:, :3]
        cov = rows['covariance'].reshape(-1, 6, 6)[:, :3, :3]
        assert len(rows) == len(truth)
        square = (off[:, None] @ np.linalg.solve(cov, off[..., None]))[:, 0, 0]
        assert square.max() < chdtri(3, 0.001)
    assert not lines


def test_what_hides_a_sixth_of_a_ball_makes_its_center_and_its_size_uncertain():
    """Its box lacks a sixth, its center is off by a twelfth of the diameter at most."""
    config, _, (_, seen) = picture(10 / 3, 'fused')
    kinds = Kinds.of(config).take(np.zeros(4, int))
    measured = measured_of(seen.rows, kinds, config, VIEW.camera, None)
    lacks = seen.rows['box_h'][COVERED] - seen.rows['box_w'][COVERED]
    assert measured.lasting[COVERED] == pytest.approx([(lacks / 2) ** 2, 0, 0, (lacks / 2) ** 2, 0])
    assert (np.diagonal(measured.R[COVERED]) >= measured.lasting[COVERED]).all()
    assert not measured.lasting[[0, 2, 3]].any()


@pytest.mark.parametrize('dt', [0.01, 1 / 30, 1.0, 30.0])
def test_errors_that_last_tell_in_sum_what_correlated_ones_do(dt):
    """The information about a constant, 1^T C^-1 1, of six errors of an autoregression."""
    one = Measured(np.zeros((1, 5)), 4 * np.eye(5)[None], np.ones((1, 5), bool), np.full((1, 5), 4))
    apart = dt * np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    told = np.linalg.inv(4 * np.exp(-apart / LASTS)).sum()
    later = one.after(np.full(1, dt)).R[0, 0, 0]
    assert 1 / one.R[0, 0, 0] + 5 / later == pytest.approx(told)
    assert one.after(np.full(1, 1e9)).R[0, 0, 0] == pytest.approx(4)
