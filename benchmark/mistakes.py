"""What the locator does on a robot that somebody has set up wrongly, mistake by mistake.

python benchmark/mistakes.py [ROOM...] [--method NAME] [--seed N] prints a table for each room. A
robot drives through the simulated room, and what its detector sees goes to tracker and locator
once for each mistake. Told: when the locator tells its first line [s]; silent: from when on
nothing is published any more [s]. Wrong are rows that are farther from the truth than their 99.9 %
ellipse: how many before anything is told, and how many after it.
"""

import argparse
from dataclasses import dataclass
from dataclasses import replace

from following import COLORS
from following import IN_THE_ROOM
from following import NAMES
from following import NOISE
from following import ROLLING
from following import STANDING
from following import swing
import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.special import chdtri
from world_scene import ways
from wrong_odometry import dies
from wrong_odometry import flat
from wrong_odometry import wheels

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
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
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.following import Following
from colortrack_ros.world.following import FollowingConfig
from colortrack_ros.world.following import Target
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.view import View

SECONDS, RATE = 12.0, 30
OUTSIDE = chdtri(3, 0.001)


def balls(*ways):
    """Three balls, each with a path and its speed along it [m/s]."""
    return tuple(
        Thing(thing.name, ThingConfig(rgb=thing.config.rgb, diameter=0.24, path=path, speed=speed))
        for thing, (path, speed) in zip(BALLS[1:], ways, strict=True)
    )


ROLLERS = balls(
    ((2.5, -0.4, 4.5, -1.4), 0.3), ((3.0, 1.5, 4.5, 2.5, 2.0, 2.5), 0.5), ((1.5, 2.5), 0.0)
)
ALIKE = balls(*(
    (path, 0.25)
    for path in ((2.5, -1.0, 5.5, 1.4), (3.0, -0.2, 6.0, 2.2), (3.4, -1.6, 6.4, 0.8))
))  # fmt: skip
AHEAD = balls(((4.0, -0.7), 0.4), ((4.6, 0.8), 0.4), ((5.2, -0.1), 0.4))


def straight(seconds):
    """Straight on at 0.3 m/s, after standing for 2 s."""
    return 0.3 * (seconds > 2), 0.0


ROOMS = {
    'follows': ({}, IN_THE_ROOM, None),
    'swings': ({}, IN_THE_ROOM, swing),
    'rests': ({}, IN_THE_ROOM, lambda _: (0.0, 0.0)),
    'three stand': ({'room': 'empty', 'objects': STANDING}, ROLLING, swing),
    'two roll': ({'room': 'empty', 'objects': ROLLERS}, ROLLING, swing),
    'straight': ({'room': 'empty', 'objects': AHEAD}, ROLLING, straight),
    'roll alike': ({'room': 'empty', 'objects': ALIKE}, ROLLING, straight),
}
"""What is there besides the room, what the locator is told of it, and how the robot drives; None:
after the ball."""


@dataclass
class Recording:
    """All that the robot sees, with where it is and where things are.

    :ivar pictures: of each the detections, the pose of the robot, and the truth.
    """

    camera: CameraModel
    mount: Pose
    kinds: dict
    pictures: list


def record(room, seed=0):
    """Drive through a room, after the ball or by a function of time."""
    parameters, kinds, command = ROOMS[room]
    simulation, rng = Simulation(SimulationConfig(**parameters)), np.random.default_rng(seed)
    detector = Detector(DetectorConfig(colors=COLORS, min_area=20))
    following, pictures = Following(FollowingConfig()), []
    for _ in range(round(SECONDS * RATE)):
        for _ in range(2):
            simulation.advance(round(1e9 / RATE / 2))
            now, robot = simulation.time, simulation.robot
            speeds = following.step(now, robot.odometry.pose, now)
            robot.command(*(command(now * 1e-9) if command else speeds))
        sight = simulation.look()
        seen = detector.detect(Frame(sight.image, 'bgr8', now, 'camera'))
        rows = seen.rows.copy()
        for name in ('u', 'v'):
            rows[name] += NOISE * rng.normal(size=len(rows))
            rows[f'cov_{name * 2}'] += NOISE**2
        truth = simulation.truth(sight.visible).rows
        ball = (np.array([truth[a][0], truth[b][0]], float) for a, b in (('x', 'y'), ('vx', 'vy')))
        following.see(Target(*ball, now, now))
        names = [thing.name for thing in simulation.things]
        told = dict(zip(names, truth, strict=True))
        pictures.append((replace(seen, rows=rows), robot.place.pose, told))
    return Recording(simulation.camera, simulation.mount, kinds, pictures)


