"""What moves slowly on a table, seen by a camera on the wrist of an arm, 0.4 m above it."""

import numpy as np
import pytest
from scipy.special import chdtri
from support.balls_seen import seen

from colortrack_ros.world import CameraModel
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(640, 480, (520, 0, 320, 0, 520, 240, 0, 0, 1))
PLACE, SIGMA = (0.05, 0.0, 0.04, 0.0, np.pi / 2, 0.0), (0.003, 0.003, 0.003, 0.01, 0.01, 0.01)
TABLE, RADIUS, FRAME = 0.75, 0.015, 33_333_333


def flange(t):
    """The arm sways by a few centimeters and degrees."""
    at = 0.4 + 0.06 * np.sin(1.1 * t), 0.1 * np.sin(0.8 * t), 1.11 + 0.03 * np.sin(0.6 * t)
    return Pose.of_rpy(at, (0.05 * np.sin(t), 0.06 * np.sin(0.9 * t), 0.3 * np.sin(0.5 * t)))


def squared_distances(method, rng):
    """Of what is located from what slides by 2 cm/s, over its covariance, for 6 s."""
    kind = KindConfig(diameter=2 * RADIUS, speed=0.05, wander=0.025)
    config = LocatorConfig(
        method=method, colors=(Kind('red', kind),), camera_pose_sigma=SIGMA, ground_height=TABLE
    )
    off = np.array(PLACE) + rng.normal(size=6) * SIGMA
    told, true = (Pose.of_rpy(p[:3], p[3:]) for p in (PLACE, off))
    locator, out = Locator(config, lambda _: None), []
    for k in range(180):
        t = k / 30
        things = np.array([[0.45, 0.05, 0], [0.5, -0.06, 0], [0.42 + 0.02 * t, -0.02, 0]])
        things[:, 2] = TABLE + RADIUS
        picture = seen(View(CAMERA, flange(t), true), things, (k + 1) * FRAME, radius=RADIUS)
        for name in ('u', 'v'):
            picture[1].rows[name] += 0.5 * rng.normal(size=3)
        picture[1].rows['cov_uu'] = picture[1].rows['cov_vv'] = 0.25
        row = locator.update(*picture, View(CAMERA, flange(t), told)).rows[2]
        e = np.array([row['x'], row['y'], row['z']]) - things[2]
        out.append(e @ np.linalg.solve(row['covariance'].reshape(6, 6)[:3, :3], e))
    return out


@pytest.mark.slow
@pytest.mark.parametrize('method', ['ground', 'size'])
def test_what_is_said_to_be_slow_is_where_it_is_said_to_be(method):
    """With a wander of 0.5 m/s it is taken to stand, and in its ellipsoid in 29 % of the rows."""
    rng = np.random.default_rng(4)
    far = np.concatenate([squared_distances(method, rng) for _ in range(6)])
    assert np.mean(far < chdtri(3, 0.05)) > 0.88
