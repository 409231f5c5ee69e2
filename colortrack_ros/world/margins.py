"""Test of blob sizes against the ranges by the ground or by depth.

Boxes of a neural network are often larger than the objects, by about the same margin at all ranges.
Seen from near the horizon, that looks like a pitch that is off, so sizes cannot be told from the
ground by one object. Two hypotheses are compared over all objects, as they begin and come nearer:
the set-up is as configured, or the sizes have a margin, besides, and scatter. In both, the camera
errors are estimated from how much larger than expected objects are seen, by a linear Kalman filter.
"""

from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.checks import blobs_of
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.filter import GATE
from colortrack_ros.world.filter import started
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import guesses
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import PLANE_SIGMA
from colortrack_ros.world.measurement import U
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import EDGE
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import OF_CAMERA
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.view import View

MARGIN_SIGMA = 10.0
"""Standard deviation of the margin [px]. A network that small-size soccer robots use has 11 to 12
(`jgocm/ssl-detector`)."""

FACTOR_SIGMA = 0.5
"""Standard deviation of the factor, less 1, that sizes may have besides. Assumed."""

SCATTER_SIGMA = 2.0
"""Standard deviation of the margin by object [px]; there it is 2 to 3."""

SELDOM, DISTRUSTED = np.log(0.1), np.log(0.25)
"""Log odds that sizes have a margin: before any object is seen, assumed, and from which on they are
not trusted. Low, as without sizes objects are located less precisely, but not wrongly."""

MOST_TOLD = 3.0
"""Most that one object changes the log odds: it may be held up, or be of another size. Chosen: two
objects that fit outweigh one that does not."""

CHANGED_SIZE = np.log(1.25)
"""Log ratio of sizes from which on an object tells anew. Chosen."""

MOST_SIZES = 1000
"""Most sizes that are kept, of objects that have gone, too. Chosen."""

LARGEST_BOXES = 3.0
"""Ratio of sizes from which on they are no box's, but the set-up is wrong. A ball of 9 px has had a
box of 26 px there; upside down, ratios are 4 and more. Chosen."""


class Margins:
    """Evidence, over all objects, that their sizes have a margin.

    :ivar config: the configuration of the locator that follows from it.
    :ivar smaller: whether sizes are not trusted as they are too small, which no margin explains.
    """

    def __init__(self, config: LocatorConfig, cameras: int) -> None:
        self.config, self._doubted = config, config.method not in ('fused', 'size')
        self.smaller = False
        self._odds, self._ratios = SELDOM, deque[float](maxlen=MOST_SIZES)
        self._sizes = dict[tuple[int, int], float]()
        self._stamps = [0] * cameras
        self._errors = CameraErrors.of(replace(config, way_sigma=0.0), cameras)
        count = len(self._errors.first)
        self._mean, self._cov = np.zeros((2, count + 1)), np.zeros((2, count + 1, count + 1))
        self._cov[:, :-1, :-1] = self._errors.first
        edges = np.arange(EDGE - OF_OBJECT, OF_CAMERA * cameras, OF_CAMERA)
        self._cov[1, edges, edges] += MARGIN_SIGMA**2
        self._cov[1, -1, -1] = FACTOR_SIGMA**2

    def see(
        self,
        stamp: int,
        tracks: NDArray[np.uint32],
        measured: Measured,
        kinds: Kinds,
        view: View,
        camera: int,
    ) -> str:
        """Add what a picture measures, (N,); return a line once sizes are not trusted any more.

        :param stamp: of the picture [ns]; what is not new is added once a second.
        :param tracks: IDs; objects count when they begin and when their sizes have changed.
        :param measured: their measurements; sizes count if another range is measured, too.
        """
        if self._doubted:
            return ''
        due = abs(stamp - self._stamps[camera]) >= NANOSECONDS
        if due:
            self._stamps[camera] = stamp
        if len(self._sizes) > MOST_SIZES:
            self._sizes.clear()
        fresh = [(camera, track) not in self._sizes for track in tracks.tolist()]
        rows = measured.used[:, BLOB] & (np.array(fresh, bool) | due)
        if not rows.any():
            return ''
        self._compare(tracks[rows], measured.take(rows), kinds.take(rows), view, camera)
        if self._odds <= DISTRUSTED:
            return ''
        ratio = float(np.median(self._ratios))
        if not 1 / LARGEST_BOXES < ratio < LARGEST_BOXES:
            return ''
        return self._changed(ratio, bool(measured.used[:, DEPTH].any()))

    def _compare(
        self,
        tracks: NDArray[np.uint32],
        measured: Measured,
        kinds: Kinds,
        view: View,
        camera: int,
    ) -> None:
        """Compare sizes, (N,), with those expected by the other ranges."""
        other, ground = _without_sizes(measured, kinds), self.config.ground_height
        guess = guesses(other, kinds, view, ground)
        reach = 10 * np.linalg.norm(guess - view.optical.t, axis=1)
        motion = started(guess, reach, other, view, kinds, self._errors, ground, camera)
        size, slope, own = blobs_of(motion, self._errors, view, kinds, ground, camera)
        for at, track in enumerate(tracks.tolist()):
            last = self._sizes.setdefault((camera, track), TINY)
            if abs(np.log(size[at] / last)) > CHANGED_SIZE and np.isfinite(own[at]):  # not of NaN
                self._sizes[camera, track] = size[at]
                seen = measured.z[at, BLOB]
                self._add(seen - size[at], np.append(slope[at], size[at]), own[at])
                self._ratios.append(seen / size[at])

    def _changed(self, ratio: float, depth: bool) -> str:
        """Go on without sizes, or with uncertain ones if there is nothing else; say so."""
        self._doubted, self.smaller = True, ratio < 1
        if self.config.method == 'fused':
            self.config = replace(self.config, method='depth' if depth else 'ground')
            then = f'located by {self.config.method} alone'
        else:
            sigma = float(np.hypot(self.config.size_sigma, MARGIN_SIGMA))
            self.config = replace(self.config, size_sigma=sigma)
            then = f'with size_sigma of {sigma:.0f} px'
        return (
            f'blobs are {ratio:.2f} times as large as objects would be seen on '
            f'the ground or at their depth: they restart, {then}; boxes are larger than objects, '
            'or camera_pose, calibration or diameter is wrong'
        )

    def _add(self, off: float, slope: Floats, own: float) -> None:
        """Update both hypotheses by the size of one object.

        :param off: seen minus expected size [px]; slope: (9 C + 1,) of that by the errors.
        :param own: its variance by the object alone [px^2].
        """
        variance = own + self.config.size_noise**2 + np.array([0.0, SCATTER_SIGMA**2])
        e = off - self._mean @ slope
        gain = self._cov @ slope
        S = variance + gain @ slope
        log = -(np.log(S) + e * e / S) / 2
        self._odds += float(np.clip(log[1] - log[0], -MOST_TOLD, MOST_TOLD))
        gain[e * e / S > GATE[0]] = 0.0
        self._mean += gain * (e / S)[:, None]
        self._cov -= gain[:, :, None] * gain[:, None, :] / S[:, None, None]


def _without_sizes(measured: Measured, kinds: Kinds) -> Measured:
    """Return measurements by the ground and by depth alone."""
    used, R = measured.used.copy(), measured.R.copy()
    used[:, BLOB], used[:, PLANE] = False, used[:, U] & kinds.bound
    R[:, PLANE, PLANE] = PLANE_SIGMA**2
    return replace(measured, R=R, used=used)
