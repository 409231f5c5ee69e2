"""How near the objects in the world are, and how honest their covariances, over 100 runs each.

python benchmark/world.py [--runs N] [--seed N] [--pitch DEGREES] [--objects N] prints the table,
--elsewhere that of other cameras, places, rates and ranges. --ways SHARE is the standard deviation
of the scale of odometry, which the locator is told.
The pitch is the standard deviation of that of the camera, 1 degree. Each run draws its own errors
of the camera's place, of diameters and so on; three objects stand, rest, roll or bounce, 1.5 to 5 m
away, and are measured at 30 Hz for 6 s with 0.5 px of noise, by a camera 0.5 m high that looks down
by 14 degrees: on a robot that stands, or that drives at 0.5 m/s and swings by up to 60 degrees/s.
What rests stands as well, but the locator is told that it may roll. Slow are speeds below 0.05 m/s.
NEES is of worlds drawn from all that the locator is told (world_told.py), RMSE of these.
"""

import argparse
from dataclasses import dataclass
from dataclasses import replace
import time

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.special import chdtri
from world_scene import as_seen
from world_scene import bases
from world_scene import CAMERA
from world_scene import config_of
from world_scene import DT
from world_scene import ELSEWHERE
from world_scene import HERE
from world_scene import KNOWN
from world_scene import look
from world_scene import measure
from world_scene import MOTIONS
from world_scene import MOUNT
from world_scene import move
from world_scene import OBJECTS
from world_scene import PITCH
from world_scene import RATE
from world_scene import SETTLED
from world_scene import truths
from world_scene import WANDER
from world_told import begun_as_told
from world_told import moved_as_told
from world_told import published

from colortrack_ros.world import Locator
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.config import RANGE_METHODS
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.objects import Objects
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.settling import published as settled
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View


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
    rate: float = RATE

    @property
    def mean_nees(self):
        """Of the objects that have been seen."""
        return self.nees[self.begun > 0].mean()

    @property
    def bounds(self):
        """The 95 % interval of the mean NEES of as many runs."""
        return chdtri(self.dof * self.runs, [0.975, 0.025]) / self.runs

    def rmse(self, since=0.0):
        """Root mean square of the error as a share of the range, from a time [s] on."""
        first = round(since * self.rate)
        return np.sqrt(np.mean(np.square(self.error[first:][self.counted[first:] > 0])))

    def slow(self, since=0.0):
        """Share of the states whose speed is below 0.05 m/s, from a time [s] on."""
        first = round(since * self.rate)
        return np.mean(self.speed[first:][self.counted[first:] > 0] < 0.05)


def judge(belief, truth, known, distance):
    """NEES, error over distance, and speed of each object."""
    mean, cov = belief.combined()
    e = mean - truth[:, :8]
    weighted = np.linalg.solve(cov[:, known][:, :, known], e[:, known, None])[:, :, 0]
    nees = (e[:, known] * weighted).sum(axis=1)
    return nees, np.linalg.norm(e[:, :3], axis=1) / distance, np.linalg.norm(mean[:, 3:6], axis=1)


def run(
    method, motion, drives, runs=100, seed=0, pitch=PITCH, objects=OBJECTS, scene=HERE, ways=0.0,
    told=None, as_told=False,
):  # fmt: skip
    """All runs of one kind at once, each with a camera, wheels and objects of its own.

    :param ways: standard deviation of the scale of odometry; told: that which the locator is told.
    :param as_told: whether objects and camera do all that the locator is told; see world_told.
    """
    rng, config = np.random.default_rng(seed), config_of(method, motion, pitch)
    config = replace(config, way_sigma=ways if told is None else told)
    longer = np.repeat(ways * np.random.default_rng([seed, 1]).normal(size=runs), objects)
    kinds = Kinds.of(config).take(np.zeros(runs * objects, int))
    belief = Belief.of(config, robots=runs)
    errors, first = CameraErrors.of(config), begun_as_told if as_told else truths
    truth = first(scene, motion, runs, objects, kinds, errors, rng)
    known, last, frames = KNOWN[motion], np.zeros(3), []
    seen, each = np.zeros(len(truth), bool), np.arange(len(truth))
    for k, base in enumerate(bases(scene, drives)):
        if k and as_told:
            moved_as_told(truth, kinds, errors, objects, scene.dt, ~seen, rng)
        elif k:
            move(truth, scene.dt, motion, rng)
        # odometry knows where it is: by its frame, what stands comes nearer
        truth[:, :3] -= longer[:, None] * (base.t - last)
        view = View(scene.camera, base, scene.mount)
        measured, there = measure(view, truth, kinds, method, motion, rng)
        distance = np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
        if k == 0:
            begun, belief = there, first_belief(belief, truth, there, measured, view, kinds, rng)
            table = Objects.begun(each, each, 1, belief, kinds)
        else:
            look(table, measured, view, begun, base.t - last, k, scene.dt)
        judged, last, seen = begun & there & within(scene, distance), base.t, there
        shown = published(truth, rng) if as_told else truth
        now = settled(belief, kinds)
        frames.append(np.stack([*judge(now, shown, known, distance), judged, begun]))
    return Outcome(len(known), runs, objects, *np.array(frames).swapaxes(0, 1), scene.rate)


