"""Where objects end by their hue, which shading does not change."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blur import ENDS
from colortrack_ros.detection.blur import has_inside
from colortrack_ros.detection.blur import object_share
from colortrack_ros.detection.blur import PROFILE_SAMPLES
from colortrack_ros.detection.blur import PROFILES
from colortrack_ros.detection.blur import Profiles

NO_HUE = 16
"""Least distance of the surroundings from the object's hue, in levels: nearer, noise and JPEG make
the difference, and brightness tells them apart instead. Half and twice as much are no better in
random worlds."""

MOST_DIFFERENT = 0.8
"""Share of the greatest squared difference of two neighbors' hue from which on they are the
surroundings: texture and shadows of what is behind differ from its most different part."""

LEAST_MIXED = 1 / 12
"""Mean integral of f (1 - f) across outlines, f the share of the surroundings, from which on their
place within a pixel is known [px]: half of that of an outline 1 px wide."""

MIXED = 0.45
"""Share of a shift that counts where even the inside is a mixture with what is behind. With whole
shifts `fast` has 0.53 instead of 1.08 at 640x360, and 0.50 instead of 0.85 at 640x480. Random
worlds are a little better with 2/3, but then balls that are smeared over all of themselves have
0.7."""

ROUNDED_SLANT = 0.43
"""Distance of two middles from their mean up to which the rounding of their ends to whole pixels
may be the cause [px]: three standard deviations, 3 / 48^(1/2)."""

SAME_SLANT = 1 / 4
"""Difference of the slants of an object and of its blob up to which they are one [of the blob's].
On dark sides that the tolerance cuts off they differ by three fifths and more."""

LEAST_COLOR = 1e-6
"""Least length of a color that has a direction: black has none."""


@dataclass(frozen=True)
class Chords(Columns):
    """How far the middles of N objects, by their hue, are from the centroids of their blobs.

    The tolerance cuts off the dark side of an object, its highlight, and more of one end of its
    blur than of the other. The dark side is a multiple of the object's color, though, and what is
    behind is not: a chord between the places where that begins is the object's own.

    :param shift: (N, 2) along u and v, the mean over chords [px].
    :param error: (N,) standard error of the shift, over both axes [px].
    :param rounded: (N,) how far ends are known to whole pixels only, 0..1: 1 for outlines without
        any mixed pixels.
    """

    shift: NDArray[np.float64]
    error: NDArray[np.float64]
    rounded: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        levels: NDArray[np.float32],
        gap: NDArray[np.float32],
        profiles: Profiles,
        blobs: BlobTable,
        blur: NDArray[np.float64],
    ) -> 'Chords':
        """The chords of blobs along a few rows and columns.

        :param levels, gap: of :func:`profile_levels`.
        :param blur: (N, 2) widths of the outline along u and v [px].
        """
        outside = outside_share(levels)
        inside = (1 - outside) * gap[:, None, None, None]
        farther = inside.sum(axis=-1)
        mixed = (inside * outside).sum(axis=(1, 2, 3, 4)) / (2 * 2 * PROFILES)
        own = profiles.end.sum(axis=-1) / 2
        middle = own + (farther[..., 0] - farther[..., 1]) / 2
        middle -= blobs.mean[..., None] + _slant(middle, own, profiles.line, blobs.mean)
        count = middle.shape[-1]
        shift = middle.sum(axis=-1) / count
        away = middle - shift[..., None]
        shift *= np.where(has_inside(blobs.axes[0], blur), 1, MIXED)[:, None]
        error = (away * away).sum(axis=(1, 2)) / (2 * count * (count - 1))
        return cls(shift, np.sqrt(error), np.maximum(1 - mixed / LEAST_MIXED, 0))


def _slant(
    middle: NDArray[np.float64],
    own: NDArray[np.float64],
    line: NDArray[np.intp],
    mean: NDArray[np.float64],
) -> NDArray[np.float64]:
    """How far the middles of chords are from the centroid because the object leans.

    The middles of a leaning rod are on its axis, and those of a turned square on either side of its
    center: that is their shape, and no error. What the tolerance cuts off makes a blob lean, too,
    but not the object. The lines of the chords are not quite even about the centroid.

    :param middle, own: (N, 2, PROFILES) of the object and of its blob [px].
    :param line: (N, 2, PROFILES) of :class:`Profiles`; mean: (N, 2) centroids [px].
    """
    away, slant, across = (m - m.mean(axis=-1, keepdims=True) for m in (middle, own, line))
    far = np.abs(slant)
    slant = slant * ((far > ROUNDED_SLANT) & (np.abs(away - slant) < SAME_SLANT * far))
    steep = (slant * across).sum(axis=-1) / np.maximum((across * across).sum(axis=-1), 0.5)
    return slant + (steep * (line.mean(axis=-1) - mean[:, ::-1]))[..., None]


def outside_share(levels: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, 2, PROFILES, 2, 2 PROFILE_SAMPLES) share of the surroundings along profiles.

    The surroundings are the first two neighbors outside whose hue differs about as much as that of
    any. The blob's own pixels are inside as far as something inside is beyond them, such as
    highlights, and what is beyond the surroundings is none of the object.
    """
    hue = _hue(levels)
    beside = levels - (levels * hue).sum(axis=0) * hue
    square = (beside * beside).sum(axis=0)[..., PROFILE_SAMPLES:]
    pair = square[..., 1:] + square[..., :-1]
    most = pair.max(axis=-1, keepdims=True)
    first = (pair >= MOST_DIFFERENT * most).argmax(axis=-1)[..., None]
    first += np.arange(first.size).reshape(first.shape) * 2 * PROFILE_SAMPLES + PROFILE_SAMPLES
    flat = beside.reshape(len(beside), -1)
    behind = (flat.take(first, axis=1) + flat.take(first + 1, axis=1)) / 2
    square = (behind * behind).sum(axis=0)
    share = (beside * behind).sum(axis=0) / np.maximum(square, NO_HUE**2)
    if (is_dull := square[..., 0] < NO_HUE**2).any():
        share[is_dull] = 1 - object_share(levels[:, is_dull])
    np.minimum(np.maximum(share, 0, out=share), 1, out=share)
    within, beyond = share[..., PROFILE_SAMPLES - 1 :: -1], share[..., PROFILE_SAMPLES:]
    np.minimum.accumulate(within, axis=-1, out=within)
    np.maximum.accumulate(beyond, axis=-1, out=beyond)
    return share


def _hue(levels: NDArray[np.float32]) -> NDArray[np.float32]:
    """(channels, N, 1, 1, 1, 1) direction of the color inside: the median over all profiles.

    Half of them may lie on highlights.
    """
    inside = levels[..., :ENDS].sum(axis=-1).reshape(*levels.shape[:2], -1)
    inside /= np.maximum(np.sqrt((inside * inside).sum(axis=0)), 1)
    inside.sort(axis=-1)
    half = inside.shape[-1] // 2
    hue = inside[..., half - 1] + inside[..., half]
    hue /= np.maximum(np.sqrt((hue * hue).sum(axis=0)), LEAST_COLOR)
    return np.asarray(hue[..., None, None, None, None])
