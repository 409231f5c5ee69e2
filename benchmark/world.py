"""How near the objects in the world are, and how honest their covariances, over 100 runs each.

python benchmark/world.py [--runs N] [--pitch DEGREES] prints the table.
The pitch is the standard deviation of that of the camera, 1 degree. Each run draws its own errors
of the camera's place, the diameter and so on; an object stands, rolls or bounces, 1.5 to 5 m away,
and is measured at 30 Hz for 6 s with 0.5 px of noise, by a camera 0.5 m high that looks down by 14
degrees: on a robot that stands, or that drives at 0.5 m/s and swings by up to 60 degrees/s.
"""

import argparse
from dataclasses import dataclass
import time

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.stats import chi2

from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.config import RANGE_METHODS
from colortrack_ros.world.filter import predict
from colortrack_ros.world.filter import started
from colortrack_ros.world.filter import update
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import PLANE_SIGMA
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import BIASES
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(
    640, 480, (520, 0, 320, 0, 520, 240, 0, 0, 1), (-0.28, 0.09, 1e-3, -8e-4, -0.01)
)
MOUNT = Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))
RATE, SECONDS = 30.0, 6.0
DT = 1 / RATE
PITCH = 1.0
MOTIONS = {'stands': 'still', 'rolls': 'plane', 'bounces': 'free_fall'}
KNOWN = {'stands': [0, 1, 2], 'rolls': [0, 1, 3, 4], 'bounces': [0, 1, 2, 3, 4, 5]}
"""The states that are not known beforehand."""
SPEED = {'stands': (0, 0, 0), 'rolls': (0.15, 0.15, 0), 'bounces': (0.3, 0.3, 1.0)}
WANDER = {'stands': 0.0, 'rolls': 0.1, 'bounces': 0.0}
RESTITUTION = (0.7, 0.1)


@dataclass
class Outcome:
    """Of all runs: NEES (frames, runs), and of what is in sight at 1 to 5 m errors and speeds."""

    dof: int
    nees: np.ndarray
    error: np.ndarray
    speed: np.ndarray

    @property
    def bounds(self):
        """The 95 % interval of the mean NEES of as many runs."""
        runs = self.nees.shape[1]
        return chi2.ppf([0.025, 0.975], self.dof * runs) / runs


def config_of(method, motion, pitch=PITCH):
    kind = KindConfig(
        diameter=0.2,
        motion=MOTIONS[motion],
        speed=max(SPEED[motion]),
        wander=max(WANDER[motion], 0.05),
    )
    sigma = (0.01, 0.01, 0.01, 0.01, float(np.radians(pitch)), 0.01)
    return LocatorConfig(method=method, colors=(Kind('red', kind),), camera_pose_sigma=sigma)


def truths(motion, runs, kinds, rng):
    """The first states, (runs, 16), biases included."""
    truth = np.zeros((runs, 16))
    away, angle = rng.uniform(1.5, 5, runs), rng.uniform(-0.35, 0.35, runs)
    truth[:, 0], truth[:, 1] = away * np.cos(angle), away * np.sin(angle)
    truth[:, BIASES] = rng.normal(size=(runs, 10)) * kinds.sigma
    truth[:, 2] = kinds.height + truth[:, HEIGHT]
    if motion == 'bounces':
        truth[:, 2] = rng.uniform(0.5, 1.0, runs)
    truth[:, 3:6] = rng.normal(size=(runs, 3)) * SPEED[motion]
    return truth


def move(truth, motion, rng):
    """One step of the true states, in place."""
    runs = len(truth)
    truth[:, :3] += DT * truth[:, 3:6]
    truth[:, 3:5] += rng.normal(size=(runs, 2)) * WANDER[motion] * np.sqrt(DT)
    if motion == 'bounces':
        truth[:, 2] -= GRAVITY * DT * DT / 2
        truth[:, 5] -= GRAVITY * DT
        down = (truth[:, 2] < 0.1) & (truth[:, 5] < 0)
        share = rng.normal(*RESTITUTION, runs)[down]
        truth[down, 2] = 0.1 + share * (0.1 - truth[down, 2])
        truth[down, 5] *= -share


def bases(drives):
    """Where the robot is in each frame."""
    x = y = yaw = 0.0
    for k in range(round(SECONDS * RATE)):
        yield Pose.of_rpy((x, y, 0), (0, 0, yaw))
        if drives:
            yaw += DT * np.radians(60) * np.sin(2 * np.pi * k * DT / 3)
            x, y = x + 0.5 * DT * np.cos(yaw), y + 0.5 * DT * np.sin(yaw)


def measure(view, truth, kinds, method, motion, rng):
    """What is measured, and which objects are in sight."""
    thrown = motion == 'bounces'
    z, _ = expected(view, truth, kinds.diameter, kinds.height)
    seen = np.isfinite(z).all(axis=1) & view.camera.contains(z[:, :2])
    used = np.zeros((len(truth), 5), bool)
    used[:, :2] = True
    used[:, PLANE] = method in ('ground', 'fused') and not thrown
    used[:, BLOB] = method in ('size', 'fused') or (method == 'ground' and thrown)
    used[:, DEPTH] = method in ('depth', 'fused')
    used &= seen[:, None]
    sigma = np.tile([0.5, 0.5, PLANE_SIGMA, 0.5, 0.0], (len(truth), 1))
    sigma[:, DEPTH] = 0.01 * z[:, DEPTH]
    sigma = np.where(used, sigma, 1.0)
    noise = rng.normal(size=z.shape) * sigma
    noise[:, PLANE] = 0.0
    measured = Measured(
        np.where(used, z + noise, 0.0), np.square(sigma)[:, :, None] * np.eye(5), used
    )
    return measured, seen


