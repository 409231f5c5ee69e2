"""How noisy measurements are, as told by the tracks that were made of them."""

from collections.abc import Iterable

import numpy as np

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks

MEDIAN_OF_PAIRS = 2 * np.log(2)
"""Of the sum of two squared normal variables, chi-square with two degrees."""

OF_DETECTION = (('area', 'area'), ('box_w', 'box_w'), ('box_h', 'box_h'), ('color', 'color'))
"""What a track has of the last detection that it took, which tells them apart from all others."""


def noise_of(frames: Iterable[tuple[Tracks, Detections]]) -> dict[str, float]:
    """Of the detections that confirmed tracks took.

    What is left of a measurement z after the update, r = z - H x, has the covariance R - H P H^T
    (Mehra 1970), so r r^T + H P H^T has R for its mean; medians, as some pairs are other objects.

    :return: noise: standard deviation on an axis [px]; noise_claimed: what the detections say of
        themselves [px]; nothing if no track took any.
    """
    squares, variances, claims = [], [], []
    for tracks, detections in frames:
        rows = tracks.rows[tracks.rows['state'] == CONFIRMED]
        same = np.ones((len(rows), len(detections.rows)), bool)
        for ours, theirs in OF_DETECTION:
            same &= rows[ours][:, None] == detections.rows[theirs]
        alone = (same.sum(axis=1) == 1)[:, None] & (same.sum(axis=0) == 1)
        i, j = np.nonzero(same & alone)
        track, z = rows[i], detections.rows[j]
        squares.append((z['u'] - track['u']) ** 2 + (z['v'] - track['v']) ** 2)
        P = track['covariance']
        variances.append((P[:, 0, 0] + P[:, 1, 1]) / 2)
        claims.append((z['cov_uu'] + z['cov_vv']) / 2)
    if not sum(map(len, squares)):
        return {}
    r, P, R = (float(np.median(np.concatenate(some))) for some in (squares, variances, claims))
    return {'noise': float(np.sqrt(r / MEDIAN_OF_PAIRS + P)), 'noise_claimed': float(np.sqrt(R))}
