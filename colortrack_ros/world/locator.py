"""Tracks, detections and the place of the camera -> objects in a fixed frame."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.special import chdtri

from colortrack_ros.data import Detections
from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.world.checks import off_height
from colortrack_ros.world.checks import off_size
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.filter import drift
from colortrack_ros.world.filter import predict
from colortrack_ros.world.filter import started
from colortrack_ros.world.filter import update
from colortrack_ros.world.matching import measured_of
from colortrack_ros.world.matching import taken_detections
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import guesses
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Objects
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.view import View

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

GATE = chdtri(np.arange(1, 6), 1e-4)
"""Of the normalized innovation squared, by the number of what is measured: one measurement in ten
thousand that is right is refused, one in a minute of 150 measurements a second."""

NEVER = 1e9
"""Cost of a track and an object that do not fit: above all that do."""

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

SILENT = 1.0
"""A camera that has told nothing for so long [s] sees none of its tracks any more. Assumed."""


class Locator:
    """The objects in the world, seen by one camera or several.

    With one camera objects have the IDs of its tracks. With several they have their own: a track
    that begins is of the object that it fits, or of a new one.

    :param config: how they are located.
    :param tell: takes what is wrong, one line at a time.
    :param cameras: how many there are.
    """

    def __init__(
        self, config: LocatorConfig, tell: Callable[[str], object], cameras: int = 1
    ) -> None:
        self._tell, self._cameras, self._next_id = tell, cameras, 1
        self.configure(config)

    def configure(self, config: LocatorConfig) -> None:
        """Take other parameters into use; all objects start anew."""
        self._config = config
        self._kinds = Kinds.of(config, self._cameras)
        self.reset()

    def reset(self) -> None:
        """Forget all objects, as when odometry has jumped."""
        self._objects = Objects.none(self._kinds, self._cameras)
        self._heard = np.zeros(self._cameras, np.int64)
        self._stamp = 0
        self._view: View | None = None

    def update(
        self,
        tracks: Tracks,
        detections: Detections,
        view: View,
        depth: NDArray[np.float32] | None = None,
        camera: int = 0,
    ) -> Locations:
        """The objects after one more picture.

        :param tracks, detections: of the picture.
        :param view: the camera when it was taken.
        :param depth: (H, W) [m], aligned with it, for methods depth and fused.
        :param camera: which of them has taken it.
        """
        self._advance(tracks.stamp, view)
        detections = self._inside(detections, view)
        rows = self._known(tracks)
        taken = taken_detections(rows, detections)
        self._follow(rows, camera)
        found = rows['track_id'][taken >= 0]
        seen = detections.rows[taken[taken >= 0]]
        kinds = self._kinds.take(rows['color'][taken >= 0].astype(np.intp))
        measured = measured_of(seen, kinds, self._config, view.camera, depth)
        old = np.isin(found, self._objects.track_id[:, camera])
        self._correct(found[old], measured.take(old), view, camera)
        rows, measured = self._recognize(rows[taken >= 0][~old], measured.take(~old), view, camera)
        self._start(rows, measured, view, camera)
        for trouble in (
            off_height(self._objects, self._config),
            off_size(self._objects, found, seen, view, camera, self._config),
        ):
            if trouble:
                self._tell(trouble)
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
        rows['track_id'] = objects.object_id
        for name in ('color', 'state', 'score'):
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

    def _follow(self, tracks: NDArray[np.void], camera: int) -> None:
        """Drop the objects whose tracks have gone, and note what the others' tracks tell."""
        objects = self._objects
        self._heard[camera] = self._stamp
        for silent in np.flatnonzero(self._stamp - self._heard > SILENT * NANOSECONDS):
            objects.unlink(np.arange(len(objects)), int(silent))
        objects.follow(tracks, camera)

    def _correct(self, found: Indices, measured: Measured, view: View, camera: int) -> None:
        """Update objects that are measured; tracks that do not fit for long are of another one."""
        objects, number = self._objects, measured.used.sum(axis=1)
        own = objects.track_id[:, camera]
        order = np.argsort(own)
        rows = order[np.searchsorted(own[order], found)]
        front = view.optical.inverse().apply(objects.mean[rows, POSITION])[:, 2] > 0
        chosen = front & (number > 0)
        rows, measured, number = rows[chosen], measured.take(chosen), number[chosen]
        if not len(rows):
            return
        mean, cov, nis = update(
            objects.mean[rows], objects.cov[rows], measured, view, objects.kinds.take(rows),
            self._config.ground_height, camera=camera,
        )  # fmt: skip
        right = nis <= GATE[number - 1]
        objects.mean[rows[right]], objects.cov[rows[right]] = mean[right], cov[right]
        objects.updates[rows[right], camera] = self._stamp
        unfit = self._stamp - objects.updates[rows, camera] > STUBBORN * NANOSECONDS
        lost = rows[~right & unfit]
        if len(lost):
            self._tell(
                f'object {objects.object_id[lost[0]]} is not measured where it is expected: it '
                'starts anew; if that repeats, camera_pose, calibration or diameter is wrong'
            )
            objects.unlink(lost, camera)
            objects.keep(np.flatnonzero(objects.track_id.any(axis=1)))

    def _recognize(
        self, tracks: NDArray[np.void], measured: Measured, view: View, camera: int
    ) -> tuple[NDArray[np.void], Measured]:
        """Give tracks that begin to objects that other cameras see; return those that are left."""
        objects, number = self._objects, measured.used.sum(axis=1)
        front = view.optical.inverse().apply(objects.mean[:, POSITION])[:, 2] > 0
        fit = (objects.track_id[:, camera] == 0) & front
        one, other = (
            fit[:, None] & (objects.color[:, None] == tracks['color']) & (number > 0)
        ).nonzero()
        if not len(one):
            return tracks, measured
        mean, cov, nis = update(
            objects.mean[one], objects.cov[one], measured.take(other), view,
            objects.kinds.take(one), self._config.ground_height, camera=camera,
        )  # fmt: skip
        cost = np.full((len(objects), len(tracks)), NEVER)
        right = nis <= GATE[number[other] - 1]
        cost[one[right], other[right]] = nis[right]
        pairs = np.stack(linear_sum_assignment(cost))
        pairs = pairs[:, cost[pairs[0], pairs[1]] < NEVER]
        for row, track in pairs.T:
            (pair,) = ((one == row) & (other == track)).nonzero()[0]
            objects.mean[row], objects.cov[row] = mean[pair], cov[pair]
        objects.link(pairs[0], tracks[pairs[1]], camera, self._stamp)
        left = np.setdiff1d(np.arange(len(tracks)), pairs[1])
        return tracks[left], measured.take(left)

    def _start(self, tracks: NDArray[np.void], measured: Measured, view: View, camera: int) -> None:
        """Begin objects where a measurement says how far away they are."""
        rows = measured.used[:, PLANE] | measured.used[:, BLOB] | measured.used[:, DEPTH]
        tracks, measured = tracks[rows], measured.take(rows)
        kinds = self._kinds.take(tracks['color'].astype(np.intp))
        guess = guesses(measured, kinds, view, self._config.ground_height)
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
            guess[near], 10 * away[near], measured, view, kinds, self._config.ground_height,
            camera,
        )  # fmt: skip
        spread = np.sqrt(np.trace(cov[:, POSITION, POSITION], axis1=1, axis2=2))
        sure = np.isfinite(spread) & (spread < UNCERTAIN * away[near])
        tracks, count = tracks[sure], int(np.count_nonzero(sure))
        ids, self._next_id = self._next_id + np.arange(count), self._next_id + count
        each = np.zeros((count, self._cameras), np.int64)
        first = len(self._objects)
        self._objects.extend(
            Objects(
                tracks['track_id'].astype(np.int64) if self._cameras == 1 else ids,
                tracks['color'].astype(np.int64), each, each.astype(np.uint8), each.astype(float),
                each.copy(), mean[sure], cov[sure], kinds.take(sure),
            )
        )  # fmt: skip
        self._objects.link(first + np.arange(count), tracks, camera, self._stamp)
