"""Measurement covariance of blob centroids."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.chords import Chords
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.shape import extent
from colortrack_ros.detection.shape import PIXEL_MOMENT

# Fitted means: to the rendered scenes at five sizes, and to balls of 6 to 42 px in random worlds
# (color, wall, light, exposure, noise, focus, speed), for the greatest likelihood of the errors and
# a normalized squared error, NSE, close to 1 in each. NSE alone does not tell a covariance that is
# too short along the light and too wide across it. `python benchmark/detection_covariance.py --fit`
# does so on the scenes.

OUTLINE_VARIANCE = 0.052
"""Variance of the membership of an outline pixel, which is in or out by the position of the outline
between pixels. For discs of radius 4 to 14 px at random places, in steps of 0.25 px, after an
erosion by 3x3: 0.02 to 0.09 by the radius, 0.055 on average; 0.074 without erosion. Fitted to
scenes and worlds: 0.051 to 0.054."""

SHIFT_OF_ENDS = 8 / (3 * np.pi)
"""Shift of a disc's centroid over that of both its ends along an axis, if the outline at angle t
shifts by cos(t) |cos(t)| times that: the integral of |cos(t)|^3 over a turn, over pi. Blur along
the way of an exposure is |cos(t)| as wide, and what light from a side does to it is as cos(t)."""

ROUND = np.eye(2)
"""A covariance that is the same in all directions."""

TO_SHIFT = SHIFT_OF_ENDS**2 * (0.75 * np.eye(4) + 0.25 * np.outer(ROUND, ROUND))
"""(4, 4) linear map of matrices in :func:`shift_squared`: 3/4 of B and 1/4 of its trace."""

SHADED_VARIANCE = 0.02
"""Factor of the squared shift by one standard deviation of D / tolerance in the blob. Fitted."""

UNSEEN_CHANCE, CHORD_VARIANCE, CHORD_ERROR = 0.37, 0.55, 0.22
"""Share of the outline's chance that chords do not show, and factors of the square of what they
show and of that of its standard error. Fitted."""

ROUNDED_SHIFT, LEAST_SHIFT = 0.6, 1e-6
"""Shift up to which the rounding of ends to whole pixels may be the cause [px]: three standard
deviations of the mean of two chords along each axis, (9 / 24)^(1/2). A shift that is none [px]."""

ALONG_ROWS = 0.9
"""Share of its box that a blob fills from which on its sides are taken to be along rows and
columns: a disc fills pi / 4, a square that is turned by 3 degrees 0.9. Each side is then rounded as
a whole, so all of what chords show is the centroid's error."""

ROUNDED_SIDES, UNSEEN_SIDES = 1 / 24, 0.07
"""Variance of the middle of two sides that are each rounded to whole pixels [px^2], and the share
of it that chords never show: levels are no linear mixture. Of sharp boxes with a gamma of 2.2 the
middle of chords is off by 0.07 px, a share of 0.12, of blurred ones by less. Chosen between."""

LEAST_DEVIATION = 0.02
"""Least standard deviation of D / tolerance: that of methods without a color is 0."""

CUT_SHIFT = (0.33, 0.055)
"""Shift of a centroid due to a partial occlusion: coefficients of the three-fold skewness of the
visible part and of its square [half axes]."""

MOST_SKEWED = 1.2
"""Three-fold skewness of half a disc: more than half of an object is seldom hidden."""

HIDDEN_REACH = 6
"""Distance beyond the ends of its runs at which the color of a partly hidden blob is looked for
[px]: beyond the part removed by an erosion of 3 and the blur of an outline."""

FARTHEST_HIDDEN = 0.6
"""Largest assumed distance of the center of a disc beyond the picture's border [lengths of contact
between blob and border]. It is larger if less than a tenth of the disc is visible."""

HALF_DISC = 4 / (3 * np.pi)
"""Shift of the centroid of half a disc [radii]."""

SEGMENT_POWER = 1.4
"""Exponent of the hidden part of a radius in the shift of a disc's centroid, up to half a disc:
within 0.01 radii of the integral."""


