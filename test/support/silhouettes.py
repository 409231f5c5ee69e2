"""Detections made by hand: of points, and of discs that cover each other or hide behind a bar."""

import cv2
import numpy as np

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS

FRAME = NANOSECONDS // 24
RATE = 30
"""Of frames that have a number [Hz]."""

PLACES = np.array([[100.0, 100.0], [300.0, 110.0], [500.0, 105.0], [200.0, 300.0], [450.0, 310.0]])
"""Of five objects that stay, far from each other [px]."""


def points(z, stamp=0, variance=0.0, color=0, size=None):
    """Detections at z, (N, 2), in boxes of a width and height, (2,) or (N, 2); without if None."""
    z = np.asarray(z, float).reshape(-1, 2)
    rows = Detections.from_points(z, colors=color).rows
    rows['cov_uu'] = rows['cov_vv'] = variance
    if size is not None:
        size = np.broadcast_to(size, z.shape)
        rows['box_w'], rows['box_h'], rows['area'] = *size.T, size.prod(axis=1)
        rows['box_u'], rows['box_v'] = (z - size / 2 + 0.5).T
    return Detections(rows, stamp, 'camera')


def jittering(seen, jitter, k, rng):
    """Return the boxes of frame k around the places seen; the sides jitter by a share."""
    z, size = seen + rng.normal(0, 1, seen.shape), 60 * rng.lognormal(0, jitter, seen.shape)
    return points(z, round(k / 30 * 1e9), size=size)


def lasting(rng, shape, rho):
    """Errors of standard deviation 1 with the autocorrelation rho along the first axis."""
    e = rng.normal(0, 1, shape)
    for k in range(1, len(e)):
        e[k] = rho * e[k - 1] + np.sqrt(1 - rho**2) * e[k]
    return e


def message(z, k, color=0):
    """Points at z, (N, 2), known to a pixel, in the frame of number k."""
    return points(z, round(k * NANOSECONDS / RATE), 1.0, color)


def discs(centers, radius, shape, bar=None, stamp=0):
    """Blobs of discs of one color in a picture of shape (H, W), behind a bar (u0, u1)."""
    v, u = np.ogrid[: shape[0], : shape[1]]
    mask = np.zeros(shape, bool)
    for center in np.asarray(centers, float).reshape(-1, 2):
        first = np.clip(np.floor(center - radius), 0, shape[::-1]).astype(int)
        last = np.clip(np.ceil(center + radius) + 1, 0, shape[::-1]).astype(int)
        across, down = map(slice, first, last)
        square = (u[:, across] - center[0]) ** 2 + (v[down] - center[1]) ** 2
        mask[down, across] |= square <= radius**2
    if bar is not None:
        mask[:, bar[0] : bar[1]] = False
    return blobs_of(mask, stamp)


def blobs_of(mask, stamp=0):
    """Detections of what is connected in a mask, (H, W), largest first."""
    mask = mask.astype(np.uint8)
    left, top, width, height = cv2.boundingRect(mask)  # what is empty is not looked through
    part = mask[top : top + max(height, 1), left : left + max(width, 1)]
    _, _, stats, centroids = cv2.connectedComponentsWithStats(part)
    stats[:, :2] += left, top
    centroids += left, top
    (u, v), (left, top, width, height, area) = centroids[1:].T, stats[1:].T
    rows = np.zeros(len(area), DETECTION)
    cut_u = (left == 0) | (left + width == mask.shape[1])
    cut_v = (top == 0) | (top + height == mask.shape[0])
    for name, values in {
        'u': u, 'v': v, 'area': area, 'box_u': left, 'box_v': top, 'box_w': width, 'box_h': height,
        'cov_uu': 0.05 + 1 / area + cut_u * (width / 4) ** 2,
        'cov_vv': 0.05 + 1 / area + cut_v * (height / 4) ** 2, 'score': 1.0,
    }.items():  # fmt: skip
        rows[name] = values
    return Detections(rows[np.argsort(-rows['area'], kind='stable')], stamp, 'camera')


def run(tracker, frames):
    """Rows (track_id, u, v) of the confirmed and coasting tracks, frame by frame."""
    out = []
    for detections in frames:
        rows = tracker.update(detections).rows
        rows = rows[np.isin(rows['state'], (CONFIRMED, COASTING))]
        out.append(np.stack([rows['track_id'], rows['u'], rows['v']], axis=1))
    return out


def inside(centers, radius, shape):
    """Which discs are at least half in the picture."""
    u, v = np.asarray(centers, float).reshape(-1, 2).T
    return (u >= 0) & (u <= shape[1] - 1) & (v >= 0) & (v <= shape[0] - 1)
