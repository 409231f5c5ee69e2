"""What is known of a target besides its filter and its template, and how it is published."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TRACK

Floats = NDArray[np.float64]

RECORD = np.dtype(
    [
        ('track_id', 'u4'),
        ('born', 'i8'),
        ('updated', 'i8'),
        ('hits', 'u4'),
        ('box', 'f4', 2),
        ('similarity', 'f8'),
        ('usual', 'f8'),
        ('last', 'f8', (2, 2)),
        ('drift', 'f8', (2, 2)),
    ]
)
"""One target.

born, updated: stamp of the first and of the last valid match [ns]; hits: their number; box: width
and height [px]; similarity: of the last valid match, 0 before the first; usual: mean distance of
matches from where they were expected [px]; last: (u, v) that matching and filter gave in the last
frame [px]; drift: covariance of what the template has moved on the object [px^2].
"""


def births(center: Floats, box: Floats, stamp: int, first_id: int) -> NDArray[np.void]:
    """Records of new targets.

    :param center: (K, 2) u, v [px].
    :param box: (K, 2) width and height [px].
    :param stamp: of their first frame [ns].
    :param first_id: of the first one; the others follow.
    """
    new = np.zeros(len(center), RECORD)
    new['track_id'] = first_id + np.arange(len(center))
    new['born'] = new['updated'] = stamp
    new['hits'], new['usual'] = 1, np.inf
    new['box'], new['last'] = box, center[:, None]
    return new


def rows(
    records: NDArray[np.void], mean: Floats, covariance: Floats, stamp: int, patience: float
) -> NDArray[np.void]:
    """The tracks as they are published, (N,) of dtype TRACK.

    :param mean: (N, 4) of the filters.
    :param covariance: (N, 4, 4); that of the position grows by the drift of the template.
    :param stamp: of the frame [ns].
    :param patience: time without a valid match [s] in which the score falls to 0.
    """
    tracks = np.zeros(len(records), TRACK)
    for name in ('track_id', 'hits'):
        tracks[name] = records[name]
    tracks['box_w'], tracks['box_h'] = records['box'].T
    tracks['area'] = records['box'].prod(axis=1)
    tracks['u'], tracks['v'], tracks['du'], tracks['dv'] = mean.T
    tracks['covariance'] = covariance
    tracks['covariance'][:, :2, :2] += records['drift']
    tracks['state'] = np.where(records['updated'] == stamp, CONFIRMED, COASTING)
    tracks['age'] = (stamp - records['born']) / NANOSECONDS
    since = (stamp - records['updated']) / NANOSECONDS
    tracks['time_since_update'] = since
    similarity = np.where(records['hits'] > 1, records['similarity'], 1.0)
    left = np.clip(1 - since / max(patience, 1e-3), 0, 1)
    tracks['score'] = np.clip(similarity, 0, 1) * left
    return tracks
