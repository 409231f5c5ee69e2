"""Whether the covariances of centroids are right: the normalized squared error, NSE, is 1 if so.

python benchmark/detection_covariance.py [SIZE...] prints it for each scene at each size, such as
640x360, of balls that are wholly visible, partly covered (by 3 % to 70 %) and partly out of the
picture. Balls that touch another of their color are left out: two in one blob have no centroid.
python benchmark/detection_covariance.py --fit prints the constants of detection/covariance.py for
which the errors are likeliest and the NSE of all scenes nearest to 1.
"""

import argparse
from collections import defaultdict

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import minimize

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import covariance
from colortrack_ros.detection import detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.scenes import open_scene

MOVING = {'moving_only': True, 'min_area': 200}
RUNS = [
    *((scene, 50.0, {}) for scene in ('single', 'enter_exit', 'five', 'crossing', 'occlusion')),
    *((scene, 0.0, {}) for scene in ('single', 'five', 'occlusion')),
    *((scene, 50.0, {}) for scene in ('turns', 'blackout', 'flicker', 'fast')),
    *((scene, 50.0, {'split': True}) for scene in ('collision', 'swarm')),
    *(('juggle', tolerance, {}) for tolerance in (0.0, 50.0)),
    *(('clutter', tolerance, MOVING) for tolerance in (0.0, 25.0)),
    ('light', 25.0, {'follow_light': 60.0}),
    ('light', 50.0, {'white_balance': 'gray_world'}),
]
"""Scene, tolerance (0: found) and parameters, with which the balls are found as they are."""

VISIBLE, COVERED, LEAVING = 'visible', 'covered', 'leaving'
FITTED = (
    'UNSEEN_CHANCE', 'CHORD_VARIANCE', 'CHORD_ERROR', 'SHADED_VARIANCE', 'CUT_SHIFT',
)  # fmt: skip
FIT_BALLS = 40
"""Balls of each group that constants are fitted to, about."""
CLOSE_TO_ONE = 0.3
"""Weight of log(NSE)^2 beside the mean negative log-likelihood of a group."""
STEP = 3
"""Frames from one that is judged to the next."""


class Recorder:
    """Keeps what covariances are made of, to make them again with other constants."""

    def __init__(self):
        self.made = None
        self._covariance = covariance.centroid_covariance
        detector.centroid_covariance = self._keep

    def _keep(self, blobs, size, *values):
        count = len(blobs.area)
        self.made = blobs, size, [np.full(count, x) if np.isscalar(x) else x for x in values]
        return self._covariance(blobs, size, *values)

    def of(self, row):
        """What the covariance of a row of the last picture was made of; None if it is a part."""
        blobs, size, values = self.made
        mine = (blobs.mean == [row['u'], row['v']]).all(axis=1)
        if not mine.any():
            return None
        mine_of = (x[mine] if isinstance(x, np.ndarray) else x.take(mine) for x in values)
        return blobs.take(mine), size, *mine_of

    def again(self, made):
        """The covariance with the constants of now."""
        return self._covariance(*made)[0]


def errors(spec, tolerance, parameters, recorder):
    """By what is seen of the ball: (error, what its covariance was made of)."""
    scene = open_scene(spec)
    colors = tuple(ReferenceColor.from_rgb(*c, tolerance) for c in scene.colors.items())
    detect = detector.Detector(DetectorConfig(colors=colors, **parameters)).detect
    found = defaultdict(list)
    for k in range(len(scene)):
        truth = scene.truth(k)
        rows = detect(Frame(scene.render(k), stamp=round(k * NANOSECONDS / scene.rate))).rows
        for ball in truth if len(rows) and k % STEP == 0 else ():
            gaps = np.hypot(truth['u'] - ball['u'], truth['v'] - ball['v'])
            gaps[truth['color'] != ball['color']] = np.inf
            error = np.array([rows['u'] - ball['u'], rows['v'] - ball['v']]).T
            away = np.where(rows['color'] == ball['color'], np.hypot(*error.T), np.inf)
            if (
                away.min() < ball['radius']
                and np.sort(gaps)[1:2].min(initial=1e9) > 2.4 * (ball['radius'])
            ):
                i = int(away.argmin())
                if made := recorder.of(rows[i]):
                    found[state(ball, scene)].append((error[i], made))
    return found


def state(ball, scene):
    """What is seen of a ball."""
    if ball['visible'] == 1:
        return VISIBLE
    size = np.array([scene.width, scene.height])
    center = np.array([ball['u'], ball['v']])
    if (center < ball['radius']).any() or (center > size - 1 - ball['radius']).any():
        return LEAVING
    return COVERED if 0.3 < ball['visible'] < 0.97 else 'hidden'


def nse(found, recorder):
    """Mean normalized squared error over two, with the constants of now."""
    return squared(found, recorder)[0]


def squared(found, recorder):
    """NSE, and the mean negative log-likelihood of the errors, up to a constant."""
    both = []
    for e, made in found:
        covariance_now = recorder.again(made)
        half = e @ np.linalg.solve(covariance_now, e) / 2
        both.append((half, half + np.log(np.linalg.det(covariance_now)) / 2))
    return np.mean(both, axis=0)


def fit(groups, recorder):
    """Print the constants for which errors are likeliest, with NSE close to 1 in each group."""
    start = np.concatenate([np.atleast_1d(getattr(covariance, name)) for name in FITTED])

    def loss(values):
        if values.min() < 0:
            return np.inf
        for name, value in zip(FITTED, values, strict=False):
            setattr(covariance, name, value)
        covariance.CUT_SHIFT = tuple(values[-2:])
        each = np.array([squared(found, recorder) for found in groups])
        return (each[:, 1] + CLOSE_TO_ONE * np.log(each[:, 0]) ** 2).mean()

    best = minimize(loss, start, method='Nelder-Mead', options={'maxiter': 120, 'xatol': 1e-3})
    loss(best.x)
    print('loss', round(best.fun, 2), {name: getattr(covariance, name) for name in FITTED})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('sizes', nargs='*', default=['640x360'])
    parser.add_argument('--fit', action='store_true')
    arguments = parser.parse_args()
    table, recorder, groups = Table('scene', 'tolerance', 'size'), Recorder(), []
    for name in (VISIBLE, COVERED, LEAVING):
        table.add_column(name)
    for size in arguments.sizes:
        width, height = size.split('x')
        for scene, tolerance, parameters in RUNS:
            spec = f'{scene}?width={width}&height={height}&duration=10'
            found = errors(spec, tolerance, parameters, recorder)
            groups += [
                found[name][:: len(found[name]) // FIT_BALLS + 1]
                for name in (VISIBLE, COVERED)
                if len(found[name]) > 5
            ]
            cells = [
                f'{nse(found[name], recorder):.2f} ({len(found[name])})' if found[name] else ''
                for name in (VISIBLE, COVERED, LEAVING)
            ]
            table.add_row(scene, f'{tolerance:g}', size, *cells)
    Console().print(table)
    if arguments.fit:
        fit(groups, recorder)


if __name__ == '__main__':
    main()
