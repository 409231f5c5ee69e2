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
Change = Callable[[View], View]

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

MIRROR = np.diag([1.0, -1.0, 1.0])


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
        rays, far = _rays(measured, kinds, view)
        stamps = np.full(len(rays), stamp, np.int64)
        return cls(stamps, track[seen].astype(np.int64), measured, kinds, rays, far)


def _rays(measured: Measured, kinds: Kinds, view: View) -> tuple[Floats, Floats]:
    """The rays of what a camera has measured, and how far along them: see :class:`_Sights`."""
    pixels = measured.z[:, :2]
    rays = view.camera.rays(pixels)
    by_size = ranges_by_size(view, pixels, measured.z[:, BLOB], kinds.diameter)
    far = np.where(measured.used[:, PLANE] | ~measured.used[:, BLOB], np.nan, by_size)
    return rays, np.where(measured.used[:, DEPTH], measured.z[:, DEPTH] / rays[:, 2], far)


def _mounted(change: Callable[[Pose], Pose]) -> Change:
    return lambda view: replace(view, mount=change(view.mount))


def _driven(change: Callable[[Pose], Pose]) -> Change:
    return lambda view: replace(view, base=change(view.base))


def _scaled(share: float) -> Change:
    """With a camera matrix of a picture so many times as large."""

    def change(view: View) -> View:
        camera = view.camera
        K = np.diag([share, share, 1.0]) @ camera.K
        return replace(view, camera=CameraModel(K, camera.lens, camera.width, camera.height))

    return change


def _rolled(degrees: float) -> Change:
    own = Pose.of_rpy(np.zeros(3), (np.radians(degrees), 0, 0))
    return _mounted(lambda mount: mount @ own)


def _yawed(degrees: float) -> Change:
    turn = Pose.of_rpy(np.zeros(3), (0, 0, np.radians(degrees))).R
    return _mounted(lambda mount: Pose(mount.t, turn @ mount.R))


def _nodded(mount: Pose) -> Pose:
    """With the opposite pitch."""
    pitch = -np.arcsin(np.clip(mount.R[2, 0], -1, 1))
    return mount @ Pose.of_rpy(np.zeros(3), (0, -2 * pitch, 0))


MISTAKES: dict[str, Change] = {
    'camera_pose has roll 0 for a camera that is upside down, or pi for one that is not': (
        _rolled(180)
    ),
    'the camera lies on its side, and camera_pose has roll off by pi/2': _rolled(90),
    'the camera lies on its side, and camera_pose has roll off by -pi/2': _rolled(-90),
    'the pitch of camera_pose has the wrong sign: positive looks down': _mounted(_nodded),
    'the camera looks backward: the yaw of camera_pose is off by pi': _yawed(180),
    'the yaw of camera_pose is off by pi/2: positive looks left': _yawed(90),
    'the yaw of camera_pose is off by -pi/2: positive looks left': _yawed(-90),
    'camera_pose is of the optical frame, expected of the body, x forward, z up': _mounted(
        lambda mount: mount @ OPTICAL.inverse()
    ),
    'the frame of the pictures is the body of the camera, expected the optical frame': _mounted(
        lambda mount: mount @ OPTICAL
    ),
    'the height of the camera has the wrong sign': _mounted(
        lambda mount: Pose(mount.t * [1, 1, -1], mount.R)
    ),
    'the calibration is of pictures half as large': _scaled(2.0),
    'the calibration is of pictures twice as large': _scaled(0.5),
    'odometry goes backward where the robot drives forward': _driven(
        lambda base: Pose(-base.t, base.R)
    ),
    'odometry turns right where the robot turns left': _driven(
        lambda base: Pose(MIRROR @ base.t, MIRROR @ base.R @ MIRROR)
    ),
}
"""What is told of each, and what would mend it."""


def _as_given(view: View) -> View:
    return view


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
        given = self._spread(sights, of, count, _as_given, ground)
        if self.made:
            other = self._spread(sights, of, count, MISTAKES[self.made], ground)
            if given < AT_REST and other > WORSE * given:
                self.made = ''
        elif given > LEAST:
            spreads = [
                self._spread(sights, of, count, change, ground) for change in MISTAKES.values()
            ]
            least = int(np.argmin(spreads))
            fits = spreads[least] < min(AT_REST, given / WORSE)
            self._looks = self._looks + 1 if fits and least == self._suspected else int(fits)
            self._suspected = least
            if self._looks >= AGREEING:
                self.made = list(MISTAKES)[least]

    def _spread(
        self,
        sights: _Sights,
        of: NDArray[np.intp],
        count: NDArray[np.intp],
        change: Change,
        ground: float,
    ) -> float:
        """How much places move, as a share of their distance: the median over objects.

        Infinite if most of it would be nowhere.

        :param of: (M,) the object of each sight.
        :param count: how many sights there are of each.
        """
        views = [change(view) for view in self._views.values()]
        picture = np.searchsorted(list(self._views), sights.stamp)
        eyes, R = (np.stack([getattr(v.optical, name) for v in views])[picture] for name in 'tR')
        rays, far = sights.rays, sights.far
        if views[-1].camera is not self._views[max(self._views)].camera:
            rays, far = _rays(sights.measured, sights.kinds, views[-1])
        way = (R @ rays[..., None])[..., 0]
        with np.errstate(divide='ignore', invalid='ignore'):
            by_plane = (ground + sights.kinds.height - eyes[:, 2]) / way[:, 2]
        far = np.where(np.isnan(far), by_plane, far)
        way *= np.where(far > 0, far, np.nan)[:, None]
        moved = _spreads(eyes + way, of, count) / _sums(far, of, len(count)) * count
        return float(np.median(np.nan_to_num(moved[count >= LEAST_SEEN], nan=np.inf)))


def _sums(values: Floats, of: NDArray[np.intp], count: int) -> Floats:
    """Of each of so many groups, the sum of its values."""
    return np.asarray(np.bincount(of, values, count), float)


def _spreads(places: Floats, of: NDArray[np.intp], count: NDArray[np.intp]) -> Floats:
    """Of each group, the root mean square of the distances of its places from their mean."""
    mean = np.stack([_sums(axis, of, len(count)) for axis in places.T], axis=1) / count[:, None]
    away = np.square(places - mean[of]).sum(axis=1)
    return np.asarray(np.sqrt(_sums(away, of, len(count)) / count))
