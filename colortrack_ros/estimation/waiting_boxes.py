"""Boxes of requested targets, kept until the next frame arrives."""

import numpy as np
from numpy.typing import ArrayLike

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats


class WaitingBoxes:
    """Boxes that wait for the next frame: u, v of the top left pixel, width and height [px].

    :param targets: (N, 4) for the first frame, and for the first one after each restart.
    :ivar refused: number of boxes refused so far: too small, outside the picture, or above the
        limit.
    :ivar took_named: whether some of those taken last were not only offered.
    """

    def __init__(self, targets: ArrayLike = ()) -> None:
        self.targets, self.refused, self.took_named = targets, 0, False
        self.restart()

    def restart(self) -> None:
        """Offer the targets to the next frame again."""
        self._boxes = _boxes(self.targets)
        self._offered = np.zeros(len(self._boxes), bool)

    def name(self, targets: ArrayLike) -> None:
        """Offer other targets to the next frame, and after each restart.

        Those of before that still wait for a frame, as while pictures are paused, are wanted no
        more.

        :param targets: (N, 4).
        """
        self.targets = targets
        detected = self._boxes[self._offered]
        self.restart()
        self.add(detected, offered=True)

    def __len__(self) -> int:
        return len(self._boxes)

    def add(self, boxes: ArrayLike, *, offered: bool) -> None:
        """Add boxes for the next frame.

        :param boxes: (N, 4).
        :param offered: use them only where there is no target yet.
        """
        more = _boxes(boxes)
        self._boxes = np.concatenate([self._boxes, more])
        self._offered = np.concatenate([self._offered, np.full(len(more), offered)])

    def take(self) -> tuple[Floats, Bools]:
        """Remove and return the boxes, (N, 4), and which of them are only offered, (N,)."""
        taken = self._boxes, self._offered
        self.took_named = not self._offered.all()
        self._boxes, self._offered = taken[0][:0], taken[1][:0]
        return taken


def _boxes(values: ArrayLike) -> Floats:
    """Values of any number of boxes as (N, 4).

    :raises ValueError: they are not whole boxes.
    """
    try:
        return np.asarray(values, float).reshape(-1, 4)
    except (TypeError, ValueError):
        raise ValueError(
            f'boxes: expected (N, 4), left, top, width and height of each [px], got {values!r}'
        ) from None
