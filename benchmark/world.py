"""How near the objects in the world are, and how honest their covariances, over 100 runs each.

python benchmark/world.py [--runs N] [--pitch DEGREES] [--objects N] prints the table.
The pitch is the standard deviation of that of the camera, 1 degree. Each run draws its own errors
of the camera's place, of diameters and so on; three objects stand, rest, roll or bounce, 1.5 to 5 m
away, and are measured at 30 Hz for 6 s with 0.5 px of noise, by a camera 0.5 m high that looks down
by 14 degrees: on a robot that stands, or that drives at 0.5 m/s and swings by up to 60 degrees/s.
What rests stands as well, but the locator is told that it may roll. Slow are speeds below 0.05 m/s.
"""

import argparse
from dataclasses import dataclass
import time

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.stats import chi2

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.world import Locator
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.config import RANGE_METHODS
from colortrack_ros.world.filter import forget
from colortrack_ros.world.filter import started
from colortrack_ros.world.filter import update
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import PLANE_SIGMA
from colortrack_ros.world.motion import predict
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import BIASES
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(
    640, 480, (520, 0, 320, 0, 520, 240, 0, 0, 1), (-0.28, 0.09, 1e-3, -8e-4, -0.01)
)
MOUNT = Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))
RATE, SECONDS = 30.0, 6.0
SETTLED = 2.0
DT = 1 / RATE
PITCH = 1.0
OBJECTS = 3
MOTIONS = {'stands': 'still', 'rests': 'plane', 'rolls': 'plane', 'bounces': 'free_fall'}
"""What the locator is told of each: of what rests it is told that it may roll."""
KNOWN = {
    'stands': [0, 1, 2], 'rests': [0, 1, 2], 'rolls': [0, 1, 3, 4], 'bounces': [0, 1, 2, 3, 4, 5]
}  # fmt: skip
"""The states that are not known beforehand."""
SPEED = {
    'stands': (0, 0, 0), 'rests': (0, 0, 0), 'rolls': (0.15, 0.15, 0), 'bounces': (0.3, 0.3, 1.0)
}  # fmt: skip
WANDER = {'stands': 0.0, 'rests': 0.0, 'rolls': 0.1, 'bounces': 0.0}
RESTITUTION = (0.7, 0.1)


@dataclass
class Outcome:
    """Of all runs, (frames, runs * objects) each: NEES, error over range, speed, what counts."""

    dof: int
    runs: int
    objects: int
    nees: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    counted: np.ndarray
    begun: np.ndarray

    @property
    def mean_nees(self):
        """Of the objects that have been seen."""
        return self.nees[self.begun > 0].mean()

    @property
    def bounds(self):
        """The 95 % interval of the mean NEES of as many runs."""
        return chi2.ppf([0.025, 0.975], self.dof * self.runs) / self.runs

    def rmse(self, since=0.0):
        """Root mean square of the error as a share of the range, from a time [s] on."""
        first = round(since * RATE)
        return np.sqrt(np.mean(np.square(self.error[first:][self.counted[first:] > 0])))

    def slow(self, since=0.0):
        """Share of the states whose speed is below 0.05 m/s, from a time [s] on."""
        first = round(since * RATE)
        return np.mean(self.speed[first:][self.counted[first:] > 0] < 0.05)


def config_of(method, motion, pitch=PITCH):
    told = {'speed': max(SPEED[motion]), 'wander': max(WANDER[motion], 0.05)}
    kind = KindConfig(diameter=0.2, motion=MOTIONS[motion], **({} if motion == 'rests' else told))
    sigma = (0.01, 0.01, 0.01, 0.01, float(np.radians(pitch)), 0.01)
    return LocatorConfig(method=method, colors=(Kind('red', kind),), camera_pose_sigma=sigma)


def truths(motion, runs, objects, kinds, errors, rng):
    """The first states, (runs * objects, 16); those of one run share the errors of its camera."""
    count = runs * objects
    truth = np.zeros((count, 16))
    away, angle = rng.uniform(1.5, 5, count), rng.uniform(-0.35, 0.35, count)
    truth[:, 0], truth[:, 1] = away * np.cos(angle), away * np.sin(angle)
    truth[:, BIASES] = rng.normal(size=(count, 2)) * kinds.sigma
    off = rng.normal(size=(runs, 8)) * np.sqrt(np.diag(errors.first))
    truth[:, 8:] = np.repeat(off, objects, axis=0)
    truth[:, 2] = kinds.height + truth[:, HEIGHT]
    if motion == 'bounces':
        truth[:, 2] = rng.uniform(0.5, 1.0, count)
    truth[:, 3:6] = rng.normal(size=(count, 3)) * SPEED[motion]
    return truth


