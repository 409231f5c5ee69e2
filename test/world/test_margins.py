"""Boxes that are larger than the objects, as those of neural networks are."""

import sys

import numpy as np
import pytest
from support.balls_seen import FRAME
from support.balls_seen import seen
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world_scene

from colortrack_ros.world import CameraModel
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(640, 480, (640, 0, 320, 0, 640, 240, 0, 0, 1), ())
LOW = View(CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), Pose.of_rpy((0.1, 0, 0.16), (0, 0.28, 0)))
RADIUS = 0.0215
POINTS = np.array([[0.6, 0.0, RADIUS], [0.9, 0.2, RADIUS], [1.3, -0.3, RADIUS]])
OUTSIDE = 13.8
"""The 99.9 % ellipse."""


def located(method, enlarged, view=LOW, pictures=10):
    """The last of some pictures of balls whose blobs are enlarged; what was told."""
    kind, lines = Kind('ball', KindConfig(diameter=2 * RADIUS)), []
    locator = Locator(LocatorConfig(method=method, colors=(kind,), eroded=0.0), lines.append)
    for k in range(pictures):
        tracks, detections = seen(view, POINTS, 10**9 + k * FRAME, radius=RADIUS)
        for rows in (tracks.rows, detections.rows):
            rows['box_w'] = rows['box_h'] = enlarged(rows['box_w'] + LocatorConfig.eroded)
            rows['area'] = np.pi / 4 * rows['box_w'] ** 2
        rows['box_u'], rows['box_v'] = rows['u'] - rows['box_w'] / 2, rows['v'] - rows['box_h'] / 2
        found = locator.update(tracks, detections, view).rows
    return found, lines


def off(found):
    """The distances from the truth on the ground, and their squares by covariance."""
    e = np.stack([found['x'], found['y']], axis=1) - POINTS[found['track_id'] - 1, :2]
    cov = found['covariance'].reshape(-1, 6, 6)[:, :2, :2]
    return np.hypot(*e.T), (e * np.linalg.solve(cov, e[..., None])[..., 0]).sum(axis=1)


@pytest.mark.parametrize(('enlarged', 'published'), [(lambda w: w + 12, 3), (lambda w: 1.6 * w, 0)])
def test_sizes_that_contradict_the_ground_are_not_used_and_it_is_told(enlarged, published):
    """Sizes 1.6 times as large may as well be those seen from another height: nothing is sure."""
    found, lines = located('fused', enlarged)
    assert len(found) == published
    assert off(found)[0] == pytest.approx(0, abs=0.02)
    assert [line for line in lines if 'boxes are larger' in line and 'by ground alone' in line]


@pytest.mark.parametrize(('share', 'published'), [(0.6, 0), (1.3, 3)])
def test_boxes_that_are_smaller_than_objects_speak_against_the_camera(share, published):
    """No detector's boxes are; larger ones may be all that is wrong."""
    found, lines = located('fused', lambda w: share * w, pictures=60)
    assert 'by ground alone' in lines[0]
    assert len(found) == published
    assert any('nothing is published' in line for line in lines) == (not published)


@pytest.mark.parametrize('share', [0.2, 4.0])
def test_sizes_that_no_box_has_speak_against_the_set_up(share):
    _, lines = located('fused', lambda w: share * w)
    assert ['camera_pose' in line for line in lines] == [True]
    assert 'by ground alone' not in lines[0]


def test_by_size_covariances_are_as_large_as_boxes_are_wrong_and_it_is_told():
    found, lines = located('size', lambda w: w + 12)
    assert len(found) == 3
    assert (off(found)[1] < OUTSIDE).all()
    assert [line for line in lines if 'boxes are larger' in line and 'size_sigma' in line]


@pytest.mark.parametrize('method', ['fused', 'size'])
def test_sizes_that_are_right_are_used_and_nothing_is_told(method):
    found, lines = located(method, lambda w: w)
    assert off(found)[0] == pytest.approx(0, abs=0.02)
    assert not lines


@pytest.mark.parametrize('name', [None, *world_scene.ELSEWHERE])
def test_right_robots_with_errors_as_expected_trust_sizes(name):
    """At most 1 of 20, each with a pitch of its own, 1 degree, and four balls."""
    scene = world_scene.ELSEWHERE.get(name, world_scene.HERE)
    config, base = world_scene.config_of('fused', 'rests'), Pose.of_rpy((0, 0, 0), (0, 0, 0))
    kinds, view = Kinds.of(config).take(np.zeros(4, int)), View(scene.camera, base, scene.mount)
    told = 0
    for seed in range(20):
        rng, lines = np.random.default_rng(seed), []
        truth = world_scene.truths(scene, 'rests', 1, 4, kinds, CameraErrors.of(config), rng)
        measured, there = world_scene.measure(view, truth, kinds, 'fused', 'rests', rng)
        shown = world_scene.as_seen(measured.z, there, config, 10**9)
        Locator(config, lines.append).update(*shown, view)
        told += any('boxes are larger' in line for line in lines)
    assert told <= 1
