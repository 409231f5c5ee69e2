"""The last measurements of each track, kept so that what they tell is learned every few frames."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.records import Records

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

EVERY = 5
"""Frames from one look at the measurements to the next, which takes all of these, to save time.
Assumed: in a sixth of a second noise and process noise change little."""

RING = 16
"""Frames of which measurements are kept: six measurements tell how noisy they are, see differences,
and of objects that are missed every other time eight are in so many frames."""

Z, GIVEN = slice(0, 2), slice(2, 4)
VARIANCE, UNMEASURED, MANEUVERED, WHOLE, STEADY_CAMERA, RING_COLUMNS = range(4, 10)
"""Columns of what is kept of a measurement: position by axis [px]; variance by axis as given, and
their mean as used [px^2]; time since the one before [s], 0 for none; probability that the track has
maneuvered in it; 1 if it was measured wholly; 1 if it was so and in the last frame as well."""

RECENT_FIELDS = [('measured', 'f8', (RING, RING_COLUMNS)), ('in_a_row', 'i8')]
"""What is recorded of a track: its last measurements by frame, the oldest overwritten, and how many
there were in a row."""


class Recent:
    """Which of the last frames is where in the records, and when it was.

    :ivar stamps: (RING,) of the frames [s], by slot, from any time.
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
        whole: NDArray[np.bool_],
        steady: NDArray[np.bool_],
        dt: float,
    ) -> bool:
        """Take what was measured in a frame; tell whether it is time to look at it.

        :param records: (N,) of all tracks, with RECENT_FIELDS.
        :param track: (K,) which were measured, each once; for the rest see the columns.
        :param dt: since the last frame [s].
        """
        slot = self._frame % RING
        self.stamps[slot] = self.stamps[slot - 1] + dt
        new = np.empty((len(track), RING_COLUMNS))
        new[:, Z] = z
        new[:, GIVEN], new[:, VARIANCE] = given, variance
        new[:, UNMEASURED], new[:, MANEUVERED] = unmeasured, maneuvered
        new[:, WHOLE], new[:, STEADY_CAMERA] = whole, steady
        ring, in_a_row = records['measured'][:, slot], records['in_a_row']
        if len(track) == len(records):
            ring[:] = new
            in_a_row *= steady
            in_a_row += 1
        else:
            ring[:, UNMEASURED] = ring[:, WHOLE] = 0.0
            ring[track] = new
            in_a_row[track] = in_a_row[track] * steady + 1
        self._frame += 1
        return self._frame % EVERY == 0

    def newest_first(self) -> Indices:
        """(RING,) slots of the last frames."""
        return (self._frame - 1 - np.arange(RING)) % RING

    def ages(self, dt: float) -> Floats:
        """(RING,) time since the frames, by slot [s].

        :param dt: since the last one [s].
        """
        return np.asarray(self.stamps[(self._frame - 1) % RING] - self.stamps + dt)

    def since_look(self, dt: float) -> float:
        """Time since the last frame in which it was time to look [s]; dt as in ages()."""
        return float(self.ages(dt)[(self._frame - 1 - self._frame % EVERY) % RING])
