"""What a locator tells of calibrations that are wrong, how soon, and what it publishes until then.

python benchmark/world_wrong.py [NAME...] [--runs N] [--seed N] [--methods M...] [--ways W...]
prints by method and way of the robot, for each mistake: in how many runs it is told and when
(median, [s]), and in how many nothing is published at the end. Of the rows in sight, of what
stands; rolls, while nothing was told: how many there are of both, the share outside of their 95 %
ellipsoid, NEES over 3 (1 is honest), and the RMSE as a share of the range. Three balls of 0.2 m
stand, 2 to 6 m away, and three roll; the locator is told their diameter, and nothing else. Each run
draws errors of the camera as expected, beside the mistake, which is of the first camera only where
there are two. In `right` nothing may be told. Beside that, rows that came after a line, and how
many of them are outside. What is marked with ! is wrong in silence: not told in half of the runs,
and one in five of the rows of what stands, or of what rolls, is outside. NAME is a part of a
mistake's.
"""

import argparse
from dataclasses import dataclass
from dataclasses import field

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.special import chdtri
from world_odometry import driven
from world_scene import as_seen
from world_scene import buffered
from world_scene import CAMERA
from world_scene import measure
from world_scene import MOUNT
from world_scene import PITCH
from world_strangers import scored
from wrong_calibrations import WRONG

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.course import way_at
from colortrack_ros.world.matching import BULGE
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import BIASES
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

RATE, SECONDS, OBJECTS = 15.0, 8.0, 6
ROLLS = 0.3
OUTSIDE = chdtri(3, 0.05)
SIGMA = (0.01, 0.01, 0.01, 0.01, float(np.radians(PITCH)), 0.01)
APART = (Pose.of_rpy((0, 0.1, 0), (0, 0, -0.1)), Pose.of_rpy((0, -0.1, 0), (0, 0, 0.1)))
"""Where two cameras are beside the one."""
METHODS = {
    'ground': ('ground', 1), 'size': ('size', 1), 'depth': ('depth', 1),
    'two cameras': ('ground', 2), 'two, size': ('size', 2),
}  # fmt: skip
"""Of each the method of the locator, and how many cameras there are."""
COLUMNS = (
    'mistake',
    'told',
    's',
    'silent',
    'rows',
    'outside',
    'told: outside',
    'NEES/3',
    'RMSE',
    '',
    'line',
)
WAYS = {'stands': (0.0, 0.0), 'straight': (0.4, 0.0), 'swings': (0.4, np.radians(60))}
"""Of each the speed of the robot [m/s], and the largest turn [rad/s]."""


@dataclass
class Outcome:
    """Of a run: the first line and its time [s], silent at the end, and rows.

    :ivar rows: errors over range, NEES, whether it rolls, whether nothing was told yet, time [s].
    """

    line: str = ''
    when: float = np.inf
    silent: bool = False
    rows: list = field(default_factory=list)


def config_for(method, diameter):
    kinds = tuple(Kind(f'c{i}', KindConfig(diameter=diameter)) for i in range(OBJECTS))
    return LocatorConfig(method=method, colors=kinds, camera_pose_sigma=SIGMA)


