"""From a frame to its detections."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.blobs import sample_pixels
from colortrack_ros.detection.blur import outline_blur
from colortrack_ros.detection.blur import outline_sides
from colortrack_ros.detection.blur import Profiles
from colortrack_ros.detection.blur import SHARP
from colortrack_ros.detection.config import DetectorConfig
from colortrack_ros.detection.covariance import centroid_covariance
from colortrack_ros.detection.covariance import open_part
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.methods import METHODS
from colortrack_ros.detection.morphology import close
from colortrack_ros.detection.morphology import erode
from colortrack_ros.detection.morphology import open_
from colortrack_ros.detection.pixels import channels_of
from colortrack_ros.detection.pixels import split_rgb
from colortrack_ros.detection.regions import Regions
from colortrack_ros.detection.shape import keep_shapes
from colortrack_ros.detection.skewness import UsualSkewness
from colortrack_ros.detection.split import split_touching
from colortrack_ros.detection.touching import TouchingThings
from colortrack_ros.encodings import check
from colortrack_ros.encodings import is_yuv
from colortrack_ros.encodings import plain
from colortrack_ros.encodings import size_of

SCORE_PIXELS = 16
"""Pixels of a blob, at most, whose mean closeness is its score: it is known to a quarter of their
spread; `python benchmark/detection_quality.py --constants` halves and doubles it."""


class Detector:
    """Finds blobs of reference colors (Pegoretti 2021, 3.1.1), or with another method.

    The method says which pixels belong to which color, by default by color distance (2.1) and
    threshold (2.2). Then, for all methods, closing (2.7), erosion (2.4), opening (2.6), 8-connected
    components, area and centroid by moments (2.9)-(2.11). A blob is of one color; area and centroid
    are those of the mask at the end, and so is the box, but of a color whose tolerance was found:
    that has back what the erosion took. Of things that were blobs of their own, and have come
    together to one, they are those of what each looked like before, fitted to it.

    :param config: what to look for.

    blobs: those of the last frame that are detected, before they are told apart.
    """

    def __init__(self, config: DetectorConfig) -> None:
        self._background = BackgroundModel()
        self._mask = LabelImage.empty(0, 0)
        self.blobs = find_blobs(self._mask, 1)
        self.configure(config)

    def configure(self, config: DetectorConfig) -> None:
        """Take another configuration; the next frame is detected with it.

        The background that was learned is kept.

        :raises ValueError: when there is no picture at mask; the old configuration stays.
        """
        self._regions = Regions(config.regions, config.mask)
        self._method = METHODS[config.method](config, self._background)
        self._skewness = UsualSkewness(self._method.labels)
        self._touching = TouchingThings()
        self._config, self._areas = config, config.areas()

    def learn_background(self) -> None:
        """Forget the background: what stands still from the next frame on is background."""
        self._background.restart()
        self._method.restart()

    @property
    def trouble(self) -> str:
        """What a person should know and do; empty when all is well."""
        return self._method.trouble

    @property
    def labels(self) -> NDArray[np.uint8]:
        """(H, W) of the last frame, k + 1 where a blob of color k may be, 0 elsewhere; a view."""
        return self._mask.pixels

    @property
    def mask(self) -> NDArray[np.uint8]:
        """(H, W) of the last frame, 255 where a blob may be, 0 elsewhere."""
        return np.where(self.labels != 0, np.uint8(255), np.uint8(0))

    def background(self, frame: Frame) -> tuple[NDArray, NDArray] | None:
        """The learned background, and where a frame is not like it; None if none is learned.

        :returns: (H, W, 3) BGR, and (H, W), 255 for what moves, 0 elsewhere.
        """
        frame = plain(frame)
        picture = channels_of(frame)
        if not self._background.knows(picture):
            return None
        red, green, blue = split_rgb(self._background.recent, frame.encoding)
        moves = self._background.moves(picture, self._config.difference_threshold)
        return cv2.merge([blue, green, red]), moves

    def detect(self, frame: Frame) -> Detections:
        """The blobs of a frame, largest area first; at equal area, in raster order.

        :param frame: of any size, 0 included, which may change from frame to frame.
        :raises ValueError: when the encoding is not known or does not fit the picture's shape.
        """
        check(frame)
        if not (self._method.reads_yuv and is_yuv(frame)):
            frame = plain(frame)
        if not frame.image.size:
            return Detections(stamp=frame.stamp, frame_id=frame.frame_id)
        config, method = self._config, self._method
        image = self._mask = method.label(frame)
        whole = method.whole
        if self._regions:
            whole = whole or image.copy()
            self._regions.apply(image)
        close(image, config.closing_size, method.labels)
        erode(image, config.erosion_size, method.labels)
        open_(image, config.opening_size, method.labels)
        blobs = self._blobs(image)
        most = self._areas[1]
        if config.split and split_touching(image, blobs, int(most.max())):
            blobs = self._blobs(image)
        kept = blobs.take(method.keep(frame, blobs))
        kept = self.blobs = keep_shapes(kept.take(kept.area <= most[kept.label]), config)
        method.learn(frame, blobs, kept)
        part = open_part(kept, image, whole) if whole else 0.0
        height, width = size_of(frame)
        rows = self._rows(frame, kept, part)
        rows = self._touching.tell_apart(rows, kept, frame.stamp)
        return Detections(rows, frame.stamp, frame.frame_id, (width, height))

    def _blobs(self, image: LabelImage) -> BlobTable:
        """Those that are large enough for their color."""
        least = self._areas[0]
        blobs = find_blobs(image, int(least.min()), connect=self._method.connect)
        return blobs.take(blobs.area >= least[blobs.label])

    def _rows(self, frame: Frame, blobs: BlobTable, part: NDArray | float) -> NDArray[np.void]:
        rows = np.zeros(len(blobs.area), DETECTION)
        rows['u'], rows['v'] = blobs.mean.T
        if not len(rows):
            return rows
        score = rows['score'] = self._score(frame, blobs)
        covariance = self._covariance(frame, blobs, score, part)
        rows['cov_uu'], rows['cov_uv'] = covariance[:, 0, 0], covariance[:, 0, 1]
        rows['cov_vv'] = covariance[:, 1, 1]
        rows['area'] = blobs.area
        box = self._boxes(blobs, *size_of(frame))
        for name, column in zip(('box_u', 'box_v', 'box_w', 'box_h'), box.T, strict=True):
            rows[name] = column
        rows['color'] = blobs.label - 1
        return rows

    def _boxes(self, blobs: BlobTable, height: int, width: int) -> NDArray[np.int64]:
        """(N, 4) of the blobs; of a color whose end was found, with what the erosion took off.

        An eroded mask, dilated again, is within what it was.
        """
        is_found = _of_label(self._method.is_found, blobs.label)
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
        score: NDArray[np.float64],
        part: NDArray[np.float64] | float,
    ) -> NDArray[np.float64]:
        """(N, 2, 2) of the centroids, by what is seen of each blob."""
        height, width = size_of(frame)
        skewness = self._skewness.beyond(blobs, blobs.inside(width, height), frame.stamp)
        doubt = _of_label(self._method.doubt, blobs.label)
        profiles = Profiles.of(blobs)
        blur = outline_blur(frame, blobs, profiles)
        sided = self._one_sidedness(frame, blobs, profiles, blur)
        return centroid_covariance(
            blobs, (height, width), score, blur, sided, part, skewness, doubt
        )

    def _one_sidedness(
        self,
        frame: Frame,
        blobs: BlobTable,
        profiles: Profiles,
        blur: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """(N, 2, 2) see centroid_covariance(); 0 where the outline is sharp.

        And where all of a blob is outline: its middle is a mix as well.
        """
        sided = np.zeros((*blur.shape, 2))
        width = blur.max(axis=1)
        is_blurred = (width > SHARP) & (width < 2 * np.sqrt(blobs.axes[0]))
        if not is_blurred.any():
            return sided
        profiles, blur = profiles.take(is_blurred), blur[is_blurred]
        columns = size_of(frame)[1]
        inside, outside = outline_sides(frame, profiles, blur)
        end = self._method.end_share(
            frame,
            np.divmod(inside.reshape(-1), columns),
            np.divmod(outside.reshape(-1), columns),
            blobs.label[is_blurred].repeat(inside[0].size),
        ).reshape(inside.shape)
        shift = (end[..., 1] - end[..., 0]) / 2
        error = np.sqrt(shift.var(axis=2, ddof=1) / shift.shape[2])
        sided[is_blurred] = np.stack([np.abs(shift.mean(axis=2)), error], axis=2)
        return sided

    def _score(self, frame: Frame, blobs: BlobTable) -> NDArray[np.float64]:
        """(N,) mean closeness to the color over the blob, over SCORE_PIXELS of it at most."""
        blob, position = sample_pixels(blobs, SCORE_PIXELS)
        pixel = np.divmod(position, blobs.runs.stride)
        closeness = self._method.closeness(frame, pixel, blobs.label[blob])
        count = len(blobs.area)
        return np.bincount(blob, closeness, count) / np.bincount(blob, minlength=count)


def _of_label(value: NDArray[Any] | float, label: NDArray[np.uint8]) -> NDArray[Any]:
    """(N,) what a method says of each label, or of all of them."""
    return value[label] if isinstance(value, np.ndarray) else np.full(len(label), value)
