"""Color distance: detects objects by their color (Pegoretti 2021, 3.1.1)."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import clear
from colortrack_ros.detection.blobs import connect
from colortrack_ros.detection.blobs import find_runs
from colortrack_ros.detection.blobs import sample_pixels
from colortrack_ros.detection.chroma_filter import ChromaFilter
from colortrack_ros.detection.finder import ColorFinder
from colortrack_ros.detection.kept_table import KeptTable
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.light import ColorFollower
from colortrack_ros.detection.light import GrayWorld
from colortrack_ros.detection.methods.base import Method
from colortrack_ros.detection.methods.color_config import ColorDistanceConfig
from colortrack_ros.detection.morphology import colors_touch
from colortrack_ros.detection.morphology import erode
from colortrack_ros.detection.pieces import join_pieces
from colortrack_ros.detection.pixels import channels_of
from colortrack_ros.detection.pixels import Pixels
from colortrack_ros.detection.pixels import rgb_at
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.small_things import among
from colortrack_ros.detection.small_things import SmallThings
from colortrack_ros.detection.smoothing import Smoothing
from colortrack_ros.detection.sought_color import NOTHING
from colortrack_ros.detection.touching import Things
from colortrack_ros.encodings import is_yuv
from colortrack_ros.encodings import plain

FOLLOW_PIXELS = 16
"""Pixels of a blob whose mean a reference color follows. 16 give the mean to a quarter of the
pixels' spread, and the time constant averages over many frames."""
LEARNS_BY = ('white_balance', 'follow_light', 'smoothing')
"""Parameters that what has been learned of each color, and of the light, depends on."""


