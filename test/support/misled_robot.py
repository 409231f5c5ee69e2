"""A robot before balls, whose locator may be told something wrong of its camera."""

import sys

import numpy as np
from support.balls_seen import RADIUS
from support.balls_seen import seen
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

from world import CAMERA
from world import MOUNT

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.view import View

FRAME = 33_333_333
BALLS = np.array([(2.5, 0.5, RADIUS), (3.5, -0.5, RADIUS), (4.0, 0.2, RADIUS)])
STANDING = 30
"""Pictures before the robot moves."""


class Robot:
    """A robot that looks at balls, stands for a second, and then drives and swings."""

    def __init__(self, told_diameter=0.0, method='ground', thrown=False, motion='plane', **config):
        ball = KindConfig(diameter=told_diameter, height=RADIUS, motion=motion)
        kinds = [Kind('red', ball)]
        if thrown:
            kinds += [Kind('green', KindConfig(diameter=told_diameter, motion='free'))]
        self.told, self.rng = [], np.random.default_rng(0)
        config = LocatorConfig(method=method, colors=tuple(kinds), **config)
        self.locator = Locator(config, self.told.append)
        self.k, self.thrown = 0, thrown

    def see(
        self, balls=BALLS, camera=CAMERA, mount=MOUNT, odometry=lambda *way: way, really=MOUNT,
        ids=None,
    ):  # fmt: skip
        """The objects after one more picture, by a camera that is really somewhere else."""
        t = max(self.k - STANDING, 0) * FRAME / 1e9
        x, yaw = 0.3 * t, 0.3 * np.sin(2 * t)
        self.k += 1
        tracks, detections = seen(view(x, yaw, mount=really), balls, self.k * FRAME, ids)
        for rows, of in ((tracks.rows, balls), (detections.rows, balls[::-1])):
            rows['color'] = of[:, 2] > RADIUS if self.thrown else 0
        noise = 0.3 * self.rng.normal(size=(2, len(balls)))
        detections.rows['u'] += noise[0]
        detections.rows['v'] += noise[1]
        return self.locator.update(tracks, detections, view(*odometry(x, yaw), camera, mount))

    def drive(self, pictures, **wrong):
        return [len(self.see(**wrong).rows) for _ in range(pictures)]


def view(x, yaw, camera=CAMERA, mount=MOUNT):
    return View(camera, Pose.of_rpy((x, 0, 0), (0, 0, yaw)), mount)
