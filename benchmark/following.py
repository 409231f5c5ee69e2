"""A robot in the simulated room: how well it follows, and what it knows of the room on its way.

python benchmark/following.py [--seeds N] prints the table, of 1 seed by default. The pictures go
through detector, tracker, locator and follower, with 0.5 px of noise on each detection and a pitch
of the camera that is off by 1 degree (sigma); depths have holes and the errors of a stereo camera,
2 cm at 2 m. What a picture tells is known 2 pictures (67 ms) later.
"""

import argparse
from dataclasses import replace
import math

import numpy as np
from rich.console import Console
from rich.table import Table
from world import measured_once
from world import prior_of
from world_scene import measure

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.simulation import Simulation
from colortrack_ros.simulation import SimulationConfig
from colortrack_ros.simulation import Thing
from colortrack_ros.simulation import ThingConfig
from colortrack_ros.simulation.rooms import BALLS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.course import way_at
from colortrack_ros.world.following import Following
from colortrack_ros.world.following import FollowingConfig
from colortrack_ros.world.following import Target
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.poses import PoseBuffer
from colortrack_ros.world.selection import Selector
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

RATE = 30
TICK = round(1e9 / RATE / 2)
LATE = 2
NOISE, PITCH = 0.5, math.radians(1.0)
SIGMA = (0.01, 0.01, 0.01, 0.01, PITCH, 0.01)
DEPTHS = {'depth_noise': 0.005, 'depth_holes': 0.3}
"""Of a common stereo camera: 2 cm at 2 m; so much of the picture is lost besides the edges."""
SECONDS, SETTLED, GONE, SWINGING = 24.0, 5.0, 5.0, 8.0
"""Of following; when it has begun; when the ball is taken away; of driving and turning."""

COLORS = tuple(ReferenceColor.from_rgb(t.name, t.config.rgb, 0.0) for t in BALLS)
NAMES = [color.name for color in COLORS]
STANDING = tuple(
    Thing(t.name, ThingConfig(rgb=t.config.rgb, diameter=0.24, path=path))
    for t, path in zip(BALLS[1:], ((2.5, -0.4), (3.0, 1.5), (1.5, 2.5)), strict=True)
)
IN_THE_ROOM = {
    'ball': KindConfig(diameter=0.2),
    'standing': KindConfig(diameter=0.24, motion='still'),
    'post': KindConfig(height=0.25, motion='still'),
    'bouncing': KindConfig(diameter=0.2, motion='free_fall'),
}
ROLLING = dict.fromkeys(NAMES, KindConfig(diameter=0.24))
"""That they stand is not known beforehand."""


class Run:
    """A room, a robot, and all that it runs, in one process.

    :ivar log: of each picture, time, distance of the ball, speed of the robot.
    :ivar found: of each confirmed object in each picture, error [m], range [m], speed [m/s].
    :ivar ids: the IDs that each thing has had.
    """

    def __init__(self, seed, kinds, method='ground', **parameters):
        self.simulation = Simulation(SimulationConfig(seed=seed, **parameters))
        self._rng = np.random.default_rng(seed)
        self._detector = Detector(DetectorConfig(colors=COLORS, min_area=20))
        self._tracker = Tracker(TrackerConfig(ego_motion='odometry'))
        colors = tuple(Kind(name, kinds[name]) for name in NAMES)
        config = LocatorConfig(method=method, colors=colors, camera_pose_sigma=SIGMA)
        self.told = []
        self._locator = Locator(config, self.told.append)
        pose = SimulationConfig().camera_pose + self._rng.normal(size=6) * SIGMA
        self._mount = Pose.of_rpy(pose[:3], pose[3:])
        self._late, self._poses = [], PoseBuffer('odom', 'base_link')
        self.following = Following(FollowingConfig())
        self._selector = Selector('ball', NAMES)
        self.log, self.found, self.ids = [], [], {}

    def picture(self):
        """Take a picture; the objects in it."""
        simulation = self.simulation
        sight = simulation.look()
        frame = Frame(sight.image, 'bgr8', simulation.time, 'camera')
        detections = self._detector.detect(frame)
        rows = detections.rows.copy()
        for name in ('u', 'v'):
            rows[name] += NOISE * self._rng.normal(size=len(rows))
            rows[f'cov_{name * 2}'] += NOISE**2
        base = simulation.robot.odometry.pose
        self._poses.add(simulation.time, base)
        way = way_at(self._poses.at, simulation.time, base)
        view = View(simulation.camera, base, self._mount, way)
        detections = replace(detections, rows=rows, viewpoint=view)
        tracks = self._tracker.update(detections)
        depth = sight.depth * (1 + 0.01 * self._rng.normal())
        locations = self._locator.update(tracks, detections, view, depth)
        self._note(locations, simulation.truth(sight.visible))
        return locations

    def _note(self, locations, truth):
        eye = self.simulation.view.optical.t
        names = [thing.name for thing in self.simulation.things]
        true = dict(zip(names, truth.rows, strict=True))
        for row in locations.rows[locations.rows['state'] == CONFIRMED]:
            is_at, should = (xyz(r) for r in (row, true[NAMES[row['color']]]))
            speed = math.hypot(row['vx'], row['vy'], row['vz'])
            self.found.append((math.dist(is_at, should), math.dist(should, eye), speed))
            self.ids.setdefault(NAMES[row['color']], set()).add(int(row['track_id']))

    def go(self, seconds, command=None):
        """Let time go by, following the ball or by a function of time."""
        simulation = self.simulation
        for _ in range(round(seconds * RATE)):
            for _ in range(2):
                simulation.advance(TICK)
                robot, now = simulation.robot, simulation.time
                speeds = self.following.step(now, robot.odometry.pose, now)
                robot.command(*(command(now * 1e-9) if command else speeds))
            self._late.append(self.picture())
            if len(self._late) > LATE:
                self._tell(self._late.pop(0))
            first = simulation.truth(np.zeros(len(simulation.things))).rows[0]
            away = math.hypot(first['x'] - robot.place.x, first['y'] - robot.place.y)
            self.log.append((now * 1e-9, away, robot.speed))
        return np.array(self.log)

    def _tell(self, locations):
        row = self._selector.choose(locations, self.simulation.robot.odometry.pose.t)
        if row is None:
            return
        found = locations.rows[row]
        unseen = round(float(found['time_since_update']) * 1e9)
        sigma = math.sqrt(np.linalg.eigvalsh(found['covariance'][:2, :2])[-1])
        self.following.see(
            Target(
                np.array([found['x'], found['y']], float),
                np.array([found['vx'], found['vy']], float),
                locations.stamp, locations.stamp - unseen, sigma,
            )
        )  # fmt: skip


