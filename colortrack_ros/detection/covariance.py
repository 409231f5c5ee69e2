"""The measurement covariance of a blob's centroid."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.label_image import LabelImage

# The constants below were fitted to rendered balls of 10 to 130 px radius. The normalized squared
# error, NSE in `python benchmark/detection_quality.py --constants`, is 1 where the covariance is
# right: it is 0.6 in the scene `single` and 1.8 in `fast`, where half of SMEAR_SHARE makes it 3.0
# and twice of it 1.0.

OUTLINE_VARIANCE = 0.06
"""Variance of the membership of a pixel on the outline, which is in or out by chance; 1/4 were the
toss of a coin."""

PIXELATION = 1 / 12
"""Variance of a position within its pixel [px^2]: that of the uniform distribution of width 1."""

SHADING_SHIFT = 0.0115
"""Shift of a centroid by shading and motion blur, for a mean D / tolerance of 1 [radii]."""

LENS_SHIFT = 0.05
"""Shift of a centroid by the blur of a lens, for a mean D / tolerance of 1 [px]."""

SMEAR_SHARE = 0.004
"""Variance along a smear over what it adds to the second moment: its ends fade unequally."""

ROUND_AXES = 1.1
"""Ratio of the second moments up to which a blob is not taken for a smear."""

HIDDEN_REACH = 6
"""How far beyond the ends of its runs the color of a blob that is partly hidden is looked for [px]:
beyond what an erosion of 3 and the blur of an outline take off."""


def centroid_covariance(
    blobs: BlobTable,
    score: NDArray[np.float64],
    part: NDArray[np.float64] | float,
    width: int,
    height: int,
) -> NDArray[np.float64]:
    """Measurement covariance of each centroid.

    A sum of independent errors, with N the area, S the central second moments of the blob and B
    the length of its outline, that of the ellipse-like shape in its box, pi (w + h) / 2:

    - each outline pixel is in or out by chance. The second moments of an outline about its center
      are twice those of the area within: 2 S B OUTLINE_VARIANCE / N^2, which falls with the
      blob's diameter;
    - the grid: PIXELATION / N;
    - shading: blur mixes the object with what is around, and a mix is within tolerance up to the
      farther out the nearer the object itself is to the reference color, which on its light and
      its dark side is not the same. The blur of motion grows with the object in the picture, that
      of a lens is some pixels, and the part of it by which the outline is shifted grows with the
      part of the tolerance that is used up, on the mean 1 - score: ((1 - score) (SHADING_SHIFT r +
      LENS_SHIFT))^2, with r^2 / 4 the minor second moment;
    - the smear of a moving object: SMEAR_SHARE times what the major second moment has beyond
      ROUND_AXES times the minor one, up to twice the minor one: longer things are long by
      themselves.

    A blob that touches the picture's border is cut there, by an unknown length. With an extent e,
    the larger side of its box, and a hidden part between nothing and e, its true center is up to
    e / 2 farther out: e^2 / 12 is added in that direction. Inside the picture it may be cut where
    pixels of its color were dropped. A segment whose arc is a small part s of the outline cuts off
    little, and more than half of the blob is seldom hidden: s^4 (e / 2)^2 / 12.

    :param score: (N,) mean closeness to the reference color, 0..1.
    :param part: (N,) of the outline beyond which the color was dropped, 0..1, see open_part().
    :param width, height: of the picture [px].
    :returns: (N, 2, 2) [px^2], positive definite.
    """
    left, top, box_width, box_height = blobs.box.T
    outline = np.pi / 2 * (box_width + box_height)
    share = 2 * OUTLINE_VARIANCE * outline / blobs.area**2
    covariance: NDArray[np.float64] = share[:, None, None] * blobs.spread
    minor, major = blobs.axes
    smear = np.minimum(np.maximum(major - ROUND_AXES * minor, 0), 2 * minor)
    hidden = np.maximum(box_width, box_height) ** 2 / 12
    shift = (1 - score) * (SHADING_SHIFT * 2 * np.sqrt(minor) + LENS_SHIFT)
    even = PIXELATION / blobs.area + shift**2
    even += SMEAR_SHARE * smear + part**4 * hidden / 4
    at_side = (left == 0) | (left + box_width == width)
    at_end = (top == 0) | (top + box_height == height)
    covariance[:, 0, 0] += even + at_side * hidden
    covariance[:, 1, 1] += even + at_end * hidden
    return covariance


def open_part(blobs: BlobTable, image: LabelImage, whole: LabelImage) -> NDArray[np.float64]:
    """The part of the left or the right outline, the greater, beyond which the color goes on.

    :param image: the labels that the blobs are made of.
    :param whole: the labels before some were dropped.
    :returns: (N,) 0..1.
    """
    row, left, right = blobs.runs.ends()
    beyond = np.stack([left - HIDDEN_REACH, right - 1 + HIDDEN_REACH]).clip(0, image.width - 1)
    dropped = (whole.pixels[row, beyond] == blobs.runs.label) & (image.pixels[row, beyond] == 0)
    if not len(row):
        return np.zeros(0)
    count = np.add.reduceat(dropped, blobs.first_run, axis=1, dtype=float).max(axis=0)
    return np.asarray(count / np.diff(blobs.first_run, append=len(row)))
