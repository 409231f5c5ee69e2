"""Pictures of a camera that sways or trembles, moved back to where their background was learned."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.areas import Mask
from colortrack_ros.contours.background import STILL_LEVELS
from colortrack_ros.contours.background import StillBackground
from colortrack_ros.contours.scene_change import LEAST_SPREAD_OUT
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.background_model import Picture
from colortrack_ros.detection.pixels import channels_of

Gray = NDArray[np.uint8]
Part = tuple[slice, slice]

CORNER_CELLS = 12, 16
"""Rows and columns of cells of the picture, in each of which the best corner is found again, so
that they are spread evenly: 192, of which a crowd leaves enough. Of 108 as large a share moves
alike in a film of a highway (benchmark/notes/contours.md)."""

CORNER_BLOCK, FLOW_WINDOW = 5, (11, 11)
"""Sides of the block that makes a corner, and of the window that it is found by [px]. With OpenCV's
21 px as many move alike in that film (126 and 125 of 160), in twice the time."""

CHOOSING_COLUMNS = 640
"""Pictures are reduced to about this width to choose corners in: at 1920x1080 that took 34 ms."""

LEAST_STRENGTH = 1e-3
"""Least smaller eigenvalue of a corner's gradients, in OpenCV's units: the best corner of a cell is
0.0005 to 0.0009 in noise of 5 levels, twice a camera's (scene_change.TEXTURED)."""

LEAST_CORNERS = 16
"""Least number of corners that move alike: as many as judge a quarter of the picture
(scene_change.QUARTER_TILES)."""

ALIKE_PIXELS = 1.0
"""Corners that move alike differ by at most this [px]: in swaying films they are found to 0.1 to
0.6 px (standard deviation)."""

OFF_PIXELS = 0.6
"""The picture is moved by whole pixels, which leaves its levels as they are, and again once it is
off by this much [px]: more than a half, so that it does not go back and forth."""

MOVED_SHARE = 0.1
"""Farthest move as a share of the picture's sides: as much of the background is out of sight then,
and as much beside it is not looked at. Farther off it is another scene (scene_change)."""

USE_GUESS = cv2.OPTFLOW_USE_INITIAL_FLOW
"""Corners are looked for around where the last picture had them."""

RENEWAL_SECONDS = 1.5
"""Time after which corners are chosen in the background again [s]: learn_seconds."""