def first_belief(belief, truth, seen, measured, view, kinds, rng):
    """The belief after the first picture; of objects outside of it anything, they do not count."""
    guess = truth[:, :3] + 0.02 * rng.normal(size=(len(truth), 3))
    guess[~seen] = view.optical.t + view.optical.R[:, 2]
    reach = 10 * np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
    return belief.started(guess, reach, measured, view, kinds, 0.0)


def within(scene, distance):
    """Which objects count: at 1 to 5 m, or where the scene has them."""
    return (distance > min(1, scene.reach[0])) & (distance < max(5, scene.reach[1]))


def prior_of(motion, kinds, errors, runs, objects):
    """Covariance, (runs, 8 objects + 8, 8 objects + 8), before anything is measured."""
    n = 8 * objects
    speed = np.zeros(3) if motion == 'rests' else kinds.speed[0]
    own = np.tile(np.concatenate([np.full(3, 100.0), speed, kinds.sigma[0]]), objects)
    cov = np.zeros((runs, n + 8, n + 8))
    cov[:, :n, :n], cov[:, n:, n:] = np.diag(np.square(own)), errors.first[:8, :8]
    return cov


def measured_once(cov, H, R, objects):
    """Covariance, as in :func:`prior_of`, after a measurement of each object: Kalman's."""
    n = 8 * objects
    for i in range(objects):
        one = np.zeros((len(cov), 5, n + 8))
        one[:, :, 8 * i : 8 * i + 8], one[:, :, n:] = H[i::objects, :, :8], H[i::objects, :, 8:]
        PH = cov @ one.swapaxes(1, 2)
        S = one @ PH + R[i::objects]
        cov = cov - PH @ np.linalg.solve(S, PH.swapaxes(1, 2))
    return cov


def bound(method, motion, drives, runs=100, seed=0, pitch=PITCH, objects=OBJECTS, scene=HERE):
    """The least RMSE, as a share of the range, that any estimator could have (Cramer-Rao).

    The recursion of Tichavsky et al. (1998) for motions that are linear, of the states of all
    objects of a run and its camera's errors: Kalman's covariance, linearized at the truth.

    :return: (frames, runs * objects) variance as a share of the squared range, and what counts.
    """
    rng, config = np.random.default_rng(seed), config_of(method, motion, pitch)
    kinds = Kinds.of(config).take(np.zeros(runs * objects, int))
    errors = CameraErrors.of(config, robots=runs)
    truth = truths(scene, motion, runs, objects, kinds, errors, rng)
    cov, out = prior_of(motion, kinds, errors, runs, objects), []
    F, of = np.eye(8 * objects + 8), np.arange(8 * objects).reshape(objects, 8)
    F[of[:, :3], of[:, 3:6]] = scene.dt
    for k, base in enumerate(bases(scene, drives)):
        if k:
            move(truth, scene.dt, motion, rng)
            cov = F @ cov @ F.T
            cov[:, of[:, 3:5], of[:, 3:5]] += WANDER[motion] ** 2 * scene.dt
        view = View(scene.camera, base, scene.mount)
        measured, seen = measure(view, truth, kinds, method, motion, rng)
        _, H = expected(view, truth, kinds.diameter, kinds.height)
        H[~measured.used] = 0.0
        cov = measured_once(cov, H, measured.R, objects)
        if k == 0:
            begun = seen
        distance = np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
        variance = np.diagonal(cov, axis1=1, axis2=2)[:, of[:, :3]].sum(axis=2).reshape(-1)
        out.append(np.stack([variance / distance**2, begun & seen & within(scene, distance)]))
    return np.array(out).swapaxes(0, 1)


