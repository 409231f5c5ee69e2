"""Which detections a tracker takes: what is broken, repeated, or too many is told and left out."""

from collections.abc import Callable
import warnings

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import Floats
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.measurements import accept
from colortrack_ros.tracking.measurements import Measurements

USED_BYTES = 68
"""Used bytes of a row of DETECTION; the rest is padding with arbitrary contents."""

FIRST_ONES = 30
"""Detections, all in the corner's pixel, at which their unit is doubted: a second's, of one object.
Assumed."""

MANY_COLORS = 30
"""Detections after the first frame, each with a color of its own, at which colors seem to be
numbers of detections. Assumed: a detector looks for fewer colors, and finds one of them again."""

MANY_PARTS = 100
"""Messages on end with one stamp at which it seems that nobody sets stamps: 3 s of a usual camera.
Assumed: no detector splits a frame into as many."""

SCORE_ERROR = 1e-3
"""By how much a score may be off 0 to 1, by rounding. Assumed."""


class Screening:
    """Refuses, counts and reports detections that the tracker cannot use."""

    def __init__(self) -> None:
        self.refuse: Callable[[str], object] = _warn
        """Takes the reason for each frame with such detections; by default it is a UserWarning."""
        self.dropped = 0
        """Detections refused so far: not finite, absurdly large, or with an invalid covariance."""
        self.repeated = 0
        """Detections refused so far: the same as before, with the same stamp."""
        self.crowded_out = 0
        """Detections left out so far: the smallest of a frame with more than max_detections."""
        self._known = np.zeros(0, DETECTION)
        self._unsure = FIRST_ONES
        """How many more detections in the corner's pixel raise doubts; 0 once that is decided."""
        self._colors: set[int] | None = set()
        """Of all detections so far, while no color was seen twice."""
        self._together = 0
        """How many of these are of the first frame, which may have as many classes."""
        self._parts = 0
        """Messages on end that had the stamp of the one before."""
        self._unscored = FIRST_ONES
        """How many more detections raise doubts about their scores; 0 once that is decided."""
        self._camera: str | None = None
        self._other_camera: str | None = None
        """Frame IDs of the last message, and of the last one that had another."""

    def measure(
        self, detections: Detections, learned: Adaptation, config: TrackerConfig, *, again: bool
    ) -> Measurements:
        """Convert the detections of a frame.

        :param learned: size of the picture, which is learned here, and noise of the detections.
        :param again: whether these are more detections of the previous stamp.
        """
        rows = detections.rows
        if detections.frame_id != self._camera:
            self._meet(detections.frame_id)
        if again:
            rows = self._add(rows)
        else:
            self._known, self._parts = rows, 0
        few = largest(rows, config.max_detections)
        if few is not rows:
            self.crowded_out += len(rows) - len(few)
            self.refuse(f'the smallest detections: expected max_detections={len(few)} at most')
        given = all(config.image_size)
        learned.know_size(config.image_size if given else detections.image_size)
        blobs = accept(few, config, learned)
        if len(blobs.rows) < len(few):
            self.dropped += len(few) - len(blobs.rows)
            self.refuse('detections: expected up to 1e6 px, a positive definite or zero covariance')
        if self._unsure and len(blobs.z) and self._are_shares(blobs.z):
            self.refuse('positions: expected px, got 0 to 1; are they shares of the picture?')
        if self._unscored and self._are_unscaled(blobs.rows['score']):
            self.refuse('scores: expected 0 to 1, got others, which start_score does not fit')
        if self._colors is not None and self._are_numbers(blobs.rows['color'], self._colors):
            self.refuse('colors: expected one that a thing keeps, got another for each detection')
        learned.learn_size(blobs.z)
        if config.detection_covariance:
            blobs.scale(learned.noisiness)
        return blobs

    def _add(self, rows: NDArray[np.void]) -> NDArray[np.void]:
        """Return which of the rows, (N,) of dtype DETECTION, are new among those of their stamp.

        With a stamp that never changes all would be of one moment, and tracks would pile up.
        """
        self._parts += 1
        if self._parts >= MANY_PARTS:
            self.crowded_out += len(rows)
            self.refuse('messages: expected a stamp for each frame, got the same for all of late')
            return rows[:0]
        new = unrepeated(rows, self._known)
        self.repeated += len(rows) - len(new)
        self._known = np.concatenate([self._known, new], dtype=DETECTION)
        return new

    def _are_unscaled(self, score: NDArray[np.float32]) -> bool:
        """Decide, once, whether scores, (M,), are on another scale, such as logits."""
        known = np.abs(score - 0.5) <= 0.5 + SCORE_ERROR
        are_unscaled = bool(np.count_nonzero(known) < len(score))
        self._unscored = 0 if are_unscaled else max(self._unscored - len(score), 0)
        return are_unscaled

    def _are_shares(self, z: Floats) -> bool:
        """Decide, once, whether positions z, (M, 2), seem to be shares of the picture."""
        are_pixels = bool(z.max() > 1 or z.min() < 0)
        self._unsure = 0 if are_pixels else max(self._unsure - len(z), 0)
        return not (are_pixels or self._unsure)

    def _are_numbers(self, color: NDArray[np.uint32], known: set[int]) -> bool:
        """Decide, once, whether colors, (M,), seem to number the detections, as IDs of rows do.

        :param known: those of earlier frames.
        """
        before = len(known)
        known.update(color.tolist())
        self._together = self._together or len(known)
        are_numbers = len(known) - self._together >= MANY_COLORS
        if len(known) < before + len(color):
            self._colors, are_numbers = None, False
        elif are_numbers:
            self._colors = None
        return are_numbers

    def _meet(self, camera: str) -> None:
        """Note the frame ID of another camera, and tell when that of before comes back."""
        if camera == self._other_camera:
            two = ' and '.join(sorted([repr(camera), repr(self._camera)]))
            self.refuse(f'frame_id: expected one camera for each tracker, got {two} by turns')
        self._camera, self._other_camera = camera, self._camera


def _warn(reason: str) -> None:
    """Warn whoever has called Tracker.update: once for each line, since the text has no counts."""
    warnings.warn(f'refused: {reason}', stacklevel=5)


def unrepeated(rows: NDArray[np.void], known: NDArray[np.void]) -> NDArray[np.void]:
    """The rows, of dtype DETECTION, that are not bitwise equal to any of the known ones."""
    before = set(_bytes_of(known))
    return rows[np.array([row not in before for row in _bytes_of(rows)], bool)]


def _bytes_of(rows: NDArray[np.void]) -> list[bytes]:
    """Each row without its padding."""
    size = DETECTION.itemsize
    raw = np.ascontiguousarray(rows).tobytes()
    return [raw[i : i + USED_BYTES] for i in range(0, len(raw), size)]


def largest(rows: NDArray[np.void], most: int) -> NDArray[np.void]:
    """The rows, of dtype DETECTION; the largest, in their order, if there are more than most."""
    if len(rows) <= most:
        return rows
    return rows[np.sort(np.argsort(-rows['area'], kind='stable')[:most])]