class Steady:
    """Finds how far the picture has moved as a whole, and moves it back.

    Corners of the background are found again by pyramidal Lucas-Kanade. If enough of those outside
    known targets are still where they were last, the camera stands still, whatever else moves. If
    not, the largest group of those that moved alike tells, if it is a larger share of them than
    things cover of a picture. Either has to be spread over as much of it: one thing is not. A crowd
    that walks one way is, and so the picture is moved only if that makes it more like the
    background.

    :ivar shift: (2,) columns and rows by which the picture is off to the right and down [px].
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Take the next picture as the one that others are moved to."""
        self.shift: Indices = np.zeros(2, int)
        self._off = np.zeros(2)
        self._gray: Gray = np.zeros((0, 0), np.uint8)
        self._corners = np.zeros((0, 2))
        self._renewed = 0

    def rest(self) -> None:
        """Leave pictures where they are until the next one that is steadied."""
        self.shift = np.zeros(2, int)

    def steadied(self, frame: Frame, background: StillBackground, known: Floats) -> Frame:
        """Return a frame moved back; what it does not show is background.

        A background that the camera has left while it was learned is learned anew.

        :param known: (N, 4) predicted boxes of targets in the picture [px].
        """
        picture = channels_of(frame)
        if min(picture.shape[:2]) < max(CORNER_CELLS):
            self.rest()
            return frame
        if not background.knows(picture):  # as each picture is that has another size
            self.restart()
            return frame
        gray = _gray(picture)
        starts, recent = gray.shape != self._gray.shape, background.recent
        if not starts and not self._look(gray, self.back(known), recent) and background.is_learning:
            background.restart()
            starts = True
        if starts:
            self.restart()
            self._choose(gray, frame.stamp)
            return frame
        if not 0 <= frame.stamp - self._renewed < RENEWAL_SECONDS * NANOSECONDS:
            self._choose(_gray(recent), frame.stamp)
        if not self.shift.any():
            return frame
        return replace(frame, image=_moved(frame.image, self.shift, recent))

    def back(self, box: Floats) -> Floats:
        """Return where boxes of the picture, (N, 4), are in the steadied one [px]."""
        return box - np.tile(self.shift, 2)

    def seen(self, mask: Mask) -> Mask:
        """Return a mask of the steadied picture, 0 where it shows what is out of sight."""
        if not self.shift.any():
            return mask
        there, _ = _overlap(self.shift, mask.shape)
        result = np.zeros_like(mask)
        result[there] = mask[there]
        return result

    def along(self, areas: Areas, picture: Picture) -> Areas:
        """Return where areas of the steadied picture are in the picture.

        They are cut where that ends, and where what was learned does.
        """
        if not self.shift.any():
            return areas
        box, last = areas.box + np.tile(self.shift, 2), np.array(picture.shape[1::-1]) - 1
        cut = areas.cut | np.hstack([box[:, :2] <= 0, box[:, 2:] >= last])
        return replace(areas, box=box, center=areas.center + self.shift, cut=cut)

    def _choose(self, gray: Gray, stamp: int) -> None:
        self._gray, self._renewed, self._corners = gray, stamp, _best_corners(gray)

    def _look(self, gray: Gray, known: Floats, background: Picture) -> bool:
        """Find how far a picture is off; as far as the last one where its corners do not tell.

        :return: whether it is within reach, as far as they tell.
        """
        corners, off = self._find(gray, self._corners[~_is_in(self._corners, known)])
        if len(off) < LEAST_CORNERS:
            return True
        size = np.array(gray.shape[::-1])
        alike: Bools = np.asarray((np.abs(off[:, None] - off) <= ALIKE_PIXELS).all(axis=2))
        most: Bools = np.asarray(alike[alike.sum(axis=1).argmax()])
        stay: Bools = np.asarray((np.abs(off - self._off) <= ALIKE_PIXELS).all(axis=1))
        if _are_of_scene(corners[stay], size):
            return self._follow(off[stay].mean(axis=0), gray, background)
        if most.mean() >= LEAST_SPREAD_OUT and _are_of_scene(corners[most], size):
            return self._follow(off[most].mean(axis=0), gray, background)
        return True

    def _find(self, gray: Gray, corners: Floats) -> tuple[Floats, Floats]:
        """Return those of corners that are found in a picture, and how far off, (P, 2) each."""
        if not len(corners):
            return corners, corners
        before, guess = (each.astype(np.float32) for each in (corners, corners + self._off))
        after, found, _ = cv2.calcOpticalFlowPyrLK(
            self._gray, gray, before, guess, winSize=FLOW_WINDOW, flags=USE_GUESS
        )
        there = np.asarray(after, float)
        seen = ((there >= 0) & (there < gray.shape[::-1])).all(axis=1) & (found[:, 0] > 0)
        return corners[seen], (there - corners)[seen]

    def _follow(self, off: Floats, gray: Gray, background: Picture) -> bool:
        """Move pictures as far as corners tell, if that is right; see _look for what it returns."""
        moves = bool((np.abs(off - self.shift) > OFF_PIXELS).any())
        shift = np.rint(off).astype(int) if moves else self.shift
        if moves and not _is_more_alike(gray, _gray(background), shift, self.shift):
            return True
        if (np.abs(off) > MOVED_SHARE * np.array(gray.shape[::-1])).any():
            return False
        self._off, self.shift = off, shift
        return True


