"""What a locator tells of odometry that is wrong, and what it publishes until then.

python benchmark/world_odometry.py [--runs N] [--seed N] [--wheels SHARE] [WAY...] prints a table
for each way of the robot, whose locator is told how uncertain the scale of its wheels is: for each
fault of the odometry, before balls that stand (declared, or not), that stand beside one that rolls,
and that roll alike: how many runs are told of and when (median, [s]), in how many nothing is
published at the end, and of the rows that show what is in sight how many are farther from the
truth, seen from the robot, than their 99.9 % ellipse: while nothing is told; after that. NEES is
that of all of these rows, of 3. Right odometry has to be told of in no run.
"""

import argparse
from dataclasses import dataclass
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.special import chdtri
from world_scene import as_seen
from world_scene import config_of
from world_scene import HERE
from world_scene import measure
from world_scene import truths
from world_scene import ways
from wrong_odometry import dies
from wrong_odometry import flat

from colortrack_ros.world import Locator
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

SECONDS = 8.0
SCENE = replace(HERE, reach=(2.5, 6.0))
OUTSIDE = chdtri(3, 0.001)
MIDDLE = np.array([SCENE.camera.width, SCENE.camera.height]) / 2 - 0.5
BALLS = {
    'declared': ('stands', 3, 0),
    'three stand': ('rests', 3, 0),
    'two stand': ('rests', 2, 0),
    'one rolls': ('rests', 3, 1),
    'roll alike': ('rests', 3, 3),
}
"""What is there: what the locator is told of it, how many there are, and how many of them roll."""


def speeds(way, rng):
    """Speed [m/s] and turn [rad/s] in each step of a way."""
    t = np.arange(round(SECONDS * SCENE.rate)) * SCENE.dt
    speed, turn, period = rng.uniform(0.2, 0.6), rng.uniform(0.3, 1.0), rng.uniform(3, 6)
    starts = np.clip((t - 1) / 0.5, 0, 1)
    swing = turn * np.cos(2 * np.pi * t / period)
    none = np.zeros(len(t))
    return {
        'stands': (none, none), 'straight': (speed * starts, none), 'turns': (none, swing),
        'swings': (speed * starts, swing),
    }[way]  # fmt: skip


def driven(speed, turn, dt=SCENE.dt):
    """Poses by speeds."""
    x = y = yaw = 0.0
    for v, w in zip(speed, turn, strict=True):
        yield Pose.of_rpy((x, y, 0), (0, 0, yaw))
        yaw += w * dt
        x, y = x + v * dt * np.cos(yaw), y + v * dt * np.sin(yaw)


def each(told):
    """Odometry of a mistake of wrong_odometry.py at all pictures."""
    return lambda poses, v, w: [told(poses, k) for k in range(len(poses))]


def scaled(way, turn):
    """Odometry of wheels of another radius or track."""
    return lambda poses, v, w: list(driven(way * v, turn * w))


def slips(way, turn):
    """Odometry that drives and turns on by wheels that slip, from the third second on."""

    def told(poses, v, w):
        t = np.arange(len(v)) * SCENE.dt
        return list(driven(v + way * (t > 3), w + turn * (t > 3)))

    return told


FAULTS = {
    'right': lambda poses, v, w: poses,
    'stands': lambda poses, v, w: [poses[0]] * len(poses),
    'dies': each(dies),
    'slips ahead': slips(0.4, 0.0),
    'slips and turns': slips(0.0, 0.5),
    'way 0.8': scaled(0.8, 1), 'way 0.9': scaled(0.9, 1), 'way 1.25': scaled(1.25, 1),
    'turn 0.8': scaled(1, 0.8), 'turn 1.25': scaled(1, 1.25),
    'wheels 0.8': scaled(0.8, 0.8), 'wheels 1.25': scaled(1.25, 1.25),
    'x and y swapped': each(flat(exchanged=True)),
    'y inverted': each(flat(y=-1)),
    'yaw inverted': each(flat(yaw=-1)),
    'other way': each(flat(y=-1, yaw=-1)),
    'backward': each(flat(x=-1, y=-1)),
    'y is ahead': each(flat(off=90)),
}  # fmt: skip


