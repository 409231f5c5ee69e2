"""Detections as the tracker works with them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import DETECTION
from colortrack_ros.tracking.config import TrackerConfig

Floats = NDArray[np.float64]

DOUBLES, SINGLES = slice(0, 5), slice(10, 16)
"""Where a row of DETECTION, seen as doubles, holds u, v, cov_uu, cov_uv, cov_vv, and, seen as
singles, area, box_u, box_v, box_w, box_h, score."""

FARTHEST = 1e6
"""No picture has a place farther out [px]; a covariance and an area are at most its square."""


@dataclass(frozen=True)
class Blobs:
    """The good rows of one frame.

    :param rows: (M,) of dtype DETECTION.
    :param z: (M, 2) centroid [px].
    :param R: (M, 2, 2) its covariance [px^2].
    :param box: (M, 2, 2) outer borders of the box, low and high side, by axis (u, v) [px]; a
        detection without a box is a point.
    :param joined: (M,) put together of several.
    """

    rows: NDArray[np.void]
    z: Floats
    R: Floats
    box: Floats
    joined: NDArray[np.bool_]

    def reach(self, which: NDArray[np.intp]) -> Floats:
        """(K, 2, 2) how far boxes reach from their centroids, low and high side, by axis [px]."""
        z, box = self.z[which], self.box[which]
        return np.stack([z - box[:, 0], box[:, 1] - z], axis=1)

    @property
    def size(self) -> Floats:
        """(M, 2) width and height of the box [px]."""
        return self.box[:, 1] - self.box[:, 0]


def accept(rows: NDArray[np.void], config: TrackerConfig) -> Blobs:
    """Leave out rows that are not finite or absurdly large, or whose covariance is none.

    :param rows: (N,) of dtype DETECTION.
    :param config: says where the covariance comes from, and whether boxes are used.
    :return: the rows left, M <= N.
    """
    rows = np.ascontiguousarray(rows)
    doubles = rows.view(np.float64).reshape(-1, DETECTION.itemsize // 8)[:, DOUBLES]
    singles = rows.view(np.float32).reshape(-1, DETECTION.itemsize // 4)[:, SINGLES]
    a, b, c = doubles[:, 2], doubles[:, 3], doubles[:, 4]
    with np.errstate(invalid='ignore', over='ignore'):
        none = (a == 0) & (b == 0) & (c == 0)
        good = none | ((a > 0) & (a * c > b * b))
        good &= (np.abs(doubles[:, :2]) <= FARTHEST).all(axis=1)  # neither is NaN
        good &= (np.abs(doubles[:, 2:]) <= FARTHEST**2).all(axis=1)
        good &= (np.abs(singles) <= FARTHEST**2).all(axis=1)
    if not good.all():
        rows, doubles, singles, none = rows[good], doubles[good], singles[good], none[good]
    z, R = doubles[:, :2].copy(), doubles[:, [2, 3, 3, 4]].reshape(-1, 2, 2)
    if not config.detection_covariance:
        none[:] = True
    if none.any():
        R[none] = config.measurement_noise**2 * np.eye(2)
    box, size = np.empty((len(rows), 2, 2)), singles[:, 3:5]
    if config.use_boxes:
        box[:, 0] = singles[:, 1:3] - 0.5
        box[:, 1] = box[:, 0] + size
        point = (size <= 0).any(axis=1)
        box[point] = z[point, None]
    else:
        box[:] = z[:, None]
    return Blobs(rows, z, R, box, np.zeros(len(rows), bool))
