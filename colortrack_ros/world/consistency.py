"""Whether what is seen is consistent with what is said of the camera, by all objects at once.

While a camera is set up as it is said to be, its errors are estimated within what is expected of
them, and things of known diameter are seen, where that is not what locates them, as large as their
covariance allows. Of both the normalized squares, which are independent of each other, are added
and have a chi-square distribution (Bar-Shalom, Li and Kirubarajan 2001, 5.4). The degrees of
freedom are what pictures have told of the camera, trace(I - P P0^-1), and the number of sizes.
"""

import numpy as np
from scipy.special import chdtri

from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.checks import BlobSizes
from colortrack_ros.world.state import columns_of
from colortrack_ros.world.state import OF_OBJECT

ONE_IN = 1e6
"""Of so many right set-ups one is told to be wrong, as by OUT_OF_PLACE."""

NAMES = (
    *(('x', 'm', 1.0), ('y', 'm', 1.0), ('z', 'm', 1.0)),
    *((name, 'degrees', 180 / np.pi) for name in ('roll', 'pitch', 'yaw')),
    *(('edge of blobs', 'px', 1.0), ('scale of depths', '', 1.0)),
)
"""Of the errors of a camera, and their units, with how many of each a meter or radian is."""


def inconsistency(belief: Belief, camera: int, sizes: BlobSizes) -> str:
    """What does not fit together; empty where all does.

    :param sizes: of objects that sizes do not locate.
    """
    own = columns_of(camera)[OF_OBJECT:] - OF_OBJECT
    mean, cov = belief.combined_errors()
    first = np.diagonal(belief.errors.first)[own]
    (may,) = first.nonzero()
    e, share = mean[0, own][may], (np.diagonal(cov[0])[own] / np.maximum(first, TINY))[may]
    off = sizes.seen - sizes.expected
    square = np.sum(e * e / first[may]) + off @ np.linalg.solve(sizes.cov, off)
    freedom = np.sum(1 - np.minimum(share, 1.0)) + len(off)
    if square <= chdtri(max(freedom, 1.0), 1 / ONE_IN):
        return ''
    most = may[np.argmax(e * e / first[may])]
    name, unit, scale = NAMES[most]
    amount = mean[0, own[most]]
    line = (
        'what is seen does not fit together: by it the '
        f'{name} of the camera is off by {scale * amount:+.2g} {unit}, '
        f'{abs(amount) / np.sqrt(first[most]):.1f} times what is expected'
    )
    if len(off):
        line += (
            f', and blobs are {np.mean(sizes.seen / sizes.expected):.2f} times as large as expected'
        )
    return line + ': camera_pose, calibration, odometry or a diameter is wrong'
