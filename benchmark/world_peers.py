"""The locator beside what the textbook has, and beside what most people build, on the same input.

python benchmark/world_peers.py [--runs N] [--seed N] prints RMSE, NEES and coverage on the ground,
in the scenes of world.py. All have the true noise of pixels and the true change of velocity.
EKF: x, y and their speeds of each object on the plane, the pixel of its center as the measurement
(Bar-Shalom et al. 2001, 10.3); the camera is where it is said to be. KF: the ray is intersected
with the plane, and x, y filtered by a linear Kalman filter, with the pixel's covariance carried
to the plane (right), or with one covariance for all (fixed), that of 3 m away.
"""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.special import chdtri
from world import run
from world_scene import bases
from world_scene import config_of
from world_scene import HERE
from world_scene import measure
from world_scene import move
from world_scene import OBJECTS
from world_scene import SETTLED
from world_scene import SPEED
from world_scene import truths
from world_scene import WANDER

from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import guesses
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

NOISE, FIXED, LEAST_RUN = 0.5, 3.0, 1e-4
FILTERS = 'EKF', 'KF, right', 'KF, fixed'


def on_plane(view, xy, kinds):
    """The pixels of objects on the plane, (N, 2), and their Jacobians by x and y, (N, 2, 2)."""
    mean = np.zeros((len(xy), 16))
    mean[:, :2], mean[:, 2] = xy, kinds.height
    z, H = expected(view, mean, kinds.diameter, kinds.height)
    return z[:, :2], H[:, :2, :2]


def begin(motion, count):
    """States x, y and their speeds, (N, 4), and covariances, (N, 4, 4), before any is measured."""
    variance = np.array([100.0] * 2 + [max(SPEED[motion][0], LEAST_RUN) ** 2] * 2)
    return np.zeros((count, 4)), np.tile(np.diag(variance), (count, 1, 1))


def measurements(which, x, where, seen, view, kinds):
    """What states would measure, (N, 2), its slopes, (N, 2, 4), and covariances, (N, 2, 2).

    :param where: (N, 2) where the rays meet the plane.
    """
    count, R = len(x), NOISE**2 * np.eye(2)
    at = x[:, :2] if which == 'EKF' else where
    z, H = on_plane(view, np.where(seen[:, None], at, view.optical.t[:2] + 3), kinds)
    if which == 'EKF':
        return z, np.concatenate([H, np.zeros_like(H)], axis=2), np.tile(R, (count, 1, 1))
    if which == 'KF, fixed':
        bearing = np.arctan2(*(view.optical.R[:2, 2])[::-1])
        place = view.optical.t[:2] + FIXED * np.array([np.cos(bearing), np.sin(bearing)])
        _, there = on_plane(view, place[None], kinds.take(np.zeros(1, int)))
        H = np.tile(there, (count, 1, 1))
    to = np.linalg.inv(H)
    return x[:, :2], np.tile(np.eye(2, 4), (count, 1, 1)), to @ R @ to.swapaxes(1, 2)


def correct(x, P, e, H, R):
    """States and covariances after innovations e, (K, 2); the covariance in Joseph form."""
    HP = H @ P
    K = np.linalg.solve(HP @ H.swapaxes(1, 2) + R, HP).swapaxes(1, 2)
    A = np.eye(4) - K @ H
    return x + (K @ e[..., None])[..., 0], A @ P @ A.swapaxes(1, 2) + K @ R @ K.swapaxes(1, 2)


def peer(which, motion, drives, runs, seed):
    """Errors on the plane, (frames, N, 2), covariances, (frames, N, 2, 2), ranges, what counts."""
    rng, config = np.random.default_rng(seed), config_of('ground', motion)
    kinds = Kinds.of(config).take(np.zeros(runs * OBJECTS, int))
    truth = truths(HERE, motion, runs, OBJECTS, kinds, CameraErrors.of(config), rng)
    F, Q = np.eye(4), np.zeros((4, 4))
    F[:2, 2:] = HERE.dt * np.eye(2)
    Q[2:, 2:] = WANDER[motion] ** 2 * HERE.dt * np.eye(2)
    x, P = begin(motion, len(truth))
    begun, frames = np.zeros(len(truth), bool), []
    for k, base in enumerate(bases(HERE, drives)):
        if k:
            move(truth, HERE.dt, motion, rng)
            x, P = x @ F.T, F @ P @ F.T + Q
        view = View(HERE.camera, base, HERE.mount)
        measured, seen = measure(view, truth, kinds, 'ground', motion, rng)
        if k == 0:
            rng.normal(size=(len(truth), 3))  # as run() does, for the same noise
        where = guesses(measured, kinds, view, 0.0)[:, :2]
        far = np.linalg.norm(where - view.optical.t[:2], axis=1)
        seen &= np.isfinite(far) & (far < 20)
        x[seen & ~begun, :2] = where[seen & ~begun]
        begun |= seen
        z, H, R = measurements(which, x, where, seen, view, kinds)
        e = (measured.z[:, :2] if which == 'EKF' else where) - z
        ok = seen & np.isfinite(e).all(axis=1) & np.isfinite(H).all(axis=(1, 2))
        x[ok], P[ok] = correct(x[ok], P[ok], e[ok], H[ok], R[ok])
        away = np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
        counts = begun & seen & (away > 1) & (away < 5)
        frames.append((x[:, :2] - truth[:, :2], P[:, :2, :2].copy(), away, counts))
    return [np.array(part) for part in zip(*frames, strict=True)]


def figures(error, cov, away, counted):
    """RMSE over the range, of all and from 2 s on [%], NEES of 2, and coverage of 95 %."""
    nees = (error * np.linalg.solve(cov, error[..., None])[..., 0]).sum(axis=-1)
    share, first = np.linalg.norm(error, axis=-1) / away, round(SETTLED * HERE.rate)
    rmse = [100 * np.sqrt(np.mean(share[k:][counted[k:]] ** 2)) for k in (0, first)]
    inside = np.mean(nees[counted] < chdtri(2, 0.05))
    return *rmse, np.mean(nees[counted]), 100 * inside


def main():
    parser = argparse.ArgumentParser('world_peers', description=__doc__)
    parser.add_argument('--runs', type=int, default=50)
    parser.add_argument('--seed', type=int, default=0)
    a = parser.parse_args()
    table = Table(title=f'{a.runs} runs each, ground')
    for column in ('robot, object', 'filter', 'RMSE %', 'from 2 s on', 'NEES', 'of', 'in 95 %'):
        table.add_column(column)
    for drives in (False, True):
        for motion in ('stands', 'rests', 'rolls'):
            name = f'{"drives" if drives else "stands"}, {motion}'
            out = run('ground', motion, drives, a.runs, a.seed)
            inside = np.mean(out.nees[out.counted > 0] < chdtri(out.dof, 0.05))
            row = 100 * out.rmse(), 100 * out.rmse(SETTLED), out.mean_nees, out.dof, 100 * inside
            table.add_row(name, 'locator', *(f'{value:.3g}' for value in row))
            for which in FILTERS:
                *rmse, nees, inside = figures(*peer(which, motion, drives, a.runs, a.seed))
                row = *rmse, nees, 2, inside
                table.add_row(name, which, *(f'{value:.3g}' for value in row))
    Console(width=110).print(table)


if __name__ == '__main__':
    main()
