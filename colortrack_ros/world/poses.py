"""Poses: rigid motions, and a buffer of poses over time, as in tf2."""

from bisect import bisect_left
from bisect import insort
from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS

CACHE = 10.0
"""Time for which poses are kept [s]: tf2's default cache time."""

WENT_BACK = 0.5
"""Time [s] by which a pose is older than the newest only if time has gone back, as when a
simulation or a short bag starts again. Chosen: robots send odometry at 10 Hz or more."""

SPARSE, APART = 0.05, 0.5
"""Interval between poses [s] above which the path is interpolated as a curve, and largest interval
for that. A robot whose turn rate swings by 60 degrees/s within 3 s deviates from the chord by 0.04
degrees in 0.05 s, half a pixel at f = 700 px, and by 0.6 degrees in 0.2 s."""

HARDEST = 5.0, 15.0
"""Accelerations [m/s^2], [rad/s^2] above which a curve is a jump or noise rather than a robot's
motion: the path is interpolated linearly. Assumed."""

UNIT_TOLERANCE = 1e-2
"""Largest deviation of a quaternion's squared norm from 1, as in tf2: drivers round, or add up
turns in single precision. It is normalized."""

FARTHEST_ON_EARTH = 1e8
"""Largest coordinate [m]: those of UTM and of the Earth's center are below 1.1e7 on Earth."""


class TransformError(ValueError):
    """A pose is not available.

    :ivar later: whether a later pose may provide it, so that waiting helps.
    """

    def __init__(self, reason: str, later: bool = False) -> None:
        super().__init__(reason)
        self.later = later


@dataclass(frozen=True, eq=False)
class Pose:
    """Pose of a frame in its parent: a point p of the frame is at R p + t in the parent.

    :param t: (3,) [m].
    :param R: (3, 3) rotation.
    """

    t: Floats
    R: Floats

    @classmethod
    def of_rpy(cls, xyz: ArrayLike, rpy: ArrayLike) -> 'Pose':
        """Create from fixed-axis roll, pitch, yaw [rad], as REP-103: R = Rz(yaw) Ry(pitch)
        Rx(roll).
        """
        (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
        R = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
        return cls(np.asarray(xyz, float), np.array(R))

    @classmethod
    def of_quaternion(cls, xyz: ArrayLike, xyzw: ArrayLike) -> 'Pose':
        """Create from a quaternion in the order of geometry_msgs.

        :raises TransformError: it is no rotation, or numbers are not finite, or not on Earth.
        """
        t, q = np.asarray(xyz, float), np.asarray(xyzw, float)
        length = math.hypot(*q.tolist())
        if not (
            abs(length * length - 1) < UNIT_TOLERANCE and (np.abs(t) < FARTHEST_ON_EARTH).all()
        ):
            raise TransformError(
                f'pose with position {t.tolist()} and quaternion {q.tolist()}: expected numbers '
                f'below {FARTHEST_ON_EARTH:g} m and a quaternion of length 1'
            )
        return cls(t, rotation_of(q / length))

    @property
    def quaternion(self) -> Floats:
        """Rotation as a quaternion x, y, z, w, with w >= 0."""
        # the eigenvector of Bar-Itzhack (2000) is exact at every angle, unlike the trace formulas
        R = self.R
        K = np.array(
            [
                [R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
                [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
                [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)],
            ]
        )
        q = np.linalg.eigh(K, UPLO='L')[1][:, -1]
        return np.asarray(q if q[3] >= 0 else -q)

    @property
    def turn(self) -> Floats:
        """Rotation vector, (3,) [rad]."""
        q = self.quaternion
        sine = float(np.linalg.norm(q[:3]))
        return np.asarray(2 * math.atan2(sine, q[3]) / sine * q[:3] if sine > 0 else q[:3])

    def __matmul__(self, other: 'Pose') -> 'Pose':
        """Compose: return a pose in this frame as a pose in this frame's parent.

        Either or both may be arrays of V poses: t (V, 3), R (V, 3, 3).
        """
        return Pose((self.R @ other.t[..., None])[..., 0] + self.t, self.R @ other.R)

    def inverse(self) -> 'Pose':
        """Return the pose of the parent in this frame."""
        return Pose(-self.R.T @ self.t, self.R.T)

    def apply(self, points: Floats) -> Floats:
        """Transform points, (N, 3), from the frame to the parent."""
        return points @ self.R.T + self.t

    def between(self, other: 'Pose', share: float) -> 'Pose':
        """Interpolate to another pose as tf2 does: linear position, and slerp.

        :param share: 0..1 of the way.
        """
        a, b = self.quaternion, other.quaternion
        cosine = float(a @ b)
        a, cosine = (a, cosine) if cosine >= 0 else (-a, -cosine)
        angle = math.acos(min(cosine, 1.0))
        if angle < 1e-6:  # sin(angle) would divide by zero; the chord is as good
            weights = 1 - share, share
        else:
            weights = math.sin((1 - share) * angle), math.sin(share * angle)
        q = weights[0] * a + weights[1] * b
        return Pose(
            (1 - share) * self.t + share * other.t, rotation_of(q / math.sqrt(float(q @ q)))
        )


OPTICAL = Pose(np.zeros(3), np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]]))
"""Optical frame (x right, y down, z forward) in the body of its camera (x forward, y left, z up),
REP-103."""

