"""Boxes that are larger than the objects: `fused` and `size` beside `ground`.

python benchmark/world_boxes.py [--runs N] [--seed N] prints, by how boxes are drawn and by method,
the RMSE as a share of the range, the share of rows within their 95 % ellipse, how many rows are
published, and in how many runs a line is told of sizes. Four balls stand before a robot that drives
for 2 s, each run with its own errors of the camera, 1 degree of pitch: balls of 0.2 m before a
camera 0.5 m high, and golf balls before one that is 0.16 m high, as of small-size soccer robots.
"""

import argparse

import numpy as np
from scipy.special import chdtri
from world_scene import as_seen
from world_scene import bases
from world_scene import HERE
from world_scene import measure
from world_scene import PITCH
from world_scene import Scene
from world_scene import truths

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

SECONDS, COUNT, EVERY = 2.0, 4, 3
INSIDE = chdtri(2, 0.05)
SIGMA = (0.01, 0.01, 0.01, 0.01, float(np.radians(PITCH)), 0.01)
ROBOTS = {
    '0.5 m high, balls of 0.2 m': (HERE, 0.2),
    '0.16 m high, golf balls': (
        Scene(mount=Pose.of_rpy((0.1, 0, 0.16), (0, 0.28, 0)), reach=(0.4, 2.5)),
        0.043,
    ),
}
BOXES = {
    'right': (1.0, 0.0, 0.0), '1.3 times': (1.3, 0.0, 0.0), '1.6 times': (1.6, 0.0, 0.0),
    '2.4 times': (2.4, 0.0, 0.0), 'by 12 px, 2 px': (1.0, 12.0, 2.0),
}  # fmt: skip
"""The factor and the margin [px] of boxes, and the standard deviation of the margin by object."""


def once(scene, diameter, boxes, method, seed):
    """The error over range of each row and its square by covariance, and what was told."""
    rng, lines = np.random.default_rng(seed), []
    kind = Kind('ball', KindConfig(diameter=diameter))
    config = LocatorConfig(method=method, colors=(kind,), camera_pose_sigma=SIGMA)
    kinds = Kinds.of(config).take(np.zeros(COUNT, int))
    truth = truths(scene, 'stands', 1, COUNT, kinds, CameraErrors.of(config), rng)
    factor, margin, scatter = boxes
    larger, locator, rows = margin + scatter * rng.normal(size=COUNT), None, []
    locator = Locator(config, lines.append)
    for k, base in enumerate(bases(scene, True)):
        if k % EVERY or k * scene.dt > SECONDS:
            continue
        view = View(scene.camera, base, scene.mount)
        measured, seen = measure(view, truth, kinds, 'fused', 'rests', rng)
        measured.z[:, BLOB] = factor * measured.z[:, BLOB] + larger
        stamp = round((1 + k * scene.dt) * 1e9)
        found = locator.update(*as_seen(measured.z, seen, config, stamp), view).rows
        of = found['track_id'] - 1
        e = np.stack([found['x'], found['y']], axis=1) - truth[of, :2]
        cov = found['covariance'].reshape(-1, 6, 6)[:, :2, :2]
        square = (e * np.linalg.solve(cov, e[..., None])[..., 0]).sum(axis=1)
        away = np.linalg.norm(truth[of, :3] - view.optical.t, axis=1)
        rows.append(np.stack([np.hypot(*e.T) / away, square])[:, seen[of]])
    return np.concatenate(rows, axis=1), any('boxes are larger' in line for line in lines)


def main():
    parser = argparse.ArgumentParser('world_boxes', description=__doc__)
    parser.add_argument('--runs', type=int, default=20)
    parser.add_argument('--seed', type=int, default=0)
    a = parser.parse_args()
    for name, (scene, diameter) in ROBOTS.items():
        print(name)
        for drawn, boxes in BOXES.items():
            for method in ('ground', 'fused', 'size'):
                runs = [once(scene, diameter, boxes, method, a.seed + k) for k in range(a.runs)]
                error, square = np.concatenate([rows for rows, _ in runs], axis=1)
                rmse = 100 * np.sqrt(np.mean(error**2)) if len(error) else np.nan
                inside = 100 * np.mean(square < INSIDE) if len(error) else np.nan
                told = sum(line for _, line in runs)
                print(
                    f'  {drawn:15s} {method:6s} {rmse:5.1f} % {inside:5.1f} % of {len(error):5d} '
                    f'rows, told in {told} of {a.runs}',
                    flush=True,
                )


if __name__ == '__main__':
    main()
