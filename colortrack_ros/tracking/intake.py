"""Detections as the tracker works with them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.tracking.config import TrackerConfig

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Blobs:
    """The good rows of one frame.

    :param rows: (M,) of dtype DETECTION.
    :param z: (M, 2) centroid [px].
    :param R: (M, 2, 2) its covariance [px^2].
    :param box: (M, 2, 2) outer borders of the box, low and high side, by axis (u, v) [px]; a
        detection without a box is a point.
    """

    rows: NDArray[np.void]
    z: Floats
    R: Floats
    box: Floats

    @property
    def reach(self) -> Floats:
        """(M, 2, 2) how far the box reaches from the centroid, low and high side, by axis [px]."""
        return np.stack([self.z - self.box[:, 0], self.box[:, 1] - self.z], axis=1)

    @property
    def size(self) -> Floats:
        """(M, 2) width and height of the box [px]."""
        return self.box[:, 1] - self.box[:, 0]


def accept(rows: NDArray[np.void], config: TrackerConfig) -> Blobs:
    """Leave out rows that are not finite, or whose covariance is none.

    :param rows: (N,) of dtype DETECTION.
    :param config: says where the covariance comes from, and whether boxes are used.
    :return: the rows left, M <= N.
    """
    names = [name for name in rows.dtype.names or () if name != 'color']
    finite = np.isfinite([rows[name] for name in names]).all(axis=0)
    a, b, c = rows['cov_uu'], rows['cov_uv'], rows['cov_vv']
    none = (a == 0) & (b == 0) & (c == 0)
    with np.errstate(invalid='ignore', over='ignore'):
        positive = (a > 0) & (c > 0) & (a * c > b * b)
    good = finite & (none | positive)
    rows, none = rows[good], none[good] | (not config.detection_covariance)
    z = np.stack([rows['u'], rows['v']], axis=1)
    R = np.stack([rows['cov_uu'], rows['cov_uv'], rows['cov_uv'], rows['cov_vv']], axis=1)
    R = R.reshape(-1, 2, 2)
    R[none] = config.measurement_noise**2 * np.eye(2)
    low = np.stack([rows['box_u'], rows['box_v']], axis=1) - 0.5
    size = np.stack([rows['box_w'], rows['box_h']], axis=1)
    box = np.stack([low, low + size], axis=1).astype(float)
    point = (size <= 0).any(axis=1) | (not config.use_boxes)
    box[point] = z[point, None]
    return Blobs(rows, z, R, box)
