"""Balls that fly through air, which slows them down and turns those that spin."""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from support.balls_seen import seen

from colortrack_ros.world import CameraModel
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.flight import fall
from colortrack_ros.world.flight import FRICTION
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import DRAG
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(1280, 720, (1280, 0, 640, 0, 1280, 360, 0, 0, 1), ())
VIEW = View(CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), Pose.of_rpy((0, 0, 1.3), (0, 0.2, 0)))
RADIUS = 0.02
RATE, STEPS = 30, 50
DT = 1 / RATE
HIGH = 100.0
"""Height at which nothing bounces [m]."""


def flown(at, velocity, drag, spin, seconds):
    """Position and velocity after a flight, by small steps; spin turns the way: (3,) lift/drag."""
    at, velocity = np.array(at, float), np.array(velocity, float)
    dt = seconds / STEPS
    for _ in range(STEPS):
        fast = np.linalg.norm(velocity)
        force = drag * fast * (np.cross(spin, velocity) - velocity) - [0, 0, GRAVITY]
        at, velocity = at + dt * velocity + dt**2 / 2 * force, velocity + dt * force
    return at, velocity


def ball(**config):
    return Kind('red', KindConfig(diameter=2 * RADIUS, motion='free_fall', **config))


def one(config, velocity, drag=0.0):
    """State of a ball high up, its kind, and no errors of the camera."""
    errors = CameraErrors.of(config)
    mean = np.zeros((1, 2, OF_OBJECT))
    mean[..., 2], mean[..., 3:6], mean[..., DRAG] = HIGH, velocity, drag
    cov = np.tile(np.diag([0.01, 0.01, 0.01, 0.2, 0.2, 0.2, 1e-3, 1e-6]), (1, 2, 1, 1))
    slope = np.zeros((1, 2, OF_OBJECT, len(errors.first)))
    slope[..., range(6), range(6)] = 1.0
    return Motions.of(mean, slope, cov, np.array([[0.0, 1.0]])), Kinds.of(config), errors


def fallen(objects, kinds, errors, dt=DT):
    """Mean after one step, (8,), moved as predict() does."""
    objects.whole[..., :3, :] += dt * objects.whole[..., 3:6, :]
    fall(objects, errors, kinds, 0.0, dt, np.zeros(1, bool))
    return objects.mean[0, 1]


velocities = st.tuples(*[st.floats(-10, 10)] * 3)


@pytest.mark.slow
@given(velocities, st.floats(0, 0.3))
def test_air_slows_it_down_by_its_drag_and_the_square_of_its_speed(velocity, drag):
    config = LocatorConfig(colors=(ball(drag=drag),))
    got = fallen(*one(config, velocity))
    at, then = flown((0, 0, HIGH), velocity, drag, (0, 0, 0), DT)
    np.testing.assert_allclose(got[:3], at, atol=2e-3)
    np.testing.assert_allclose(got[3:6], then, atol=0.04)


@pytest.mark.slow
@given(velocities, st.floats(0.01, 0.3))
def test_what_is_lost_in_the_air_is_linearized_as_finite_differences_say(velocity, drag):
    config = LocatorConfig(colors=(ball(drag=0.0),))
    objects, kinds, errors = one(config, velocity, drag)
    fallen(objects, kinds, errors)
    for column in (3, 4, 5):  # the slope is that of the velocity by these errors
        step = np.zeros(3)
        step[column - 3] = 1e-4
        there = [
            fallen(*one(config, np.array(velocity) + sign * step, drag))[3:6] for sign in (-1, 1)
        ]
        want = (there[1] - there[0]) / 2e-4
        np.testing.assert_allclose(objects.slope[0, 1, 3:6, column], want, atol=1e-3)
    there = [fallen(*one(config, velocity, drag + sign * 1e-4))[3:6] for sign in (-1, 1)]
    by_drag = (there[1] - there[0]) / 2e-4
    got = objects.cov[0, 1, 3:6, DRAG] / objects.cov[0, 1, DRAG, DRAG]
    np.testing.assert_allclose(got, by_drag, atol=1e-3 * (1 + np.abs(by_drag).max()))


