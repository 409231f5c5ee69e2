"""Segmentation of what moves (De Bem 2007, section 3), in every frame."""

import cv2
import numpy as np

from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.areas import find_areas
from colortrack_ros.contours.areas import Mask
from colortrack_ros.contours.background import StillBackground
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.differencing import Differencing
from colortrack_ros.contours.displaced import is_displaced
from colortrack_ros.contours.scene_change import SceneChange
from colortrack_ros.contours.shadows import without_shadows
from colortrack_ros.contours.steady import Steady
from colortrack_ros.contours.unknown import goes_on
from colortrack_ros.contours.usual import UsualArea
from colortrack_ros.contours.vacant import is_vacant
from colortrack_ros.contours.weak import with_weak
from colortrack_ros.data import Bools
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.background_model import Picture
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.methods import BackgroundSubtraction
from colortrack_ros.detection.morphology import open_
from colortrack_ros.detection.pixels import channels_of
from colortrack_ros.estimation.boxes import intersections
from colortrack_ros.estimation.records import Records

MAX_FOREGROUND = 0.3
"""If a larger share of the picture differs, the background itself moves, since most of a picture is
background by definition. Half of it changes nothing on three real clips
(``benchmark/real_contours.py FOLDER --constants foreground.MAX_FOREGROUND``)."""

SETTLED_SECONDS = 1.5
"""Time after which another scene that stands still becomes the background [s]: learn_seconds. Half
and twice the value: MOTA of PETS S3.MF1 bumped by 30 px 0.44 and 0.47, not 0.52; a hand before it
for a second 0.55 and 0.74, not 0.74 (``benchmark/disturbed_contours.py CLIP OTHER --after 4
--constants foreground.SETTLED_SECONDS``)."""

BLIND_SECONDS = 3.0
"""Time of seeing nothing after which it is told [s]: twice that in which a scene is learned."""

BLIND = (
    'nothing new is looked for: the camera moves, or something covers what it saw; hold it still, '
    'or name targets (start: targets)'
)
"""What is told then."""

CLUTTER_SECONDS, CLUTTER_SHARE = 10.0, 0.3
"""Time [s], and share of it in which a place differs without anything moving on, for it to count as
flicker. IDF1 of PETS S3.MF1 is 0.84 (benchmark/notes/contours.md), 0.85 and 0.83 with half and
twice the first, 0.86 and 0.83 with half and twice the second (``benchmark/real_contours.py FOLDER
--constants foreground.CLUTTER_SHARE``)."""

RIM_SHARE = 0.3
"""Share of difference_threshold that a weak difference exceeds in the mean of 3x3 px as well, for
noise about half of weak.WEAK_SHARE. Chosen against the rim of 1 to 2 px that the Gaussian adds
beside what is strong (benchmark/notes/contours.md)."""


