"""Real flights of a table tennis ball, seen by one camera or two: how near, and how honest.

python benchmark/flights.py FOLDER [--noise PX], where FOLDER is data/evaluation of the public
repository cogsys-tuebingen/tt3d: 139 strokes of two players, measured by several cameras, 25
pictures a second, with the pose of three cameras from which they are to be found again. What a
detector would tell is computed from the measured place, with noise of 0.5 px on each axis, or that
of --noise, and 0.5 px of the diameter. The locator gets the poses, within 0.003 m and rad, and the
diameter, and otherwise has its defaults. Counted from the fourth picture of each stroke.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.special import chdtri
import yaml

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
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.view import View

DIAMETER = 0.04
SKIPPED = 3
CAMERAS = (('side',), ('oblique',), ('back',), ('side', 'oblique'), ('side', 'back'))
KINDS = {
    'defaults': {},
    'drag 0.13': {'drag': 0.13, 'drag_sigma': 0.02},
    'no air': {'drag': 0.0, 'drag_sigma': 0.0},
    'no air, 1 m/s at first': {'drag': 0.0, 'drag_sigma': 0.0, 'speed': 1.0},
}


def camera_of(path):
    """The view of one of the cameras."""
    told = yaml.safe_load(path.read_text())
    R, _ = cv2.Rodrigues(np.array(told['rvec']))
    width, height, f = told['w'], told['h'], told['f']
    lens = CameraModel.of(width, height, (f, 0, width / 2, 0, f, height / 2, 0, 0, 1), ())
    optical = Pose(-R.T @ np.array(told['tvec']), R.T)
    return View(lens, Pose.of_rpy((0, 0, 0), (0, 0, 0)), optical @ OPTICAL.inverse())


def seen(view, at, stamp, noise, eroded, rng):
    """Track and detection of the ball at a place, (3,)."""
    x, y, z = (at - view.optical.t) @ view.optical.R
    f = view.camera.K[0, 0]
    rows, tracks = np.zeros(1, DETECTION), np.zeros(1, TRACK)
    off = rng.normal(size=3) * [noise, noise, 0.5]
    size = max(DIAMETER * f / z + off[2] - eroded, 1.0)
    rows['u'] = f * x / z + view.camera.K[0, 2] + off[0]
    rows['v'] = f * y / z + view.camera.K[1, 2] + off[1]
    rows['cov_uu'] = rows['cov_vv'] = noise**2
    rows['area'], rows['box_w'], rows['box_h'] = np.pi / 4 * size**2, size, size
    rows['box_u'], rows['box_v'] = rows['u'] - size / 2, rows['v'] - size / 2
    for name in ('u', 'v', 'area', 'box_w', 'box_h'):
        tracks[name] = rows[name]
    tracks['track_id'], tracks['state'] = 1, CONFIRMED
    return Tracks(tracks, stamp), Detections(rows, stamp)


def stroke(config, views, flight, noise, rng):
    """Errors, (K, 3), and covariances, (K, 3, 3), after each picture of a flight, (K, 4)."""
    locator, off, cov = Locator(config, lambda line: None, len(views)), [], []
    for t, *at in flight:
        for camera, view in enumerate(views):
            stamp = round((t + 1) * 1e9)
            tracks, detections = seen(view, at, stamp, noise, config.eroded, rng)
            found = locator.update(tracks, detections, view, camera=camera).rows
        row = found[0]
        off.append(np.array([row['x'], row['y'], row['z']]) - at)
        cov.append(row['covariance'].reshape(6, 6)[:3, :3])
    return np.array(off), np.array(cov)


def judge(folder, names, kind, noise):
    """RMSE as a share of the range, NEES, and the share of errors within the 95 % ellipsoid."""
    views = [camera_of(folder / f'{name}.yaml') for name in names]
    ball = Kind('ball', KindConfig(diameter=DIAMETER, motion='free_fall', bounce=0.85, **kind))
    config = LocatorConfig('size', (ball,), camera_pose_sigma=(0.003,) * 6, max_range=40.0)
    shares, nees = [], []
    for k, path in enumerate(sorted((folder / names[0]).glob('*.csv'))):
        flight = np.genfromtxt(path, delimiter=',', skip_header=1).reshape(-1, 8)[:, :4]
        off, cov = stroke(config, views, flight, noise, np.random.default_rng(k))
        away = np.linalg.norm(flight[:, 1:] - views[0].optical.t, axis=1)
        shares.append((np.linalg.norm(off, axis=1) / away)[SKIPPED:])
        nees.append(np.einsum('ni,nij,nj->n', off, np.linalg.inv(cov), off)[SKIPPED:])
    shares, nees = np.concatenate(shares), np.concatenate(nees)
    return np.sqrt(np.mean(shares**2)), nees.mean(), np.mean(nees < chdtri(3, 0.05))


def main():
    parser = argparse.ArgumentParser('flights', description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--noise', type=float, default=0.5)
    a = parser.parse_args()
    table = Table(title='RMSE % of the range, NEES of 3, % within the 95 % ellipsoid')
    for column in ('cameras', *KINDS):
        table.add_column(column)
    for names in CAMERAS:
        cells = [judge(a.folder, names, kind, a.noise) for kind in KINDS.values()]
        told = (f'{100 * rmse:.2f}, {nees:.2f}, {100 * share:.0f}' for rmse, nees, share in cells)
        table.add_row(', '.join(names), *told)
    Console(width=110).print(table)


if __name__ == '__main__':
    main()
