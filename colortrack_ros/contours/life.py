"""What is known of a target besides its contour, and how it is published."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.filters import shifts
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK

Floats = NDArray[np.float64]

CONFIRMING = 3
"""Measurements that confirm a target."""

MISSED = 0.35
"""Share of what a curve misses of an outline that does not cancel out from node to node."""

RECORD = np.dtype(
    [
        ('track_id', 'u4'),
        ('born', 'i8'),
        ('updated', 'i8'),
        ('hits', 'u4'),
        ('found', 'f4'),
        ('placed', 'f8'),
        ('miss', 'f8'),
    ]
)
"""One target.

born, updated: stamp of the first and of the last measurement [ns]; hits: their number; found: share
of its lines that had an edge in the last of them; placed: area when its nodes were placed [px];
miss: what the curve missed of its outline then [root of that area].
"""


def births(miss: Floats, area: Floats, stamp: int, first_id: int) -> NDArray[np.void]:
    """Records of new targets.

    :param miss: (K,) what the curve misses of the outline [px].
    :param area: (K,) [px].
    :param stamp: of their first frame [ns].
    :param first_id: of the first one; the others follow.
    """
    new = np.zeros(len(miss), RECORD)
    new['track_id'] = first_id + np.arange(len(miss))
    new['born'] = new['updated'] = stamp
    new['hits'] = new['found'] = 1
    new['placed'] = np.maximum(area, 1.0)
    new['miss'] = miss / np.sqrt(new['placed'])
    return new


def rows(
    records: NDArray[np.void], contours: Contours, spline: Spline, rate: float, stamp: int,
    patience: float,
) -> tuple[NDArray[np.void], Floats]:  # fmt: skip
    """The tracks as they are published, (N,) of dtype TRACK, and their outlines (N, P, 2) [px].

    The position is the centroid of the spline's area. Its covariance is that of the nodes, carried
    over by its derivatives, and by them what the curve cannot follow of the outline.

    :param rate: frames of the filters in a second.
    :param stamp: of the frame [ns].
    :param patience: time without a measurement [s] in which the score falls to 0.
    """
    tracks = np.zeros(len(records), TRACK)
    outlines = spline.outline(contours.nodes)
    if not len(records):
        return tracks, outlines
    for name in ('track_id', 'hits'):
        tracks[name] = records[name]
    center, change = spline.centroid(contours.nodes)
    n = contours.nodes.shape[1]
    carry = np.zeros((len(records), 4, contours.cov.shape[1]))
    carry[:, :2, : 2 * n] = change.reshape(-1, 2, 2 * n)
    carry[:, 2:, 2 * n :] = rate * carry[:, :2, : 2 * n] @ shifts(contours.nodes)
    velocity = (carry[:, 2:, 2 * n :] @ contours.motion[..., None])[..., 0]
    tracks['u'], tracks['v'] = center.T
    tracks['du'], tracks['dv'] = velocity.T
    tracks['covariance'] = carry @ contours.cov @ carry.swapaxes(1, 2)
    area = spline.area(contours.nodes)
    blur = (MISSED * records['miss']) ** 2 * np.maximum(area, 0.0)
    tracks['covariance'][:, :2, :2] += blur[:, None, None] * (
        carry[:, :2, : 2 * n] @ carry[:, :2, : 2 * n].swapaxes(1, 2)
    )
    state = np.where(records['hits'] < CONFIRMING, TENTATIVE, CONFIRMED)
    coasting = (state == CONFIRMED) & (records['updated'] < stamp)
    tracks['state'] = np.where(coasting, COASTING, state)
    tracks['age'] = (stamp - records['born']) / NANOSECONDS
    since = (stamp - records['updated']) / NANOSECONDS
    tracks['time_since_update'] = since
    tracks['area'] = area
    tracks['box_w'], tracks['box_h'] = np.ptp(outlines, axis=1).T
    left = np.clip(1 - since / max(patience, 1e-3), 0, 1)
    tracks['score'] = np.clip(records['found'], 0, 1) * left
    return tracks, outlines
