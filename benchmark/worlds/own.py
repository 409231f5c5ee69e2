"""What our own detector makes of rendered scenes, tracked: whether its covariances last."""

from functools import partial

import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.scenes import open_scene
from worlds.following import ELLIPSE
from worlds.world import Figure
from worlds.world import tracker

LEARNED = 20
"""Frames at the start that are not judged."""

APART = 2.4
"""Radii to the next of the same color, up to which two may be one blob, which has no center."""

SCENES = {
    'clutter': (25.0, {'moving_only': True, 'min_area': 200}, 67.0),
    'fast': (50.0, {}, 81.0),
    'light': (25.0, {'follow_light': 60.0}, 66.0),
}
"""Tolerance, parameters, and the share in the 95 % ellipse before, at 1280x720 and 24 Hz."""


def squared_errors(rows, truth):
    """Normalized by the covariances (K, 2, 2) of rows, of balls that are wholly seen and alone."""
    for ball in truth[truth['visible'] == 1]:
        same = truth['color'] == ball['color']
        gaps = np.sort(np.hypot(truth['u'] - ball['u'], truth['v'] - ball['v'])[same])
        away = np.hypot(rows['u'] - ball['u'], rows['v'] - ball['v'])
        away[rows['color'] != ball['color']] = np.inf
        if away.min(initial=np.inf) < ball['radius'] and (gaps[1:] > APART * ball['radius']).all():
            row = rows[away.argmin()]
            e = np.array([row['u'] - ball['u'], row['v'] - ball['v']])
            yield e @ np.linalg.solve(row['covariance'][:2, :2], e)


def tracked(seed, rivals, name, options='width=960&height=540&rate=30'):
    """Positions of what is measured, against the truth."""
    tolerance, parameters, before = SCENES[name]
    scene, ours, d2 = open_scene(f'{name}?{options}&seed={seed}'), tracker(), []
    colors = tuple(ReferenceColor.from_rgb(*c, tolerance) for c in scene.colors.items())
    detector = Detector(DetectorConfig(colors=colors, **parameters))
    for k in range(len(scene)):
        frame = Frame(scene.render(k), stamp=round(k * NANOSECONDS / scene.rate))
        rows = ours.update(detector.detect(frame)).rows
        if k >= LEARNED:
            d2 += squared_errors(rows[rows['time_since_update'] == 0], scene.truth(k))
    yield Figure('in 95 % of position', 100 * np.mean(np.array(d2) < ELLIPSE), before, low=90)
    yield Figure('squared error over the covariance', np.mean(d2) / 2, high=1.2)


WORLDS = {f'18 own detections, {name}': partial(tracked, name=name) for name in SCENES}
