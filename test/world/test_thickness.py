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


def located(boxes, away, **kind):
    """Range and its standard deviation of what is ahead, after two pictures a second.

    :param boxes: width and height in each picture [px], and the share of them that is filled.
    :param away: depth of the surface [m].
    """
    rng, row, track = np.random.default_rng(0), np.zeros(1, DETECTION), np.zeros(1, TRACK)
    config = LocatorConfig('depth', (Kind('red', KindConfig(motion='free', **kind)),))
    locator = Locator(config, lambda line: None)
    track['track_id'], track['state'] = 1, CONFIRMED
    row['u'], row['v'], row['cov_uu'], row['cov_vv'] = 320, 240, 0.1, 0.1
    for k, (width, height, filled) in enumerate(boxes):
        row['box_w'], row['box_h'], row['area'] = width, height, width * height * filled
        row['box_u'], row['box_v'] = 320 - width / 2, 240 - height / 2
        for name in ('u', 'v', 'area', 'box_w', 'box_h'):
            track[name] = row[name]
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
    x, sigma = located([box] * pictures, away)
    assert abs(x - away - behind) < 1.96 * sigma
    assert sigma < 0.07 * away


RADIUS = 0.1
SIZE = 2 * RADIUS * 525 / 2 - 2.55
BALL, HALF = (SIZE, SIZE, np.pi / 4), (SIZE / 2, SIZE, np.pi / 4)


@pytest.mark.slow
def test_the_center_of_a_ball_is_known_from_its_size_once_all_of_it_is_seen():
    x, sigma = located([HALF] * 5 + [BALL] * 15, 2 - RADIUS)
    assert abs(x - 2) < 0.02
    assert sigma < 0.02 < located([HALF] * 20, 2 - RADIUS)[1]


def test_half_of_a_ball_tells_as_much_if_its_diameter_is_known():
    x, sigma = located([HALF] * 20, 2 - RADIUS, diameter=0.2)
    assert 2 - RADIUS < x < 2
    assert sigma < 0.02