def move(truth, motion, rng):
    """One step of the true states, in place."""
    count = len(truth)
    truth[:, :3] += DT * truth[:, 3:6]
    truth[:, 3:5] += rng.normal(size=(count, 2)) * WANDER[motion] * np.sqrt(DT)
    if motion == 'bounces':
        truth[:, 2] -= GRAVITY * DT * DT / 2
        truth[:, 5] -= GRAVITY * DT
        down = (truth[:, 2] < 0.1) & (truth[:, 5] < 0)
        share = rng.normal(*RESTITUTION, count)[down]
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


def run(method, motion, drives, runs=100, seed=0, pitch=PITCH, objects=OBJECTS):
    """All runs of one kind at once, each with a camera and objects of its own."""
    rng, config = np.random.default_rng(seed), config_of(method, motion, pitch)
    kinds = Kinds.of(config).take(np.zeros(runs * objects, int))
    errors = CameraErrors.of(config, robots=runs)
    truth = truths(motion, runs, objects, kinds, errors, rng)
    known, frames = KNOWN[motion], []
    for k, base in enumerate(bases(drives)):
        if k:
            move(truth, motion, rng)
        view = View(CAMERA, base, MOUNT)
        measured, seen = measure(view, truth, kinds, method, motion, rng)
        distance = np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
        if k == 0:
            # outside of the picture a run has not begun: it is not counted
            begun, guess = seen, truth[:, :3] + 0.02 * rng.normal(size=(len(truth), 3))
            guess[~seen] = view.optical.t + view.optical.R[:, 2]
            states = started(guess, 10 * distance, measured, view, kinds, errors, 0.0)
        else:
            forget(errors, DT)
            predict(states, errors, kinds, 0.0, DT)
            update(states, errors, measured, view, kinds, 0.0)
        mean, cov = states.combined(errors)
        e = mean - truth[:, :8]
        weighted = np.linalg.solve(cov[:, known][:, :, known], e[:, known, None])[:, :, 0]
        frames.append(
            np.stack([
                (e[:, known] * weighted).sum(axis=1),
                np.linalg.norm(e[:, :3], axis=1) / distance,
                np.linalg.norm(mean[:, 3:6], axis=1),
                begun & seen & (distance > 1) & (distance < 5),
                begun,
            ])
        )  # fmt: skip
    return Outcome(len(known), runs, objects, *np.array(frames).swapaxes(0, 1))


def bound(method, motion, drives, runs=100, seed=0, pitch=PITCH, objects=OBJECTS):
    """The least RMSE, as a share of the range, that any estimator could have (Cramer-Rao).

    The recursion of Tichavsky et al. (1998) for motions that are linear, of the states of all
    objects of a run and its camera's errors: Kalman's covariance, linearized at the truth.

    :return: (frames, runs * objects) variance as a share of the squared range, and what counts.
    """
    rng, config = np.random.default_rng(seed), config_of(method, motion, pitch)
    kinds = Kinds.of(config).take(np.zeros(runs * objects, int))
    errors = CameraErrors.of(config, robots=runs)
    truth = truths(motion, runs, objects, kinds, errors, rng)
    n = 8 * objects
    speed = np.zeros(3) if motion == 'rests' else kinds.speed[0]
    own = np.tile(np.concatenate([np.full(3, 100.0), speed, kinds.sigma[0]]), objects)
    cov = np.zeros((runs, n + 8, n + 8))
    cov[:, :n, :n], cov[:, n:, n:] = np.diag(np.square(own)), errors.first
    F, out = np.eye(n + 8), []
    for at in range(0, n, 8):
        F[at : at + 3, at + 3 : at + 6] = DT * np.eye(3)
    of = np.arange(n).reshape(objects, 8)
    for k, base in enumerate(bases(drives)):
        if k:
            move(truth, motion, rng)
            cov = F @ cov @ F.T
            for axis in (3, 4):
                cov[:, of[:, axis], of[:, axis]] += WANDER[motion] ** 2 * DT
        view = View(CAMERA, base, MOUNT)
        measured, seen = measure(view, truth, kinds, method, motion, rng)
        _, H = expected(view, truth, kinds.diameter, kinds.height)
        H[~measured.used] = 0.0
        for i in range(objects):
            one = np.zeros((runs, 5, n + 8))
            one[:, :, of[i]], one[:, :, n:] = H[i::objects, :, :8], H[i::objects, :, 8:]
            PH = cov @ one.swapaxes(1, 2)
            S = one @ PH + measured.R[i::objects]
            cov = cov - PH @ np.linalg.solve(S, PH.swapaxes(1, 2))
        if k == 0:
            begun = seen
        distance = np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
        variance = np.diagonal(cov, axis1=1, axis2=2)[:, of[:, :3]].sum(axis=2).reshape(-1)
        out.append(np.stack([
            variance / distance**2, begun & seen & (distance > 1) & (distance < 5)
        ]))  # fmt: skip
    return np.array(out).swapaxes(0, 1)


