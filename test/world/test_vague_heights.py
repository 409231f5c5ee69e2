"""What stands at a height that nobody knows well stays as uncertain as that."""

import numpy as np
import pytest
from scipy.special import chdtri
from support.ball_before_camera import view_of
from support.balls_seen import FRAME
from support.balls_seen import seen

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig

PEOPLE = np.array([(2.0, 0.3, 1.0), (3.0, -0.4, 0.8), (2.5, 0.8, 0.95)])
"""Their centers, 0.9 m above the ground to 0.1 m."""


def located(kind, pictures=45, speed=0.0, points=PEOPLE):
    """What is published of them from a camera 1.2 m high, at the end."""
    config = LocatorConfig(method='ground', colors=(Kind('person', kind),))
    locator, rng = Locator(config, lambda line: None), np.random.default_rng(0)
    for k in range(pictures):
        base = Pose.of_rpy((speed * k * FRAME / 1e9, 0, 0), (0, 0, 0))
        view = view_of(base, Pose.of_rpy((0.1, 0, 1.2), (0, 0.15, 0)))
        tracks, detections = seen(view, points, (k + 1) * FRAME)
        for name in ('u', 'v'):
            detections.rows[name] += rng.normal(0, 0.3, len(points))
        locations = locator.update(tracks, detections, view)
    return locations.rows


@pytest.mark.slow
@pytest.mark.parametrize('speed', [0.0, 0.5])
def test_people_are_where_they_may_be_by_how_tall_they_may_be(speed):
    """They were 0.6 to 1 m away from that, which was said to be known to 0.3 m and less."""
    rows = located(KindConfig(height=0.9, height_sigma=0.1), speed=speed)
    off = np.stack([rows[axis] for axis in 'xyz'], axis=1) - PEOPLE
    cov = rows['covariance'][:, :3, :3]
    nees = (off * np.linalg.solve(cov, off[..., None])[..., 0]).sum(axis=1)
    assert len(rows) == 3
    assert (nees < chdtri(3, 0.05)).all()
    along = np.sqrt(np.trace(cov, axis1=1, axis2=2))
    assert (along < 0.6 * np.linalg.norm(PEOPLE, axis=1)).all()


def test_heights_that_are_known_are_taken_as_such():
    told = [KindConfig(height=0.9, height_sigma=sigma) for sigma in (0.005, 0.02)]
    points = PEOPLE * (1, 1, 0) + (0, 0, 0.9)
    for kind in told:
        cov = located(kind, pictures=2, points=points)['covariance'][:, :3, :3]
        assert (np.trace(cov, axis1=1, axis2=2) < np.square(0.3 * points[:, 0])).all()
