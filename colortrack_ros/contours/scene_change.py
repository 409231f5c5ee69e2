"""Detection of scene changes: a cut, or a camera that was bumped or turned."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.background import STILLNESS_STEP
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.background_model import Picture

OTHER_SCENE = 'another scene stands still: a cut, or the camera was moved; targets have ended'
"""Reason for the restart, published with the tracks."""

LOOK_PIXELS = 76_800
"""Pixels of the reduced picture, as many as of 320x240, in which a bump by 5 px of 640 is 2 px.
Half and twice the value: MOTA of PETS S3.MF1 that trembles by 4 px 0.14 and 0.20, not 0.25, and
nothing else (as below)."""

TILE_SIDE = 8
"""Side of a tile [px of the reduced picture]: the correlation of noise in its 64 pixels has a
standard deviation of 1/8. With twice the value a bump by 5 px is not noticed (as below)."""

TEXTURED = 5.0
"""Least standard deviation of a textured tile [levels]: twice that of a camera's noise.
With half of it MOTA of PETS S3.MF1 that trembles by 4 px is 0.18, not 0.25, with twice the value a
bump by 5 px is not noticed (``benchmark/disturbed_contours.py CLIP OTHER --after 4 --constants
scene_change.TEXTURED``)."""

ALIKE = 0.5
"""Least correlation of tiles that show the same: four sigma of that of noise. With half the value a
bump by 5 px is not noticed; with 1 nothing matches (as above)."""

QUARTER_TILES = 16
"""Least number of textured tiles to judge a quarter of the picture: the standard deviation of a
share of one half is 1/8. Half and twice the value: what trembles by 4 px 0.16 and -0.12, not 0.25,
and nothing else (as above)."""

LEAST_SPREAD_OUT = 0.3
"""Least share of the rows times that of the columns in which texture has gone. Where it is less, a
thing may have left a plain background: the share of the picture that things cover at most
(foreground.MAX_FOREGROUND). Another scene is not noticed there, either."""


class Tiles:
    """Tiles of a picture, with their texture.

    :param picture: (H, W, channels).
    :ivar textured: (rows, columns) which tiles have texture.
    """

    def __init__(self, picture: Picture) -> None:
        height, width = picture.shape[:2]
        self._pitch = TILE_SIDE * max(1, int(np.sqrt(height * width / LOOK_PIXELS)))
        rows, columns = max(height // self._pitch, 1), max(width // self._pitch, 1)
        self._shape, size = (columns, rows), (columns * TILE_SIDE, rows * TILE_SIDE)
        self._whole = rows * self._pitch, columns * self._pitch
        whole = picture[: self._whole[0], : self._whole[1]]
        small = cv2.resize(whole, size, interpolation=cv2.INTER_AREA).reshape(*size[::-1], -1)
        equal = np.full((1, small.shape[2]), 1 / small.shape[2])
        gray = np.asarray(cv2.transform(small.astype(np.float32), equal), np.float32)
        mean = cv2.resize(self._mean(gray), size, interpolation=cv2.INTER_NEAREST)
        self._off = gray - mean
        self._sigma = np.sqrt(self._mean(self._off * self._off))
        self.textured: Bools = np.asarray(self._sigma > TEXTURED)

    def _mean(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the mean of each tile, (rows, columns)."""
        return np.asarray(cv2.resize(values, self._shape, interpolation=cv2.INTER_AREA))

    def free_of(self, known: Floats) -> Bools:
        """Return which tiles are not touched by any box, (N, 4) [px]."""
        free = np.ones(self.textured.shape, bool)
        for left, top, right, bottom in np.maximum(known // self._pitch, 0).astype(int).tolist():
            free[top : bottom + 1, left : right + 1] = False
        return free

    def touched(self, where: Bools) -> Bools:
        """Return which tiles have pixels of a mask, (H, W)."""
        whole = where[: self._whole[0], : self._whole[1]].astype(np.float32)
        return np.asarray(cv2.resize(whole, self._shape, interpolation=cv2.INTER_AREA) > 0)

    def alike(self, other: 'Tiles') -> Bools:
        """Return which tiles show the same in another picture of the same size."""
        common = self._mean(self._off * other._off)
        return np.asarray(common > ALIKE * np.maximum(self._sigma * other._sigma, 1.0))

    def mostly_as(self, other: 'Tiles', free: Bools) -> bool:
        """Return whether most texture is the same in another picture of the same size."""
        textured = self.textured & free
        return bool(2 * np.sum(textured & self.alike(other)) > np.sum(textured))


class SceneChange:
    """Tells another scene from things in front of the same one, by texture, in any light.

    The scene has changed if, in each quarter of the picture, most of the background's texture has
    gone, and most of the new texture stands still. A thing that leaves a plain background takes all
    of its texture along, but only from where it stood. The correlation of small tiles does not
    depend on the light; whatever moves, including the picture of a moving camera, does not stand
    still; a cover without texture shows nothing; and known targets are left out.

    :ivar seconds: time for which another scene has stood still [s].
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget everything seen."""
        self._backgrounds: list[Tiles] = []
        self._renewed = 0
        self._forget()

    def _forget(self) -> None:
        self._first: Tiles | None = None
        self._since, self.seconds = 0, 0.0

    def look(
        self,
        picture: Picture,
        stamp: int,
        backgrounds: list[Picture],
        known: Floats,
        settled: Bools | None = None,
    ) -> bool:
        """Take the next picture.

        :param picture: (H, W, channels).
        :param stamp: of the picture [ns].
        :param backgrounds: of the same shape.
        :param known: (N, 4) boxes of targets [px].
        :param settled: (H, W) where the backgrounds no longer show what moves; None if everywhere.
        :return: whether the background has gone.
        """
        age = (stamp - self._renewed) / NANOSECONDS
        if not self._backgrounds or not 0 <= age < STILLNESS_STEP:
            self._backgrounds = [Tiles(each) for each in backgrounds]
            self._renewed = stamp
        now = Tiles(picture)
        free = now.free_of(known)
        if settled is not None:
            free &= ~now.touched(~settled)
        if not self._has_gone(now, self._backgrounds, free):
            self._forget()
            return False
        if self._first is None or not now.mostly_as(self._first, free):
            self._first, self._since = now, stamp
        self.seconds = (stamp - self._since) / NANOSECONDS
        return True

    @staticmethod
    def _has_gone(now: Tiles, before: list[Tiles], free: Bools) -> bool:
        """Return whether, in each quarter with texture, most of the backgrounds' has gone."""
        textured = before[0].textured & free
        gone = textured & ~np.any([now.alike(each) for each in before], axis=0)
        middle = np.array(free.shape) // 2
        quarters = [
            np.s_[rows, columns]
            for rows in (np.s_[: middle[0]], np.s_[middle[0] :])
            for columns in (np.s_[: middle[1]], np.s_[middle[1] :])
        ]
        has, lost = (np.array([np.sum(x[q]) for q in quarters]) for x in (textured, gone))
        judged = has >= QUARTER_TILES
        spread = gone.any(axis=0).mean() * gone.any(axis=1).mean()
        is_all = judged.sum() >= 2 and (2 * lost > has)[judged].all()
        return bool(is_all and spread >= LEAST_SPREAD_OUT)
