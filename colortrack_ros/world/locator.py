"""Locator: objects in a fixed frame from tracks, detections and the pose of the camera."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from colortrack_ros.columns import whole_rows
from colortrack_ros.data import Detections
from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.checks import beyond
from colortrack_ros.world.checks import coarse
from colortrack_ros.world.checks import UNCERTAIN
from colortrack_ros.world.checks import unknown
from colortrack_ros.world.checks import unsaid
from colortrack_ros.world.checks import unsure
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.doubts import Doubts
from colortrack_ros.world.fitting import fitting
from colortrack_ros.world.margins import Margins
from colortrack_ros.world.matching import measured_of
from colortrack_ros.world.matching import taken_detections
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import guesses
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.objects import Objects
from colortrack_ros.world.settling import published
from colortrack_ros.world.settling import settle
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.timing import Timing
from colortrack_ros.world.view import jumped
from colortrack_ros.world.view import View

NEVER = 1e9
"""Cost of an incompatible pair of track and object: above that of any compatible pair."""

STUBBORN = 1.0
"""Time without an accepted measurement [s] after which an object restarts: it was moved, or its ID
was passed to another object. Assumed."""

GAP = 10.0
"""Gap between pictures [s] after which all objects restart: as long as poses are kept."""

SILENT = 1.0
"""Time without a picture [s] after which a camera counts as having lost all its tracks. Assumed."""


class Locator:
    """Locates objects in the world, seen by one camera or several.

    With one camera, objects have the IDs of its tracks. With several, they have their own IDs: a
    new track is linked to the object that it matches, or starts a new one.

    :param config: the parameters.
    :param tell: receives warnings, one line at a time.
    :param cameras: number of cameras.
    """

    def __init__(
        self, config: LocatorConfig, tell: Callable[[str], object], cameras: int = 1
    ) -> None:
        self._tell, self._cameras, self._next_id = tell, cameras, 1
        self.configure(config)

    def configure(self, config: LocatorConfig) -> None:
        """Apply changed parameters; all objects restart."""
        self._config = config
        self._kinds, self._margins = Kinds.of(config), Margins(config, self._cameras)
        self._timing = Timing(config.stamp_sigma, self._cameras, self._tell)
        self.reset()

    def reset(self) -> None:
        """Forget all objects, for example after a jump of odometry."""
        belief = Belief.of(self._config, self._cameras)
        self._objects = Objects.none(self._kinds, self._cameras, belief)
        self._heard = np.zeros(self._cameras, np.int64)
        self._doubts = Doubts(self._config, self._cameras, self._margins.smaller)
        self._stamp = self._before = 0
        self._view: View | None = None
        self._vain: int | None = None  # since when all ranges are too uncertain [ns]

    def update(
        self,
        tracks: Tracks,
        detections: Detections,
        view: View,
        depth: NDArray[np.float32] | None = None,
        camera: int = 0,
    ) -> Locations:
        """Return the objects after one more picture.

        :param tracks, detections: of the picture.
        :param view: the camera at the time of the picture.
        :param depth: (H, W) [m], aligned with the picture, for methods depth and fused.
        :param camera: index of the camera that took the picture.
        """
        self._advance(tracks.stamp, view, camera)
        detections, depth = fitting(detections, depth, view, self._tell)
        rows = self._known(tracks)
        taken = taken_detections(rows, detections)
        self._follow(rows, camera)
        (some,) = (taken >= 0).nonzero()
        rows, seen = rows.take(some), detections.rows.take(taken[some])
        kinds = self._kinds.take(rows['color'].astype(np.intp))
        measured = measured_of(seen, kinds, self._config, view.camera, depth)
        found, stamp = rows['track_id'], tracks.stamp
        if line := self._margins.see(stamp, found, measured, kinds, view, camera):
            self._config = replace(self._margins.config, stamp_sigma=self._timing.sigma)
            self.reset()
            restarted = self.update(tracks, detections, view, depth, camera)
            self._tell(line)
            return restarted
        self._recognize(rows, measured, view, camera)
        self._correct(found, measured, view, camera)
        self._start(rows, measured, view, camera)
        self._doubts.see(stamp, view, found, measured, kinds, self._objects, camera)
        for line in self._doubts.lines(self._objects, found, seen, view, camera):
            self._tell(line)
        return self.locations(stamp)

    def locations(self, stamp: int) -> Locations:
        """Return the objects that nothing contradicts at a time [ns], predicted if it is later."""
        objects, belief = self._objects, self._objects.belief
        ahead = (stamp - self._stamp) / NANOSECONDS
        if ahead > 0 and len(objects):
            belief = deepcopy(belief)
            belief.predict(objects.kinds, self._config.ground_height, ahead, self._unseen)
        mean, cov = published(belief, objects.kinds).combined()
        rows = np.zeros(len(objects), LOCATION)
        singles = np.ndarray((len(rows), LOCATION.itemsize // 4), np.float32, rows)
        singles[:, :6] = mean[:, :6]  # x, y, z, vx, vy, vz
        if self._view is not None:
            shares = self._doubts.shares(objects.object_id)
            added = unsaid(mean, cov, objects.kinds, self._view, self._config, shares)
            cov[:, POSITION, POSITION] += added
        rows['covariance'] = cov[:, :6, :6]
        rows['track_id'] = objects.object_id
        for name in ('color', 'state', 'score'):
            rows[name] = getattr(objects, name)
        rows['diameter'] = objects.kinds.diameter
        rows['time_since_update'] = (stamp - objects.updated) / NANOSECONDS
        order = np.argsort(objects.object_id)
        order = order[self._doubts.believed(objects.object_id)[order]]
        return Locations(whole_rows(rows)[order].view(LOCATION), stamp)

    @property
    def doubt(self) -> str:
        """Reason why no objects are published; empty if some are."""
        return self._doubts.reason

    def _advance(self, stamp: int, view: View, camera: int) -> None:
        """Predict all objects to the time of a picture."""
        if self._timing.changes(self._objects.belief, view, camera):
            self._config = replace(self._config, stamp_sigma=self._timing.sigma)
            self.reset()
        dt = (stamp - self._stamp) / NANOSECONDS
        if self._view is not None and not 0 <= dt < GAP:
            self._tell(f'time has gone from one picture to the next by {dt:.3f} s: objects restart')
            self.reset()
        elif self._view is not None:
            objects, (moved, angle) = self._objects, view.way_since(self._view)
            way = view.base.t - self._view.base.t
            if jump := jumped(moved, angle, dt):
                self._tell(
                    f'{jump}: objects restart; odometry was reset, or fixed_frame jumps as map does'
                )
                self.reset()
                objects = self._objects
            belief = objects.belief
            belief.forget(dt)
            belief.predict(objects.kinds, self._config.ground_height, dt, self._unseen)
            belief.drift(view.base.t, way, angle, np.array(self._config.odometry_sigma))
        if line := coarse(view):
            self._tell(line)
        self._stamp, self._view = stamp, view

    @property
    def _unseen(self) -> NDArray[np.bool_]:
        """Which objects, (N,), were not measured by any camera in its last picture."""
        recent = self._heard[self._stamp - self._heard <= SILENT * NANOSECONDS]
        return np.asarray(self._objects.updated < recent.min(initial=self._stamp))

    def _known(self, tracks: Tracks) -> NDArray[np.void]:
        """Return the tracks with known colors."""
        known = tracks.rows['color'] < len(self._kinds)
        if np.count_nonzero(known) == len(known):
            return tracks.rows
        self._tell(unknown(tracks.rows['color'][~known][0], len(self._kinds)))
        return np.asarray(tracks.rows[known])

    def _follow(self, tracks: NDArray[np.void], camera: int) -> None:
        """Drop objects whose tracks have ended, and update the others from their tracks."""
        objects = self._objects
        self._before, self._heard[camera] = self._heard[camera], self._stamp
        for silent in (self._stamp - self._heard > SILENT * NANOSECONDS).nonzero()[0]:
            objects.unlink(np.arange(len(objects)), int(silent))
        objects.follow(tracks, camera)

    def _correct(
        self, found: NDArray[np.uint32], measured: Measured, view: View, camera: int
    ) -> None:
        """Update measured objects, and unlink tracks whose measurements are refused for too long.

        :param found: (K,) IDs of the measured tracks, whether linked to an object or not.
        """
        objects = self._objects
        since = (self._stamp - objects.updates[:, camera]) / NANOSECONDS
        all_measured = measured.aligned(found, objects.track_id[:, camera]).after(since)
        refused = objects.belief.update(
            all_measured, view, objects.kinds, self._config.ground_height, camera
        )
        if np.count_nonzero(refused):
            ground, times = self._config.ground_height, (self._before, self._stamp)
            refused = objects.kick(refused, all_measured, view, ground, camera, times)
        settle(objects.belief, objects.kinds)
        right = all_measured.used.any(axis=1) & ~refused
        objects.updates[right, camera] = self._stamp
        unfit = self._stamp - objects.updates[:, camera] > STUBBORN * NANOSECONDS
        (lost,) = (refused & unfit).nonzero()
        if len(lost):
            self._tell(
                f'object {objects.object_id[lost[0]]} is not measured where it is expected: it '
                'starts anew; if that repeats, camera_pose, calibration or diameter is wrong'
            )
            objects.unlink(lost, camera)
            objects.keep(np.flatnonzero(objects.track_id.any(axis=1)))

    def _recognize(
        self, tracks: NDArray[np.void], measured: Measured, view: View, camera: int
    ) -> None:
        """Link new tracks to objects that other cameras see."""
        objects, own = self._objects, self._objects.track_id[:, camera]
        (free,) = (own == 0).nonzero()
        if not len(free):
            return
        new = ~np.isin(tracks['track_id'], own) & measured.used.any(axis=1)
        mean, _ = objects.belief.combined()
        front = view.optical.inverse().apply(mean[free, POSITION])[:, 2] > 0
        one, other = (
            front[:, None] & (objects.color[free, None] == tracks['color']) & new
        ).nonzero()
        if not len(one):
            return
        cost = np.full((len(free), len(tracks)), NEVER)
        off = objects.belief.take(free[one]).misfit(
            measured.take(other), view, objects.kinds.take(free[one]), self._config.ground_height,
            camera,
        )  # fmt: skip
        cost[one[off <= 1], other[off <= 1]] = off[off <= 1]
        pairs = np.stack(linear_sum_assignment(cost))
        row, track = pairs[:, cost[pairs[0], pairs[1]] < NEVER]
        objects.link(free[row], tracks[track], camera, self._stamp)

    def _start(self, tracks: NDArray[np.void], measured: Measured, view: View, camera: int) -> None:
        """Start objects whose range is measured.

        :param tracks: (K,) of dtype TRACK, the measured ones, whether linked to an object or not.
        """
        own = self._objects.track_id[:, camera]
        rows = ~(tracks['track_id'][:, None] == own).any(axis=1)
        rows &= measured.used[:, PLANE] | measured.used[:, BLOB] | measured.used[:, DEPTH]
        if not np.count_nonzero(rows):
            return
        tracks, measured = tracks[rows], measured.take(rows)
        kinds = self._kinds.take(tracks['color'].astype(np.intp))
        guess = guesses(measured, kinds, view, self._config.ground_height)
        away = np.linalg.norm(guess - view.optical.t, axis=1)
        near = away <= self._config.max_range
        if not near.all():
            self._tell(beyond(tracks['track_id'][~near][0], self._config))
        tracks, measured, kinds = tracks[near], measured.take(near), kinds.take(near)
        if not near.any():
            return
        belief = self._objects.belief.started(
            guess[near], 10 * away[near], measured, view, kinds, self._config.ground_height, camera
        )
        variance = np.trace(belief.combined()[1][:, POSITION, POSITION], 0, 1, 2)
        sure = variance < np.square(UNCERTAIN * away[near])  # not of NaN
        self._vain = None if len(self._objects) or sure.any() else self._vain or self._stamp
        if self._vain and self._stamp - self._vain > SILENT * NANOSECONDS:
            self._tell(unsure(tracks['track_id'][0]))
        tracks, count = tracks[sure], int(np.count_nonzero(sure))
        ids, self._next_id = self._next_id + np.arange(count), self._next_id + count
        if self._cameras == 1:
            ids = tracks['track_id'].astype(np.int64)
        colors = tracks['color'].astype(np.int64)
        belief, kinds = belief.take(sure), kinds.take(sure)
        self._objects.extend(Objects.begun(ids, colors, self._cameras, belief, kinds))
        self._objects.link(np.arange(-count, 0), tracks, camera, self._stamp)
