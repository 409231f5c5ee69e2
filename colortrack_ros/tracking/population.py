"""Population: the number of objects of each color, where known, and their IDs."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Indices

Colors = NDArray[np.uint32]


class Population:
    """Assigns the IDs 1 to n to n objects, color by color.

    :param counts: number of objects of each color; 0 for unknown.
    """

    def __init__(self, counts: Sequence[int]) -> None:
        ends = 1 + np.cumsum([*counts, 0])
        self._counts = np.array([*counts, 0])
        self._next = ends - self._counts
        self._ends = ends
        self.total = int(ends[-1]) - 1
        """Number of objects, and the last of their IDs."""

    def is_counted(self, color: Colors) -> Bools:
        """Return for which colors, (K,), the number of objects is known, (K,)."""
        return np.asarray(self._counts[self._place(color)] > 0)

    def is_complete(self, color: Colors) -> Bools:
        """Return for which colors, (K,), all objects have been seen, (K,)."""
        place = self._place(color)
        return self.is_counted(color) & (self._next[place] == self._ends[place])

    def is_unnamed(self, track_id: NDArray[np.uint32], color: Colors) -> Bools:
        """Return which tracks, (K,), of counted colors are unidentified, (K,)."""
        return self.is_counted(color) & (track_id > self.total)

    def name(self, color: Colors) -> NDArray[np.uint32]:
        """Return IDs for objects seen for the first time, (K,); 0 for surplus ones.

        :param color: (K,), each counted.
        """
        ids = np.zeros(len(color), np.uint32)
        for k, place in enumerate(self._place(color)):
            if self._next[place] < self._ends[place]:
                ids[k] = self._next[place]
                self._next[place] += 1
        return ids

    def _place(self, color: Colors) -> Indices:
        """Return the indices of colors in the counts; those beyond the counts get the last."""
        return np.minimum(color.astype(np.intp), len(self._counts) - 1)
