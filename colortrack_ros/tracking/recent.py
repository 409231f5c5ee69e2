"""The last measurements of each track, kept in a ring buffer to learn from every few frames."""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.records import Records

EVERY = 5
"""Frames from one look at the measurements to the next, which takes all new ones, to save time.
Assumed: noise and process noise change little in a sixth of a second."""

RING = 16
"""Frames whose measurements are kept: evidence on noise takes six measurements, see differences,
and an object missed every other time has eight in that many frames."""

Z, GIVEN = slice(0, 2), slice(2, 4)
VARIANCE, UNMEASURED, MANEUVERED, WHOLE, STEADY_CAMERA = range(4, 9)
SEEN_SIZE, RING_COLUMNS = slice(9, 11), 11
"""Columns of a measurement: position by axis [px]; variance by axis as given, and their mean as
used [px^2]; time since the previous measurement [s], 0 for none; probability that the track has
maneuvered; 1 if the object was seen completely; 1 if so, and measured in the previous frame too;
width and height of the box [px]."""

RECENT_FIELDS = [('measured', 'f8', (RING, RING_COLUMNS)), ('in_a_row', 'i8')]
"""Recent fields of a track: its measurements in the last frames, in a ring buffer, and the number
of them in a row."""


class Recent:
    """Slots and times of the last frames in the records.

    :ivar stamps: (RING,) of the frames [s], by slot, from an arbitrary origin.
    """

    def __init__(self) -> None:
        self.stamps = np.arange(-RING, 0.0)
        self._frame = 0

    def take(
        self,
        records: Records,
        track: Indices,
        z: Floats,
        given: Floats,
        variance: Floats,
        unmeasured: Floats,
        maneuvered: Floats,
        whole: Bools,
        steady: Bools,
        size: Floats,
        dt: float,
    ) -> bool:
        """Record the measurements of a frame; return whether a look at them is due.

        :param records: (N,) of all tracks, with RECENT_FIELDS.
        :param track: (K,) tracks measured, each once; for the rest see the columns.
        :param dt: since the last frame [s].
        """
        slot = self._frame % RING
        self.stamps[slot] = self.stamps[slot - 1] + dt
        ring, in_a_row = records['measured'][:, slot], records['in_a_row']
        every = len(track) == len(records)
        new = ring if every else np.empty((len(track), RING_COLUMNS))
        new[:, Z], new[:, SEEN_SIZE] = z, size
        new[:, GIVEN], new[:, VARIANCE] = given, variance
        new[:, UNMEASURED], new[:, MANEUVERED] = unmeasured, maneuvered
        new[:, WHOLE], new[:, STEADY_CAMERA] = whole, steady
        if every:
            in_a_row *= steady
            in_a_row += 1
        else:
            ring[:, UNMEASURED] = ring[:, WHOLE] = 0.0
            ring[track] = new
            in_a_row[track] = in_a_row[track] * steady + 1
        self._frame += 1
        return self._frame % EVERY == 0

    def newest_first(self) -> Indices:
        """Return the slots of the last frames, (RING,)."""
        return (self._frame - 1 - np.arange(RING)) % RING

    def ages(self, dt: float) -> Floats:
        """Return the time since each frame, by slot, (RING,) [s].

        :param dt: since the last one [s].
        """
        return np.asarray(self.stamps[(self._frame - 1) % RING] - self.stamps + dt)

    def since_look(self, dt: float) -> float:
        """Return the time since the last frame with a look [s]; dt as in ages()."""
        return float(self.ages(dt)[(self._frame - 1 - self._frame % EVERY) % RING])
