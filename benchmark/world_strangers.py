"""A whole locator on robots that nobody had in mind: how near, how honest, and what is told.

python benchmark/world_strangers.py [NAME...] [--runs N] [--seed N] prints by robot and method, of
what stands and of what rolls, the RMSE as a share of the range from 2 s on, the mean NEES over 3
(1 is honest), its median over that of chi-square, and the shares of rows in sight and out of it
that are outside of their 99.9 % ellipse, with the number of balls that these are of: a ball that is
lost is outside in up to 180 rows. Then in how many runs nothing was published at the end, and what
was told. Three balls stand, and three roll, before a robot that drives at 0.5 m/s and swings, each
run with its own errors of the camera. NAME is a part of a robot's.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import field
from itertools import accumulate

import numpy as np
from scipy.special import chdtri
from world_scene import as_seen
from world_scene import bases
from world_scene import buffered
from world_scene import came
from world_scene import CAMERA
from world_scene import measure
from world_scene import PITCH
from world_scene import Scene
from world_scene import SETTLED
from world_scene import ways

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import PoseBuffer
from colortrack_ros.world.state import BIASES
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

OUTSIDE, MEDIAN = chdtri(3, [0.001, 0.5])
WANDERS = 0.1
DOME = CameraModel.of(900, 900, (230, 0, 450, 0, 230, 450, 0, 0, 1), (0.0,) * 4, 'equidistant')
SIGMA = (0.01, 0.01, 0.01, 0.01, float(np.radians(PITCH)), 0.01)


def same(poses, rate, rng):
    """Poses as they are."""
    return poses


def at_5_hz(poses, rate, rng):
    """Known five times a second; between them as the node reads them."""
    buffer, step = PoseBuffer('odom', 'base_link'), round(rate / 5)
    for k in (*range(0, len(poses), step), len(poses) - 1):
        buffer.add(round((k + rate) * 1e9 / rate), poses[k])
    return [buffer.at(round((k + rate) * 1e9 / rate)) for k in range(len(poses))]


def old(by):
    """Its stamps are late by so much [s], or, if that is negative, early."""

    def told(poses, rate, rng):
        step = poses[-2].inverse() @ poses[-1]
        ahead = list(accumulate([step] * round(rate), Pose.__matmul__, initial=poses[-1]))
        buffer, stamps = buffered([*poses, *ahead[1:]], rate)
        return [buffer.at(max(s - round(by * 1e9), stamps[0])) for s in stamps[: len(poses)]]

    return told


def stays(poses, rate, rng):
    """The robot does not move."""
    return [poses[0]] * len(poses)


def leaning(roll, pitch):
    """The robot leans by so much, and its odometry tells it."""
    lean = Pose.of_rpy((0, 0, 0), (roll, pitch, 0))
    return lambda poses, rate, rng: [pose @ lean for pose in poses]


def bumpy(poses, rate, rng, degrees=2.0):
    """The robot pitches as it drives over bumps, for a tenth of a second each."""
    bumps, share, lean = np.zeros(len(poses)), np.exp(-1 / (0.1 * rate)), rng.normal()
    for k in range(len(poses)):
        bumps[k] = lean
        lean = share * lean + np.sqrt(1 - share**2) * rng.normal()
    angles = np.radians(degrees) * bumps
    return [p @ Pose.of_rpy((0, 0, 0), (0, a, 0)) for p, a in zip(poses, angles, strict=True)]


def far_away(poses, rate, rng):
    """In UTM, where nobody has chosen another origin."""
    return [Pose(pose.t + np.array([500_000.0, 4_600_000.0, 0]), pose.R) for pose in poses]


@dataclass(frozen=True)
class Robot:
    """A robot that somebody has.

    :ivar moves: what its way becomes; odometry: what is told of that; each of poses, rate, rng.
    :ivar diameters: of the colors as told; factor: the true ones, by object in turn.
    :ivar table: how high above the ground objects stand [m].
    :ivar walls: half of the width of the room, at whose walls what rolls bounces [m].
    """

    scene: Scene = field(default_factory=Scene)
    moves: Callable = same
    odometry: Callable = same
    angles: float = 0.35
    ahead: float = 0.0
    diameters: tuple = (0.2,)
    heights: tuple = ()
    factor: tuple = (1.0,)
    table: float = 0.0
    walls: float = np.inf
    speed: float = 0.15
    start: int = 1_000_000_000 * 10**9
    rate_told: dict = field(default_factory=dict)


def mounted(xyz, rpy, camera=CAMERA, **scene):
    return Scene(camera, Pose.of_rpy(xyz, rpy), **scene)


ROBOTS = {
    'as usual': Robot(),
    'looks to the left': Robot(mounted((0, 0.1, 0.5), (0, 0.25, np.pi / 2)), ahead=np.pi / 2),
    '0.15 m high, balls of 6 cm': Robot(
        mounted((0.1, 0, 0.15), (0, 0.1, 0), reach=(0.4, 2.0)), diameters=(0.06,)
    ),
    '0.15 m high, balls of 20 cm': Robot(mounted((0.1, 0, 0.15), (0, 0.05, 0), reach=(0.6, 3.0))),
    'on the ceiling': Robot(
        mounted((0, 0, 3.0), (0, np.pi / 2, 0), reach=(0.1, 1.2)), moves=stays, angles=np.pi
    ),
    'fisheye of 220 degrees': Robot(
        mounted((0, 0, 0.6), (0, 0.3, 0), DOME, reach=(0.6, 3.0)), angles=1.3
    ),
    'odometry at 5 Hz': Robot(odometry=at_5_hz),
    'odometry at 5 Hz, told': Robot(odometry=at_5_hz, rate_told={'odometry_sigma': (0.02, 0.02)}),
    'odometry 50 ms old': Robot(odometry=old(0.05)),
    'odometry 50 ms ahead': Robot(odometry=old(-0.05)),
    'odometry 100 ms old': Robot(odometry=old(0.1)),
    'odometry 100 ms ahead': Robot(odometry=old(-0.1)),
    'UTM': Robot(moves=far_away),
    'stamps from 0 on': Robot(start=0),
    'three diameters, a color each': Robot(diameters=(0.07, 0.2, 0.4)),
    'three diameters, one color': Robot(factor=(0.7, 1.0, 1.5)),
    'leans by 8 degrees, told': Robot(moves=leaning(0.05, 0.14)),
    'pitch of bumps, 2 degrees': Robot(odometry=same, moves=bumpy),
    'pitch of bumps, 2 degrees, not told': Robot(moves=lambda p, r, g: p, odometry=bumpy),
    'bounces off walls': Robot(walls=1.0, speed=0.6),
    'on a table of 0.5 m': Robot(table=0.5, scene=mounted((0.1, 0, 0.9), (0, 0.25, 0))),
    'tall cones': Robot(diameters=(0.0,), heights=(0.25,)),
    '7 Hz': Robot(Scene(rate=7.0)),
}


def config_for(robot, method):
    heights = robot.heights or [d / 2 for d in robot.diameters]
    kinds = tuple(
        Kind(
            f'c{i}', KindConfig(diameter=d, height=h, speed=max(robot.speed, 0.15), wander=WANDERS)
        )
        for i, (d, h) in enumerate(zip(robot.diameters, heights, strict=True))
    )
    return LocatorConfig(method=method, colors=kinds, camera_pose_sigma=SIGMA, **robot.rate_told)


def placed(robot, kinds, colors, errors, rng, count):
    """The first states, (count, 16); the first half stands."""
    truth = np.zeros((count, 16))
    away = rng.uniform(*robot.scene.reach, count)
    angle = robot.ahead + rng.uniform(-robot.angles, robot.angles, count)
    truth[:, 0], truth[:, 1] = away * np.cos(angle), away * np.sin(angle)
    truth[:, BIASES] = rng.normal(size=(count, 2)) * kinds.sigma
    truth[:, 7] += kinds.diameter * (np.resize(robot.factor, count) - 1)
    truth[:, 2] = kinds.height + truth[:, HEIGHT] + robot.table
    if len(robot.factor) > 1:
        truth[:, 2] += truth[:, 7] / 2
    truth[count // 2 :, 3:5] = robot.speed * rng.normal(size=(count - count // 2, 2))
    truth[:, 8:] = rng.normal(size=8) * np.sqrt(np.diag(errors.first)[:8])
    return truth


def roll(truth, dt, walls, middle, rng):
    """One step, in place."""
    moving = truth[:, 3:5].any(axis=1)
    truth[:, :2] += dt * truth[:, 3:5]
    truth[moving, 3:5] += rng.normal(size=(np.count_nonzero(moving), 2)) * WANDERS * np.sqrt(dt)
    out = (np.abs(truth[:, :2] - middle) > walls) & moving[:, None]
    inward = -np.sign(truth[:, :2] - middle) * np.abs(truth[:, 3:5])
    truth[:, 3:5] = np.where(out, 0.7 * inward, truth[:, 3:5])


def as_cones(tracks, detections, seen):
    """Boxes of what is twice as high as wide, and has no known size, in place."""
    detections['box_w'], detections['box_h'] = 20, 40
    detections['area'] = 500 + np.arange(len(detections))
    detections['box_u'], detections['box_v'] = detections['u'] - 10, detections['v'] - 20
    for name in ('box_w', 'box_h', 'area'):
        tracks[name][seen] = detections[name]


def scored(found, truth, eye):
    """Of rows of locations their errors over the range, and their NEES."""
    e = np.stack([found[a] for a in 'xyz'], axis=1).astype(float) - truth
    cov = found['covariance'].reshape(-1, 6, 6)[:, :3, :3] + 1e-12 * np.eye(3)
    nees = (e * np.linalg.solve(cov, e[..., None])[..., 0]).sum(axis=1)
    return np.linalg.norm(e, axis=1) / np.linalg.norm(truth - eye, axis=1), nees


def once(robot, method, seed, count=6):
    """Of one run: errors over range, NEES over 3, with the time, whether silent, and lines."""
    rng, scene, config = np.random.default_rng(seed), robot.scene, config_for(robot, method)
    colors = np.resize(np.arange(len(robot.diameters)), count)
    kinds, errors = Kinds.of(config).take(colors), CameraErrors.of(config)
    truth = placed(robot, kinds, colors, errors, rng, count)
    way = list(bases(scene, True))
    real = robot.moves(way, scene.rate, rng)
    before = came(real, scene.rate)
    told_poses = robot.odometry(before + real, scene.rate, rng)
    odometry = list(zip(told_poses, ways(told_poses, scene.rate), strict=True))
    if robot.moves is far_away:
        truth[:, :2] += real[0].t[:2]
    middle, lines, rows = truth[:, :2].mean(axis=0), [], []
    locator = Locator(config, lines.append)
    for k, (base, told) in enumerate(zip(real, odometry[len(before) :], strict=True)):
        if k:
            roll(truth, scene.dt, robot.walls, middle, rng)
        there = View(scene.camera, base, scene.mount)
        measured, seen = measure(there, truth, kinds, 'fused', 'rolls', rng)
        seen = seen & scene.camera.contains(measured.z[:, :2])
        stamp = robot.start + round((k + 1) * 1e9 * scene.dt)
        tracks, detections = as_seen(measured.z, seen, config, stamp)
        tracks.rows['color'], detections.rows['color'] = colors, colors[seen]
        if not kinds.diameter.any():
            as_cones(tracks.rows, detections.rows, seen)
        view = View(scene.camera, told[0], scene.mount, told[1])
        found = locator.update(tracks, detections, view).rows
        of = found['track_id'] - 1
        scores = scored(found, truth[of, :3], there.optical.t)
        since = np.full(len(of), k * scene.dt)
        rows.append(np.stack([since, *scores, of >= count // 2, seen[of], of + count * seed]))
    return np.concatenate(rows, axis=1).T, locator.doubt, lines


def cell(rows):
    """The figures of some rows."""
    late = rows[(rows[:, 0] >= SETTLED) & (rows[:, 4] > 0)]
    if not len(late):
        return 'nothing published'
    out, seen = rows[:, 2] > OUTSIDE, rows[:, 4] > 0
    shares = [100 * out[which].sum() / max(which.sum(), 1) for which in (seen, ~seen)]
    return (
        f'{100 * np.sqrt(np.mean(late[:, 1] ** 2)):5.1f} % {rows[:, 2].mean() / 3:6.2f} '
        f'{np.median(rows[:, 2]) / MEDIAN:5.2f} {shares[0]:5.1f} {shares[1]:5.1f} % '
        f'of {len(np.unique(rows[out, 5])):2d}'
    )


def main():
    parser = argparse.ArgumentParser('world_strangers', description=__doc__)
    parser.add_argument('names', nargs='*')
    parser.add_argument('--runs', type=int, default=10)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--methods', nargs='+', default=['ground', 'size'])
    a = parser.parse_args()
    for name, robot in ROBOTS.items():
        if a.names and not any(n in name for n in a.names):
            continue
        for method in a.methods:
            if method == 'size' and not all(robot.diameters):
                continue
            runs = [once(robot, method, a.seed + k) for k in range(a.runs)]
            rows = np.concatenate([r for r, _, _ in runs])
            silent = [doubt for _, doubt, _ in runs if doubt]
            cells = [cell(rows[rows[:, 3] == moving]) for moving in (0, 1)]
            lines = [line for _, _, told in runs for line in told]
            print(
                f'{name:36s} {method:6s} stand {cells[0]} | roll {cells[1]} | rows {len(rows):5d}, '
                f'silent {len(silent)}, lines {len(lines)}'
            )
            for line in sorted({*(x[:110] for x in silent), *(x[:110] for x in lines[:2])}):
                print('      ', line)


if __name__ == '__main__':
    main()
