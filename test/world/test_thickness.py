"""Things that are no balls before a depth camera: nobody knows how far their centers lie behind."""

import numpy as np
import pytest

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.world import CameraModel
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.view import View

LENS = CameraModel.of(640, 480, (525, 0, 320, 0, 525, 240, 0, 0, 1))
AHEAD = View(LENS, Pose.of_rpy((0, 0, 1), (0, 0, 0)), Pose.of_rpy((0, 0, 0), (0, 0, 0)))


def located(width, height, filled, away, pictures, **kind):
    """Range and its standard deviation of what is ahead, after some pictures, two a second.

    :param width, height: of the box [px].
    :param filled: share of it.
    :param away: depth of the surface [m].
    """
    rng, row, track = np.random.default_rng(0), np.zeros(1, DETECTION), np.zeros(1, TRACK)
    row['u'], row['v'], row['box_w'], row['box_h'] = 320, 240, width, height
    row['box_u'], row['box_v'] = 320 - width / 2, 240 - height / 2
    row['area'], row['cov_uu'], row['cov_vv'] = width * height * filled, 0.1, 0.1
    for name in ('u', 'v', 'area', 'box_w', 'box_h'):
        track[name] = row[name]
    track['track_id'], track['state'] = 1, CONFIRMED
    config = LocatorConfig('depth', (Kind('red', KindConfig(motion='free', **kind)),))
    locator = Locator(config, lambda line: None)
    for k in range(pictures):
        stamp = (k + 1) * 500_000_000
        depth = rng.normal(away, 0.01 * away, (480, 640)).astype(np.float32)
        out = locator.update(Tracks(track, stamp), Detections(row, stamp), AHEAD, depth)
    (found,) = out.rows
    return float(found['x']), float(np.sqrt(found['covariance'].flat[0]))


@pytest.mark.parametrize('pictures', [1, 20])
@pytest.mark.parametrize(
    ('box', 'away', 'behind'),
    [
        pytest.param((90, 75, 0.47), 1.4, 0.0, id='a magazine on a table'),
        pytest.param((36, 53, 0.6), 2.56, 0.01, id='a book on a shelf'),
        pytest.param((88, 297, 0.75), 3.0, 0.12, id='a person in red'),
        pytest.param((120, 20, 0.9), 1.0, 0.02, id='a stick'),
    ],
)
def test_the_center_of_what_is_no_ball_lies_between_its_surface_and_that_of_a_ball(
    box, away, behind, pictures
):
    x, sigma = located(*box, away, pictures)
    assert abs(x - away - behind) < 1.96 * sigma
    assert sigma < 0.07 * away


def test_the_center_of_a_ball_is_known_from_its_size_and_that_of_a_known_diameter_as_before():
    radius = 0.1
    size = 2 * radius * 525 / 2 - 2.55
    x, sigma = located(size, size, np.pi / 4, 2 - radius, 20)
    assert abs(x - 2) < 0.02
    assert sigma < 0.02
    half, sure = located(size / 2, size, np.pi / 4, 2 - radius, 20, diameter=0.2)
    assert sure < 0.02 < located(size / 2, size, np.pi / 4, 2 - radius, 20)[1]
    assert half > 2 - radius
