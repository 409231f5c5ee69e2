"""Whether what is seen would stand if the camera were mounted otherwise, as by a common mistake.

A camera that is upside down, that looks elsewhere, or has the calibration of another picture gives
places that move whenever the robot does. Each mistake is tried on the pictures of the last seconds:
where one of them makes most of what they show stand, and the given pose of the camera does not, it
has been made. What really moves stands by none of them, so nothing has to be known of the objects
but what gives their range.
"""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import ranges_by_size
from colortrack_ros.world.measurement import U
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

Floats = NDArray[np.float64]
BETWEEN, LOOKS_BACK = 0.2, 4.0
"""Time between the pictures that are looked at, and how long they are kept [s]: at 0.5 m/s a robot
drives 2 m in it. Chosen."""

LEAST_SEEN = 8
"""Pictures that must show an object: 1.6 s of the 4. Chosen."""

AT_REST = 0.025
"""Spread of the places of what stands, as a share of its distance. By the ground it is 0.011 for
0.5 px at 2.5 to 5 m from a camera 0.5 m high that drives, and more if its pitch is off by a degree
or two; by sizes and depths 0.002."""

WORSE, LEAST = 10.0, 0.05
"""How many times as much the places by the given pose must spread, and how much at least: by the
mistakes of the list they spread 0.1 to 0.8. Of what rolls, seen by right cameras, 5 times has been
seen by chance in 4 of 60 runs of 10 s, 10 times in none of 240."""

AGREEING = 3
"""Successive pictures that must say the same. Chosen."""

UNSEEN = 10**18
"""Before the first picture [ns]."""

SIDEWAYS, UPSIDE = np.diag([1.0, -1.0, 1.0]), np.diag([1.0, 1.0, -1.0])
"""Mirrors of left and right, and of up and down, which turn the signs of yaw and of pitch."""

T = TypeVar('T')


def _as_given(what: T) -> T:
    return what


@dataclass
class _Sights(Columns):
    """What pictures have shown, one row for each object in each.

    :ivar stamp: (M,) of the picture [ns].
    :ivar track: (M,) IDs.
    :ivar measured, kinds: of each.
    :ivar rays: (M, 3) in the optical frame.
    :ivar far: (M,) along the ray, by depth or size [m]; NaN where the ground tells it.
    """

    stamp: NDArray[np.int64]
    track: NDArray[np.int64]
    measured: Measured
    kinds: Kinds
    rays: Floats
    far: Floats

    @classmethod
    def of(
        cls, stamp: int, track: NDArray[np.uint32], measured: Measured, kinds: Kinds, view: View
    ) -> '_Sights':
        """Those of one picture."""
        seen = measured.used[:, U]
        measured, kinds = measured.take(seen), kinds.take(seen)
        rays, far = _rays(measured, kinds, view.camera)
        stamps = np.full(len(rays), stamp, np.int64)
        return cls(stamps, track[seen].astype(np.int64), measured, kinds, rays, far)


def _rays(measured: Measured, kinds: Kinds, camera: CameraModel) -> tuple[Floats, Floats]:
    """The rays of what a camera has measured, and how far along them: see :class:`_Sights`."""
    rays, far = camera.rays(measured.z[:, :2]), np.full(len(kinds), np.nan)
    sized = measured.used[:, BLOB] & ~measured.used[:, PLANE]
    if sized.any():
        by_size = ranges_by_size(camera, rays, measured.z[:, BLOB], kinds.diameter)
        far[sized] = by_size[sized]
    return rays, np.where(measured.used[:, DEPTH], measured.z[:, DEPTH] / rays[:, 2], far)


@dataclass(frozen=True)
class Mistake:
    """How things would be if it had been made; of what is not named, as given.

    :ivar mount, base: of the poses of the camera on the robot and of the robot, of V pictures at
        once: t (V, 3), R (V, 3, 3).
    :ivar camera: of the lens.
    """

    mount: Callable[[Pose], Pose] = _as_given
    base: Callable[[Pose], Pose] = _as_given
    camera: Callable[[CameraModel], CameraModel] = _as_given


def _scaled(share: float) -> Mistake:
    """With a camera matrix of a picture so many times as large."""
    return Mistake(camera=lambda camera: replace(camera, K=np.diag([share, share, 1.0]) @ camera.K))


def _rolled(degrees: float) -> Mistake:
    own = Pose.of_rpy(np.zeros(3), (np.radians(degrees), 0, 0))
    return Mistake(lambda mount: mount @ own)


def _yawed(degrees: float) -> Mistake:
    turn = Pose.of_rpy(np.zeros(3), (0, 0, np.radians(degrees))).R
    return Mistake(lambda mount: Pose(mount.t, turn @ mount.R))


def _mirrored(pose: Pose, mirror: Floats) -> Pose:
    """Its rotation as a mirror shows it, (3, 3) diagonal."""
    return Pose(pose.t, mirror @ pose.R @ mirror)


