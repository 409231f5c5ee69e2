"""Measurement covariance of blob centroids."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.label_image import LabelImage

# The constants below were fitted to rendered balls of 8 to 43 px radius by
# `python benchmark/detection_covariance.py --fit`. It brings the normalized squared error, NSE, of
# all scenes close to 1, the value for a correct covariance. They were rounded so that the NSE is
# 0.8 to 1.0 over the five scenes without maneuvers at 320x240 to 3840x2160.

OUTLINE_VARIANCE = 0.01
"""Variance of the membership of an outline pixel, which is in or out by chance; a fair coin would
have 1/4. Fitted to the scenes."""

PIXELATION = 1 / 12
"""Variance of a position within its pixel [px^2]: that of a uniform distribution of width 1."""

SHADING_SHIFT = 0.195
"""Ratio of the shift of a centroid to the width of the blur, for a mean D / tolerance of 1."""

SEEN_SHARE = 0.8
"""Ratio of the shift of a centroid to the shift seen at the ends of a few rows and columns: 0.4 to
1.5 by scene (least squares). Half and twice of it change the NSE of a scene by at most 0.45."""

BLURRED_DISTANCE = 0.25
"""Excess of the mean D / tolerance of blurred pixels over that of the rest of a blob: 1/2 if it
rises evenly from 0 at the inner end of the blur to 1 at the outline, less if blur has no inner
end."""

BLURRED_MARGIN = 1.0
"""Width of the blur that is not part of the blob [px]: the default erosion removes it."""

LEAST_DISTANCE = 0.02
"""Least mean D / tolerance of pixels without blur: the score is that of 16 pixels."""

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
    score: NDArray[np.float64],
    blur: NDArray[np.float64],
    sided: NDArray[np.float64],
    part: NDArray[np.float64] | float,
    skewness: NDArray[np.float64],
    doubt: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Measurement covariance of each centroid: the sum over independent errors.

    - outline pixels that are in or out by chance: :func:`chance`;
    - the pixel grid: PIXELATION / N;
    - shading, the surroundings, and the limit of the color: :func:`blur_shift`, :func:`seen_shift`;
    - :func:`border_shift` across the border, or :func:`cut_shift` in any direction;
    - pixels dropped beside the blob, along a share s of the outline: s^4 (e / 2)^2 / 12, since a
      small s cuts off little, and more than half of an extent e is seldom cut off.

    :param size: height and width of the picture [px].
    :param score: (N,) mean closeness to the reference color, 0..1.
    :param blur: (N, 2) width of the outline along u and v [px], see outline_blur().
    :param sided: (N, 2, 2) by how much farther out blobs end on one side of each axis, as seen in
        the picture, and its standard error [shares of blur].
    :param part: (N,) share of the outline beyond which color was dropped, 0..1: open_part().
    :param skewness: (N,) excess three-fold skewness, see UsualSkewness.
    :param doubt: (N,) shift due to the uncertain limit of a blob [shares of blur], see Method.
    :returns: (N, 2, 2) [px^2], positive definite.
    """
    outline = np.asarray(np.pi / 2 * blobs.box[:, 2:].sum(axis=1), np.float64)
    covariance = chance(blobs, outline)
    shift = seen_shift(blur_shift(blobs, blur, score, outline), blur, sided, doubt)
    beyond = border_shift(blobs, *size[::-1])
    cut = np.where(beyond.any(axis=1), 0, cut_shift(blobs, skewness))
    dropped = part**4 * blobs.box[:, 2:].max(axis=1) ** 2 / 48
    even = PIXELATION / blobs.area + cut**2 / 2 + dropped
    for axis in range(2):
        covariance[:, axis, axis] += even + shift[:, axis] ** 2 + beyond[:, axis] ** 2
    return covariance


def chance(blobs: BlobTable, outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance from outline pixels in or out by chance: 2 S B OUTLINE_VARIANCE / N^2.

    N is the area, S are the central second moments, and B is the outline of the ellipse-like shape
    in the box, whose second moments about its center are twice those of the area.

    :returns: (N, 2, 2) [px^2].
    """
    share = 2 * OUTLINE_VARIANCE * outline / blobs.area**2
    return np.asarray(share[:, None, None] * blobs.spread)


def blur_shift(
    blobs: BlobTable,
    blur: NDArray[np.float64],
    score: NDArray[np.float64],
    outline: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Shift of each centroid by blur and shading, along u and v (standard deviation).

    Blur mixes the object with its surroundings. The closer the object itself is to the reference
    color, the farther out a mixture is within tolerance, and the light and the dark side of an
    object differ in this. The shift of an outline is therefore a part of the blur width that grows
    with D / tolerance. Its mean is 1 - score, minus the contribution of the blur itself. With light
    from the side, a blur of width |w cos(t)| at angle t shifts a disc half as far: the integral of
    |cos(t)| sin(t)^2 is half that of |cos(t)|^3.

    :returns: (N, 2) [px].
    """
    inner = np.maximum(blur.mean(axis=1) / 2 - BLURRED_MARGIN, 0)
    blurred = np.minimum(inner * outline / blobs.area, 1)
    distance = np.maximum(1 - score - BLURRED_DISTANCE * blurred, LEAST_DISTANCE)
    along, aside = blur, blur[:, ::-1] / 2
    return np.asarray(SHADING_SHIFT * distance[:, None] * np.hypot(along, aside))


def seen_shift(
    expected: NDArray[np.float64],
    blur: NDArray[np.float64],
    sided: NDArray[np.float64],
    doubt: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Shift of each centroid by the ends of its outline, along u and v (standard deviation).

    The expected and the observed shift are the same quantity, so the larger one counts.
    Surroundings that vary along the outline, and doubt, are independent errors.

    :param expected: (N, 2) of :func:`blur_shift` [px].
    :returns: (N, 2) [px].
    """
    shift = np.hypot(expected, blur * sided[..., 1])
    shift = np.maximum(shift, SEEN_SHARE * blur * sided[..., 0])
    return np.asarray(np.hypot(shift, blur * doubt[:, None]))


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
        return np.zeros_like(depth)
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
