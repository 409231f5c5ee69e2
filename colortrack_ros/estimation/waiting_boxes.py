"""Boxes of targets that somebody names, until a frame comes."""

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]


class WaitingBoxes:
    """Boxes that wait for the next frame: u, v of the top left pixel, width and height [px].

    :param targets: (N, 4) of the first frame, and of the first one after each restart.
    :ivar refused: boxes refused so far: too small, outside the picture, or one too many.
    """

    def __init__(self, targets: ArrayLike = ()) -> None:
        self.targets, self.refused = targets, 0
        self.restart()

    def restart(self) -> None:
        """Wait for a first frame."""
        self._boxes = _boxes(self.targets)
        self._offered = np.zeros(len(self._boxes), bool)

    def __len__(self) -> int:
        return len(self._boxes)

    def add(self, boxes: ArrayLike, *, offered: bool) -> None:
        """Take boxes of the next frame.

        :param boxes: (N, 4).
        :param offered: they are for where no target is yet.
        """
        more = _boxes(boxes)
        self._boxes = np.concatenate([self._boxes, more])
        self._offered = np.concatenate([self._offered, np.full(len(more), offered)])

    def take(self) -> tuple[Floats, Bools]:
        """The boxes, (N, 4), and which are offered, (N,): none waits any more."""
        taken = self._boxes, self._offered
        self._boxes, self._offered = taken[0][:0], taken[1][:0]
        return taken


def _boxes(values: ArrayLike) -> Floats:
    """(N, 4) of any numbers of boxes."""
    return np.asarray(values, float).reshape(-1, 4)
