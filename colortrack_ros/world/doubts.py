"""Doubts: objects whose location contradicts other evidence; they are not published."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.world.checks import BlobSizes
from colortrack_ros.world.checks import off_height
from colortrack_ros.world.checks import off_size
from colortrack_ros.world.checks import other_diameters
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.consistency import inconsistency
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.mistakes import Mistakes
from colortrack_ros.world.objects import Objects
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

CHECKED = 10
"""Pictures per check for contradictions, besides those in which an object begins: mistakes last.
Chosen."""

AGREEING = 3
"""Successive checks that must agree. Chosen."""

CONTRADICTED = 0.5
"""Share of contradicting objects from which on no object of a camera is trusted. A single one may
be of another kind than its color says. Chosen: the majority."""


class Doubts:
    """Evidence against the cameras, and thus against the objects that they see.

    :param suspect: whether blobs were too small for where their objects were by other ranges.
    """

    def __init__(self, config: LocatorConfig, cameras: int, suspect: bool) -> None:
        self._config, self._suspect = config, suspect
        self._mistakes = [
            Mistakes(
                config.camera_pose_sigma,
                config.odometry_sigma,
                config.way_sigma,
                config.stamp_sigma,
            )
            for _ in range(cameras)
        ]
        self._pictures = self._stamp = 0
        self._newest = 0
        self._wrong = np.zeros(cameras, bool)
        self._unfit, self._looks = [''] * cameras, [0] * cameras
        self._contradicted: set[int] = set()
        self._shares: dict[int, float] = {}

    @property
    def reason(self) -> str:
        """Why no object is trusted; empty if some are."""
        if np.count_nonzero(self._wrong):
            return 'what is seen is not where it is located: nothing is published'
        return self._made()

    def _made(self) -> str:
        """Return which mistake was made, or that one was."""
        made = next((mistakes.made for mistakes in self._mistakes if mistakes.made), '')
        if made:
            return f'nothing is published, since what moves would stand if not: {made}'
        unfit = next((line for line in self._unfit if line), '')
        return unfit and f'nothing is published: {unfit}'

    def believed(self, ids: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which objects, (N,) by their IDs, nothing contradicts."""
        if self.reason:
            return np.zeros(len(ids), bool)
        if not self._contradicted:
            return np.ones(len(ids), bool)
        return ~np.isin(ids, list(self._contradicted))

    def shares(self, ids: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the spread of objects, (N,) by their IDs, if their diameters may be wrong.

        See :func:`other_diameters`.
        """
        return np.array([self._shares.get(one, 0.0) for one in ids.tolist()])

    def see(
        self,
        stamp: int,
        view: View,
        tracks: NDArray[np.uint32],
        measured: Measured,
        kinds: Kinds,
        objects: Objects,
        camera: int,
    ) -> None:
        """Add a picture to the search for mistakes.

        :param tracks: (K,) IDs; measured, kinds: of each; objects: after it.
        """
        ground, self._stamp = self._config.ground_height, stamp
        self._mistakes[camera].see(stamp, view, tracks, measured, kinds, ground, objects, camera)
        if self._config.method == 'depth':
            self._thicken(tracks, measured, objects, camera)

    def lines(
        self,
        objects: Objects,
        found: NDArray[np.uint32],
        seen: NDArray[np.void],
        view: View,
        camera: int,
    ) -> list[str]:
        """Return the contradictions, one line each; for the parameters see :func:`off_size`."""
        newest = int(objects.object_id.max(initial=0))
        self._pictures += 1
        if self._pictures % CHECKED != 1 and newest <= self._newest:
            return []
        self._newest = newest
        measured = np.isin(objects.track_id[:, camera], found)
        height, below = off_height(objects, view, self._config)
        sizes = BlobSizes.of_picture(objects, found, seen, view, camera, self._config)
        bound, method = objects.kinds.bound, self._config.method
        ids = objects.object_id
        self._resize(sizes, objects, view)
        # objects located by size always have the expected size
        elsewhere_told = (bound & (method == 'ground')) | (method in ('depth', 'fused'))
        size, elsewhere = off_size(sizes, ids)
        told = ((sizes.of & elsewhere_told) | (bound & (method in ('size', 'depth')))) & measured
        wrong = (below | elsewhere) & told
        self._contradicted -= set(ids[told & ~wrong].tolist())
        self._contradicted = (self._contradicted | set(ids[wrong].tolist())) & set(ids.tolist())
        if told.any():
            self._wrong[camera] = np.count_nonzero(wrong) >= CONTRADICTED * np.count_nonzero(told)
        # an object whose measurement was refused may have been moved
        unused = objects.updates[:, camera] == self._stamp
        unused &= (bound & (method == 'ground')) | (method == 'depth')
        reported = self._suspect or bool(self._unfit[camera])
        sizes = sizes.take(unused)
        self._fit(camera, inconsistency(objects.belief, camera, sizes, reported))
        made = self._made()
        odometry = self._mistakes[camera].odometry
        return [made] if made else [line for line in (height, size, odometry) if line]

    def _resize(self, sizes: BlobSizes, objects: Objects, view: View) -> None:
        """Note the spread of what the ground locates, and keep that of what is not measured."""
        if self._config.method == 'ground':
            self._shares |= other_diameters(sizes, objects, view, self._config)
        there = objects.object_id.tolist()
        self._shares = {one: self._shares[one] for one in there if one in self._shares}

    def _thicken(
        self, tracks: NDArray[np.uint32], measured: Measured, objects: Objects, camera: int
    ) -> None:
        """Note the spread of what depth locates: 0 if it is known how thick it is."""
        each = measured.aligned(tracks, objects.track_id[:, camera])
        located = each.used[:, DEPTH]
        shares = np.sqrt(each.lasting[located, DEPTH]) / each.z[located, DEPTH]
        ids = objects.object_id[located].tolist()
        self._shares |= dict(zip(ids, shares.tolist(), strict=True))

    def _fit(self, camera: int, line: str) -> None:
        """Note an inconsistency, or that there is none, once several checks agree."""
        self._looks[camera] = (
            self._looks[camera] + 1 if bool(line) != bool(self._unfit[camera]) else 0
        )
        if self._looks[camera] >= AGREEING:
            self._unfit[camera], self._looks[camera] = line, 0
