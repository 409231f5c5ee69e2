"""How far the center of a box is off the middle of a thing that deforms or is seen in parts."""

import numpy as np

from colortrack_ros.data import Floats

LASTING_SHARE = 1 / 20
"""Standard deviation of a center, on each axis, over the longer side of its box: 1/20 of the height
of pedestrians, the default of trackers of boxes (Wojke, Bewley, Paulus: Simple online and realtime
tracking with a deep association metric, 2017)."""


def lasting_variance(size: Floats, share: float | Floats = LASTING_SHARE) -> Floats:
    """Return the variances on each axis, (K, 1) [px^2], of errors that last for seconds.

    :param size: (K, 2) width and height of the boxes [px].
    :param share: standard deviation over the longer side, of all or of each, (K, 1).
    """
    return np.asarray((share * size.max(axis=1, keepdims=True)) ** 2)


def variance_of_part(share: float, size: Floats) -> Floats:
    """Return the variances, by u and v, (2,) [px^2], of a center of which a part is seen.

    The center of a part that covers a share s along one axis is at most (1 - s) / 2 of the size off
    the thing's center, and half of that averaged over all positions of the part.

    :param share: s, 0 to 1.
    :param size: width and height of the thing [px].
    """
    return np.asarray(((1 - share) / 4 * size) ** 2)