MISTAKES: dict[str, Mistake] = {
    'camera_pose has roll 0 for a camera that is upside down, or pi for one that is not': (
        _rolled(180)
    ),
    'the camera lies on its side, and camera_pose has roll off by pi/2': _rolled(90),
    'the camera lies on its side, and camera_pose has roll off by -pi/2': _rolled(-90),
    'the pitch of camera_pose has the wrong sign: positive looks down': Mistake(
        lambda mount: _mirrored(mount, UPSIDE)
    ),
    'the camera looks backward: the yaw of camera_pose is off by pi': _yawed(180),
    'the yaw of camera_pose is off by pi/2: positive looks left': _yawed(90),
    'the yaw of camera_pose is off by -pi/2: positive looks left': _yawed(-90),
    'camera_pose is of the optical frame, expected of the body, x forward, z up': Mistake(
        lambda mount: mount @ OPTICAL.inverse()
    ),
    'the frame of the pictures is the body of the camera, expected the optical frame': Mistake(
        lambda mount: mount @ OPTICAL
    ),
    'the height of the camera has the wrong sign': Mistake(
        lambda mount: Pose(mount.t * [1, 1, -1], mount.R)
    ),
    'the calibration is of pictures half as large': _scaled(2.0),
    'the calibration is of pictures twice as large': _scaled(0.5),
    'odometry goes backward where the robot drives forward': Mistake(
        base=lambda base: Pose(-base.t, base.R)
    ),
    'odometry turns right where the robot turns left': Mistake(
        base=lambda base: _mirrored(Pose(base.t * [1, -1, 1], base.R), SIDEWAYS)
    ),
}
"""What is told of each, and what would mend it."""

AS_GIVEN = Mistake()


class Mistakes:
    """Watches the pictures of one camera for a mistake."""

    def __init__(self) -> None:
        self._views: dict[int, View] = {}
        self._sights: _Sights | None = None
        self._suspected = self._looks = 0
        self.made = ''

    def see(
        self,
        stamp: int,
        view: View,
        tracks: NDArray[np.uint32],
        measured: Measured,
        kinds: Kinds,
        ground: float,
    ) -> None:
        """Take a picture, and find out whether a mistake is made, or is no longer.

        :param tracks: (K,) IDs; measured, kinds: of each.
        :param ground: its height in the fixed frame [m].
        """
        last = max(self._views, default=stamp - UNSEEN)
        if 0 <= stamp - last < BETWEEN * NANOSECONDS:
            return
        new = _Sights.of(stamp, tracks, measured, kinds, view)
        self._judge(self._take(stamp, view, new), ground)

    def _take(self, stamp: int, view: View, new: _Sights) -> _Sights:
        """Keep what a picture shows, and forget what is old."""
        if self._sights is None or stamp < max(self._views):
            self._sights, self._views = new, {}
        else:
            self._sights.extend(new)
        since = stamp - round(LOOKS_BACK * NANOSECONDS)
        self._views = {stamp: view for stamp, view in self._views.items() if stamp > since} | {
            stamp: view
        }
        self._sights.keep(self._sights.stamp > since)
        return self._sights

    def _judge(self, sights: _Sights, ground: float) -> None:
        """Find the mistake that explains what moves, or that it no longer does."""
        _, of, count = np.unique(sights.track, return_inverse=True, return_counts=True)
        if count.max(initial=0) < LEAST_SEEN:
            return
        order = np.argsort(of, kind='stable')
        sights = sights.take(order[count[of[order]] >= LEAST_SEEN])
        (given,) = self._spreads(sights, [AS_GIVEN], ground)
        if self.made:
            (other,) = self._spreads(sights, [MISTAKES[self.made]], ground)
            if given < AT_REST and other > WORSE * given:
                self.made = ''
        elif given > LEAST:
            spreads = self._spreads(sights, list(MISTAKES.values()), ground)
            least = int(np.argmin(spreads))
            fits = spreads[least] < min(AT_REST, given / WORSE)
            self._looks = self._looks + 1 if fits and least == self._suspected else int(fits)
            self._suspected = least
            if self._looks >= AGREEING:
                self.made = list(MISTAKES)[least]

    def _spreads(self, sights: _Sights, mistakes: list[Mistake], ground: float) -> Floats:
        """How much places move if a mistake is made, as a share of their distance: (C,).

        The median over objects; infinite if most of it would be nowhere.

        :param sights: (M,), those of one object after those of another.
        """
        views = list(self._views.values())
        base, mount = (
            Pose(*(np.stack([getattr(getattr(v, of), name) for v in views]) for name in 'tR'))
            for of in ('base', 'mount')
        )
        picture = np.searchsorted(list(self._views), sights.stamp)
        optical = [m.base(base) @ (m.mount(mount) @ OPTICAL) for m in mistakes]
        eyes, R = (np.stack([getattr(o, name) for o in optical])[:, picture] for name in 'tR')
        rays, far = np.stack([sights.rays] * len(R)), np.stack([sights.far] * len(R))
        for row, mistake in enumerate(mistakes):
            if mistake.camera is not _as_given:
                camera = mistake.camera(views[-1].camera)
                rays[row], far[row] = _rays(sights.measured, sights.kinds, camera)
        way = (R @ rays[..., None])[..., 0]
        with np.errstate(divide='ignore', invalid='ignore'):
            by_plane = (ground + sights.kinds.height - eyes[..., 2]) / way[..., 2]
        far = np.where(np.isnan(far), by_plane, far)
        far = np.where(far > 0, far, np.nan)
        moved = _spread_of_each(eyes + way * far[..., None], far, sights.track)
        return np.asarray(np.median(np.nan_to_num(moved, nan=np.inf), axis=1))


def _spread_of_each(places: Floats, far: Floats, track: NDArray[np.int64]) -> Floats:
    """Root mean square of the distances of places from their mean, over that from the camera.

    :param places: (C, M, 3); far: (C, M).
    :param track: (M,) the object of each, those of one after those of another.
    :return: (C, K) of each object.
    """
    first = np.flatnonzero(np.append(True, track[1:] != track[:-1]))
    count = np.diff(np.append(first, len(track)))
    mean = np.add.reduceat(places, first, axis=1) / count[:, None]
    away = np.square(places - np.repeat(mean, count, axis=1)).sum(axis=-1)
    spread = np.sqrt(np.add.reduceat(away, first, axis=1) / count)
    return np.asarray(spread * count / np.add.reduceat(far, first, axis=1))
