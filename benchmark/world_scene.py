"""Objects before a camera as world.py draws them: where they are, and what is measured."""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.course import way_at
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import PLANE_SIGMA
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import PoseBuffer
from colortrack_ros.world.settling import settle
from colortrack_ros.world.state import BIASES
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import HEIGHT

CAMERA = CameraModel.of(
    640, 480, (520, 0, 320, 0, 520, 240, 0, 0, 1), (-0.28, 0.09, 1e-3, -8e-4, -0.01)
)
MOUNT = Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))
RATE, SECONDS = 30.0, 6.0
SETTLED = 2.0
DT = 1 / RATE
PITCH = 1.0


@dataclass(frozen=True)
class Scene:
    """A camera on a robot, its rate [Hz], and how far away objects are at first [m]."""

    camera: CameraModel = CAMERA
    mount: Pose = MOUNT
    rate: float = RATE
    reach: tuple[float, float] = (1.5, 5.0)

    @property
    def dt(self):
        """Time from picture to picture [s]."""
        return 1 / self.rate


HERE = Scene()
FISHEYE = CameraModel.of(
    800, 600, (300, 0, 400, 0, 300, 300, 0, 0, 1), (0.02, -0.01, 0.0, 0.0), 'equidistant'
)
TELE = CameraModel.of(1280, 720, (1400, 0, 640, 0, 1400, 360, 0, 0, 1))
ELSEWHERE = {
    'low, level, near': Scene(mount=Pose.of_rpy((0.1, 0, 0.2), (0, 0.05, 0)), reach=(0.5, 2.5)),
    'high, steep': Scene(mount=Pose.of_rpy((0, 0, 1.5), (0, 0.7, 0)), reach=(1.0, 3.0)),
    'high, far, tele': Scene(TELE, Pose.of_rpy((0.2, 0.1, 1.2), (0, 0.2, 0)), reach=(3.0, 8.0)),
    'fisheye, 10 Hz': Scene(FISHEYE, Pose.of_rpy((0, 0, 0.8), (0, 0.4, 0)), 10.0, (0.8, 4.0)),
    'straight down': Scene(mount=Pose.of_rpy((0, 0, 2.5), (0, np.pi / 2, 0)), reach=(0.2, 1.0)),
    '60 Hz': Scene(rate=60.0),
}
"""Other cameras, places, rates and ranges: nothing was chosen by them."""
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


def config_of(method, motion, pitch=PITCH):
    told = {'speed': max(SPEED[motion]), 'wander': max(WANDER[motion], 0.05)}
    kind = KindConfig(diameter=0.2, motion=MOTIONS[motion], **({} if motion == 'rests' else told))
    sigma = (0.01, 0.01, 0.01, 0.01, float(np.radians(pitch)), 0.01)
    return LocatorConfig(method=method, colors=(Kind('red', kind),), camera_pose_sigma=sigma)


def truths(scene, motion, runs, objects, kinds, errors, rng):
    """The first states, (runs * objects, 16); those of one run share the errors of its camera."""
    count = runs * objects
    truth = np.zeros((count, 16))
    away, angle = rng.uniform(*scene.reach, count), rng.uniform(-0.35, 0.35, count)
    truth[:, 0], truth[:, 1] = away * np.cos(angle), away * np.sin(angle)
    truth[:, BIASES] = rng.normal(size=(count, 2)) * kinds.sigma
    off = rng.normal(size=(runs, 8)) * np.sqrt(np.diag(errors.first)[:8])
    truth[:, 8:] = np.repeat(off, objects, axis=0)
    truth[:, 2] = kinds.height + truth[:, HEIGHT]
    if motion == 'bounces':
        truth[:, 2] = rng.uniform(0.5, 1.0, count)
    truth[:, 3:6] = rng.normal(size=(count, 3)) * SPEED[motion]
    return truth


def move(truth, dt, motion, rng):
    """One step of the true states, in place."""
    count = len(truth)
    truth[:, :3] += dt * truth[:, 3:6]
    truth[:, 3:5] += rng.normal(size=(count, 2)) * WANDER[motion] * np.sqrt(dt)
    if motion == 'bounces':
        truth[:, 2] -= GRAVITY * dt * dt / 2
        truth[:, 5] -= GRAVITY * dt
        down = (truth[:, 2] < 0.1) & (truth[:, 5] < 0)
        share = rng.normal(*RESTITUTION, count)[down]
        truth[down, 2] = 0.1 + share * (0.1 - truth[down, 2])
        truth[down, 5] *= -share


def bases(scene, drives):
    """Where the robot is in each frame."""
    x = y = yaw = 0.0
    dt = scene.dt
    for k in range(round(SECONDS * scene.rate)):
        yield Pose.of_rpy((x, y, 0), (0, 0, yaw))
        if drives:
            yaw += dt * np.radians(60) * np.sin(2 * np.pi * k * dt / 3)
            x, y = x + 0.5 * dt * np.cos(yaw), y + 0.5 * dt * np.sin(yaw)


def came(poses, rate):
    """Where the robot was in the second before its poses: it came as it drives on."""
    return [Pose(2 * poses[0].t - poses[k].t, poses[k + 1].R) for k in range(round(rate), 0, -1)]


def buffered(poses, rate):
    """A buffer with poses at a rate, and their stamps."""
    buffer = PoseBuffer('odom', 'base_link')
    stamps = [round((k + 1) * NANOSECONDS / rate) for k in range(len(poses))]
    for stamp, pose in zip(stamps, poses, strict=True):
        buffer.add(stamp, pose)
    return buffer, stamps


def ways(poses, rate):
    """How the robot moves at each of its poses, as a node reads it; at first that is not known."""
    buffer, stamps = buffered(poses, rate)
    return [way_at(buffer.at, *each) for each in zip(stamps, poses, strict=True)]


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
        np.where(used, z + noise, 0.0), np.square(sigma)[:, :, None] * np.eye(5), used,
        np.zeros(z.shape),
    )  # fmt: skip
    return measured, seen


def look(table, measured, view, begun, way, k, dt):
    """Predict by a step to picture k, and update, as the locator does; way: of the robot since."""
    belief, (before, now) = table.belief, (round(i * dt * NANOSECONDS) for i in (k - 1, k))
    belief.forget(dt)
    belief.predict(table.kinds, 0.0, dt, table.updated < before)
    belief.drift(view.base.t, way, 0.0, np.zeros(2))
    refused = belief.update(measured, view, table.kinds, 0.0)
    refused[begun] = table.kick(refused & begun, measured, view, 0.0, 0, (before, now))[begun]
    settle(belief, table.kinds)
    table.updates[measured.used.any(axis=1) & ~refused] = now


def as_seen(z, seen, config, stamp):
    """Tracks and detections of what is measured, (N, ...); those that are not seen have no row."""
    tracks, rows = np.zeros(len(seen), TRACK), np.zeros(len(seen), DETECTION)
    rows['u'], rows['v'] = z[:, :2].T
    size = np.maximum(z[:, BLOB] - config.eroded, 1.0)
    rows['area'], rows['box_w'], rows['box_h'] = np.pi / 4 * size**2, size, size
    rows['box_u'], rows['box_v'] = rows['u'] - size / 2, rows['v'] - size / 2
    rows['cov_uu'] = rows['cov_vv'] = 0.25
    for name in ('u', 'v', 'area', 'box_w', 'box_h'):
        tracks[name] = rows[name]
    tracks['track_id'], tracks['state'] = np.arange(len(seen)) + 1, CONFIRMED
    tracks['time_since_update'] = ~seen
    return Tracks(tracks, stamp), Detections(rows[seen], stamp)