def placed(kinds, rng):
    """The first states, (OBJECTS, 16), without errors of the camera; the first half stands."""
    truth = np.zeros((OBJECTS, 16))
    away, angle = rng.uniform(2.0, 6.0, OBJECTS), rng.uniform(-0.35, 0.35, OBJECTS)
    truth[:, 0], truth[:, 1] = away * np.cos(angle), away * np.sin(angle)
    truth[:, BIASES] = rng.normal(size=(OBJECTS, 2)) * kinds.sigma
    truth[:, 2] = kinds.height + truth[:, HEIGHT]
    truth[OBJECTS // 2 :, 3:5] = ROLLS * rng.normal(size=(OBJECTS - OBJECTS // 2, 2))
    return truth


def alone(z):
    """Which of what is measured, (N, 5), no nearer one may hide or touch."""
    apart = np.linalg.norm(z[:, None, :2] - z[None, :, :2], axis=2)
    behind = z[:, None, DEPTH] > z[None, :, DEPTH]
    touch = apart < (z[:, None, BLOB] + z[None, :, BLOB]) / 2 + 2
    return ~(behind & touch).any(axis=1)


def surfaces(measured, seen, camera, tracks):
    """A depth picture, [m], whose patches are the surfaces of what is measured."""
    picture = np.zeros((CAMERA.height, CAMERA.width), np.float32)
    f = np.sqrt(camera.K[0, 0] * camera.K[1, 1])
    for row, z in zip(tracks.rows[seen], measured.z[seen], strict=True):
        half = int(np.ceil(row['box_w'] / 2))
        u, v = round(float(row['u'])), round(float(row['v']))
        behind = BULGE * min(z[BLOB] / (2 * f), 0.5)
        part = slice(max(v - half, 0), v + half + 1), slice(max(u - half, 0), u + half + 1)
        picture[part] = z[DEPTH] * (1 - behind)
    return picture


def driven_through(v, w):
    """Poses by speeds, in a buffer, the one after a second at the origin."""
    poses = list(driven(v, w, 1 / RATE))
    origin = poses[round(RATE)].inverse()
    return buffered([origin @ pose for pose in poses], RATE)[0]


class Run:
    """A run of a seed."""

    def __init__(self, wrong, method, way, seed):
        self.method, self.cameras = METHODS[method]
        self.wrong, self.rng = wrong, np.random.default_rng(seed)
        config = config_for(self.method, 0.2)
        self.kinds = Kinds.of(config)
        self.truth = placed(self.kinds, self.rng)
        first = np.sqrt(np.diag(CameraErrors.of(config, 2).first))
        self.errors = (self.rng.normal(size=len(first)) * first)[:16].reshape(2, 8)
        self.told = config_for(self.method, 0.2 * wrong.diameter)
        # one second before and after, as stamps are apart
        t = np.arange(-round(RATE), round((SECONDS + 1) * RATE)) / RATE
        speed, most = WAYS[way]
        v, w = speed * np.ones(len(t)), most * np.cos(2 * np.pi * t / 3)
        self.real, self.base = (driven_through(each * v, w) for each in (1.0, wrong.way))
        count = round(SECONDS * RATE)
        self.stamps = [round((k + 1 + RATE) * NANOSECONDS / RATE) for k in range(count)]

    def view(self, camera, stamp):
        """The camera as it is told, and as it was when the picture of a stamp was taken."""
        mount, lens = MOUNT, CAMERA
        if self.cameras > 1:
            mount = MOUNT @ APART[camera]
        taken = stamp - round(self.wrong.apart[camera] * NANOSECONDS)
        there = View(lens, self.real.at(taken), mount)
        if camera == 0:
            mount, lens = self.wrong.mount(mount), self.wrong.camera(lens)
        base = self.base.at(stamp)
        return View(lens, base, mount, way_at(self.base.at, stamp, base)), there

    def picture(self, locator, camera, stamp):
        """Show a picture; return the locations, and which objects are seen."""
        told, there = self.view(camera, stamp)
        truth = self.truth.copy()
        truth[:, :3] -= self.wrong.apart[camera] * truth[:, 3:6]
        truth[:, 8:] = self.errors[camera]
        measured, seen = measure(there, truth, self.kinds, 'fused', 'rolls', self.rng)
        seen = seen & there.camera.contains(measured.z[:, :2]) & alone(measured.z)
        tracks, detections = as_seen(measured.z, seen, self.told, stamp)
        tracks.rows['color'] = np.arange(OBJECTS)
        detections.rows['color'] = np.arange(OBJECTS)[seen]
        depth = None
        if self.method == 'depth':
            depth = surfaces(measured, seen, there.camera, tracks)
        found = locator.update(tracks, detections, told, depth, camera).rows
        return found, seen, there.optical.t

    def outcome(self):
        """All pictures."""
        lines, out = [], Outcome()
        locator = Locator(self.told, lines.append, self.cameras)
        for k, stamp in enumerate(self.stamps):
            self.truth[:, :3] += (k > 0) / RATE * self.truth[:, 3:6]
            seen = np.zeros(OBJECTS, bool)
            for camera in range(self.cameras):
                found, shown, eye = self.picture(locator, camera, stamp)
                seen |= shown
            if lines and not out.line:
                out.line, out.when = lines[0], k / RATE
            found = found[seen[found['color']]]
            of = found['color'].astype(int)
            off, nees = scored(found, self.truth[of, :3], eye)
            untold, rolls = np.full(len(of), not lines), of >= OBJECTS // 2
            out.rows.append(np.stack([off, nees, rolls, untold, np.full(len(of), k / RATE)]))
        out.silent = bool(locator.doubt)
        return out


def cells(outs):
    """The figures of the runs of a mistake, and whether it is wrong in silence."""
    rows = np.concatenate([row for out in outs for row in out.rows], axis=1)
    told = [out for out in outs if out.line]
    when = f'{np.median([out.when for out in told]):.1f}' if told else ''
    untold, later = (
        [rows[:, (rows[3] == which) & (rows[2] == rolls)] for rolls in (0, 1)] for which in (1, 0)
    )
    shares, after = (
        [np.mean(part[1] > OUTSIDE) if part.size else 0.0 for part in parts]
        for parts in (untold, later)
    )
    nees = [np.mean(part[1]) / 3 if part.size else np.nan for part in untold]
    rmse = [100 * np.sqrt(np.mean(part[0] ** 2)) if part.size else np.nan for part in untold]
    silent = 2 * len(told) <= len(outs) and max(shares) > 0.2
    return [
        f'{len(told)} of {len(outs)}', when, str(sum(out.silent for out in outs)),
        str(sum(part.shape[1] for part in untold)),
        '{:.0f}; {:.0f} %'.format(*(100 * s for s in shares)),
        f'{sum(part.shape[1] for part in later)}: {100 * after[0]:.0f}; {100 * after[1]:.0f} %',
        '{:.1f}; {:.1f}'.format(*nees), '{:.1f}; {:.1f} %'.format(*rmse), '!' if silent else '',
    ]  # fmt: skip


def table_of(method, way, a):
    """One row for each mistake."""
    table = Table(title=f'{method}, robot: {way}, {a.runs} runs')
    for column in COLUMNS:
        table.add_column(column, justify='left' if column in ('mistake', 'line') else 'right')
    for name, wrong in WRONG.items():
        of_two = any(wrong.apart[1:]) and METHODS[method][1] < 2
        if of_two or not any(n in name for n in a.names or ['']):
            continue
        outs = [Run(wrong, method, way, a.seed + k).outcome() for k in range(a.runs)]
        lines = [out.line for out in outs if out.line]
        line = max(lines, key=lines.count)[: a.line] if lines else ''
        table.add_row(name, *cells(outs), line)
    return table


def main():
    parser = argparse.ArgumentParser('world_wrong', description=__doc__)
    parser.add_argument('names', nargs='*')
    parser.add_argument('--methods', nargs='+', choices=METHODS, default=[*METHODS][:4])
    parser.add_argument('--ways', nargs='+', choices=WAYS, default=[*WAYS])
    parser.add_argument('--runs', type=int, default=3)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--line', type=int, default=60, help='length of the line that is shown')
    a = parser.parse_args()
    for method in a.methods:
        for way in a.ways:
            Console(width=120 + a.line).print(table_of(method, way, a))


if __name__ == '__main__':
    main()