def centroid_covariance(
    blobs: BlobTable,
    size: tuple[int, int],
    spread: NDArray[np.float64],
    blur: NDArray[np.float64],
    chords: Chords,
    part: NDArray[np.float64] | float,
    skewness: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Measurement covariance of each centroid: the sum over independent errors.

    - outline pixels that are in or out by chance: :func:`chance`, as far as chords do not show it;
    - what chords show of the object's own middle: :func:`seen_in_chords`; of sides along rows and
      columns, also what they do not show;
    - shading, the surroundings, and the limit of the color: :func:`shading`;
    - :func:`border_shift` across the border, or :func:`cut_shift` in any direction;
    - pixels dropped beside the blob, along a share s of the outline: s^4 (e / 2)^2 / 12, since a
      small s cuts off little, and more than half of an extent e is seldom cut off.

    :param size: height and width of the picture [px].
    :param spread: (N,) standard deviation of D / tolerance within each blob.
    :param blur: (N, 2, 2) square of the width of the outline [px^2], see outline_blur().
    :param chords: how far the objects' middles, by their hue, are from the centroids.
    :param part: (N,) share of the outline beyond which color was dropped, 0..1: open_part().
    :param skewness: (N,) excess three-fold skewness, see UsualSkewness.
    :returns: (N, 2, 2) [px^2], positive definite.
    """
    unseen = UNSEEN_CHANCE + (1 - UNSEEN_CHANCE) * chords.rounded
    covariance = unseen[:, None, None] * chance(blobs) + shading(spread, blur)
    aligned = extent(blobs) > ALONG_ROWS
    covariance += seen_in_chords(chords, aligned)
    beyond = border_shift(blobs, *size[::-1])
    cut = np.where(beyond.any(axis=1), 0, cut_shift(blobs, skewness))
    dropped = part**4 * blobs.box[:, 2:].max(axis=1) ** 2 / 48
    sides = ROUNDED_SIDES * np.maximum(chords.rounded, UNSEEN_SIDES)
    even = cut**2 / 2 + dropped + sides * aligned
    for axis in range(2):
        covariance[:, axis, axis] += even + beyond[:, axis] ** 2
    return covariance


def chance(blobs: BlobTable) -> NDArray[np.float64]:
    """Covariance from outline pixels in or out by chance: 2 S B OUTLINE_VARIANCE / N^2.

    N is the area, S are the central second moments, those of each pixel included, and B is the
    outline of the ellipse-like shape in the box, whose second moments about its center are twice
    those of the area. What is inside the outline has no error.

    :returns: (N, 2, 2) [px^2].
    """
    share = 2 * OUTLINE_VARIANCE * outline_length(blobs) / blobs.area**2
    return np.asarray(share[:, None, None] * (blobs.spread + PIXEL_MOMENT * ROUND))


def outline_length(blobs: BlobTable) -> NDArray[np.float64]:
    """(N,) length of the outline of the ellipse-like shape in the box of each blob [px]."""
    return np.asarray(np.pi / 2 * blobs.box[:, 2:].sum(axis=1))


def shading(spread: NDArray[np.float64], blur: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance of each centroid due to blur and shading.

    Blur mixes the object with its surroundings. The closer the object itself is to the reference
    color, the farther out a mixture is within tolerance, and the light and the dark side of an
    object differ in this, or what is behind them. The shift of a centroid is therefore a share of
    the width of the blur. Chords show some of it; the rest grows with the spread of D / tolerance.

    :returns: (N, 2, 2) [px^2].
    """
    variance = SHADED_VARIANCE * np.maximum(spread, LEAST_DEVIATION) ** 2
    return np.asarray(shift_squared(blur) * variance[:, None, None])


def seen_in_chords(chords: Chords, aligned: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Covariance of each centroid due to what is seen of its object's own middle, and its error.

    Where ends are known to whole pixels only, a shift of which that may be the cause is none.

    :param aligned: (N,) which blobs have sides along rows and columns.
    :returns: (N, 2, 2) [px^2].
    """
    shift = chords.shift[..., None]
    squared = np.maximum((chords.shift * chords.shift).sum(axis=1), LEAST_SHIFT**2)
    counts = np.maximum(1 - chords.rounded * ROUNDED_SHIFT**2 / squared, 0)
    counts *= np.where(aligned, 1, CHORD_VARIANCE)
    error = CHORD_ERROR * (1 - chords.rounded) * chords.error**2
    return np.asarray(
        counts[:, None, None] * shift * shift.transpose(0, 2, 1) + error[:, None, None] * ROUND
    )


def shift_squared(blur: NDArray[np.float64]) -> NDArray[np.float64]:
    """Square of the map from the seen share of the blur, along u and v, to a disc's shift.

    If an outline with normal n shifts by its width times n g, a disc shifts by the integral of that
    along n, over pi. If the width is w |n m|, m a unit vector, this is 8 w / (3 pi) g along m, and
    half of that across it: of |cos(t)| sin(t)^2, the integral is half of that of |cos(t)|^3.

    :param blur: (N, 2, 2) of :func:`outline_blur`, w^2 m m' for blur along m alone.
    :returns: (N, 2, 2) [px^2].
    """
    return np.asarray(np.matmul(blur.reshape(-1, 4), TO_SHIFT).reshape(-1, 2, 2))


def cut_shift(blobs: BlobTable, skewness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of each centroid from that of the complete, possibly occluded object.

    The visible part of an occluded disc is not an ellipse: its three-fold skewness tells how much
    is missing.

    :returns: (N,) [px].
    """
    skewness = np.minimum(skewness, MOST_SKEWED)
    half_axis = 2 * np.sqrt(blobs.axes[1])
    return np.asarray((CUT_SHIFT[0] + CUT_SHIFT[1] * skewness) * skewness * half_axis)


def border_shift(blobs: BlobTable, width: int, height: int) -> NDArray[np.float64]:
    """Distance of each centroid from that of the complete object, cut by the picture's border.

    The object is assumed to be a disc with the same extent and the same length of contact with the
    border. If its depth exceeds half that length, the center is inside the picture, and less than
    half of it is missing. If a blob touches opposite borders, its extent is unknown.

    :returns: (N, 2) across the left or right border and the upper or lower one, 0 for blobs that do
        not touch it [px].
    """
    depth = blobs.box[:, 2:].astype(np.float64)
    if blobs.inside(width, height).all():
        return np.zeros(depth.shape)
    row, left, right = blobs.runs.ends()
    length = right - left
    along = np.array([left == 0, right == width, length * (row == 0), length * (row == height - 1)])
    chord = np.add.reduceat(along.astype(np.float64), blobs.first_run, axis=1)
    both = (chord.reshape(2, 2, -1) > 0).all(axis=1).T
    chord = chord.reshape(2, 2, -1).max(axis=1).T
    radius = np.maximum(depth[:, ::-1], chord) / 2
    hidden = 1 - np.sqrt(np.maximum(1 - (chord / 2 / radius) ** 2, 0))
    less = HALF_DISC * radius * hidden**SEGMENT_POWER
    # The centroid of a flat segment is 0.6 of its depth from the border.
    radius = (chord**2 / 4 + depth**2) / (2 * depth)
    more = np.minimum(radius - 0.6 * depth, FARTHEST_HIDDEN * chord)
    shift = np.where(depth < chord / 2, more, less)
    return np.where(both, FARTHEST_HIDDEN * chord, shift)


def open_part(blobs: BlobTable, image: LabelImage, whole: LabelImage) -> NDArray[np.float64]:
    """Share of the left or right outline, whichever is larger, beyond which the color continues.

    :param image: the labels from which the blobs were made.
    :param whole: the labels before some were dropped.
    :returns: (N,) 0..1.
    """
    row, left, right = blobs.runs.ends()
    beyond = np.stack([left - HIDDEN_REACH, right - 1 + HIDDEN_REACH]).clip(0, image.width - 1)
    dropped = (whole.pixels[row, beyond] == blobs.runs.label) & (image.pixels[row, beyond] == 0)
    if not len(row):
        return np.zeros(0)
    count = np.add.reduceat(dropped, blobs.first_run, axis=1, dtype=float).max(axis=0)
    return np.asarray(count / blobs.run_count)
