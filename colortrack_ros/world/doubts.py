"""Which objects are not where they are located, by all that tells: they are not published."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.world.checks import off_height
from colortrack_ros.world.checks import off_size
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.mistakes import Mistakes
from colortrack_ros.world.objects import Objects
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

CHECKED = 10
"""Of so many pictures one is looked at for what does not fit together, and those in which an object
begins: what is wrong lasts."""

CONTRADICTED = 0.5
"""Share of the objects that contradict a camera from which on none of its objects is believed: one
is an object that is no such object."""


class Doubts:
    """What contradicts the cameras, and so the objects that they see."""

    def __init__(self, config: LocatorConfig, cameras: int) -> None:
        self._config = config
        self._mistakes = [Mistakes(config.camera_pose_sigma) for _ in range(cameras)]
        self._pictures = 0
        self._newest = 0
        self._wrong = np.zeros(cameras, bool)
        self._contradicted: set[int] = set()

    @property
    def reason(self) -> str:
        """Why no object is believed; empty if some are."""
        if self._wrong.any():
            return 'what is seen is not where it is located: nothing is published'
        return self._made()

    def _made(self) -> str:
        """The mistake that has been made."""
        made = next((mistakes.made for mistakes in self._mistakes if mistakes.made), '')
        return made and f'nothing is published, since what moves would stand if not: {made}'

    def believed(self, ids: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which objects, (N,) by their IDs, nothing contradicts."""
        if self.reason:
            return np.zeros(len(ids), bool)
        if not self._contradicted:
            return np.ones(len(ids), bool)
        return ~np.isin(ids, list(self._contradicted))

    def see(
        self,
        stamp: int,
        view: View,
        tracks: NDArray[np.uint32],
        measured: Measured,
        kinds: Kinds,
        camera: int,
    ) -> None:
        """Take what a picture shows.

        :param tracks: (K,) IDs; measured, kinds: of each.
        """
        ground = self._config.ground_height
        self._mistakes[camera].see(stamp, view, tracks, measured, kinds, ground)

    def lines(
        self,
        objects: Objects,
        found: NDArray[np.uint32],
        seen: NDArray[np.void],
        view: View,
        camera: int,
    ) -> list[str]:
        """What does not fit, one line each; for the parameters see :func:`off_size`."""
        newest = int(objects.object_id.max(initial=0))
        self._pictures += 1
        if self._pictures % CHECKED != 1 and newest <= self._newest:
            return []
        self._newest = newest
        measured = np.isin(objects.track_id[:, camera], found)
        height, below = off_height(objects, view, self._config)
        size, sized, elsewhere = off_size(objects, found, seen, view, camera, self._config)
        bound, method = objects.kinds.bound, self._config.method
        lies = bound & (method in ('size', 'depth'))
        # what is located by its size always has it there
        sized &= (bound & (method == 'ground')) | (method in ('depth', 'fused'))
        told = (sized | lies) & measured
        wrong = (below | elsewhere) & told
        ids = objects.object_id
        self._contradicted -= set(ids[told & ~wrong].tolist())
        self._contradicted = (self._contradicted | set(ids[wrong].tolist())) & set(ids.tolist())
        if told.any():
            self._wrong[camera] = np.count_nonzero(wrong) >= CONTRADICTED * np.count_nonzero(told)
        made = self._made()
        return [made] if made else [line for line in (height, size) if line]