@pytest.mark.parametrize('by', ['own', 'camera'])
def test_a_bounce_changes_an_uncertain_speed_by_a_share_of_what_it_may_be(by):
    """Of a speed along the ground that is 0 on average, with a variance of 1 m^2/s^2."""
    config = LocatorConfig(colors=(ball(drag=0.0),), camera_pose_sigma=(1.0,) * 6)
    objects, kinds, errors = one(config, (0, 0, -3.0))
    objects.mean[..., 2], objects.cov[..., 2, 2], objects.slope[...] = RADIUS, 1e-6, 0.0
    objects.cov[..., 3, 3] = by == 'own'
    objects.slope[..., 3, 0] = by == 'camera'
    fallen(objects, kinds, errors)
    more = FRICTION**2 + (by == 'own')
    assert objects.cov[0, 1, 3, 3] == pytest.approx(more, rel=0.02)
    assert objects.slope[0, 1, 3, 0] == (by == 'camera')


def test_what_stands_beside_it_has_no_drag():
    still = Kind('blue', KindConfig(diameter=0.2, motion='plane'))
    assert Kinds.of(LocatorConfig(colors=(still, ball()))).sigma[:, 0].tolist() == [0.005, 0.06]


def test_it_may_be_thrown_faster_than_it_would_be_rolled():
    still = Kind('blue', KindConfig(diameter=0.2, motion='plane'))
    slow = ball(speed=0.3)
    kinds = Kinds.of(LocatorConfig(colors=(still, ball(), slow)))
    assert kinds.speed[:, 0].tolist() == [1.0, 5.0, 0.3]


def seen_flying(config, velocity, drag, spin, seed, seconds=0.5):
    """Errors over the range, and squared normalized errors, of a ball from its third picture on."""
    rng = np.random.default_rng(seed)
    locator = Locator(config, lambda line: None)
    at, off, weighed = np.array([4.3, -1.3, 0.4]), [], []
    for k in range(int(seconds * RATE)):
        tracks, detections = seen(VIEW, at, round((k + 1) * 1e9 / RATE), radius=RADIUS)
        for name in ('u', 'v'):
            detections.rows[name] += 0.5 * rng.normal()
        detections.rows['cov_uu'] = detections.rows['cov_vv'] = 0.25
        (row,) = locator.update(tracks, detections, VIEW).rows
        if k >= 2:
            e = np.array([row[name] for name in ('x', 'y', 'z')]) - at
            off.append(np.linalg.norm(e) / np.linalg.norm(at - VIEW.optical.t))
            weighed.append(e @ np.linalg.solve(row['covariance'].reshape(6, 6)[:3, :3], e))
        at, velocity = flown(at, velocity, drag, spin, DT)
    return off, weighed


@pytest.mark.slow
@pytest.mark.parametrize('side', [-1, 1])
def test_a_light_ball_that_spins_is_where_its_covariance_says(side):
    """As light and as fast as in table tennis: its drag of 0.13/m is by far not the default."""
    off, weighed = [], []
    for seed in range(10):
        spin = 0.5 * np.random.default_rng(seed).normal(size=3)
        more = seen_flying(
            LocatorConfig(colors=(ball(),)), (side * 0.5, 5.0, 2.5), 0.13, spin, seed
        )
        off.extend(more[0])
        weighed.extend(more[1])
    assert np.mean(np.array(weighed) < 7.815) > 0.95  # chi-square of 3, 95 %
    assert np.sqrt(np.mean(np.square(off))) < 0.05


def test_the_drag_is_learned():
    """A heavy and a light one of the same color: without, the range of the light one is 7 % off."""
    config = LocatorConfig(colors=(ball(),))
    heavy, light = (
        seen_flying(config, (0.0, 6.0, 2.5), drag, np.zeros(3), 1)[0] for drag in (0.0, 0.13)
    )
    assert max(np.mean(heavy), np.mean(light)) < 0.05