@dataclass
class Outcome:
    """Of a run: first line and its time [s], silent at the end, and rows in sight.

    :ivar rows: count, outside before anything is told, and after it; sum of NEES.
    """

    line: str
    when: float
    silent: bool
    rows: np.ndarray


def run(balls, way, fault, seed, method='ground', wheels=0.0):
    """A run of a seed; the locator is told how uncertain the wheels are (way_sigma)."""
    rng, (motion, count, rolling) = np.random.default_rng(seed), BALLS[balls]
    config = replace(config_of(method, motion), way_sigma=wheels)
    kinds, errors = Kinds.of(config).take(np.zeros(count, int)), CameraErrors.of(config)
    truth = truths(SCENE, motion, 1, count, kinds, errors, rng)
    truth[:rolling, 3:5] = rng.uniform(-0.4, 0.4, 2)
    v, w = speeds(way, rng)
    poses = list(driven(v, w))
    lines, when = [], np.inf
    locator, rows = Locator(config, lines.append), np.zeros(4)
    told_poses = FAULTS[fault](poses, v, w)
    odometry = zip(told_poses, ways(told_poses, SCENE.rate), strict=True)
    for k, (base, (told, moves)) in enumerate(zip(poses, odometry, strict=True)):
        truth[:, :3] += (k > 0) * SCENE.dt * truth[:, 3:6]
        there = View(SCENE.camera, base, SCENE.mount)
        measured, seen = measure(there, truth, kinds, 'fused', motion, rng)
        # noise puts none outside of the picture
        seen &= (np.abs(measured.z[:, :2] - MIDDLE) < MIDDLE - 1).all(axis=1)
        view = View(SCENE.camera, told, SCENE.mount, moves)
        shown = as_seen(measured.z, seen, config, round((k + 1) * 1e9 * SCENE.dt))
        found = locator.update(*shown, view).rows
        when = min(when, k * SCENE.dt) if lines else when
        for row in found[seen[found['track_id'] - 1]]:
            at = base.inverse().apply(truth[None, row['track_id'] - 1, :3])
            off = np.array([row[name] for name in 'xyz'], float) - told.apply(at)[0]
            cov = row['covariance'].reshape(6, 6)[:3, :3]
            nees = off @ np.linalg.solve(cov, off)
            rows += 1, nees > OUTSIDE and not lines, nees > OUTSIDE and bool(lines), nees
    return Outcome(lines[0] if lines else '', when, bool(locator.doubt), rows)


def table_of(way, balls, a):
    """One row for each fault."""
    table = Table(title=f'{balls}, robot: {way}, {a.method}, {a.runs} runs')
    for column in ('odometry', 'told', 'when', 'silent', 'rows', 'untold', 'told', 'NEES', 'line'):
        table.add_column(column, justify='left' if column in ('odometry', 'line') else 'right')
    for fault in a.faults or FAULTS:
        outs = [run(balls, way, fault, a.seed + k, a.method, a.wheels) for k in range(a.runs)]
        lines = [out.line for out in outs if out.line]
        rows = sum(out.rows for out in outs)
        most = max(lines, key=lines.count) if lines else ''
        when = np.median([out.when for out in outs if out.line]) if lines else np.nan
        table.add_row(
            fault, str(len(lines)), f'{when:.1f}', str(sum(out.silent for out in outs)),
            *(f'{n:.0f}' for n in rows[:3]), f'{rows[3] / max(rows[0], 1):.1f}', most[:90],
        )  # fmt: skip
    return table


def main():
    parser = argparse.ArgumentParser('world_odometry', description=__doc__)
    parser.add_argument('ways', nargs='*', default=['straight', 'stands', 'turns', 'swings'])
    parser.add_argument('--balls', nargs='*', default=list(BALLS))
    parser.add_argument('--faults', nargs='*')
    parser.add_argument('--method', default='ground')
    parser.add_argument('--wheels', type=float, default=0.0)
    parser.add_argument('--runs', type=int, default=6)
    parser.add_argument('--seed', type=int, default=0)
    a = parser.parse_args()
    for way in a.ways:
        for balls in a.balls:
            Console(width=180).print(table_of(way, balls, a))


if __name__ == '__main__':
    main()
