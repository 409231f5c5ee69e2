"""Removal of cast shadows, which lie on the ground beside a body and dim the background."""

import cv2
import numpy as np

from colortrack_ros.contours.areas import Mask
from colortrack_ros.data import Bools
from colortrack_ros.data import Indices
from colortrack_ros.detection.background_model import Picture

BODY_SHARE = 0.5
"""Columns of an area higher than this share of the highest belong to bodies. Assumed: a body twice
as far away is half as high."""

TAIL_SHARE = 0.25
"""Least reach of a shadow beyond a body, as a share of the body's height: more than a striding leg.
IDF1, MOTA of KITTI-17 with half and twice the value are 0.48, 0.09 and 0.44, 0.14, not 0.50, 0.20
(``benchmark/real_contours.py FOLDER --constants shadows.TAIL_SHARE``)."""

DIMMED = (0.1, 0.9)
"""Range of the light that remains in a shadow: some comes from the sky, and a loss of less than a
tenth may be a change of light, or noise. On sunlit paving it is 0.17 to 0.8 (KITTI-17)."""

TINT_SHARE = 0.1
"""Largest deviation of a shadow's channels from those of the dimmed background, as a share of its
level: the sky is bluer than the sun. On KITTI-17 75 % of a shadow's pixels are below 0.06, 90 %
below 0.08. With a fixed limit of 8 levels IDF1, MOTA are 0.21, -0.09 there, not 0.50, 0.20."""


def without_shadows(
    mask: Mask, picture: Picture, background: Picture, least: int, threshold: float
) -> Mask:
    """Return a mask without the shadows beside things.

    A shadow extends beyond the columns of its body. Clothes, which may look like dimmed background
    as well, do not.

    :param mask: (H, W), not 0 where something is.
    :param picture: (H, W, channels). With one channel, everything darker looks like dimmed
        background, and nothing is removed.
    :param background: of the same shape.
    :param least: smaller areas are left as they are [px].
    :param threshold: largest difference of equal pixels, mean of the channels [levels].
    """
    if picture.shape[2] == 1 or not mask.any():
        return mask
    result = mask.copy()
    left, top, width, height = cv2.boundingRect(mask)
    inner = mask[top : top + height, left : left + width]
    _, labels, stats, _ = cv2.connectedComponentsWithStats(inner)
    for k in 1 + np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= least):
        u, v, w, h, _ = stats[k].tolist()
        own = labels[v : v + h, u : u + w] == k
        for start, end in _runs(_beside_bodies(own)).tolist():
            part = np.s_[top + v : top + v + h, left + u + start : left + u + end]
            here = own[:, start:end]
            if _is_dimmed(picture[part][here], background[part][here], threshold):
                result[part][here] = 0
    return result


def _beside_bodies(own: Bools) -> Bools:
    """Return which columns of an area, (W,), are low, and far beyond bodies or between them."""
    top, bottom = own.argmax(axis=0), own[::-1].argmax(axis=0)
    high = np.where(own.any(axis=0), len(own) - top - bottom, 0)
    low = high <= BODY_SHARE * high.max()
    for start, end in _runs(low).tolist():
        is_between = start > 0 and end < len(low)
        is_low = own[:, start:end].nonzero()[0].mean() > len(own) / 2
        low[start:end] &= is_low and (is_between or end - start >= TAIL_SHARE * high.max())
    return np.asarray(low)


def _runs(which: Bools) -> Indices:
    """Return start and end, (N, 2), of each run of True."""
    steps = np.diff(which.astype(np.int8), prepend=0, append=0)
    return np.stack([np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)], axis=1)


def _is_dimmed(picture: Picture, background: Picture, threshold: float) -> bool:
    """Return whether most pixels, (P, channels), show dimmed background (Horprasert et al. 1999).

    Only pixels that differ from the background count; the rim that the Gaussian adds does not.
    """
    now, before = picture.astype(np.float32), background.astype(np.float32)
    gain = (now * before).sum(axis=1) / np.maximum((before * before).sum(axis=1), 1.0)
    off = np.abs(now - gain[:, None] * before).max(axis=1)
    differs = np.abs(now - before).mean(axis=1) > threshold
    dims = (gain > DIMMED[0]) & (gain < DIMMED[1]) & (off < TINT_SHARE * before.mean(axis=1))
    return bool(2 * np.count_nonzero(dims & differs) > np.count_nonzero(differs))