def mounted(roll=0.0, pitch=0.0, yaw=0.0, shift=(0, 0, 0)):
    """The camera is said to be turned by so many degrees about its own axes, yaw the robot's."""
    own = Pose.of_rpy(np.zeros(3), np.radians([roll, pitch, 0]))
    turn = Pose.of_rpy(np.zeros(3), np.radians([0, 0, yaw])).R
    return lambda m: Pose(m.t + shift, turn @ (m @ own).R)


def lens(fx=1.0, fy=1.0, distorted=True):
    """The calibration has other focal lengths, or none of the distortion."""

    def told(camera):
        K = camera.K * [[fx, 1, 1], [1, fy, 1], [1, 1, 1]]
        of_none = CameraModel.of(camera.width, camera.height, K)
        return replace(camera, K=K) if distorted else of_none

    return told


def smaller(rows):
    """The detections of a picture half as large."""
    rows = rows.copy()
    for name, center in (('u', 0.5), ('v', 0.5), ('box_u', 0), ('box_v', 0)):
        rows[name] = (rows[name] + center) / 2 - center
    for name in ('box_w', 'box_h'):
        rows[name] /= 2
    for name in ('area', 'cov_uu', 'cov_uv', 'cov_vv'):
        rows[name] /= 4
    return rows


def rotated(pose, pitch):
    """Rolls and yaws as given, and the pitch of another sign."""
    return Pose.of_rpy(pose.t, (0, pitch, 0))


@dataclass(frozen=True)
class Wrong:
    """A mistake: what is told instead of what is so.

    :ivar base: of all poses of the robot and the number of the picture.
    """

    mount: object = lambda m: m
    camera: object = lambda c: c
    base: object = lambda poses, k: poses[k]
    rows: object = lambda rows: rows


def shifted(seconds):
    """The pose of another time."""
    return lambda poses, k: poses[min(max(k + round(seconds * RATE), 0), len(poses) - 1)]


def slips(way, turn):
    """Drives and turns by so much more a second [m, rad], from the fourth to the eighth."""

    def told(poses, k):
        seconds = np.clip(k / RATE - 3, 0, 4)
        return poses[k] @ Pose.of_rpy((way * seconds, 0, 0), (0, 0, turn * seconds))

    return told


MISTAKES = {
    'none': Wrong(),
    'yaw off by 180': Wrong(mounted(yaw=180)),
    'yaw off by 90': Wrong(mounted(yaw=90)),
    'yaw off by -90': Wrong(mounted(yaw=-90)),
    'yaw off by 30': Wrong(mounted(yaw=30)),
    'yaw off by 10': Wrong(mounted(yaw=10)),
    'sign of the pitch': Wrong(lambda m: rotated(m, -0.25)),
    'pitch left out': Wrong(lambda m: rotated(m, 0.0)),
    'pitch off by 5': Wrong(mounted(pitch=5)),
    'pitch in degrees': Wrong(lambda m: rotated(m, np.degrees(0.25))),
    'roll off by 180': Wrong(mounted(roll=180)),
    'roll off by 90': Wrong(mounted(roll=90)),
    'roll off by 10': Wrong(mounted(roll=10)),
    'height twice': Wrong(mounted(shift=(0, 0, 0.5))),
    'height half': Wrong(mounted(shift=(0, 0, -0.25))),
    'height 0': Wrong(mounted(shift=(0, 0, -0.5))),
    'x off by 0.3 m': Wrong(mounted(shift=(0.3, 0, 0))),
    'camera in base exchanged': Wrong(lambda m: m.inverse()),
    'pose of the optical frame': Wrong(lambda m: m @ OPTICAL),
    'frame of the body': Wrong(lambda m: m @ OPTICAL.inverse()),
    'fx, fy 20 % more': Wrong(camera=lens(1.2, 1.2)),
    'fx, fy 20 % less': Wrong(camera=lens(0.8, 0.8)),
    'fx 20 % more': Wrong(camera=lens(1.2)),
    'distortion left out': Wrong(camera=lens(distorted=False)),
    'picture half as large': Wrong(rows=smaller),
    'odometry in mm': Wrong(base=lambda poses, k: Pose(1e3 * poses[k].t, poses[k].R)),
    'odometry 0.2 s old': Wrong(base=shifted(-0.2)),
    'odometry 0.2 s ahead': Wrong(base=shifted(0.2)),
    'odometry turns the other way': Wrong(base=flat(y=-1, yaw=-1)),
    'sign of its yaw': Wrong(base=flat(yaw=-1)),
    'sign of its y': Wrong(base=flat(y=-1)),
    'sign of its x and y': Wrong(base=flat(x=-1, y=-1)),
    'its x and y exchanged': Wrong(base=flat(exchanged=True)),
    'its base frame turned by 90': Wrong(base=flat(off=90)),
    'odometry stands': Wrong(base=lambda poses, k: poses[0]),
    'odometry dies after 6 s': Wrong(base=dies),
    'wheels slip, 0.4 m/s': Wrong(base=slips(0.4, 0)),
    'wheels slip, 30 degrees/s': Wrong(base=slips(0, 0.5)),
    'odometry drives half': Wrong(base=lambda poses, k: Pose(0.5 * poses[k].t, poses[k].R)),
    'odometry drives 0.8': Wrong(base=wheels(way=0.8)),
    'odometry drives 1.25': Wrong(base=wheels(way=1.25)),
    'odometry turns 0.8': Wrong(base=wheels(turn=0.8)),
    'odometry turns 1.25': Wrong(base=wheels(turn=1.25)),
}


