"""Odometry that is wrong: what is told of all poses of a robot at the picture of a number."""

import numpy as np

from colortrack_ros.world import Pose


def flat(x=1, y=1, yaw=1, off=0, exchanged=False):
    """Poses with these factors, a frame that is turned by so many degrees, x and y exchanged."""

    def told(poses, k):
        angle = np.arctan2(poses[k].R[1, 0], poses[k].R[0, 0])
        t = poses[k].t[[1, 0, 2]] if exchanged else poses[k].t
        return Pose.of_rpy(t * [x, y, 1], (0, 0, yaw * angle + np.radians(off)))

    return told


def wheels(way=1.0, turn=1.0):
    """Wheels of another radius, or another track: ways and turns are multiplied."""

    def told(poses, k):
        yaw = np.unwrap([np.arctan2(p.R[1, 0], p.R[0, 0]) for p in poses[: k + 1]])
        x, y = np.array([p.t[:2] for p in poses[: k + 1]]).T
        steps, more = np.diff(x + 1j * y), (turn - 1) * (yaw[1:] + yaw[:-1]) / 2
        at = poses[0].t[0] + 1j * poses[0].t[1] + (way * steps * np.exp(1j * more)).sum()
        return Pose.of_rpy((at.real, at.imag, 0), (0, 0, turn * yaw[-1]))

    return told


def dies(poses, k):
    """Repeated from the middle on."""
    return poses[min(k, len(poses) // 2)]
