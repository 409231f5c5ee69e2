"""The detector: turns a frame into detections."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.blobs import positions
from colortrack_ros.detection.blobs import sample_pixels
from colortrack_ros.detection.blur import fitting_profiles
from colortrack_ros.detection.blur import Profiles
from colortrack_ros.detection.chords import Chords
from colortrack_ros.detection.config import DetectorConfig
from colortrack_ros.detection.covariance import centroid_covariance
from colortrack_ros.detection.covariance import open_part
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.methods import METHODS
from colortrack_ros.detection.methods.base import Method
from colortrack_ros.detection.morphology import close
from colortrack_ros.detection.morphology import erode
from colortrack_ros.detection.morphology import open_
from colortrack_ros.detection.pixels import channels_of
from colortrack_ros.detection.pixels import split_rgb
from colortrack_ros.detection.reference import expect
from colortrack_ros.detection.regions import Regions
from colortrack_ros.detection.several import places_inside
from colortrack_ros.detection.shape import keep_shapes
from colortrack_ros.detection.skewness import UsualSkewness
from colortrack_ros.detection.small_things import among
from colortrack_ros.detection.small_things import worn
from colortrack_ros.detection.split import split_touching
from colortrack_ros.detection.touching import TouchingThings
from colortrack_ros.encodings import check
from colortrack_ros.encodings import is_yuv
from colortrack_ros.encodings import plain
from colortrack_ros.encodings import size_of

IN_GRAY = (
    'the pictures are gray (mono8), and no gray is within the tolerance of a color: let '
    'image_topic be where the driver has pictures in color'
)
SCORE_PIXELS = 16
"""Maximum number of pixels of a blob whose mean closeness is its score. 16 give the mean to a
quarter of the pixels' spread; `python benchmark/detection_quality.py --constants` halves and
doubles it."""


class Detector:
    """Detects blobs of reference colors (Pegoretti 2021, 3.1.1), or of another method.

    The method labels each pixel with a color, by default with color distance (2.1) and threshold
    (2.2). All methods share the steps that follow: closing (2.7), erosion (2.4), opening (2.6),
    8-connected components, and area and centroid from moments (2.9)-(2.11). A blob has one color.
    Its area, centroid and box are measured in the final mask. If the color's tolerance was
    estimated, the box regains the margin that the erosion removed. If separate objects have merged
    into one blob, their last appearances are fitted to it, and each row describes one of them.

    It learns from frame to frame: each camera needs its own, and only one thread at a time may use
    it.

    :param config: what to detect.

    blobs: the detected blobs of the last frame, before merged ones are separated.
    """

    def __init__(self, config: DetectorConfig) -> None:
        self._background = BackgroundModel()
        self._mask, self._is_gray = LabelImage.empty(0, 0), False
        self.blobs = find_blobs(self._mask, 1)
        self._method = Method()
        self.configure(config)

    def configure(self, config: DetectorConfig) -> None:
        """Apply another configuration, starting with the next frame.

        What has been learned is kept: of the background, and of the colors in the light as it has
        become, unless the colors or the handling of the light change.

        :raises ValueError: if there is no picture at mask, or this is no configuration; the old one
            stays in force.
        """
        kind = type(config).__name__
        expect(isinstance(config, DetectorConfig), 'config', kind, 'a DetectorConfig')
        self._regions = Regions(config.regions, config.mask)
        before, self._method = self._method, METHODS[config.method](config, self._background)
        self._method.take_over(before)
        self._skewness = UsualSkewness(self._method.labels)
        self._touching = TouchingThings()
        self._config, self._areas = config, config.areas()

    def learn_background(self) -> None:
        """Forget the background and learn a new one from the next frame on."""
        self._background.restart()
        self._method.restart()

    @property
    def trouble(self) -> str:
        """A problem that the user should fix, and how; empty if there is none."""
        if self._is_gray and self._method.needs_color:
            return IN_GRAY
        least = int(self._areas[0].min())
        return self._regions.trouble(least) or self._method.trouble

    @property
    def labels(self) -> NDArray[np.uint8]:
        """(H, W) labels of the last frame: k + 1 where a blob of color k may be, else 0.

        A view that the next frame overwrites.
        """
        return self._mask.pixels

    @property
    def mask(self) -> NDArray[np.uint8]:
        """(H, W) mask of the last frame: 255 where a blob may be, else 0."""
        return np.where(self.labels != 0, np.uint8(255), np.uint8(0))

    def background(self, frame: Frame) -> tuple[NDArray, NDArray] | None:
        """The learned background, and where a frame differs from it; None before one is learned.

        :returns: (H, W, 3) BGR, and (H, W), 255 for moving pixels, else 0.
        """
        frame = plain(self._method.prepare(frame))
        picture = channels_of(frame)
        if not self._background.knows(picture):
            return None
        red, green, blue = split_rgb(self._background.recent, frame.encoding)
        moves = self._background.moves(picture, self._config.difference_threshold)
        return cv2.merge([blue, green, red]), moves

    def detect(self, frame: Frame) -> Detections:
        """Detect the blobs of a frame, largest area first, and in raster order at equal area.

        :param frame: of any size, even empty; the size may change between frames.
        :raises ValueError: if the encoding is unknown or does not match the shape of the picture.
        """
        check(frame)
        if not (self._method.reads_yuv and is_yuv(frame)):
            frame = plain(frame)
        if not frame.image.size:
            return Detections(stamp=frame.stamp, frame_id=frame.frame_id)
        config, method = self._config, self._method
        self._is_gray = frame.encoding == 'mono8'
        frame = method.prepare(frame)
        image = self._mask = method.label(frame)
        whole = method.whole
        if self._regions:
            whole = whole or image.copy()
            self._regions.apply(image)
        self._clean(image)
        blobs = self._blobs(image)
        most = self._areas[1]
        if config.split and split_touching(image, blobs, int(most.max())):
            blobs = self._blobs(image)
        kept = blobs.take(method.keep(frame, blobs, self._touching.things))
        kept = self.blobs = keep_shapes(kept.take(kept.area <= most[kept.label]), config)
        method.learn(frame, blobs, kept)
        part = open_part(kept, image, whole) if whole else 0.0
        height, width = size_of(frame)
        rows = self._rows(frame, kept, part)
        rows = self._touching.tell_apart(rows, kept, frame.stamp)
        return Detections(rows, frame.stamp, frame.frame_id, (width, height))

    def _clean(self, image: LabelImage) -> None:
        """Closing, erosion, and opening, in place, which all but small things undergo."""
        config, count, small = self._config, self._method.labels, self._method.small
        labels = image.padded.reshape(-1)
        place = positions(small.runs) if small else np.zeros(0, np.intp)
        spared = labels[place]
        close(image, config.closing_size, count)
        erode(image, config.erosion_size, count)
        open_(image, config.opening_size, count)
        labels[place] = spared

    def _blobs(self, image: LabelImage) -> BlobTable:
        """Find the blobs that have the least area of their color, and small things."""
        least, small = self._areas[0], self._method.small
        smallest = int(min(least.min(), small.area.min() if small else least.max()))
        blobs = find_blobs(image, smallest, connect=self._method.connect)
        return blobs.take((blobs.area >= least[blobs.label]) | among(blobs, small))

    def _rows(self, frame: Frame, blobs: BlobTable, part: NDArray | float) -> NDArray[np.void]:
        rows = np.zeros(len(blobs.area), DETECTION)
        rows['u'], rows['v'] = blobs.mean.T
        if not len(rows):
            return rows
        rows['score'], spread = self._closeness(frame, blobs)
        covariance = self._covariance(frame, blobs, spread, part)
        rows['cov_uu'], rows['cov_uv'] = covariance[:, 0, 0], covariance[:, 0, 1]
        rows['cov_vv'] = covariance[:, 1, 1]
        is_small = among(blobs, self._method.small)
        rows['area'] = blobs.area
        rows['area'][is_small] = worn(blobs.area[is_small], self._config.erosion_size)
        box = self._boxes(blobs, is_small, *size_of(frame))
        for name, column in zip(('box_u', 'box_v', 'box_w', 'box_h'), box.T, strict=True):
            rows[name] = column
        rows['color'] = blobs.label - 1
        return rows

    def _boxes(
        self, blobs: BlobTable, is_small: NDArray[np.bool_], height: int, width: int
    ) -> NDArray[np.int64]:
        """(N, 4) boxes; if the color's tolerance was estimated, with the eroded margin restored.

        Dilating an eroded mask never exceeds the original mask.
        """
        is_found = _of_label(self._method.is_found, blobs.label) & ~is_small
        if not is_found.any():
            return blobs.box
        low, high = blobs.box[:, :2], blobs.box[:, :2] + blobs.box[:, 2:]
        margin = is_found[:, None] * (self._config.erosion_size // 2)
        low, high = np.maximum(low - margin, 0), np.minimum(high + margin, [width, height])
        return np.hstack([low, high - low])

    def _covariance(
        self,
        frame: Frame,
        blobs: BlobTable,
        spread: NDArray[np.float64],
        part: NDArray[np.float64] | float,
    ) -> NDArray[np.float64]:
        """(N, 2, 2) covariances of the centroids, from the visible part of each blob."""
        height, width = size_of(frame)
        inside = blobs.inside(width, height)
        skewness = self._skewness.beyond(blobs, inside, frame.stamp)
        profiles = Profiles.of(blobs)
        levels, gap, blur = fitting_profiles(frame, blobs, profiles)
        along = np.sqrt(blur.diagonal(axis1=1, axis2=2))
        chords = Chords.of(levels, gap, profiles, blobs, along)
        size = height, width
        own = centroid_covariance(blobs, size, spread, blur, chords, part, skewness)
        return own + places_inside(blobs, inside)

    def _closeness(
        self, frame: Frame, blobs: BlobTable
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(N,) mean closeness to the color, and its spread, over SCORE_PIXELS of each blob."""
        blob, position = sample_pixels(blobs, SCORE_PIXELS)
        pixel = np.divmod(position, blobs.runs.stride)
        closeness = self._method.closeness(frame, pixel, blobs.label[blob])
        count = len(blobs.area)
        number = np.minimum(blobs.area, SCORE_PIXELS)
        mean, square = (np.bincount(blob, c, count) / number for c in (closeness, closeness**2))
        return mean, np.sqrt(np.maximum(square - mean**2, 0))


def _of_label(value: NDArray[np.bool_] | bool, label: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """(N,) what a method says of each label, or of all labels."""
    return value[label] if isinstance(value, np.ndarray) else np.full(len(label), value)
