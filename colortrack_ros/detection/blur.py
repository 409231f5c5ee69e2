"""Blur of blob outlines, measured in the picture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.data import Frame
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.pixels import pixels_at
from colortrack_ros.encodings import size_of

PROFILES = 2
"""Number of rows, and of columns, per blob, each with two ends. The median of four tolerates one
with another object beside it; more cost time."""

PROFILE_SAMPLES, CLOSE = 8, 3
"""Samples of a profile on each side of the outline, and how many closest to it are of adjacent
pixels. A sharp outline is 2 px wide, and up to 2 px from the eroded mask."""

REACH_SHARE = 1 / 4
"""Length of a profile on each side [half axes], at least PROFILE_SAMPLES px. Blur up to twice as
wide is visible; an object blurred over more than half of itself has no inside to compare with."""

UNSURE = 0.1
"""Shares this close to 0 and 1 are noise and shading, not blur. Of random worlds, blur of 5 to 16
px seems 0.83 to 0.97 times as wide; with half of it, 0.75 to 0.9 times, and sharp noisy outlines
seem up to a third wider."""

BEYOND = 2
"""Distance from the last pixel of a blob to the surroundings, without half of the blur [px]: the
erosion removes one pixel, and another is partly covered."""

ERODED = 1
"""Width that the default erosion takes from each side of an object [px]."""

MOST_FARTHER = 3
"""Largest ratio of the distance of opposite sides of an outline to that of the pixels inside whose
colors are compared: what is blurred over more than half of itself has no inside."""

ENDS = 2
"""Samples whose mean is the color inside, or outside: fewer have more noise, more have less
reach."""


@dataclass(frozen=True)
class Ends(Columns):
    """By how much farther out N blobs end on one side of each axis than on the other.

    Shift and error are 0 for blobs that consist of outline alone: even their middle is a mixture
    of colors.

    :param shift: (N, 2) of the middle between both ends, along u and v [shares of the blur].
    :param error: (N,) standard error of the shift, over both axes [shares of the blur].
    :param inside: (N,) share of the inside color at the ends, the mean over all.
    """

    shift: NDArray[np.float64]
    error: NDArray[np.float64]
    inside: NDArray[np.float64]

    @classmethod
    def of(cls, share: NDArray[np.float64], blobs: BlobTable, blur: NDArray[np.float64]) -> 'Ends':
        """The ends of blobs.

        The inside color is that of a pixel some way inside, and shading varies evenly across an
        object: at its outline opposite sides differ by as much more as they are farther apart.

        :param share: (N, 2, PROFILES, 2) of the inside color at the ends of :func:`outline_sides`.
        :param blur: (N, 2) of :func:`outline_blur`.
        """
        shift = (share[..., 1] - share[..., 0]) / 2
        mean = shift.mean(axis=2)
        away = shift - mean[..., None]
        error = np.einsum('nak,nak->n', away, away) / (2 * PROFILES * (PROFILES - 1))
        has_inside = blur.max(axis=1) < 2 * np.sqrt(blobs.axes[0])
        half = blobs.box[:, 2:] / 2
        farther = (half + ERODED) / np.maximum(half - blur / 2 - 1, half / MOST_FARTHER)
        return cls(
            mean * farther * has_inside[:, None],
            np.sqrt(error) * has_inside,
            share.mean(axis=(1, 2, 3)),
        )


@dataclass(frozen=True)
class Profiles(Columns):
    """Profiles across the outlines of N blobs: rows and columns in their middle half.

    :param row, left, right: (N, PROFILES) rows, with the blob's first column and one past its last.
    :param column, top, bottom: (N, PROFILES) columns, with the blob's first row and one past its
        last.
    """

    row: NDArray[np.intp]
    left: NDArray[np.intp]
    right: NDArray[np.intp]
    column: NDArray[np.intp]
    top: NDArray[np.intp]
    bottom: NDArray[np.intp]

    @classmethod
    def of(cls, blobs: BlobTable) -> 'Profiles':
        """The profiles of blobs."""
        return cls(*_middle_rows(blobs), *_middle_columns(blobs))


def outline_blur(frame: Frame, blobs: BlobTable, profiles: Profiles) -> NDArray[np.float64]:
    """Width of the transition from a blob to its surroundings, along u and along v.

    Along a profile across the outline, the share f of the inside color decreases to 0. For a ramp
    of width w, as caused by motion during the exposure, the integral of f (1 - f) is w / 6,
    wherever the outline lies on the ramp. What UNSURE takes from a ramp is given back. Rows and
    columns are from the middle half, where they cross the outline at a right angle.

    :returns: (N, 2) [px].
    """
    height, width = size_of(frame)
    minor, _ = blobs.axes
    reach = np.maximum(REACH_SHARE * 2 * np.sqrt(minor), PROFILE_SAMPLES)
    gap = np.ones((len(reach), PROFILE_SAMPLES))
    gap[:, CLOSE:] = ((reach - CLOSE) / (PROFILE_SAMPLES - CLOSE))[:, None]
    beyond = np.rint(gap.cumsum(axis=1)).astype(np.intp)
    # 0 is the last pixel of the blob.
    out, weight = np.hstack([1 - beyond[:, ::-1], beyond]), np.hstack([gap[:, ::-1], gap])
    position = _across(profiles, out[:, None], width, height)
    f = _shares(pixels_at(frame, position.reshape(-1, 2 * PROFILES, 2, 2 * PROFILE_SAMPLES)))
    # Two ends of each of PROFILES rows, and of as many columns.
    blur = np.einsum('nkes,ns->nke', f * (1 - f), weight).reshape(-1, 2, 2 * PROFILES)
    blur *= 6 / (1 - 2 * UNSURE)
    blur.sort(axis=2)
    return np.asarray((blur[..., PROFILES - 1] + blur[..., PROFILES]) / 2)


def outline_sides(
    frame: Frame, profiles: Profiles, blur: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pixels just inside and just outside the blurred outline of each blob.

    :param blur: (N, 2) of :func:`outline_blur`.
    :returns: (N, 2, PROFILES, 2) each, v width + u: along u and along v, at the high and at the low
        end.
    """
    height, width = size_of(frame)
    half = np.ceil(blur / 2).astype(np.intp)
    sides = _across(profiles, np.stack([-half, half + BEYOND], axis=2), width, height)
    return sides[..., 0], sides[..., 1]


