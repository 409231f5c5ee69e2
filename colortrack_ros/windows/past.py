"""Places that looked the same while their target was not there: they show its background."""

from collections import deque
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.records import Records
from colortrack_ros.windows.features import to_gray
from colortrack_ros.windows.lasting import sizes

KEPT_EVERY, KEPT_PICTURES = 0.25, 16
"""Time from one picture to the next [s], and how many are kept: 4 s, as long as most of what is
followed takes to walk its own length. Assumed."""

KEPT_PIXELS = 320 * 240
"""Least number of pixels of a picture that is kept; larger ones are kept a whole number of times
smaller. Assumed: half a camera's usual 640x480, whose noise is a quarter."""

LEAST_PLACE, MOST_ALONG = 36, 32
"""Fewest pixels of a place there that are compared, and the most along either side. Assumed: 36
of noise alone correlate by 0.17 (1 / sqrt(36)), far below what is asked for."""

SAME_AS_BEFORE = 0.9
"""Least correlation of a place with what it showed before. Of MOT16-09 and 11, KITTI-17,
TUD-Campus, and Stadtmitte, forwards and backwards, none of 6,983 windows on their target has as
much, and 7 % of 1,056 on nothing (benchmark/notes/windows.md)."""

LOOKS_LIKE, SEEN_BESIDE = 0.5, 2
"""Least correlation of things that look alike, and how far from its box [px] a thing that was seen
may be. Assumed: different things correlate by chance, 0.17 as above."""

CHANGED_LEVELS, LOOKED_AROUND = 15, 3.0
"""Least difference of a pixel that has changed [levels], and how many times a first box is as wide
and high as what is looked at around it. Chosen on 20 covers before real pictures: with 25 and 2.0
three of them, not one, are taken for targets that have come (benchmark/notes/windows.md)."""

LEFT_SHARE = 0.25
"""Largest share left of what the first box had that was not there before: less than a part that
could still be the target. Assumed; on KITTI-17 and TUD-Stadtmitte 0.05 to 0.2 are left."""


class _Picture(NamedTuple):
    """A picture as it was kept.

    gray: (rows, columns); stamp [ns]; shape: of the frame; boxes: of targets that were seen in it,
    by ID: u, v of the center, width and height [px]; unlike: one minus the correlation of first
    boxes with their place in it, by ID, of targets that are newer, 0 if that is no sign of them.
    """

    gray: NDArray[np.uint8]
    stamp: int
    shape: tuple[int, ...]
    boxes: dict[int, list[float]]
    unlike: dict[int, float]


class Past:
    """Pictures of the last seconds, and where the targets were in them."""

    def __init__(self) -> None:
        self._pictures: deque[_Picture] = deque(maxlen=KEPT_PICTURES)

    def keep(self, frame: Frame, records: Records) -> None:
        """Keep a frame if the last one is old enough, and where targets are seen in it."""
        if self._pictures and frame.stamp - self._pictures[-1].stamp < KEPT_EVERY * NANOSECONDS:
            return
        gray = _gray(frame, *(slice(0, side) for side in _size(frame)))
        box, ids = np.concatenate([records['seen'], sizes(records)], axis=1), records['track_id']
        seen = np.flatnonzero(records['looks'] == 0)
        boxes = dict(zip(ids[seen].tolist(), box[seen].tolist(), strict=True))
        self._pictures.append(_Picture(gray, frame.stamp, frame.image.shape, boxes, {}))

    def begin(self, frame: Frame, ids: list[int], boxes: Floats) -> None:
        """Note what the places of first boxes showed before.

        :param boxes: (N, 4) u, v of the center, width and height [px].
        """
        pictures = [p for p in self._pictures if p.shape == frame.image.shape]
        for track_id, box in zip(ids, boxes, strict=True):
            unlike = (1 - _likeness(frame, box, pictures)) * _are_filled(frame, box, pictures)
            for picture, value in zip(pictures, unlike.tolist(), strict=True):
                picture.unlike[track_id] = value

    def showed(self, frame: Frame, track_id: int, box: Floats) -> bool:
        """Return whether a place looked as it does now while a target was not there.

        It was not if it was seen beside that place, or if it is newer, and its first box showed
        something that had not been there. Two such pictures in a row have to agree.

        :param box: the place: u, v of the center, width, height [px].
        """
        pictures, most, place = [], [], box.tolist()
        for picture in self._pictures:
            if picture.shape != frame.image.shape:
                continue
            if picture.unlike.get(track_id, 0.0) > 1 - SAME_AS_BEFORE:
                limit = min(LEFT_SHARE * picture.unlike[track_id], 1 - SAME_AS_BEFORE)
            elif track_id in picture.boxes and _are_apart(picture.boxes[track_id], place):
                limit = 1 - SAME_AS_BEFORE
            else:
                continue
            pictures.append(picture)
            most.append(limit)
        if len(pictures) < 2:
            return False
        same = 1 - _likeness(frame, box, pictures) < most
        for k in np.flatnonzero(same).tolist():
            same[k] = not _was_alike(frame, pictures[k], track_id, box)
        # In one alone, or now and then, something like the target may have passed there.
        return bool((same[1:] & same[:-1]).any())


