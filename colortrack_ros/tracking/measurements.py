"""Measurements: the detections of a frame in the form that the tracker uses."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.borders import TOUCHING
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.noise import MeasurementNoise

DOUBLES, SINGLES = slice(0, 5), slice(10, 16)
"""Columns of u, v, cov_uu, cov_uv, cov_vv in a row of DETECTION viewed as doubles, and of area,
box_u, box_v, box_w, box_h, score in one viewed as singles."""

ROW_DOUBLES = DETECTION.itemsize // 8
"""Size of a row in doubles."""

COVARIANCE = np.array([2, 3, 3, 4])
"""Columns of the four entries of the covariance, in doubles."""

FARTHEST = 1e6
"""Bound of a coordinate [px]: no picture is that wide, and doubles hold its square exactly."""

LARGEST_SQUARE = FARTHEST**2
"""Bound of covariances and areas [px^2]."""

LIMITS = np.array([FARTHEST, FARTHEST, LARGEST_SQUARE, LARGEST_SQUARE, LARGEST_SQUARE])
"""Bounds of the doubles of a valid row."""

CUT_SIGMA, LEAST_CUT = 0.2, 2.0
"""Where the size of the picture is unknown, a blob at a learned border counts as cut if its
standard deviation exceeds this share of its size and this many px; of a cut blob without a
covariance the share is its standard deviation. Assumed: the centroid of a disc of which half is out
of sight is off by 0.4 of the visible width."""

SYSTEMATIC_SHARE = 0.007
"""Largest systematic error of a centroid (shading, background), as a standard deviation over the
size of the box. Differences between frames do not show it, so the given variance in excess of what
they show counts as systematic, up to this bound. Assumed: our own detections have 0.001 to 0.017.
Halved, the 95 % ellipses of `clutter` and `fast` hold 85 and 87 % instead of 95 and 93; doubled, 97
and 100.
"""


@dataclass
class Measurements(Columns):
    """The valid detections of one frame.

    :param rows: (M,) of dtype DETECTION.
    :param z: (M, 2) centroid [px].
    :param R: (M, 2, 2) its covariance [px^2].
    :param box: (M, 2, 2) outer borders of the box, low and high side, by axis (u, v) [px]; a
        detection without a box is a point.
    :param size: (M, 2) width and height of the box [px].
    :param mixed: (M,) composed of several blobs, or of several objects.
    :param cut: (M, 2) by axis: part of the object is out of the picture, see _outside().
    :param outside: (M, 2) by axis: -1 where only the low side is, 1 where only the high side is.
    :param usual: (M, 2) by axis, of R of the detections of that color, 0 where that is unknown.
    :param factor: (M, 2) of R over what was given, by axis, see noise.MeasurementNoise.
    """

    rows: NDArray[np.void]
    z: Floats
    R: Floats
    box: Floats
    size: Floats
    mixed: Bools
    cut: Bools
    outside: NDArray[np.int8]
    usual: Floats
    factor: Floats

    def __len__(self) -> int:
        return len(self.rows)

    def scale(self, noisiness: MeasurementNoise) -> None:
        """Apply the learned factors to the covariances of all blobs that are not cut."""
        given = mean_of_axes(by_axis(self.R))
        self.factor, self.usual = noisiness.factors(self.rows['color'], given)
        if np.count_nonzero(self.cut):
            self.factor[self.cut.any(axis=1)] = 1.0
        scale = np.sqrt(self.factor)
        self.R = scale[:, :, None] * self.R * scale[:, None, :]

    def reach(self, which: Indices) -> Floats:
        """(K, 2, 2) how far boxes reach from their centroids, low and high side, by axis [px]."""
        reach = self.box.take(which, axis=0) - self.z.take(which, axis=0)[:, None]
        np.negative(reach[:, 0], out=reach[:, 0])
        return reach

    @cached_property
    def variance(self) -> Floats:
        """(M, 2) of the centroid, by axis [px^2]."""
        return by_axis(self.R)

    @cached_property
    def given(self) -> Floats:
        """(M, 2) the same without the learned factors."""
        return self.variance / self.factor

    @cached_property
    def systematic(self) -> Floats:
        """(M, 2) the part of it that is the same in every frame, see SYSTEMATIC_SHARE."""
        hidden = np.maximum(self.given - self.variance, 0.0)
        return np.minimum(hidden, np.square(SYSTEMATIC_SHARE * self.size))


def by_axis(R: Floats) -> Floats:
    """The variances, (M, 2), of covariances, (M, 2, 2); a view of them."""
    return R.reshape(-1, 4)[:, ::3]


def both_axes(which: Bools) -> Bools:
    """Which of (M, 2) are so on both axes, (M,); a reduction takes twice as long."""
    return which[:, 0] & which[:, 1]


def either_axis(which: Bools) -> Bools:
    """Which of (M, 2) are so on one axis or both, (M,)."""
    return which[:, 0] | which[:, 1]


def mean_of_axes(variance: Floats) -> Floats:
    """Means over the axes, (M,), of variances, (M, 2)."""
    mean: Floats = (variance[:, 0] + variance[:, 1]) / 2.0
    return mean


def median(values: Floats) -> Floats:
    """Median over the first axis, of finite values, at least one.

    np.median also looks for NaN, which takes ten times as long as a few values.
    """
    ordered, count = np.sort(values, axis=0), len(values)
    return np.asarray((ordered[(count - 1) // 2] + ordered[count // 2]) / 2)


def _outside(
    box: Floats, size: NDArray[np.float32], variance: Floats, learned: Adaptation
) -> tuple[Bools, NDArray[np.int8]]:
    """Which blobs extend beyond the picture's border, by axis, (M, 2), and on which side.

    Those that end at it; boxes that go beyond it are whole. Where its size is not known, those that
    end where boxes are seen to end, if their centroids are that uncertain as well.

    :param box, size, variance: of the blobs and of their centroids, see Measurements.
    :param learned: where the picture ends.
    """
    if all(learned.image_size):
        last = np.subtract(learned.image_size, 0.5)
        low, high = np.abs(box[:, 0] + 0.5) <= TOUCHING, np.abs(box[:, 1] - last) <= TOUCHING
    else:
        learned.borders.learn(box, size)
        low = variance > np.maximum(CUT_SIGMA * size, LEAST_CUT) ** 2
        high = low
        if np.count_nonzero(low):
            low, high = (low & side for side in learned.borders.touched(box).swapaxes(0, 1))
    cut = low | high
    if not np.count_nonzero(cut):
        return cut, np.zeros(cut.shape, np.int8)
    return cut & (size > 0), high.astype(np.int8) - low


def accept(rows: NDArray[np.void], config: TrackerConfig, learned: Adaptation) -> Measurements:
    """Leave out rows that are not finite or absurdly large, or have no valid covariance.

    A covariance is positive definite, or all zero where it is not known.

    :param rows: (N,) of dtype DETECTION.
    :param config: says where the covariance comes from, and whether boxes are used.
    :param learned: where the picture ends; learned here if it is not given.
    :return: the rows left, M <= N.
    """
    rows = np.ascontiguousarray(rows, DETECTION)
    doubles = np.ndarray((rows.size, ROW_DOUBLES), np.float64, rows)[:, DOUBLES]
    singles = np.ndarray((rows.size, 2 * ROW_DOUBLES), np.float32, rows)[:, SINGLES]
    near = np.abs(doubles) <= LIMITS, np.abs(singles) <= LARGEST_SQUARE  # not what is NaN
    if sum(map(np.count_nonzero, near)) < doubles.size + singles.size:
        good = near[0].all(axis=1) & near[1].all(axis=1)
        rows, doubles, singles = rows[good], doubles[good], singles[good]
    a, b, c = doubles[:, 2:].T
    definite = (a > 0) & (a * c > b * b)
    known = np.count_nonzero(definite) == rows.size
    if not known:
        good = definite | ~doubles[:, 2:].any(axis=1)
        rows, doubles, singles = rows[good], doubles[good], singles[good]
        definite = definite[good]
    z, R = doubles[:, :2].copy(), doubles.take(COVARIANCE, axis=1).reshape(-1, 2, 2)
    if not (known and config.detection_covariance) or learned.overlaps.are_estimated:
        R[~definite | (not config.detection_covariance)] = config.measurement_noise**2 * np.eye(2)
        _learn_unstated(rows, definite, config, learned)
    box, usual = _boxes(singles, z, config), np.zeros(z.shape)
    if config.use_boxes:
        given = doubles[:, 2::2] if config.detection_covariance else usual
        cut, outside = _outside(box, singles[:, 3:5], given, learned)
        if np.count_nonzero(cut):
            unknown = cut & ~definite[:, None]
            by_axis(R)[unknown] += np.square(CUT_SIGMA * singles[:, 3:5][unknown])
    else:
        cut, outside = np.zeros(z.shape, bool), np.zeros(z.shape, np.int8)
    size, mixed = box[:, 1] - box[:, 0], np.zeros(rows.size, bool)
    return Measurements(rows, z, R, box, size, mixed, cut, outside, usual, usual + 1)


def _learn_unstated(
    rows: NDArray[np.void], stated: Bools, config: TrackerConfig, learned: Adaptation
) -> None:
    """Learn from the rows, (N,) of dtype DETECTION, which of them state a covariance."""
    unstated = rows[~stated]
    learned.noisiness.guessed = unstated['color']
    if config.use_boxes:
        learned.overlaps.see(unstated, len(rows) - len(unstated))


def _boxes(singles: NDArray[np.float32], z: Floats, config: TrackerConfig) -> Floats:
    """Corners, (N, 2, 2), of the bounding boxes; both are the centroid where there is no box."""
    box = np.empty((len(z), 2, 2))
    if not config.use_boxes:
        box[:] = z[:, None]
        return box
    size = singles[:, 3:5]
    box[:, 0] = singles[:, 1:3] - 0.5
    box[:, 1] = box[:, 0] + size
    none = size <= 0
    if np.count_nonzero(none):
        point = none.any(axis=1)
        box[point] = z[point, None]
    return box