def run(method, motion, drives, runs=100, seed=0, pitch=PITCH):
    """All runs of one kind, as so many objects at once."""
    rng = np.random.default_rng(seed)
    kinds = Kinds.of(config_of(method, motion, pitch)).take(np.zeros(runs, int))
    truth = truths(motion, runs, kinds, rng)
    nees, error, speed, known = [], [], [], KNOWN[motion]
    for k, base in enumerate(bases(drives)):
        if k:
            move(truth, motion, rng)
        view = View(CAMERA, base, MOUNT)
        measured, seen = measure(view, truth, kinds, method, motion, rng)
        distance = np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
        if k == 0:
            # outside of the picture a run has not begun: it is not counted
            begun, guess = seen, truth[:, :3] + 0.02 * rng.normal(size=(runs, 3))
            guess[~seen] = view.optical.t + view.optical.R[:, 2]
            mean, cov = started(guess, 10 * distance, measured, view, kinds, 0.0)
        else:
            predict(mean, cov, kinds, 0.0, DT)
            rows = seen.nonzero()[0]
            mean[rows], cov[rows], _ = update(
                mean[rows], cov[rows], measured.take(rows), view, kinds.take(rows), 0.0
            )
        e = (mean - truth)[:, known]
        weighted = np.linalg.solve(cov[:, known][:, :, known], e[:, :, None])[:, :, 0]
        nees.append((e * weighted).sum(axis=1)[begun])
        counted = begun & seen & (distance > 1) & (distance < 5)
        error.append((np.linalg.norm((mean - truth)[:, :3], axis=1) / distance)[counted])
        speed.append(np.linalg.norm(mean[:, 3:6], axis=1)[counted])
    return Outcome(len(known), np.array(nees), np.concatenate(error), np.concatenate(speed))


def bound(method, motion, drives, runs=100, seed=0, pitch=PITCH):
    """The least RMSE, as a share of the range, that any estimator could have (Cramer-Rao).

    The recursion of Tichavsky et al. (1998) for motions that are linear, of the state with all its
    biases: Kalman's covariance, with measurements linearized at the truth.
    """
    rng = np.random.default_rng(seed)
    kinds = Kinds.of(config_of(method, motion, pitch)).take(np.zeros(runs, int))
    truth = truths(motion, runs, kinds, rng)
    sigma = np.concatenate([np.full((runs, 3), 100.0), kinds.speed, kinds.sigma], axis=1)
    cov = np.square(sigma)[:, :, None] * np.eye(sigma.shape[1])
    F, variance, begun = np.eye(sigma.shape[1]), [], None
    F[:3, 3:6] = DT * np.eye(3)
    for k, base in enumerate(bases(drives)):
        if k:
            move(truth, motion, rng)
            cov = F @ cov @ F.T
            cov[:, [3, 4], [3, 4]] += WANDER[motion] ** 2 * DT
        view = View(CAMERA, base, MOUNT)
        measured, seen = measure(view, truth, kinds, method, motion, rng)
        _, H = expected(view, truth, kinds.diameter, kinds.height)
        H[~measured.used] = 0.0
        PH = cov @ H.swapaxes(1, 2)
        gain = np.linalg.solve(H @ PH + measured.R, PH.swapaxes(1, 2)).swapaxes(1, 2)
        cov -= gain @ PH.swapaxes(1, 2)
        begun = seen if begun is None else begun
        distance = np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
        counted = begun & seen & (distance > 1) & (distance < 5)
        variance.append((np.trace(cov[:, :3, :3], axis1=1, axis2=2) / distance**2)[counted])
    return float(np.sqrt(np.mean(np.concatenate(variance))))


def update_time(objects=50, steps=50):
    """Time to predict and update so many objects [ms], fastest of the steps."""
    rng = np.random.default_rng(0)
    kinds = Kinds.of(config_of('ground', 'rolls')).take(np.zeros(objects, int))
    truth = truths('rolls', objects, kinds, rng)
    view = View(CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), MOUNT)
    measured, _ = measure(view, truth, kinds, 'ground', 'rolls', rng)
    mean, cov = started(truth[:, :3], np.full(objects, 30.0), measured, view, kinds, 0.0)
    times = []
    for _ in range(steps):
        start = time.perf_counter()
        predict(mean, cov, kinds, 0.0, DT)
        mean, cov, _ = update(mean, cov, measured, view, kinds, 0.0)
        times.append(1e3 * (time.perf_counter() - start))
    return min(times)


def main():
    parser = argparse.ArgumentParser('world', description=__doc__)
    parser.add_argument('--runs', type=int, default=100)
    parser.add_argument('--pitch', type=float, default=PITCH)
    arguments = parser.parse_args()
    runs = arguments.runs
    table = Table(title=f'Objects in the world, {runs} runs each')
    for column in ('robot', 'object', 'method', 'NEES', '95 %', 'RMSE, share of range', 'bound'):
        table.add_column(column, justify='right')
    for drives in (False, True):
        for motion in MOTIONS:
            for method in RANGE_METHODS:
                out = run(method, motion, drives, runs, pitch=arguments.pitch)
                least = '-'
                if motion != 'bounces':
                    least = (
                        f'{100 * bound(method, motion, drives, runs, pitch=arguments.pitch):.1f} %'
                    )
                table.add_row(
                    'drives' if drives else 'stands',
                    motion,
                    method,
                    f'{out.nees.mean():.2f}',
                    '{:.2f} to {:.2f}'.format(*out.bounds),
                    f'{100 * np.sqrt(np.mean(out.error**2)):.1f} %',
                    least,
                )
    Console(width=100).print(table)
    print(f'50 objects: {update_time():.2f} ms')


if __name__ == '__main__':
    main()