FULL_TURN = 2 * math.pi + 0.01
"""Largest angle of a camera on a robot [rad], with what somebody rounds off."""

NO_ROBOT = Pose(np.zeros(3), np.eye(3))
"""Base of cameras that are fixed in the room: the fixed frame itself. No odometry tells it, so it
is known by this object, not by its value, which that of a robot at its start may have, too."""


def require_radians(place: Sequence[float]) -> None:
    """Refuse a camera_pose whose angles can only be in degrees.

    :param place: x, y, z [m], roll, pitch, yaw.
    :raises ValueError: they are.
    """
    if max(map(abs, place[3:])) > FULL_TURN:
        raise ValueError(
            f'camera_pose: expected roll, pitch, yaw in rad, -6.28..6.28, got {list(place[3:])}: '
            'are these degrees?'
        )


def rotation_of(q: Floats) -> Floats:
    """Return the rotation matrix of a unit quaternion x, y, z, w."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


class PoseBuffer:
    """Buffers the poses of one frame in another over the last CACHE seconds, like tf2.

    It interpolates between poses. It does not extrapolate, and reports that in the words of tf2.

    :param parent, child: names of the frames, for error messages.
    """

    def __init__(self, parent: str, child: str) -> None:
        self.parent, self.child = parent, child
        self._stamps: list[int] = []
        self._poses: dict[int, Pose] = {}

    def __len__(self) -> int:
        return len(self._stamps)

    def add(self, stamp: int, pose: Pose) -> bool:
        """Add a pose; it replaces one with the same stamp.

        :param stamp: [ns].
        :return: False if it is older than the newest by more than WENT_BACK and was dropped.
        """
        if self._stamps and stamp < self._stamps[-1] - WENT_BACK * NANOSECONDS:
            return False
        if stamp not in self._poses:
            insort(self._stamps, stamp)
        self._poses[stamp] = pose
        while self._stamps[0] < self._stamps[-1] - CACHE * NANOSECONDS:
            del self._poses[self._stamps.pop(0)]
        return True

    def clear(self) -> None:
        """Forget all poses, for example after time has gone back."""
        self._stamps.clear()
        self._poses.clear()

    def latest(self) -> tuple[int, Pose]:
        """Return the newest pose and its stamp [ns].

        :raises TransformError: the buffer is empty.
        """
        if not self._stamps:
            raise TransformError(
                f'no pose of {self.child!r} in {self.parent!r} has come yet', later=True
            )
        return self._stamps[-1], self._poses[self._stamps[-1]]

    def at(self, stamp: int) -> Pose:
        """Return the pose at a time [ns].

        :raises TransformError: the buffer is empty, or does not cover the time.
        """
        newest, _ = self.latest()
        if stamp in self._poses:
            return self._poses[stamp]
        frames = f'when looking up transform from frame [{self.child}] to frame [{self.parent}]'
        if stamp > newest:
            raise TransformError(
                'Lookup would require extrapolation into the future. Requested time '
                f'{stamp / NANOSECONDS:.6f} but the latest data is at time '
                f'{newest / NANOSECONDS:.6f}, {frames}',
                later=True,
            )
        if stamp < self._stamps[0]:
            raise TransformError(
                'Lookup would require extrapolation into the past. Requested time '
                f'{stamp / NANOSECONDS:.6f} but the earliest data is at time '
                f'{self._stamps[0] / NANOSECONDS:.6f}, {frames}'
            )
        after = bisect_left(self._stamps, stamp)
        start, end = self._stamps[after - 1 : after + 1]
        share = (stamp - start) / (end - start)
        pose = self._poses[start].between(self._poses[end], share)
        return self._bent(pose, after, share) if end - start > SPARSE * NANOSECONDS else pose

    def _bent(self, pose: Pose, after: int, share: float) -> Pose:
        """Interpolate between two distant poses, with the acceleration from the pose before them.

        The parabola through three poses deviates from the chord by -share (1 - share) / 2 T^2 a.

        :param after: index of the later one; share: 0..1 of the way to it.
        """
        stamps = self._stamps[max(after - 2, 0) : after + 1]
        before, T = (
            1e-9 * float(step) for step in (stamps[1] - stamps[0], stamps[-1] - stamps[-2])
        )
        if len(stamps) < 3 or max(before, T) > APART:
            return pose
        one, two, three = (self._poses[stamp] for stamp in stamps)
        over = 2 / (before + T)
        a = over * ((three.t - two.t) / T - (two.t - one.t) / before)
        turns = (one.inverse() @ two).turn / before, (two.inverse() @ three).turn / T
        alpha = over * (turns[1] - turns[0])
        if np.linalg.norm(a) > HARDEST[0] or np.linalg.norm(alpha) > HARDEST[1]:
            return pose
        by = -share * (1 - share) / 2 * T * T
        half = np.append(by / 2 * alpha, 1.0)
        return Pose(pose.t + by * a, pose.R @ rotation_of(half / np.linalg.norm(half)))
