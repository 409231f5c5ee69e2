"""Detections made by hand: of points, and of discs that cover each other or hide behind a bar."""

import numpy as np
from scipy import ndimage

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
        mask |= (u - center[0]) ** 2 + (v - center[1]) ** 2 <= radius**2
    if bar is not None:
        mask[:, bar[0] : bar[1]] = False
    return blobs_of(mask, stamp)


def blobs_of(mask, stamp=0):
    """Detections of what is connected in a mask, (H, W), largest first."""
    labels, count = ndimage.label(mask, np.ones((3, 3)))
    rows = np.zeros(count, DETECTION)
    for i, (down, across) in enumerate(ndimage.find_objects(labels)):
        y, x = np.nonzero(labels[down, across] == i + 1)
        box = across.start, down.start, across.stop - across.start, down.stop - down.start
        cut_u = across.start == 0 or across.stop == mask.shape[1]
        cut_v = down.start == 0 or down.stop == mask.shape[0]
        row = rows[i]
        row['u'], row['v'], row['area'] = box[0] + x.mean(), box[1] + y.mean(), len(x)
        row['box_u'], row['box_v'], row['box_w'], row['box_h'] = box
        row['cov_uu'] = 0.05 + 1 / len(x) + cut_u * (box[2] / 4) ** 2
        row['cov_vv'] = 0.05 + 1 / len(x) + cut_v * (box[3] / 4) ** 2
        row['score'] = 1.0
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
