"""Errors of the camera that change, and ranges that contradict each other by those errors."""

import sys

import numpy as np
import pytest
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world_scene

from colortrack_ros.world.belief import Belief
from colortrack_ros.world.filter import ERROR_MEMORY
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import STANDS
from colortrack_ros.world.state import TILT
from colortrack_ros.world.view import View

VIEW = View(world_scene.CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), world_scene.MOUNT)
PITCH = TILT.start + 1


def before_a_camera(method, pitch, pictures=1):
    """What a locator knows of three balls that stand, when its pitch is off [degrees]."""
    config, rng = world_scene.config_of(method, 'stands'), np.random.default_rng(3)
    kinds = Kinds.of(config).take(np.zeros(3, int))
    truth, belief = np.zeros((3, 16)), Belief.of(config)
    truth[:, :3] = [[2, 0.2, 0.1], [3.5, -0.5, 0.1], [4.7, 0.0, 0.1]]
    truth[:, PITCH] = np.radians(pitch)
    for k in range(pictures):
        measured, _ = world_scene.measure(VIEW, truth, kinds, method, 'stands', rng)
        if k:
            belief.forget(world_scene.DT)
            belief.predict(kinds, 0.0, world_scene.DT, np.zeros(3, bool))
            belief.update(measured, VIEW, kinds, 0.0)
        else:
            reach = np.full(3, 50.0)
            belief = belief.started(truth[:, :3], reach, measured, VIEW, kinds, 0.0)
    return belief


@pytest.mark.parametrize('method', ['ground', 'size', 'fused'])
def test_what_stands_stays_as_well_known_when_the_camera_may_have_moved(method):
    belief = before_a_camera(method, 1.0, pictures=5)
    belief.errors.cov *= 0.1
    mean, cov = belief.combined()
    belief.forget(ERROR_MEMORY / 10)
    later, covered = belief.combined()
    assert later == pytest.approx(mean)
    assert covered == pytest.approx(cov, rel=1e-6, abs=1e-9)


def test_what_objects_have_in_common_with_the_errors_is_that_of_the_errors_before():
    """Of x = slope b + rest and b' = b + change: cov(x, b') = cov(x, b), and cov(b') is larger."""
    belief = before_a_camera('size', 1.0, pictures=5)
    belief.errors.cov *= 0.1
    with_errors = belief.motion.slope[:, STANDS] @ belief.errors.cov
    known = belief.errors.cov.copy()
    belief.forget(ERROR_MEMORY / 10)
    assert belief.motion.slope[:, STANDS] @ belief.errors.cov == pytest.approx(with_errors)
    assert np.linalg.eigvalsh(belief.errors.cov - known).min() > -1e-12
    assert np.diag(belief.errors.cov[0]).max() <= np.diag(belief.errors.first).max()


def test_errors_that_are_known_beforehand_stay_known():
    belief = before_a_camera('size', 0.0, pictures=2)
    for a in (belief.errors.first, belief.errors.cov[0]):
        a[0] = a[:, 0] = 0.0
    belief.forget(10.0)
    assert np.isfinite(belief.motion.whole).all()
    assert not belief.errors.cov[0, 0].any()


def test_a_pitch_that_parts_two_ranges_is_not_taken_for_the_heights_of_objects():
    """By the first picture alone, heights were said to be off by up to 0.08 m, of 5 mm."""
    for pictures in (1, 2, 10):
        belief = before_a_camera('fused', 2.7, pictures)
        mean, cov = belief.combined()
        assert (np.abs(mean[:, HEIGHT]) < 3 * np.sqrt(cov[:, HEIGHT, HEIGHT])).all()
        assert (np.abs(mean[:, HEIGHT]) < 0.012).all()
    pitch = belief.errors.mean[0, PITCH - 8]
    assert pitch == pytest.approx(np.radians(2.7), abs=np.radians(0.6))


def test_errors_change_in_each_case_by_as_much_as_in_all():
    """Cases are narrower as to where the errors were, and not as to how far they change."""
    belief = before_a_camera('ground', 1.0)
    assert len(belief.log_weight) > 1
    known = belief.errors.cov.copy()
    belief.forget(ERROR_MEMORY / 1e4)
    change = (belief.errors.cov - known)[:, PITCH - 8, PITCH - 8] / np.radians(1.0) ** 2
    share = (1 - np.exp(-2e-4)) * (1 - known[:, PITCH - 8, PITCH - 8] / np.radians(1.0) ** 2)
    assert change == pytest.approx(share, rel=1e-6)
    assert (change > 1e-4).all()