def xyz(row):
    return row['x'], row['y'], row['z']


def swing(now):
    """To and fro at 0.5 m/s, turning by up to 60 degrees/s."""
    return 0.5 if now // 4 % 2 == 0 else -0.5, math.radians(60) * math.sin(now)


def follow(seeds):
    """Largest and 95 % error of the distance [m]; times to stand after the ball has gone [s]."""
    errors, times = [], []
    for seed in range(seeds):
        log = Run(seed, IN_THE_ROOM).go(SECONDS)
        errors.append(np.abs(log[log[:, 0] > SETTLED, 1] - 1.0))
        run = Run(seed, IN_THE_ROOM, room='empty', objects=BALLS)
        last = run.go(GONE)[-1, 0]
        gone = Thing('ball', replace(BALLS[0].config, path=(50.0, 50.0)))
        run.simulation.place((gone, *BALLS[1:]))
        log = run.go(1.0)
        stands = log[(log[:, 0] > last) & (np.abs(log[:, 2]) < 0.01), 0]
        times.append(stands[0] - last)
    return np.concatenate(errors), np.array(times)


def locate(method, seeds):
    """Errors, ranges and speeds of what stands, and how often an ID changed."""
    room = {'room': 'empty', 'objects': STANDING, **DEPTHS}
    runs = [Run(s, ROLLING, method, **room) for s in range(seeds)]
    for run in runs:
        run.go(SWINGING, swing)
    switches = sum(len(ids) - 1 for run in runs for ids in run.ids.values())
    return np.concatenate([run.found for run in runs]), switches


def least(method):
    """The least RMSE, as a share of the range, that any estimator could have on the same way.

    The Cramer-Rao bound of what stands; see bound() of world.py.
    """
    simulation = Simulation(SimulationConfig(room='empty', objects=STANDING))
    kind = Kind('standing', KindConfig(diameter=0.24))
    config = LocatorConfig(method=method, colors=(kind,), camera_pose_sigma=SIGMA)
    count, rng = len(STANDING), np.random.default_rng(0)
    kinds, errors = Kinds.of(config).take(np.zeros(count, int)), CameraErrors.of(config)
    truth = np.zeros((count, 16))
    truth[:, :3] = [(*thing.config.path, kinds.height[0]) for thing in STANDING]
    cov, shares = prior_of('rests', kinds, errors, 1, count), []
    for _ in range(round(SWINGING * RATE)):
        for _ in range(2):
            simulation.advance(TICK)
            simulation.robot.command(*swing(simulation.time * 1e-9))
        view = simulation.view
        measured, seen = measure(view, truth, kinds, method, 'rests', rng)
        _, H = expected(view, truth, kinds.diameter, kinds.height)
        H[~measured.used] = 0.0
        cov = measured_once(cov, H, measured.R, count)
        away = np.linalg.norm(truth[:, :3] - view.optical.t, axis=1)
        variance = np.diagonal(cov[0])[: 8 * count].reshape(-1, 8)[:, :3].sum(axis=1)
        shares.extend((variance / away**2)[seen & (away > 1) & (away < 5)])
    return 100 * math.sqrt(np.mean(shares))


def main():
    parser = argparse.ArgumentParser('following', description=__doc__)
    parser.add_argument('--seeds', type=int, default=1)
    seeds = parser.parse_args().seeds
    table = Table(title=f'A robot in a room, {seeds} seeds')
    for column in ('what', 'here', 'asked for', 'bound'):
        table.add_column(column, justify='left' if column == 'what' else 'right')
    errors, times = follow(seeds)
    table.add_row('distance kept to a ball at 0.4 m/s, worst', f'{errors.max():.2f} m', '0.2 m')
    table.add_row('the same, 95 %', f'{np.percentile(errors, 95):.2f} m', '')
    table.add_row('stands after the ball has gone, worst', f'{times.max():.2f} s', '0.3 s')
    for method, most in (('ground', 2), ('size', 4), ('depth', 1)):
        found, switches = locate(method, seeds)
        near = found[(found[:, 1] > 1) & (found[:, 1] < 5)]
        error = 100 * np.sqrt(np.mean((near[:, 0] / near[:, 1]) ** 2))
        table.add_row(
            f'{method}: RMSE, share of range',
            f'{error:.1f} %',
            f'{most} %',
            f'{least(method):.1f} %',
        )
        slow = 100 * np.mean(found[:, 2] < 0.05)
        table.add_row(f'{method}: of what stands, below 0.05 m/s', f'{slow:.0f} %', '95 %')
        table.add_row(f'{method}: ID switches', str(switches), '0')
    Console(width=100).print(table)


if __name__ == '__main__':
    main()
