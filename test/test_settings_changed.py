"""Each number, switch and choice at the ends of its range: from the start, set back, set later.

Lists and free text are left out, and ends that are refused beside the defaults of others.
"""

from functools import cache

import numpy as np
import pytest

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.parameters.config import specs_of
from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes.ideal import detections_of
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker

FRAMES = range(15, 39)
"""The scene of contours begins with 20 frames of background."""

MOST = {'swarm_particles': 100, 'swarm_iterations': 20}
"""The greatest values that are allowed take minutes."""


@cache
def scene(name):
    """Frames, and detections by a detector that misses some and finds too many."""
    drawn = open_scene(f'{name}?width=160&height=120&rate=20&duration=3')
    frames = [Frame(drawn.render(k), 'bgr8', k * 50_000_000) for k in FRAMES]
    found = [detections_of(drawn, k, detected=0.8, noise=1.0, clutter=0.3) for k in FRAMES]
    truth = drawn.truth(FRAMES[0])
    left, top = truth['u'] - truth['radius'] + 0.5, truth['v'] - truth['radius'] + 0.5
    return frames, found, np.stack([left, top, *2 * [2 * truth['radius']]], axis=1)


def contour_tracker(config):
    tracker = ContourTracker(config)
    return tracker, tracker.update, scene('silhouette')[0]


def window_tracker(config):
    frames, _, boxes = scene('window_texture')
    tracker = WindowTracker(config, boxes)
    return tracker, tracker.update, frames[:12]


def detector(config):
    detector = Detector(config)
    return detector, detector.detect, scene('five')[0]


def tracker(config):
    tracker = Tracker(config)
    return tracker, tracker.update, scene('five')[1]


MAKERS = {
    ContourConfig: contour_tracker,
    WindowConfig: window_tracker,
    DetectorConfig: detector,
    TrackerConfig: tracker,
}


def is_allowed(config, name, value):
    """A configuration may refuse what is in the range of a parameter for its other values."""
    try:
        config(**{name: value})
    except ValueError:
        return False
    return True


def ends_of(spec):
    """Values other than the default."""
    if spec.many or (spec.kind is str and not spec.choices):
        return []
    most = MOST.get(spec.name, np.inf)
    values = spec.choices or [spec.kind(min(limit, most)) for limit in spec.limits or (0, 1)]
    return [value for value in values if value != spec.default]


CASES = [
    pytest.param(config, spec.name, value, id=f'{maker.__name__}-{spec.name}-{value}')
    for config, maker in MAKERS.items()
    for spec in specs_of(config)
    for value in ends_of(spec)
    if is_allowed(config, spec.name, value)
]


@pytest.mark.slow
@pytest.mark.parametrize('config', MAKERS)
def test_something_comes_out(config):
    _, step, given = MAKERS[config](config())
    assert len([step(each).rows for each in given][-1]) > 0


@pytest.mark.slow
@pytest.mark.filterwarnings('ignore:refused')
@pytest.mark.parametrize(('config', 'name', 'value'), CASES)
def test_what_comes_out_is_finite_whatever_is_set_and_whenever(config, name, value):
    other, usual = config(**{name: value}), config()
    made, step, given = MAKERS[config](other)
    for k, each in enumerate(given):
        if 3 * k in (len(given), 2 * len(given)):
            made.configure(usual if 3 * k == len(given) else other)
        rows = step(each).rows
        for field in rows.dtype.names:
            assert np.isfinite(rows[field]).all(), (field, k)