def outside(row, truth):
    """Whether a row is farther from the truth than its ellipse."""
    off = np.array([row[name] - truth[name] for name in 'xyz'], float)
    cov = row['covariance'].reshape(6, 6)[:3, :3]
    return off @ np.linalg.solve(cov, off) > OUTSIDE


def replay(recording, wrong, method):
    """When it is told and what; of each picture its rows, and how many of them are wrong."""
    lines, told, counts = [], None, []
    colors = tuple(Kind(name, recording.kinds[name]) for name in NAMES)
    locator = Locator(LocatorConfig(method=method, colors=colors), lines.append)
    tracker = Tracker(TrackerConfig(ego_motion='odometry'))
    camera, mount = wrong.camera(recording.camera), wrong.mount(recording.mount)
    poses = [base for _, base, _ in recording.pictures]
    moves = ways(bases := [wrong.base(poses, k) for k in range(len(poses))], RATE)
    for k, (seen, _, truth) in enumerate(recording.pictures):
        view = View(camera, bases[k], mount, moves[k])
        seen = replace(seen, rows=wrong.rows(seen.rows), viewpoint=view)
        found = locator.update(tracker.update(seen), seen, view).rows
        found = found[found['state'] == CONFIRMED]
        told = k if told is None and lines else told
        bad = sum(bool(outside(row, truth[NAMES[row['color']]])) for row in found)
        counts.append((len(found), bad))
    return told, lines[:1], np.array(counts)


def table_of(room, method, seed):
    """One row for each mistake."""
    recording = record(room, seed)
    table = Table(title=f'{room}, {method}')
    for column in ('mistake', 'told [s]', 'silent [s]', 'rows', 'wrong before', 'after', 'line'):
        table.add_column(column, justify='left' if column in ('mistake', 'line') else 'right')
    for name, wrong in MISTAKES.items():
        told, line, counts = replay(recording, wrong, method)
        silent = len(counts) - int((counts[::-1, 0] > 0).argmax()) if counts[:, 0].any() else 0
        first = len(counts) if told is None else told
        before, after = counts[:first, 1].sum(), counts[first:, 1].sum()
        table.add_row(
            name, '-' if told is None else f'{told / RATE:.1f}',
            '-' if silent == len(counts) else f'{silent / RATE:.1f}',
            str(counts[:, 0].sum()), str(before), str(after), line[0][:60] if line else '',
        )  # fmt: skip
    return table


def main():
    parser = argparse.ArgumentParser('mistakes', description=__doc__)
    parser.add_argument('rooms', nargs='*', choices=list(ROOMS))
    parser.add_argument('--method', default='ground')
    parser.add_argument('--seed', type=int, default=0)
    a = parser.parse_args()
    for room in a.rooms or ROOMS:
        Console(width=150).print(table_of(room, a.method, a.seed))


if __name__ == '__main__':
    main()
