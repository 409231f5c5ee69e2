"""Overlaps: whether objects in front of each other have detections of their own, one, or several.

A threshold turns touching blobs of one color into a single blob with a single box. A detector of
complete objects, such as a network, gives each object a box, and the boxes overlap. Then a box of
another size is neither merged nor cut, and a small one next to it is no piece: the box is in error.
"""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import DETECTION_BOX
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.rectangles import points_inside
from colortrack_ros.tracking.resolution import LEFT

LIKE_SIDES = 2.0
"""Largest ratio of the sides of two boxes that are compared: a smaller one is a piece, or lies on
the other. Assumed."""

RESOLVED_SHARE = 0.2
"""Share of overlapping objects among overlapping and merged ones above which objects count as
resolved. Assumed: many objects that a network fails to separate look merged. With 0.5, pedestrians
of two detectors lose 3 points of IDF1."""

FIRST_MERGED = 10.0
"""Initial count of merged objects. Assumed: it takes three overlapping ones to outweigh it."""

TWICE_SHARE, FIRST_ONCE = 0.05, 20.0
"""Share of detections that are duplicates above which the detector finds things twice, and initial
count of those that are none. Assumed: it takes two in the first twenty."""

LEAST_FRACTION = 0.01
"""Least difference of a side from whole pixels that is none of rounding [px]: single precision, of
shares of a picture 10,000 px wide, errs by 0.001."""

UNSCORED = 300
"""Frames without a score below 1 after which none tells of a network any longer. Assumed: in 10 s
of a network at least one detection is less than certain."""

SURE_LEFT = 0.999
"""Share of the best score that is kept at each frame with new boxes: half of it after 700. Assumed:
longer than a network is unsure of somebody in passing."""

MOST_OVERLAPPING = 8
"""Boxes compared with each, to bound the time. Assumed."""


class Overlaps:
    """Counts detections that overlap, and objects that share a detection.

    :ivar find_twice: whether objects are found several times in a frame, see duplicates.
    :ivar are_estimated: whether boxes are estimates of a network, see see().
    """

    def __init__(self) -> None:
        self._overlap = self.find_twice = self.are_estimated = False
        self._estimates, self._outlines, self._unscored = 0.0, 0.0, UNSCORED
        self._twice, self._found = 0.0, FIRST_ONCE
        self._overlapping, self._merged, self._frame = 0.0, 0.0, 0
        self._best_score = 0.0
        self._least_sure = 0.0
        """Least score of a new object in the last frame that might have had one."""

    @property
    def are_resolved(self) -> bool:
        """Whether objects in front of each other have detections of their own, or none.

        Those of a network have, though few may be seen to overlap: of boxes that do, it suppresses
        all but the best.
        """
        return self.are_estimated or self._overlap

    def see(self, rows: NDArray[np.void], stated: int = 0) -> None:
        """Count the boxes of detections, (M,) of dtype DETECTION, that state no covariance.

        Those of a color detector state one, and count as outlines.

        A network says how sure it is, if only now and then: where it is certain, it states 1, as
        may its rounding. It estimates sides to fractions of a pixel; if they were rounded, the
        middle is between pixels or on one. The outline of a blob has whole pixels, and its centroid
        any fraction; a circle around one has no score.

        :param stated: number of detections of the frame that state a covariance.
        """
        size, score = rows.view(DETECTION_BOX)['size'], rows['score']
        boxed = size[:, 0] > 0
        is_scored = np.count_nonzero(boxed & (score > 0) & (score < 1)) > 0
        self._unscored = 0 if is_scored else self._unscored + 1
        middle = np.stack([rows['u'], rows['v']], axis=1)
        fraction = _from_whole(size) > LEAST_FRACTION
        estimated = boxed & (fraction | (_from_whole(2 * middle) < LEAST_FRACTION))
        count, boxes = int(np.count_nonzero(estimated)), int(np.count_nonzero(boxed))
        self._estimates = LEFT * self._estimates + count
        self._outlines = LEFT * self._outlines + boxes - count + stated
        self.are_estimated = self._estimates > self._outlines and self._unscored < UNSCORED

    def look(self, box: Floats, color: NDArray[np.uint32]) -> None:
        """Count, every few frames, the boxes that contain the center of another.

        :param box: (M, 2, 2) see Measurements; color: (M,) of the detections.
        """
        self._frame += 1
        if self._frame % EVERY:
            return
        center, sides = box.mean(axis=1), box[:, 1] - box[:, 0]
        one, other = points_inside(center, sides / 2, center, MOST_OVERLAPPING)
        pair = (one != other) & (color[one] == color[other])
        one, other = one[pair], other[pair]
        size, beside = sides[one], sides[other]
        like = are_like(size, beside).all(axis=1)
        self._overlapping = LEFT * self._overlapping + EVERY * np.count_nonzero(like) / 2
        self._merged *= LEFT
        self._overlap = self._overlapping > RESOLVED_SHARE * (
            self._overlapping + self._merged + FIRST_MERGED
        )

    def may_start(self, free: Indices, rows: NDArray[np.void], least: float) -> Indices:
        """Those of the free detections, (K,), that may be new objects.

        Weak boxes of a network are mostly seen twice or on nothing, but go on with an object that
        is known (Zhang et al. 2022, ByteTrack). Networks differ in how sure they ever are: the
        best score of late, 1 at most, counts as sure. It is forgotten, so that after a single sure
        box, or where night falls, nothing that is less sure has to stay unseen for good.

        :param rows: (M,) of dtype DETECTION.
        :param least: least score of a new object, as a share of the best.
        """
        if self.are_estimated:
            score = rows['score']
            self._best_score = max(SURE_LEFT * self._best_score, min(score.max(), 1.0))
            self._least_sure = least * self._best_score
            free = free[score[free] >= self._least_sure]
        return free

    @property
    def weak_below(self) -> float:
        """Score below which a box is weak; 0 if none is."""
        return self._least_sure if self.are_estimated else 0.0

    def count_merged(self, count: int) -> None:
        """Add the objects of a frame that appear to share a detection."""
        self._merged += count

    def count_duplicates(self, count: int, found: int) -> None:
        """Add the duplicates of a frame, and all of its detections."""
        self._twice = LEFT * self._twice + count
        self._found = LEFT * self._found + (1 - LEFT) * FIRST_ONCE + found
        self.find_twice = self._twice > TWICE_SHARE * self._found


def _from_whole(value: Floats) -> Floats:
    """(M,) largest difference of a row from whole numbers."""
    return np.asarray(np.abs(value - np.rint(value)).max(axis=1), np.float64)


def are_like(size: Floats, beside: Floats) -> Bools:
    """Whether sides, (K, 2) and (K, 2) by axis, may be those of one object; none is 0."""
    return np.asarray(np.maximum(size, beside) < LIKE_SIDES * np.minimum(size, beside))