def locator_time(objects=50, steps=60):
    """Time of a whole picture with so many objects that roll [ms], fastest of the steps."""
    config = config_of('ground', 'rolls')
    locator = Locator(config, lambda _: None)
    x, y = np.meshgrid(np.linspace(2, 5, 10), np.linspace(-0.8, 0.8, objects // 10))
    truth = np.zeros((objects, 16))
    truth[:, 0], truth[:, 1], truth[:, 2] = x.ravel(), x.ravel() * y.ravel() / 2, 0.1
    rows, tracks = np.zeros(objects, DETECTION), np.zeros(objects, TRACK)
    rng, times = np.random.default_rng(0), []
    for k in range(steps):
        view = View(CAMERA, Pose.of_rpy((0.1 * k * DT, 0, 0), (0, 0, 0)), MOUNT)
        z, _ = expected(view, truth, np.full(objects, 0.2), np.zeros(objects))
        rows['u'], rows['v'] = z[:, :2].T + 0.5 * rng.normal(size=(2, objects))
        rows['box_w'] = rows['box_h'] = z[:, BLOB]
        rows['area'] = np.pi / 4 * z[:, BLOB] ** 2
        rows['box_u'], rows['box_v'] = rows['u'] - z[:, BLOB] / 2, rows['v'] - z[:, BLOB] / 2
        rows['cov_uu'] = rows['cov_vv'] = 0.25
        for name in ('u', 'v', 'area', 'box_w', 'box_h'):
            tracks[name] = rows[name]
        tracks['track_id'], tracks['state'] = np.arange(objects) + 1, CONFIRMED
        stamp = round((k + 1) * 1e9 * DT)
        start = time.perf_counter()
        found = locator.update(Tracks(tracks, stamp), Detections(rows, stamp), view)
        times.append(1e3 * (time.perf_counter() - start))
    return min(times[1:]), len(found.rows)


def percent(*shares):
    return ', '.join(f'{100 * share:.1f}' for share in shares)


def main():
    parser = argparse.ArgumentParser('world', description=__doc__)
    parser.add_argument('--runs', type=int, default=100)
    parser.add_argument('--pitch', type=float, default=PITCH)
    parser.add_argument('--objects', type=int, default=OBJECTS)
    a = parser.parse_args()
    table = Table(title=f'Objects in the world, {a.runs} runs each, {a.objects} objects in each')
    for column in (
        'robot', 'object', 'method', 'NEES', '95 %', f'RMSE %, from {SETTLED:g} s', 'bound',
        'slow %',
    ):  # fmt: skip
        table.add_column(column, justify='right')
    for drives in (False, True):
        for motion in MOTIONS:
            for method in RANGE_METHODS:
                kind = method, motion, drives, a.runs, 0, a.pitch, a.objects
                out, least = run(*kind), '-'
                if motion in ('stands', 'rests'):
                    variance, counted = bound(*kind)
                    least = percent(*(
                        np.sqrt(np.mean(variance[first:][counted[first:] > 0]))
                        for first in (0, round(SETTLED * RATE))
                    ))  # fmt: skip
                table.add_row(
                    'drives' if drives else 'stands', motion, method,
                    f'{out.mean_nees:.2f}', '{:.2f} to {:.2f}'.format(*out.bounds),
                    percent(out.rmse(), out.rmse(SETTLED)), least, percent(out.slow(SETTLED)),
                )  # fmt: skip
    Console(width=110).print(table)
    print('a picture with {1} objects: {0:.2f} ms'.format(*locator_time()))


if __name__ == '__main__':
    main()