def locator_time(objects=50, steps=60):
    """Time of a whole picture with so many objects that roll [ms], fastest of the steps."""
    config = config_of('ground', 'rolls')
    locator = Locator(config, lambda _: None)
    x, y = np.meshgrid(np.linspace(2, 5, 10), np.linspace(-0.8, 0.8, objects // 10))
    truth = np.zeros((objects, 16))
    truth[:, 0], truth[:, 1], truth[:, 2] = x.ravel(), x.ravel() * y.ravel() / 2, 0.1
    rng, times = np.random.default_rng(0), []
    for k in range(steps):
        view = View(CAMERA, Pose.of_rpy((0.1 * k * DT, 0, 0), (0, 0, 0)), MOUNT)
        z, _ = expected(view, truth, np.full(objects, 0.2), np.zeros(objects))
        z[:, :2] += 0.5 * rng.normal(size=(2, objects)).T
        shown = as_seen(z, np.ones(objects, bool), config, round((k + 1) * 1e9 * DT))
        start = time.perf_counter()
        found = locator.update(*shown, view)
        times.append(1e3 * (time.perf_counter() - start))
    return min(times[1:]), len(found.rows)


def percent(*shares):
    return ', '.join(f'{100 * share:.1f}' for share in shares)


def here(a):
    """The table of all motions and methods."""
    table = Table(title=f'Objects in the world, {a.runs} runs each, {a.objects} objects in each')
    for column in (
        'robot', 'object', 'method', 'NEES', '95 %', f'RMSE %, from {SETTLED:g} s', 'bound',
        'slow %',
    ):  # fmt: skip
        table.add_column(column, justify='right')
    for drives in (False, True):
        for motion in MOTIONS:
            for method in RANGE_METHODS:
                kind = method, motion, drives, a.runs, a.seed, a.pitch, a.objects
                out, least = run(*kind, ways=a.ways), '-'
                told = run(*kind, ways=a.ways, as_told=True)
                if motion in ('stands', 'rests'):
                    variance, counted = bound(*kind)
                    least = percent(*(
                        np.sqrt(np.mean(variance[first:][counted[first:] > 0]))
                        for first in (0, round(SETTLED * RATE))
                    ))  # fmt: skip
                table.add_row(
                    'drives' if drives else 'stands', motion, method,
                    f'{told.mean_nees:.2f}', '{:.2f} to {:.2f}'.format(*told.bounds),
                    percent(out.rmse(), out.rmse(SETTLED)), least, percent(out.slow(SETTLED)),
                )  # fmt: skip
    return table


def elsewhere(a):
    """NEES of each method with other cameras, of what stands before a robot that does, or drives,
    and of what rolls before one that drives.
    """
    table = Table(title=f'Elsewhere, NEES, {a.runs} runs each')
    kinds = [('stands', False), ('stands', True), ('rolls', True)]
    for column in ('scene', *(f'{motion}, {"drives" if d else "stands"}' for motion, d in kinds)):
        table.add_column(column)
    for name, scene in ELSEWHERE.items():
        row = []
        for motion, drives in kinds:
            kind = motion, drives, a.runs, a.seed
            outs = [run(m, *kind, scene=scene, as_told=True) for m in RANGE_METHODS]
            row.append(', '.join(f'{o.mean_nees:.2f}' for o in outs) + f' of {outs[0].dof}')
        table.add_row(name, *row)
    return table


def main():
    parser = argparse.ArgumentParser('world', description=__doc__)
    parser.add_argument('--runs', type=int, default=100)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--pitch', type=float, default=PITCH)
    parser.add_argument('--objects', type=int, default=OBJECTS)
    parser.add_argument('--ways', type=float, default=0.0)
    parser.add_argument('--elsewhere', action='store_true')
    a = parser.parse_args()
    if a.elsewhere:
        Console(width=140).print(elsewhere(a))
        return
    Console(width=110).print(here(a))
    print('a picture with {1} objects: {0:.2f} ms'.format(*locator_time()))


if __name__ == '__main__':
    main()
