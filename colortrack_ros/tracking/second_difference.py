"""The acceleration of a track by second differences of its past positions: Red object, (13)."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.records import Records

ACCELERATION_FIELDS = [
    ('past', 'f8', (2, 2)),
    ('past_at', 'i8', 2),
    ('past_count', 'u1'),
    ('acceleration', 'f8', 2),
]
"""Acceleration fields of a track: the last two positions kept, the later one first [px]; the stamps
of their measurements [ns]; how many there are; and the acceleration [px/s^2], 0 until known."""


def learn_acceleration(records: Records, track: Indices, z: Floats, now: int, span: float) -> None:
    """Update the acceleration of tracks from their measured positions.

    It is held between measurements. With z_0, z_1, z_2 measured at t_0 > t_1 > t_2, it is that of
    the parabola through them::

        a = 2 / (t_0 - t_2) ((z_0 - z_1) / (t_0 - t_1) - (z_1 - z_2) / (t_1 - t_2))

    :param records: (N,) of all tracks, with ACCELERATION_FIELDS.
    :param track: (K,) tracks measured, each once.
    :param z: (K, 2) their positions [px].
    :param now: stamp of the frame [ns].
    :param span: least time between two positions that are kept [s].
    """
    late = now - records['past_at'][track, 0] >= round(span * NANOSECONDS)
    due = late | (records['past_count'][track] == 0)
    track, z = track[due], z[due]
    past, at, count = (records[name][track] for name in ('past', 'past_at', 'past_count'))
    known = count == 2
    if known.any():
        h0, h1 = (now - at[known, 0]) / NANOSECONDS, (at[known, 0] - at[known, 1]) / NANOSECONDS
        late_speed = (z[known] - past[known, 0]) / h0[:, None]
        early_speed = (past[known, 0] - past[known, 1]) / h1[:, None]
        a = 2 * (late_speed - early_speed) / (h0 + h1)[:, None]
        records['acceleration'][track[known]] = a
    records['past'][track] = np.stack([z, past[:, 0]], axis=1)
    records['past_at'][track] = np.stack([np.full(len(track), now), at[:, 0]], axis=1)
    records['past_count'][track] = np.minimum(count + 1, 2)
