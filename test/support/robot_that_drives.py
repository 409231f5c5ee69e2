"""A robot that drives among balls of one color, and a tracker that knows where its camera is."""

from dataclasses import replace
import sys

import numpy as np
from support.paths import ROOT
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import CONFIRMED
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.view import View

sys.path.append(str(ROOT / 'benchmark'))

from world import CAMERA
from world import MOUNT

RADIUS = 0.12
BALLS = np.array([(2.5, -0.4, RADIUS), (3.0, 1.5, RADIUS), (1.5, 2.5, RADIUS), (3.4, -1.6, RADIUS)])
"""Balls of one color that lie on the ground."""


def driving(seconds, speed=0.5, turn=60.0, period=4.0):
    """Yield poses of a robot that drives back and forth and swings, by frame: x, y, yaw."""
    x, y, yaw = 0.0, 0.0, 0.0
    for k in range(round(seconds * 1e9 / FRAME)):
        t = k * FRAME / 1e9
        yield x, y, yaw
        way = (speed if t // period % 2 == 0 else -speed) * FRAME / 1e9
        yaw += np.radians(turn) * np.sin(t) * FRAME / 1e9
        x, y = x + way * np.cos(yaw), y + way * np.sin(yaw)


def blobs(view, balls, rng):
    """Return the detections of balls, (K, 3), and the pixels of each, NaN if unseen."""
    optical = view.optical.inverse().apply(balls)
    z = CAMERA.project(optical)
    radius = CAMERA.K[0, 0] * RADIUS / np.where(optical[:, 2] > 0.1, optical[:, 2], np.inf)
    z[~(CAMERA.contains(z - radius[:, None]) & CAMERA.contains(z + radius[:, None]))] = np.nan
    (seen,) = np.isfinite(z[:, 0]).nonzero()
    found = points(z[seen] + rng.normal(0, 0.5, (len(seen), 2)), 0, 0.25)
    rows, r = found.rows, np.round(radius[seen])
    rows['box_u'], rows['box_v'] = rows['u'] - r, rows['v'] - r
    rows['box_w'] = rows['box_h'] = 2 * r
    rows['area'] = np.pi * r**2
    return found, z


def of_a_robot_that_drives(poses, balls_at=lambda k: BALLS, odometry=lambda pose: pose, **config):
    """Yield, by frame, the tracks and the pixels of balls, NaN if unseen.

    :param balls_at: returns the positions of the balls in a frame, (K, 3).
    :param odometry: maps a pose to the one that odometry reports.
    """
    rng, tracker = np.random.default_rng(0), Tracker(TrackerConfig(**config))
    for k, pose in enumerate(poses):
        views = []
        for x, y, yaw in (pose, odometry(pose)):
            views.append(View(CAMERA, Pose.of_rpy((x, y, 0), (0, 0, yaw)), MOUNT))
        found, z = blobs(views[0], balls_at(k), rng)
        found = replace(found, stamp=k * FRAME, image_size=(640, 480), viewpoint=views[1])
        yield tracker.update(found).rows, z


def ids_of_things(frames):
    """Return the IDs that each object has had."""
    ids = {}
    for names in named(frames):
        for thing, name in names:
            ids.setdefault(thing, set()).add(name)
    return ids


def named(frames):
    """Yield, by frame, pairs of an object and the ID of the confirmed track at its place."""
    for rows, z in frames:
        rows = rows[rows['state'] == CONFIRMED]
        away = np.hypot(z[:, 0] - rows['u'][:, None], z[:, 1] - rows['v'][:, None])
        yield zip(map(int, np.nanargmin(away, axis=1)), map(int, rows['track_id']), strict=True)