def _are_of_scene(corners: Floats, size: Indices) -> bool:
    """Return whether corners, (P, 2), are enough and far enough apart to be of the scene.

    As if they were spread evenly, so that few that move alike by chance do not matter: the standard
    deviation of an even spread is its length over the square root of 12.
    """
    if len(corners) < LEAST_CORNERS:
        return False
    spread = np.sqrt(12) * corners.std(axis=0) / size
    return bool(spread.prod() >= LEAST_SPREAD_OUT)


def _best_corners(gray: Gray) -> Floats:
    """Return the strongest corner of each cell that has one, (P, 2)."""
    rows, columns = CORNER_CELLS
    step = max(min(round(gray.shape[1] / CHOOSING_COLUMNS), gray.shape[0] // rows), 1)
    if step > 1:
        small = gray.shape[1] // step, gray.shape[0] // step
        gray = np.asarray(cv2.resize(gray, small, interpolation=cv2.INTER_AREA), np.uint8)
    strength = cv2.cornerMinEigenVal(gray, CORNER_BLOCK)
    height, width = gray.shape[0] // rows, gray.shape[1] // columns
    cells = strength[: rows * height, : columns * width].reshape(rows, height, columns, width)
    cells = cells.transpose(0, 2, 1, 3).reshape(rows, columns, -1)
    v, u = np.divmod(cells.argmax(axis=2), width)
    u, v = u + width * np.arange(columns), v + height * np.arange(rows)[:, None]
    good = cells.max(axis=2) > LEAST_STRENGTH
    return step * np.stack([u[good], v[good]], axis=1) + (step - 1) / 2


def _gray(picture: Picture) -> Gray:
    """Return the mean of the channels, (H, W)."""
    channels = picture.shape[2]
    return np.asarray(cv2.transform(picture, np.full((1, channels), 1 / channels)), np.uint8)


def _is_in(points: Floats, box: Floats) -> Bools:
    """Return which points, (P, 2), are in any box, (N, 4)."""
    inside: Bools = (points[:, None] >= box[:, :2]) & (points[:, None] <= box[:, 2:])
    return np.asarray(np.any(inside.all(axis=2), axis=1))


def _overlap(shift: Indices, shape: tuple[int, ...]) -> tuple[Part, Part]:
    """Return which part of a steadied picture is in sight, and where the picture has it."""
    (right, down), (height, width) = shift.tolist(), shape[:2]
    there = np.s_[max(-down, 0) : height - max(down, 0), max(-right, 0) : width - max(right, 0)]
    here = np.s_[max(down, 0) : height + min(down, 0), max(right, 0) : width + min(right, 0)]
    return there, here


def _is_more_alike(gray: Gray, background: Gray, shift: Indices, other: Indices) -> bool:
    """Return whether a picture moved by shift is more like the background than moved by other.

    Compared are the pixels of the background that are in sight either way. One that shows something
    else counts the same, however much it differs.
    """
    low, high = np.minimum(shift, other).clip(max=0), np.maximum(shift, other).clip(min=0)
    if (high - low >= gray.shape[::-1]).any():
        return False
    (left, top), (right, bottom) = -low, gray.shape[::-1] - high
    ways = []
    for u, v in (shift.tolist(), other.tolist()):
        here = gray[top + v : bottom + v, left + u : right + u]
        apart = cv2.absdiff(here, background[top:bottom, left:right])
        _, little = cv2.threshold(apart, STILL_LEVELS, 0, cv2.THRESH_TRUNC)
        ways.append(cv2.sumElems(little)[0])
    return bool(ways[0] < ways[1])


def _moved(image: Gray, shift: Indices, background: Picture) -> Gray:
    """Return an image moved to the left and up by shift, on top of the background."""
    result = image.copy()
    result.reshape(*image.shape[:2], -1)[..., : background.shape[2]] = background
    there, here = _overlap(shift, image.shape)
    result[there] = image[here]
    return result
