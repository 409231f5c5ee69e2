"""How large things usually are, at each place of the picture."""

import cv2
import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.boxes import extents

PLACE = 16
"""Side of the squares that are one place [px]: a little more than that of the least thing
(min_area). With half and twice the value mean MOTA of 21 clips is 0.557 and 0.554, not 0.555
(benchmark/notes/contours.md)."""

PRIOR_SECONDS = 3.0
"""At a place where things have been for so long in all, half of what is usual there is what has
been there, half what is usual in the picture [s]: MOTION_SECONDS. Half and twice the value: 0.553
and 0.557, not 0.555 (as above)."""

FORGET_SECONDS = 60.0
"""Time constant with which sizes are forgotten [s]: many people walk by in that time. Assumed: half
and twice the value change nothing beyond 0.001 (as above)."""


class UsualArea:
    """Geometric mean of the areas of the boxes of things, over time, for each place.

    What is far away is small, and usual there. Where little has been it is the mean of all places,
    for which large things count more, since they cover more of them: what falls apart has more
    parts than wholes.
    """

    def __init__(self) -> None:
        self._seen = np.zeros((0, 0, 2))  # time, and its product with the logarithm of the area

    def learn(self, box: Floats, size: tuple[int, ...], seconds: float) -> None:
        """Learn from the things in a picture.

        :param box: (N, 4) of things that are seen [px].
        :param size: of the picture: height, width.
        :param seconds: since the last picture [s].
        """
        shape = -(-size[0] // PLACE), -(-size[1] // PLACE), 2
        if self._seen.shape != shape:
            self._seen = np.zeros(shape)
        self._seen *= np.exp(-seconds / FORGET_SECONDS)
        amount = seconds * np.stack([np.ones(len(box)), np.log(extents(box))], axis=1)
        for (left, top, right, bottom), each in zip(self._places(box), amount, strict=True):
            self._seen[top:bottom, left:right] += each

    def at(self, box: Floats) -> Floats:
        """Return the usual area at the places of boxes, (N, 4) [px]: (N,) [px^2], 0 if unknown."""
        if not self._seen.any():
            return np.zeros(len(box))
        sums = cv2.integral(self._seen)
        left, top, right, bottom = self._places(box).T
        here = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
        time, logs = here.T / ((bottom - top) * (right - left))
        usual = sums[-1, -1, 1] / sums[-1, -1, 0]
        return np.asarray(np.exp((logs + PRIOR_SECONDS * usual) / (time + PRIOR_SECONDS)))

    def _places(self, box: Floats) -> Indices:
        """Return the first place of each box, and the one after its last one, (N, 4)."""
        last = np.tile(np.array(self._seen.shape[1::-1]) - 1, 2)
        return np.asarray(np.clip(box.astype(int) // PLACE, 0, last) + np.array([0, 0, 1, 1]))
