"""What does not fit together where objects are located: each check gives one line, or none."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.matching import round_blobs
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.state import columns_of
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Objects
from colortrack_ros.world.view import View

OUT_OF_PLACE = 5.0
"""How many standard deviations an object may be off its height, or its blob off its size, before
somebody is told: of right ones that is one in a million."""


def off_height(objects: Objects, config: LocatorConfig) -> str:
    """Which object is said to be on the ground and is not located there."""
    above = objects.mean[:, 2] - config.ground_height - objects.kinds.height
    spread = np.sqrt(objects.cov[:, 2, 2] + objects.cov[:, HEIGHT, HEIGHT])
    off = objects.kinds.bound & (np.abs(above) > OUT_OF_PLACE * spread)
    if not off.any():
        return ''
    return (
        f'object {objects.object_id[off][0]} is {above[off][0]:+.2f} m off the height that it has '
        'on the ground: camera_pose, ground_height, diameter or depth is wrong'
    )


def off_size(
    objects: Objects,
    found: NDArray[np.int64],
    seen: NDArray[np.void],
    view: View,
    camera: int,
    config: LocatorConfig,
) -> str:
    """Which object is seen larger or smaller than it would be where it is.

    :param found: (K,) the tracks of this camera that are measured.
    :param seen: (K,) their detections.
    """
    of, order = objects.track_id[:, camera], np.argsort(found)
    (rows,) = (np.isin(of, found) & (objects.kinds.diameter > 0)).nonzero()
    if not len(rows):
        return ''
    seen = seen[order][np.searchsorted(found[order], of[rows])]
    kinds, own = objects.kinds.take(rows), columns_of(camera)
    z, H = expected(view, objects.mean[rows][:, own], kinds.diameter, kinds.height)
    H = H[:, BLOB]
    cov = objects.cov[rows][:, own][:, :, own]
    variance = (H[:, None] @ cov @ H[:, :, None])[:, 0, 0]
    sizes = np.sqrt(4 * seen['area'] / np.pi)
    off = np.abs(sizes - z[:, BLOB]) > OUT_OF_PLACE * np.sqrt(variance + config.size_noise**2)
    off &= round_blobs(seen)
    if not off.any():
        return ''
    one = off.argmax()
    return (
        f'object {objects.object_id[rows][one]} is {sizes[one]:.0f} px large, expected '
        f'{z[one, BLOB]:.0f} px where it is located: camera_pose (upside down?), calibration, '
        'ground_height or diameter is wrong'
    )