class Foreground:
    """Background subtraction like the detector's method `background`, or frame differencing.

    Subtraction, Gaussian, threshold, area opening, and opening are the detector's; the background
    starts with what has stood still longest. Differencing compares three pictures: something is
    where the current one differs from both earlier ones.

    :ivar is_new: whether another scene starts with this frame.
    :ivar is_seen: whether this frame was compared with a background that is not covered.
    :ivar trouble: why there have been no areas for long, empty if there were.
    :ivar is_busy: whether this frame, and not the last one, updated the background, so that other
        work that takes time can wait for the next one.
    """

    def __init__(self, config: ContourConfig) -> None:
        self._background, self._next = StillBackground(), StillBackground()
        self._change, self.is_new = SceneChange(), False
        self.is_seen = False
        self._looked = self.is_busy = False
        self._steady, self._differencing = Steady(), Differencing()
        self.configure(config)
        self.restart()

    def configure(self, config: ContourConfig) -> None:
        """Set another configuration; the learned background stays."""
        subtraction = DetectorConfig(
            method='background',
            difference_threshold=config.difference_threshold,
            blur_sigma=config.blur_sigma,
            min_area=config.min_area,
            learn_seconds=config.learn_seconds,
        )
        self._subtraction = BackgroundSubtraction(subtraction, self._background)
        self._config = config

    def learn_background(self) -> None:
        """Forget the background: the next picture is the first of a new one."""
        self._background.restart()
        self.restart()

    def restart(self) -> None:
        """Forget earlier pictures, but not the background."""
        self._differencing.restart()
        self._change.restart()
        self.trouble, self._saw = '', -1
        self._clutter, self._usual = np.zeros((0, 0), np.float32), UsualArea()

    @property
    def is_learning(self) -> bool:
        """Whether outlines may still be those of things in the first picture."""
        return self._config.start == 'background' and self._background.is_learning

    def goes_on(self, box: Floats, age: Floats) -> Bools:
        """Return which boxes, (N, 4), end where the background is unknown; see unknown.goes_on.

        :param age: of the targets, (N,) [s]: those that were there before the background are whole.
        """
        unknown = self._background.unknown() if self.is_seen else None
        if unknown is None:
            return np.zeros(len(box), bool)
        return goes_on(self._steady.back(box), unknown) & (age <= self._background.seconds)

    def usual_area(self, box: Floats) -> Floats:
        """Return the usual area at the places of boxes, (N, 4) [px]; see UsualArea.at."""
        return self._usual.at(self._steady.back(box))

    def is_vacant(self, outlines: Floats) -> Bools:
        """Return which outlines, (N, P, 2), show nothing; see vacant.is_vacant."""
        if not self.is_seen or not self._background.knows(self._steadied):
            return np.zeros(len(outlines), bool)
        there = outlines - self._steady.shift
        return is_vacant(there, self._mask, self._steadied, self._background.recent)

    def areas(self, frame: Frame, known: Floats) -> Areas | None:
        """Return the areas that differ, or None if too much does since the camera moves.

        Also None if there is no segmentation, and while the background is covered.

        :param known: see find_areas.
        """
        picture = self._shown = channels_of(frame)
        if self._config.start == 'background':
            frame = self._steady.steadied(frame, self._background, known)
        else:
            self._steady.rest()
        areas = self._find(frame, self._steady.back(known))
        if areas is not None:
            areas = self._steady.along(areas, picture)
        if self._saw < 0 or not self._is_blind(areas):
            self._saw = frame.stamp
        self.trouble = BLIND if frame.stamp - self._saw > BLIND_SECONDS * NANOSECONDS else ''
        return areas

    def _is_blind(self, areas: Areas | None) -> bool:
        """Return whether nothing can be found, or most of the background is still unknown."""
        if areas is None:
            return self._config.start != 'targets'
        unknown = self._background.unknown()
        return unknown is not None and 2 * np.count_nonzero(unknown) > unknown.size

    def _find(self, frame: Frame, known: Floats) -> Areas | None:
        """Return what areas() does, without noting for how long there have been none."""
        self.is_new = self.is_seen = False
        if self._config.start == 'targets':
            return None
        if self._config.start == 'difference':
            self._mask = self._differencing.mask(frame, self._config)
        elif self._is_covered(frame, known):
            return None
        else:
            self._mask = self._steady.seen(self._subtract(frame))
        if self._clutter.shape != self._mask.shape:
            self._clutter = np.zeros(self._mask.shape, np.float32)
        unknown = self._mask.copy()
        for left, top, right, bottom in np.maximum(known.astype(int), 0).tolist():
            unknown[top : bottom + 1, left : right + 1] = 0
        if cv2.countNonZero(unknown) > MAX_FOREGROUND * unknown.size:
            return None
        self.is_seen = self._config.start == 'background'
        still = self._clutter > CLUTTER_SHARE
        mask = np.where(still, np.uint8(0), self._mask)
        picture = self._steadied = channels_of(frame)
        if self._config.start == 'background' and self._background.knows(picture):
            least, threshold = self._config.min_area, self._config.difference_threshold
            mask = without_shadows(mask, picture, self._background.recent, least, threshold)
        areas = find_areas(mask, self._config.min_area, known)
        return areas.take(~self._is_background(areas, frame, known))

    def _is_background(self, areas: Areas, frame: Frame, known: Floats) -> Bools:
        """Return which areas, (K,), are slightly displaced background, and no known target."""
        picture = channels_of(frame)
        if self._config.start != 'background' or not self._background.knows(picture):
            return np.zeros(len(areas), bool)
        threshold = self._config.difference_threshold
        displaced = is_displaced(areas, picture, self._background.recent, threshold)
        return displaced & ~(intersections(known, areas.box) > 0).any(axis=0)

    def learn(self, own: Floats, records: Records, seconds: float) -> None:
        """Learn where something differs, but nothing moves on: flicker, or a thing put there; and
        how large things usually are.

        :param own: (N, 4) boxes of targets [px].
        :param records: (N,) with CONTOUR_FIELDS.
        :param seconds: time since the last frame [s].
        """
        if not self._mask.size:
            return
        own = self._steady.back(own)
        usual, share = self._clutter.copy(), min(seconds / CLUTTER_SECONDS, 1.0)
        cv2.accumulateWeighted(self._mask // 255, self._clutter, share)
        moving = own[records['state'] != TENTATIVE]
        for left, top, right, bottom in np.maximum(moving.astype(int), 0).tolist():
            part = np.s_[top : bottom + 1, left : right + 1]
            self._clutter[part] = usual[part]
        whole = (records['state'] == CONFIRMED) & records['single'] & ~records['piece']
        self._usual.learn(own[whole], self._mask.shape, seconds)

    def _subtract(self, frame: Frame) -> Mask:
        """Return what differs from the background, and learn the background from the frame."""
        if not frame.image.size:
            return np.zeros(frame.image.shape[:2], np.uint8)
        difference = self._subtraction.difference(channels_of(frame))
        smooth = self._subtraction.smoothed(difference)
        image = self._subtraction.label_of(smooth)
        self._add_weak(image, difference, smooth)
        unknown = self._background.unknown()
        if unknown is not None and unknown.shape == image.pixels.shape:
            image.pixels[unknown] = 0
        open_(image, self._config.opening_size, self._subtraction.labels)
        blobs = find_blobs(image, self._config.min_area)
        self._subtraction.learn(frame, blobs, blobs)
        looked, self._looked = self._looked, self._background.has_looked
        self.is_busy = self._looked and not looked
        return image.pixels * np.uint8(255)

    def _add_weak(self, image: LabelImage, difference: Picture, smooth: Picture) -> None:
        """Add weak differences beside strong ones to a label image, in place.

        What the Gaussian alone makes different, beside something, is left out.
        """
        background, threshold = self._background.pictures, self._config.difference_threshold
        if not background or background[0].shape[:2] != difference.shape:
            return
        rim = cv2.blur(difference, (3, 3)) <= RIM_SHARE * threshold
        smooth = np.where(rim, np.uint8(0), smooth)
        settled, strong = self._background.settled(), image.pixels
        strong[...] = with_weak(strong, smooth, background[0], threshold, settled)
        image.filled = None

    def _is_covered(self, frame: Frame, known: Floats) -> bool:
        """Return whether the background is covered: by another scene, or something in front.

        The background of another scene is learned meanwhile, and taken once it has settled.
        """
        picture = channels_of(frame)
        if not self._background.knows(picture):
            self._change.restart()  # the known one is of another size
            return False
        before, settled = self._background.pictures, self._background.settled()
        is_covered = self._change.look(picture, frame.stamp, before, known, settled)
        if not self._change.seconds:
            self._next.restart()
            return is_covered
        nothing = LabelImage(np.zeros(picture.shape[:2], np.uint8), picture.shape[1])
        learn_seconds = self._config.learn_seconds
        self._next.follow(self._shown, frame.stamp, find_blobs(nothing, 1), learn_seconds)
        if self._change.seconds >= SETTLED_SECONDS:
            self._background, self._next = self._next, self._background
            self._steady.restart()
            self.is_new = True
            self.configure(self._config)
            self.restart()
        return True