class ColorDistance(Method):
    """Color distance (2.1) and threshold (2.2), made robust to clutter and changing light.

    With grow above 1, a pixel within tolerance starts a blob, which includes the connected pixels
    within grow times the tolerance.

    With moving_only, only pixels that differ from the learned background count: stationary objects
    of the reference color are ignored, and objects that pass in front of them are detected.
    """

    def __init__(self, config: ColorDistanceConfig, background: BackgroundModel) -> None:
        self.labels = len(config.colors)
        plain_colors = config.grow == 1 and config.white_balance == 'none'
        self.reads_yuv = plain_colors and not config.moving_only
        self._config, self._background = config, background
        self._follower = ColorFollower(config.colors, config.follow_light)
        self._gray_world = GrayWorld()
        self._image: LabelImage | None = None
        self._finder = ColorFinder(config.colors)
        is_sought = any(color.is_sought for color in config.colors)
        self._small = SmallThings(config.of_small_things, self.labels, config.erosion_size)
        self._due = list[int]()
        self._smoothing = Smoothing(config.smoothing or int(not is_sought))
        is_fixed = not (is_sought or config.follow_light)
        self._tables = [KeptTable(is_fixed, config.threads) for _ in ('tight', 'loose')]
        self._take(config.colors)

    def _take(self, colors: tuple[ReferenceColor, ...]) -> None:
        """Build the color tables, or renew them if there are any."""
        config = self._config
        self._given = colors
        self.is_found = np.array([False, *(color.is_sought for color in colors)])
        colors = self._finder.resolve(colors, [*self._due, *self._small.others])
        self._looked = [k for k in self._due if colors[k].tolerance != NOTHING]
        self._table = self._tables[0].of(colors)
        self.needs_color = not (self.is_found.any() or self._table.holds_gray)
        self._chroma_filter: ChromaFilter | None = None
        if config.grow > 1:
            self._loose = self._tables[1].of(tuple(c.grown(config.grow) for c in colors))

    @property
    def trouble(self) -> str:
        """Problems of the tolerance estimation."""
        unseen = self._finder.unseen if self._config.erodes_at_once else ''
        return self._finder.trouble or unseen

    def prepare(self, frame: Frame) -> Frame:
        """Average the pixels of a noisy picture."""
        if self._config.smoothing != 1:
            self._finder.read_palette(frame)
        return self._smoothing.smooth(frame, self._finder.least_chroma)

    def label(self, frame: Frame) -> LabelImage:
        """Label each pixel with the nearest reference color that it is within tolerance of."""
        original = frame
        if self._config.white_balance == 'gray_world':
            frame = replace(frame, image=self._gray_world.balance(frame.image))
        self._frame = frame
        due = self._small.due(frame.stamp)
        if self._finder.look(frame) or due != self._due:
            self._due = due
            self._take(self._given)
        old, self._image = self._image, None
        image = self._image = self._labels(frame, old, bool(self._looked))
        self.whole = None
        if self._config.grow > 1:
            image = self._grow(image, self._loose.label(frame.image, frame.encoding))
        if self._config.moving_only:
            self.whole = image.copy()
            self._drop_background(original, image)
        if self._table.overlaps:
            image.apart = not colors_touch(image)
            if not image.apart:
                join_pieces(image, lambda position, label: self._is_within(image, position, label))
        self.small = self._small.find(image, self._looked, self._finder.missing, frame.stamp)
        return image

    def _labels(self, frame: Frame, old: LabelImage | None, is_whole: bool) -> LabelImage:
        """Label pixels with the nearest color; converts only candidate pixels of YUV frames."""
        if is_yuv(frame):
            self._chroma_filter = self._chroma_filter or ChromaFilter(self._table.touched)
            image = self._chroma_filter.label(
                frame, lambda x: self._table.label(x, 'bgr8').pixels, old
            )
            if image is not None:
                return image
            frame = plain(frame)
        is_eroded = self._config.erodes_at_once and not is_whole
        erosion = self._config.erosion_size if is_eroded else 1
        return self._table.label(frame.image, frame.encoding, erosion, old)

    def _is_within(
        self, image: LabelImage, position: NDArray[np.intp], label: NDArray[np.uint8]
    ) -> NDArray[np.bool_]:
        """(N,) whether pixels, v stride + u, are within tolerance of a color; never if inverted."""
        rgb = rgb_at(self._frame, np.divmod(position, image.stride))
        inverted = np.array([color.inverted for color in self._given])
        return (self._table.closeness(rgb, label) > 0) & ~inverted[label.astype(int) - 1]

    def _grow(self, tight: LabelImage, loose: LabelImage) -> LabelImage:
        """Keep the components of the loose image that contain a pixel of the eroded tight one."""
        erode(tight, self._config.erosion_size, self.labels)
        runs = find_runs(loose)
        count, component = connect(runs)
        started = np.zeros(count, bool)
        started[component[np.searchsorted(runs.start, tight.positions(), 'right') - 1]] = True
        clear(loose, runs.take(~started[component]))
        return loose

    def _drop_background(self, frame: Frame, image: LabelImage) -> None:
        """Clear pixels that match the background, and all pixels before one is learned."""
        picture = channels_of(frame)
        if not self._background.knows(picture):
            image.padded[...] = 0
            return
        self._background.relight(picture)
        self._background.clear_still(picture, image, self._config.difference_threshold)

    def closeness(self, frame: Frame, pixel: Pixels, label: NDArray) -> NDArray[np.float64]:
        """1 - D / tolerance."""
        return self._table.closeness(rgb_at(self._frame, pixel), label)

    def keep(self, frame: Frame, blobs: BlobTable, things: Things) -> NDArray[np.bool_]:
        """Keep blobs that are large enough, for colors whose least area is estimated."""
        return self._finder.keep(frame, blobs, things)

    def learn(self, frame: Frame, blobs: BlobTable, kept: BlobTable) -> None:
        """Update the background outside all blobs, and move the colors toward the detected ones."""
        config = self._config
        self._small.see(kept.take(~among(kept, self.small)), frame.stamp)
        if config.moving_only:
            picture = channels_of(frame)
            self._background.follow(picture, frame.stamp, blobs, config.learn_seconds)
        if config.follow_light > 0:
            blob, position = sample_pixels(kept, FOLLOW_PIXELS)
            lab = lab_from_rgb(rgb_at(self._frame, np.divmod(position, kept.runs.stride)))
            colors = self._follower.follow(lab, kept.label[blob] - 1, frame.stamp)
            if colors is not None:
                self._take(colors)

    def take_over(self, before: Method) -> None:
        """Go on with the colors as the light has become, if they and its handling are the same."""
        if not isinstance(before, ColorDistance) or any(
            getattr(before._config, name) != getattr(self._config, name) for name in LEARNS_BY
        ):
            return
        if before._config.colors == self._config.colors:
            self._follower, self._gray_world = before._follower, before._gray_world
            self._finder, self._smoothing = before._finder, before._smoothing
            self._take(before._given)
        elif self._config.white_balance == 'none':
            self._finder.take_over(before._finder)
            self._take(self._config.colors)

    def restart(self) -> None:
        """Restart from the configured colors; the next frame sets the reference light."""
        self._gray_world.restart()
        self._follower = ColorFollower(self._config.colors, self._config.follow_light)
        self._finder = ColorFinder(self._config.colors)
        self._take(self._config.colors)