def _was_alike(frame: Frame, picture: _Picture, track_id: int, box: Floats) -> bool:
    """Return whether what was at a place then looked like a target that was seen elsewhere.

    Such things may move on by one place, as on a belt that stops: they are no background.

    :param box: the place.
    """
    if track_id not in picture.boxes:
        return False
    times, gray = _times(frame), picture.gray
    there = gray[_part(box, times, gray.shape)]
    wide = np.concatenate([picture.boxes[track_id][:2], box[2:] + 2 * SEEN_BESIDE * times])
    around = gray[_part(wide, times, gray.shape)]
    if min(np.subtract(around.shape, there.shape)) < 0:
        return False
    return bool(cv2.matchTemplate(around, there, cv2.TM_CCOEFF_NORMED).max() > LOOKS_LIKE)


def _are_filled(frame: Frame, box: Floats, pictures: list[_Picture]) -> list[bool]:
    """Return for which pictures most of what has changed since, in one piece, is in a first box.

    That is a target which has come. What reaches in from outside, as a hand or a passer-by, covers
    a target that had been there, and will be seen there again.
    """
    times, size = _times(frame), _size(frame)
    wide = _part(box * (1, 1, LOOKED_AROUND, LOOKED_AROUND), times, size)
    whole = np.zeros(size, bool)
    whole[_part(box, times, size)] = True
    inside, filled = whole[wide], []
    if not inside.any():
        return [False] * len(pictures)
    now = _gray(frame, *wide).astype(np.int16)
    for picture in pictures:
        changed = np.abs(picture.gray[wide] - now) > CHANGED_LEVELS
        pieces = cv2.connectedComponents(changed.astype(np.uint8))[1]
        reaching = np.unique(pieces[changed & inside])
        pixels = np.bincount(pieces.ravel())[reaching].sum()
        filled.append(bool(2 * (changed & inside).sum() > pixels))
    return filled


def _are_apart(one: list[float], other: list[float]) -> bool:
    """Return whether two boxes of u, v of the center, width and height do not overlap."""
    (u, v, w, h), (other_u, other_v, other_w, other_h) = one, other
    return 2 * abs(u - other_u) >= w + other_w or 2 * abs(v - other_v) >= h + other_h


def _times(frame: Frame) -> int:
    """How many times smaller a frame is kept."""
    height, width = frame.image.shape[:2]
    return max(int((height * width / KEPT_PIXELS) ** 0.5), 1)


def _size(frame: Frame) -> tuple[int, int]:
    """Rows and columns of a frame as it is kept."""
    times = _times(frame)
    return frame.image.shape[0] // times, frame.image.shape[1] // times


def _gray(frame: Frame, rows: slice, columns: slice) -> NDArray[np.uint8]:
    """Return the gray levels of a part of a frame as it is kept."""
    times = _times(frame)
    part = frame.image[tuple(slice(s.start * times, s.stop * times) for s in (rows, columns))]
    size = columns.stop - columns.start, rows.stop - rows.start
    small = np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA), np.uint8)
    return np.asarray(to_gray(small, frame.encoding)).astype(np.uint8)


def _part(box: Floats, times: int, size: tuple[int, ...]) -> tuple[slice, slice]:
    """Return the rows and columns of a place in pictures that are kept so many times smaller.

    :param size: their rows and columns.
    """
    limit = np.array(size[::-1])
    low = np.clip(np.ceil((box[:2] - box[2:] / 2) / times), 0, limit).astype(int)
    high = np.clip(np.floor((box[:2] + box[2:] / 2) / times), low, limit).astype(int)
    (left, top), (right, bottom) = low.tolist(), high.tolist()
    return slice(top, bottom), slice(left, right)


def _likeness(frame: Frame, box: Floats, pictures: list[_Picture]) -> Floats:
    """Return correlations of a place now with the same place in n pictures, (n,); 0: unknown."""
    nothing = np.zeros(len(pictures))
    rows, columns = _part(box, _times(frame), _size(frame))
    h, w = rows.stop - rows.start, columns.stop - columns.start
    if not pictures or w * h < LEAST_PLACE:
        return nothing
    steps = np.s_[:: -(-h // MOST_ALONG), :: -(-w // MOST_ALONG)]
    now = _gray(frame, rows, columns)[steps].ravel().astype(np.float32)
    then = np.array([p.gray[rows, columns][steps] for p in pictures], np.float32)
    then = then.reshape(len(pictures), -1)
    then -= then.mean(axis=1, keepdims=True)
    now = now - now.mean()
    norm = np.sqrt(np.dot(now, now) * np.einsum('ij,ij->i', then, then))
    return np.asarray(np.divide(then @ now, norm, out=nothing, where=norm > 0))
