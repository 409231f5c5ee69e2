"""Unsized: detections without a box among objects that have sizes.

That nothing is known of their size is not to say that it is 0: each is as large as the object that
it is nearest to, and so neither cut nor another's. An object that never had a box has no size.
"""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.records import Records
from colortrack_ros.tracking.measurements import FARTHEST
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.rectangles import nearest_points


def lend_sizes(blobs: Measurements, center: Floats, records: Records) -> None:
    """Give blobs without a box that of the nearest object of their color, if there is any.

    :param center: (N, 2) of the objects, predicted [px]; records: of the same.
    """
    point = (~have_boxes(blobs)).nonzero()[0]
    color = _apart(np.append(records['color'], blobs.rows['color'][point]))
    z, there = blobs.z[point] + color[len(center) :], center + color[: len(center)]
    owner = nearest_points(there, z)
    alike = (np.abs(there[owner] - z) < FARTHEST).all(axis=1)
    point, owner = point[alike], owner[alike]
    reach = records['extent'][owner]
    blobs.box[point, 0] = blobs.z[point] - reach[:, 0]
    blobs.box[point, 1] = blobs.z[point] + reach[:, 1]
    blobs.size[point] = reach.sum(axis=1)


def have_boxes(blobs: Measurements) -> Bools:
    """Which blobs, (M,), have a box of their own."""
    return np.asarray((blobs.rows['box_w'] > 0) & (blobs.rows['box_h'] > 0))


def _apart(color: Indices) -> Floats:
    """(K, 1) offsets by which colors, (K,), are farther apart than a picture is wide [px]."""
    return np.asarray(3.0 * FARTHEST * np.unique(color, return_inverse=True)[1][:, None])
