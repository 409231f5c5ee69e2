"""Measurement noise, estimated from tracks and the detections they were made from."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.ellipses import ELLIPSE_95

MEDIAN_OF_PAIRS = 2 * np.log(2)
"""Median of the sum of two squared standard normal variables, chi-square with two degrees of
freedom."""

OF_DETECTION = (('area', 'area'), ('box_w', 'box_w'), ('box_h', 'box_h'), ('color', 'color'))
"""Fields that a track copies from its last detection; together they identify the detection."""


def noise_of(frames: Iterable[tuple[Tracks, Detections]]) -> dict[str, float]:
    """Noise of the detections that were assigned to confirmed tracks.

    What is left of a measurement z after the update, r = z - H x, has the covariance R - H P H^T
    (Mehra 1970), so the mean of r r^T + H P H^T is R. Medians are used, since some pairs are of
    different objects.

    :return: noise: standard deviation on an axis [px]; noise_claimed: the same according to the
        detections' own covariances [px]; empty if no track has a detection.
    """
    squares, variances, claims = [], [], []
    for tracks, detections in frames:
        track, z = _taken(tracks, detections)
        squares.append((z['u'] - track['u']) ** 2 + (z['v'] - track['v']) ** 2)
        covariance = track['covariance']
        variances.append((covariance[:, 0, 0] + covariance[:, 1, 1]) / 2)
        claims.append((z['cov_uu'] + z['cov_vv']) / 2)
    if not sum(map(len, squares)):
        return {}
    r, P, R = (float(np.median(np.concatenate(some))) for some in (squares, variances, claims))
    return {'noise': float(np.sqrt(r / MEDIAN_OF_PAIRS + P)), 'noise_claimed': float(np.sqrt(R))}


def innovations_of(frames: Iterable[tuple[Tracks, Detections]]) -> dict[str, float]:
    """How well tracks predict their detections: e = z - H F x, S = H F P F^T H^T + R.

    :param frames: in order.
    :return: nis: mean of e^T S^-1 e divided by two, 1 where the covariances are right;
        nis_coverage: share of the detections within the 95 % ellipse; empty if no track has a
        detection.
    """
    found, before = [np.zeros(0)], Tracks()
    for tracks, detections in frames:
        track, z = _taken(tracks, detections)
        _, i, j = np.intersect1d(before.rows['track_id'], track['track_id'], return_indices=True)
        seconds = (tracks.stamp - before.stamp) / NANOSECONDS
        if seconds > 0:
            found.append(_normalized(before.rows[i], z[j], seconds))
        before = tracks
    nis = np.concatenate(found)
    if not len(nis):
        return {}
    return {'nis': float(nis.mean()) / 2, 'nis_coverage': float((nis <= ELLIPSE_95).mean())}


def _normalized(x: NDArray[np.void], z: NDArray[np.void], dt: float) -> NDArray[np.float64]:
    """(N,) e^T S^-1 e of detections against predicted states."""
    e = np.stack([z[p] - x[p] - dt * x[v] for p, v in (('u', 'du'), ('v', 'dv'))], axis=1)
    HF = np.hstack([np.eye(2), dt * np.eye(2)])
    S = HF @ x['covariance'] @ HF.T
    S[:, 0, 0] += z['cov_uu']
    S[:, 1, 1] += z['cov_vv']
    S[:, 0, 1] += z['cov_uv']
    S[:, 1, 0] += z['cov_uv']
    return np.asarray((e * np.linalg.solve(S, e[..., None])[..., 0]).sum(axis=1))


def _taken(tracks: Tracks, detections: Detections) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """Confirmed tracks, and the detection of each."""
    rows = tracks.rows[tracks.rows['state'] == CONFIRMED]
    same = np.ones((len(rows), len(detections.rows)), bool)
    for ours, theirs in OF_DETECTION:
        same &= rows[ours][:, None] == detections.rows[theirs]
    alone = (same.sum(axis=1) == 1)[:, None] & (same.sum(axis=0) == 1)
    i, j = np.nonzero(same & alone)
    return rows[i], detections.rows[j]