def _across(profiles: Profiles, out: NDArray[np.intp], width: int, height: int) -> NDArray[np.intp]:
    """(N, 2, PROFILES, 2, S) pixels, v width + u, at both ends of rows and columns.

    None is past the middle.

    :param out: (N, 1 or 2, S) distance outward from the ends, 0 for the last pixel inside.
    """
    low = np.stack([profiles.left, profiles.top], axis=1)[..., None]
    high = np.stack([profiles.right, profiles.bottom], axis=1)[..., None]
    middle, out = (low + high) // 2, out[:, :, None]
    ends = np.empty((*low.shape[:3], 2, out.shape[3]), np.intp)
    np.maximum(high - 1 + out, middle, out=ends[..., 0, :])
    np.minimum(low - out, middle, out=ends[..., 1, :])
    np.maximum(ends, 0, out=ends)
    np.minimum(ends, np.array([width - 1, height - 1])[:, None, None, None], out=ends)
    ends[:, 0] += (profiles.row * width)[..., None, None]
    ends[:, 1] *= width
    ends[:, 1] += profiles.column[..., None, None]
    return ends


def _middle(low: NDArray[np.integer], size: NDArray[np.integer]) -> NDArray[np.intp]:
    """(N, PROFILES) numbers spread over the middle half of [low, low + size)."""
    share = 0.25 + 0.5 * (np.arange(PROFILES) + 0.5) / PROFILES
    return np.asarray(low[:, None] + (size[:, None] * share).astype(np.intp))


def _middle_rows(blobs: BlobTable) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """(N, PROFILES) each: rows, with the blob's first column and one past its last."""
    row, left, right = blobs.runs.ends()
    run = _middle(blobs.first_run, blobs.run_count)
    return row[run], left[run], right[run]


def _middle_columns(
    blobs: BlobTable,
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """(N, PROFILES) each: columns, with the blob's first row and one past its last."""
    row, left, right = blobs.runs.ends()
    column = _middle(blobs.box[:, 0], blobs.box[:, 2])
    mine = np.repeat(column, blobs.run_count, axis=0)
    meets = (left[:, None] <= mine) & (mine < right[:, None])
    below = np.where(meets, row[:, None], -1)
    bottom = np.maximum.reduceat(below, blobs.first_run, axis=0)
    above = np.where(meets, row[:, None], np.iinfo(np.intp).max)
    top = np.minimum.reduceat(above, blobs.first_run, axis=0)
    return column, np.minimum(top, bottom), bottom + 1


def _shares(profile: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(..., 2 PROFILE_SAMPLES) share of the inside color along profiles, (..., channels)."""
    levels = profile.astype(np.float32)
    outside = levels[..., -ENDS:, :].sum(axis=-2) / ENDS
    way = levels[..., :ENDS, :].sum(axis=-2) / ENDS - outside
    way /= np.maximum(np.einsum('...c,...c', way, way), 1)[..., None]
    levels -= outside[..., None, :]
    share = np.matmul(levels, way[..., None])[..., 0]
    share -= UNSURE
    share /= 1 - 2 * UNSURE
    return np.clip(share, 0, 1, out=share)
