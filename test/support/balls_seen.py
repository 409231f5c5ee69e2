"""Balls on the ground, as the detector and the tracker tell of them."""

import numpy as np

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import expected

FRAME = 33_000_000
RADIUS = 0.1


def seen(view, points, stamp, ids=None, radius=RADIUS):
    """Tracks and detections of balls, as the detector and the tracker would tell them."""
    points = np.atleast_2d(np.asarray(points, float))
    mean = np.zeros((len(points), 16))
    mean[:, :3] = points
    z, _ = expected(view, mean, np.full(len(points), 2 * radius), np.zeros(len(points)))
    rows, tracks = np.zeros(len(points), DETECTION), np.zeros(len(points), TRACK)
    rows['u'], rows['v'] = z[:, 0], z[:, 1]
    size = z[:, BLOB] - LocatorConfig.eroded
    rows['box_w'] = rows['box_h'] = size
    rows['area'] = np.pi / 4 * size**2
    rows['box_u'], rows['box_v'] = rows['u'] - size / 2, rows['v'] - size / 2
    rows['cov_uu'] = rows['cov_vv'] = 0.01
    for name in ('area', 'box_w', 'box_h'):
        tracks[name] = rows[name]
    # what the tracker says of the position is not what is measured: it lags behind
    tracks['u'], tracks['v'] = rows['u'] + 3, rows['v'] - 2
    tracks['track_id'] = 1 + np.arange(len(points)) if ids is None else ids
    tracks['state'], tracks['score'] = CONFIRMED, 0.9
    return Tracks(tracks, stamp, 'cam'), Detections(rows[::-1], stamp, 'cam')
