"""Tracks, detections and the place of the camera -> objects in a fixed frame."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from colortrack_ros.data import Detections
from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.filter import drift
from colortrack_ros.world.filter import predict
from colortrack_ros.world.filter import started
from colortrack_ros.world.filter import update
from colortrack_ros.world.matching import measured_of
from colortrack_ros.world.matching import round_blobs
from colortrack_ros.world.matching import taken_detections
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import ranges_by_size
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Objects
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import SIZE
from colortrack_ros.world.view import View

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

GATE = chi2.ppf(0.9999, np.arange(1, 6))
"""Of the normalized innovation squared, by the number of what is measured: one measurement in ten
thousand that is right is refused, one in a minute of 150 measurements a second."""

STUBBORN = 1.0
"""An object whose measurements have been refused for so long [s] starts anew: it was moved, or its
ID went to another one. Assumed."""

GAP = 10.0
"""After a pause of so long [s] nothing is known of where things are; as long as poses are kept."""

JUMP, FASTEST = 0.3, 20.0
"""A robot that moves or turns by more than this [m], [rad], and faster [m/s], [rad/s], has jumped:
no wheel is as fast."""

UNCERTAIN = 0.5
"""Share of the range that its standard deviation may have for an object to start: beyond, near the
horizon, it may be anywhere."""

OUT_OF_PLACE = 5.0
"""How many standard deviations an object may be off its height, or its blob off its size, before
somebody is told: of right ones that is one in a million."""


class Locator:
    """The objects in the world.

    :param config: how they are located.
    :param tell: takes what is wrong, one line at a time.
    """

    def __init__(self, config: LocatorConfig, tell: Callable[[str], object]) -> None:
        self._tell = tell
        self.configure(config)

    def configure(self, config: LocatorConfig) -> None:
        """Take other parameters into use; all objects start anew."""
        self._config = config
        self._kinds = Kinds.of(config)
        self.reset()

    def reset(self) -> None:
        """Forget all objects, as when odometry has jumped."""
        none, count = np.zeros(0, np.int64), np.zeros(0)
        self._objects = Objects(
            none, none, none.astype(np.uint8), count, none, np.zeros((0, SIZE)),
            np.zeros((0, SIZE, SIZE)), self._kinds.take(none),
        )  # fmt: skip
        self._stamp = 0
        self._view: View | None = None

    def update(
        self,
        tracks: Tracks,
        detections: Detections,
        view: View,
        depth: NDArray[np.float32] | None = None,
    ) -> Locations:
        """The objects after one more picture.

        :param tracks, detections: of the picture.
        :param view: the camera when it was taken.
        :param depth: (H, W) [m], aligned with it, for methods depth and fused.
        """
        self._advance(tracks.stamp, view)
        detections = self._inside(detections, view)
        rows = self._known(tracks)
        taken = taken_detections(rows, detections)
        self._follow(rows)
        found = rows['track_id'][taken >= 0]
        seen = detections.rows[taken[taken >= 0]]
        kinds = self._kinds.take(rows['color'][taken >= 0].astype(np.intp))
        measured = measured_of(seen, kinds, self._config, view.camera, depth)
        old = np.isin(found, self._objects.track_id)
        self._correct(found[old], measured.take(old), view)
        self._start(rows[taken >= 0][~old], measured.take(~old), view)
        self._check_height()
        self._check_size(found, seen, view)
        return self.locations(tracks.stamp)

    def locations(self, stamp: int) -> Locations:
        """The objects at a time [ns], predicted to it if it is later than the last picture."""
        objects = self._objects
        mean, cov = objects.mean, objects.cov
        ahead = (stamp - self._stamp) / NANOSECONDS
        if ahead > 0 and len(objects):
            mean, cov = mean.copy(), cov.copy()
            predict(mean, cov, objects.kinds, self._config.ground_height, ahead)
        rows = np.zeros(len(objects), LOCATION)
        for at, name in enumerate(('x', 'y', 'z', 'vx', 'vy', 'vz')):
            rows[name] = mean[:, at]
        rows['covariance'] = cov[:, :6, :6]
        for name in ('track_id', 'color', 'state', 'score'):
            rows[name] = getattr(objects, name)
        rows['diameter'] = objects.kinds.diameter
        rows['time_since_update'] = (stamp - objects.updated) / NANOSECONDS
        return Locations(rows[np.argsort(rows['track_id'])], stamp)

    def _advance(self, stamp: int, view: View) -> None:
        """Predict all objects to the time of a picture."""
        dt = (stamp - self._stamp) / NANOSECONDS
        if self._view is not None and not 0 <= dt < GAP:
            self._tell(f'time has gone from one picture to the next by {dt:.3f} s: objects restart')
            self.reset()
        elif self._view is not None:
            last, objects = self._view.base, self._objects
            moved = float(np.linalg.norm(view.base.t - last.t))
            turned = last.inverse() @ view.base
            angle = float(np.arccos(np.clip((np.trace(turned.R) - 1) / 2, -1, 1)))
            if moved > JUMP + FASTEST * dt or angle > JUMP + FASTEST * dt:
                self._tell(
                    f'the robot has jumped by {moved:.2f} m and {np.degrees(angle):.0f} degrees in '
                    f'{dt:.3f} s: objects restart; odometry was reset, or fixed_frame jumps as map '
                    'does'
                )
                self.reset()
                objects = self._objects
            predict(objects.mean, objects.cov, objects.kinds, self._config.ground_height, dt)
            arms = objects.mean[:, POSITION] - view.base.t
            drift(objects.cov, arms, moved, angle, np.array(self._config.odometry_sigma))
        self._stamp, self._view = stamp, view

    def _inside(self, detections: Detections, view: View) -> Detections:
        """The detections, none if they are of a picture of another size than the calibration."""
        pixels = np.stack([detections.rows['u'], detections.rows['v']], axis=1)
        outside = ~view.camera.contains(pixels)
        if not outside.any():
            return detections
        u, v = pixels[outside][0]
        self._tell(
            f'a detection at u {u:.0f}, v {v:.0f} is outside of the {view.camera.width}x'
            f'{view.camera.height} picture of CameraInfo: the calibration is of another picture'
        )
        return replace(detections, rows=detections.rows[:0])

    def _known(self, tracks: Tracks) -> NDArray[np.void]:
        """The tracks of the colors that are known."""
        unknown = tracks.rows['color'] >= len(self._kinds)
        if unknown.any():
            self._tell(
                f'track of color {tracks.rows["color"][unknown][0]}: expected one of the '
                f'{len(self._kinds)} in colors, which are those of the detector in its order'
            )
        return np.asarray(tracks.rows[~unknown])

    def _follow(self, tracks: NDArray[np.void]) -> None:
        """Drop the objects whose tracks have gone, and note what the others' tracks tell."""
        self._objects.keep(np.isin(self._objects.track_id, tracks['track_id']))
        at = np.searchsorted(tracks['track_id'], self._objects.track_id)
        self._objects.state = tracks['state'][at]
        self._objects.score = tracks['score'][at].astype(float)

    def _correct(self, found: Indices, measured: Measured, view: View) -> None:
        """Update objects that are measured; those that do not fit for long are dropped."""
        objects, number = self._objects, measured.used.sum(axis=1)
        order = np.argsort(objects.track_id)
        rows = order[np.searchsorted(objects.track_id[order], found)]
        front = view.optical.inverse().apply(objects.mean[rows, POSITION])[:, 2] > 0
        chosen = front & (number > 0)
        rows, measured, number = rows[chosen], measured.take(chosen), number[chosen]
        if not len(rows):
            return
        mean, cov, nis = update(
            objects.mean[rows], objects.cov[rows], measured, view, objects.kinds.take(rows),
            self._config.ground_height,
        )  # fmt: skip
        right = nis <= GATE[number - 1]
        objects.mean[rows[right]], objects.cov[rows[right]] = mean[right], cov[right]
        objects.updated[rows[right]] = self._stamp
        lost = rows[~right & (self._stamp - objects.updated[rows] > STUBBORN * NANOSECONDS)]
        if len(lost):
            self._tell(
                f'object {objects.track_id[lost[0]]} is not measured where it is expected: it '
                'starts anew; if that repeats, camera_pose, calibration or diameter is wrong'
            )
            objects.keep(np.setdiff1d(np.arange(len(objects)), lost))

    def _start(self, tracks: NDArray[np.void], measured: Measured, view: View) -> None:
        """Begin objects where a measurement says how far away they are."""
        rows = measured.used[:, PLANE] | measured.used[:, BLOB] | measured.used[:, DEPTH]
        tracks, measured = tracks[rows], measured.take(rows)
        kinds = self._kinds.take(tracks['color'].astype(np.intp))
        guess = self._guesses(measured, kinds, view)
        away = np.linalg.norm(guess - view.optical.t, axis=1)
        near = away <= self._config.max_range
        if len(near) and not near.all():
            self._tell(
                f'track {tracks["track_id"][~near][0]}: its ray does not meet the ground, or '
                'its size or depth says so, within max_range of '
                f'{self._config.max_range:g} m: it is not located; if that is so for most, '
                'camera_pose is wrong (positive pitch looks down, roll is near 0)'
            )
        tracks, measured, kinds = tracks[near], measured.take(near), kinds.take(near)
        if not near.any():
            return
        mean, cov = started(
            guess[near], 10 * away[near], measured, view, kinds, self._config.ground_height
        )
        spread = np.sqrt(np.trace(cov[:, POSITION, POSITION], axis1=1, axis2=2))
        sure = np.isfinite(spread) & (spread < UNCERTAIN * away[near])
        ids, colors = (tracks[name].astype(np.int64) for name in ('track_id', 'color'))
        score, stamps = tracks['score'].astype(float), np.full(len(kinds), self._stamp)
        new = Objects(ids, colors, tracks['state'], score, stamps, mean, cov, kinds)
        self._objects.extend(new.take(sure))

    def _guesses(self, measured: Measured, kinds: Kinds, view: View) -> Floats:
        """Where measured objects are, by the first of depth, ground and size; NaN for nowhere."""
        pixels = measured.z[:, :2]
        rays = view.camera.rays(pixels)
        directions = rays @ view.optical.R.T
        height = self._config.ground_height + kinds.height - view.optical.t[2]
        with np.errstate(divide='ignore', invalid='ignore'):
            by_plane = height / directions[:, 2]
            by_depth = measured.z[:, DEPTH] / rays[:, 2]
        by_size = ranges_by_size(view, pixels, measured.z[:, BLOB], kinds.diameter)
        distance = np.select(
            [measured.used[:, DEPTH], measured.used[:, PLANE], measured.used[:, BLOB]],
            [by_depth, by_plane, by_size],
            np.nan,
        )
        distance[~(distance > 0)] = np.nan
        return np.asarray(view.optical.t + distance[:, None] * directions)

    def _check_height(self) -> None:
        """Tell of objects that are said to be on the ground and are not located there."""
        objects = self._objects
        above = objects.mean[:, 2] - self._config.ground_height - objects.kinds.height
        spread = np.sqrt(objects.cov[:, 2, 2] + np.square(objects.kinds.sigma[:, 6]))
        off = objects.kinds.bound & (np.abs(above) > OUT_OF_PLACE * spread)
        if off.any():
            self._tell(
                f'object {objects.track_id[off][0]} is {above[off][0]:+.2f} m off the height that '
                'it has on the ground: camera_pose, ground_height, diameter or depth is wrong'
            )

    def _check_size(self, found: Indices, seen: NDArray[np.void], view: View) -> None:
        """Tell of objects that are seen larger or smaller than they would be where they are."""
        objects, order = self._objects, np.argsort(found)
        (rows,) = (np.isin(objects.track_id, found) & (objects.kinds.diameter > 0)).nonzero()
        if not len(rows):
            return
        seen = seen[order][np.searchsorted(found[order], objects.track_id[rows])]
        kinds = objects.kinds.take(rows)
        z, H = expected(view, objects.mean[rows], kinds.diameter, kinds.height)
        H = H[:, BLOB]
        variance = (H[:, None] @ objects.cov[rows] @ H[:, :, None])[:, 0, 0]
        sizes = np.sqrt(4 * seen['area'] / np.pi)
        off = np.abs(sizes - z[:, BLOB]) > OUT_OF_PLACE * np.sqrt(
            variance + self._config.size_noise**2
        )
        off &= round_blobs(seen)
        if off.any():
            one = off.argmax()
            self._tell(
                f'object {objects.track_id[rows][one]} is {sizes[one]:.0f} px large, expected '
                f'{z[one, BLOB]:.0f} px where it is located: camera_pose (upside down?), '
                'calibration, ground_height or diameter is wrong'
            )
