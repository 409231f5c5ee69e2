"""The locator's work per picture, counted, so that neither load nor machine matters."""

import sys

import numpy as np
import pytest
from support.balls_seen import FRAME
from support.balls_seen import seen
from support.paths import ROOT
from support.steps import count_work

sys.path.append(str(ROOT / 'benchmark'))

from world import CAMERA
from world import MOUNT

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.view import View

MOST = 1646
"""Most steps in a picture without a look for mistakes: 1643 with Python 3.11, a few more with 3.13.
It keeps work from being added unnoticed; it does not tell how long each takes."""


@pytest.mark.slow
@pytest.mark.parametrize('count', [1, 10])
def test_a_picture_in_which_nothing_happens_takes_so_many_steps(count):
    config = LocatorConfig(method='ground', colors=(Kind('red', KindConfig(diameter=0.2)),))
    locator, rng, steps = Locator(config, lambda line: None), np.random.default_rng(0), []
    points = np.linspace((2.0, -0.5, 0.1), (4.0, 0.5, 0.1), count)
    for k in range(45):
        view = View(CAMERA, Pose.of_rpy((0.01 * k, 0, 0), (0, 0, 0)), MOUNT)
        noise = rng.normal(0, (0.002, 0.002, 0.0), (count, 3))
        shown = seen(view, points + noise, (k + 1) * FRAME)
        steps.append(count_work(lambda shown=shown, view=view: locator.update(*shown, view)))
    assert len(locator.locations(45 * FRAME).rows) == count
    assert np.median(steps[30:]) <= MOST
