"""Chi-square test of camera errors and blob sizes over all objects.

If the camera is set up as configured, its estimated errors are within their priors, and objects of
known diameter that sizes do not locate have the expected blob sizes, within their covariance. The
normalized squares of both are independent, and their sum has a chi-square distribution (Bar-Shalom,
Li and Kirubarajan 2001, 5.4). Its degrees of freedom are the information of the pictures about the
camera, trace(I - P P0^-1), plus the number of sizes.
"""

import numpy as np
from scipy.special import chdtri

from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.checks import BlobSizes
from colortrack_ros.world.state import columns_of
from colortrack_ros.world.state import OF_CAMERA
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import time_of

ONE_IN = 1e6
"""One in so many right setups is reported as wrong, as with OUT_OF_PLACE."""

STILL_ONE_IN = 1e3
"""The same, once it was reported: as errors are learned, the sum falls below the former limit while
the setup is as wrong as before. With focal lengths 20 % too small, 467 rows were published after
3 s, with a pitch off by 4.6 standard deviations. Chosen."""

NAMES = (
    *(('x', 'm', 1.0), ('y', 'm', 1.0), ('z', 'm', 1.0)),
    *((name, 'degrees', 180 / np.pi) for name in ('roll', 'pitch', 'yaw')),
    *(('edge of blobs', 'px', 1.0), ('scale of depths', '', 1.0)),
    *(('stamp of pictures', 's', 1.0), ('scale of ways by odometry', '%', 100.0)),
)
"""Names and units of the errors of a camera and of ways, and units per meter, radian or 1."""


def inconsistency(belief: Belief, camera: int, sizes: BlobSizes, reported: bool = False) -> str:
    """Return a description of the inconsistency; empty if there is none.

    :param sizes: of objects that sizes do not locate.
    :param reported: whether there was one, and it is to be seen whether there still is, or sizes
        have spoken against the setup before.
    """
    count = len(belief.errors.first)
    own = np.append(columns_of(camera)[OF_OBJECT:] - OF_OBJECT, time_of(camera, count))
    if belief.errors.scaled:
        own = np.append(own, -1)
    mean, cov = belief.combined_errors()
    first = np.diagonal(belief.errors.first)[own]
    (may,) = first.nonzero()
    e, share = mean[0, own][may], (np.diagonal(cov[0])[own] / np.maximum(first, TINY))[may]
    off = sizes.seen - sizes.expected
    square = np.sum(e * e / first[may]) + off @ np.linalg.solve(sizes.cov, off)
    freedom = np.sum(1 - np.minimum(share, 1.0)) + len(off)
    if square <= chdtri(max(freedom, 1.0), 1 / (STILL_ONE_IN if reported else ONE_IN)):
        return ''
    most = may[np.argmax(e * e / first[may])]
    name, unit, scale = NAMES[most]
    whose, amount = ' of the camera' if most < OF_CAMERA else '', mean[0, own[most]]
    line = (
        'what is seen does not fit together: by it the '
        f'{name}{whose} is off by {scale * amount:+.2g} {unit}, '
        f'{abs(amount) / np.sqrt(first[most]):.1f} times what is expected'
    )
    if len(off):
        line += (
            f', and blobs are {np.mean(sizes.seen / sizes.expected):.2f} times as large as expected'
        )
    return line + ': camera_pose, calibration, odometry or a diameter is wrong'
