"""Blur of blob outlines, measured in the picture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Frame
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.pixels import pixels_at
from colortrack_ros.detection.pixels import RED_FIRST
from colortrack_ros.encodings import size_of

PROFILES = 2
"""Number of rows, and of columns, per blob, each with two ends. The median of four tolerates one
with another object beside it; more cost time."""

PROFILE_SAMPLES, CLOSE = 8, 3
"""Samples of a profile on each side of the outline, and how many closest to it are of adjacent
pixels. A sharp outline is 2 px wide, and up to 2 px from the eroded mask. Assumed: three pixels
show where it is, and eight all of a blur of 16 px."""

IN_MIDDLE_HALF = 0.25 + 0.5 * (np.arange(PROFILES) + 0.5) / PROFILES
"""Where the profiles are [shares of the height, or width, of the blob]."""

BOTH_WAYS = np.append(np.arange(PROFILE_SAMPLES)[::-1], np.arange(PROFILE_SAMPLES))
"""Samples of a profile by their distance from the outline, from the inside out."""

OFF_MIDDLE = 0.26
"""Tangent of the angle between the axis and the normal of a disc at the ends of its profiles, which
are a quarter of a radius off its middle."""

LEANING = np.array([[1, -1], [1, 1], [1, 1], [1, -1]]) / PROFILES
"""(2 PROFILES, 2) weights of the ends of a profile: for the sum and for the difference of the mean
of those whose normals lean to one side and of the others, which are the lower right and the upper
left ones."""

LEAST_BLUR = 1.0
"""Least width of an outline [px]: a pixel is the mean over its width."""

ENDS = 2
"""Samples whose mean is the color inside, or outside: fewer have more noise, more have less
reach."""

REACH_SHARE = 1 / 4
"""Length of a profile on each side [half axes], at least PROFILE_SAMPLES px, if the blur fits."""

BESIDE_BLUR, LONGER = ENDS, 2
"""Length of a profile on each side beyond the width of the blur, all of which may be on that side
[px]: what colors are compared with. How many times as long one becomes whose colors still change at
its end: longer than need be, it sees other things, and `clutter`, `juggle`, and `light` lose."""

UNSURE = 0.1
"""Shares this close to 0 and 1 are noise and shading, not blur. Of random worlds, blur of 5 to 16
px seems 0.83 to 0.97 times as wide; with half of it, 0.75 to 0.9 times, and sharp noisy outlines
seem up to a third wider."""

TO_END, ROUND_UP, BEYOND = np.array([1, -1]), np.array([0, 1]), np.iinfo(np.intp).max
"""Steps outward at the high and at the low end of a profile; of an even number of pixels, the
middle belongs to the high end. A coordinate beyond all others."""


@dataclass(frozen=True)
class Profiles(Columns):
    """Profiles across the outlines of N blobs, in their middle half: along u, then along v.

    :param line: (N, 2, PROFILES) their rows, and their columns [px].
    :param end: (N, 2, PROFILES, 2) the last pixel of the blob at the high and at the low end of
        each, counted along it.
    """

    line: NDArray[np.intp]
    end: NDArray[np.intp]

    @classmethod
    def of(cls, blobs: BlobTable) -> 'Profiles':
        """The profiles of blobs."""
        corner, size = blobs.box[:, 1::-1, None], blobs.box[:, :1:-1, None]
        line = corner + (size * IN_MIDDLE_HALF).astype(np.intp)
        mine = line.repeat(blobs.run_count, axis=0)
        row, left, right = blobs.runs.ends()
        first, last = np.array([row, left]).T, np.array([row, right - 1]).T
        meets = (first[..., None] <= mine) & (mine <= last[..., None])
        high = np.where(meets, last[:, ::-1, None], -1)
        low = np.where(meets, first[:, ::-1, None], BEYOND)
        end = np.empty((*line.shape, 2), np.intp)
        np.maximum.reduceat(high, blobs.first_run, axis=0, out=end[..., 0])
        low = np.minimum.reduceat(low, blobs.first_run, axis=0)
        np.minimum(low, end[..., 0], out=end[..., 1])
        return cls(line, end)

    def across(self, out: NDArray[np.intp], height: int, width: int) -> NDArray[np.intp]:
        """(N, 2, PROFILES, 2, S) pixels, v width + u, none past the middle of the blob.

        Where the picture ends before the last of them, they are those at the other end.

        :param out: (N, S) distance outward from the ends, 0 for the last pixel inside.
        """
        to_middle = (self.end[..., :1] - self.end[..., 1:] + ROUND_UP) >> 1
        to_border = np.array([[[width - 1, 0]], [[height - 1, 0]]]) - TO_END * self.end
        out = out[:, None, None, None]
        limited = np.minimum(np.maximum(out, -to_middle[..., None]), to_border[..., None])
        step = np.array([[1], [width]])
        first = self.end * step[..., None] + (self.line * step[::-1])[..., None]
        pixel = first[..., None] + (TO_END * step)[:, None, :, None] * limited
        is_beyond = out[..., -1] > to_border
        if is_beyond.any():
            pixel = np.where(is_beyond[..., None], pixel[:, :, :, ::-1], pixel)
        return pixel


def fitting_profiles(
    frame: Frame, blobs: BlobTable, profiles: Profiles
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float64]]:
    """Colors along profiles that reach beyond the blur of outlines, and that blur.

    Profiles of objects that seem to be blurred over all of themselves stay as they are.

    :returns: levels and distances of :func:`profile_levels`, and the blur of :func:`outline_blur`.
    """
    minor, major = blobs.axes
    reach = np.maximum(REACH_SHARE * 2 * np.sqrt(minor), PROFILE_SAMPLES)
    close = np.ones((len(reach), PROFILE_SAMPLES))
    close[:, CLOSE:] = ((reach - CLOSE) / (PROFILE_SAMPLES - CLOSE))[:, None]
    levels, gap = profile_levels(frame, profiles, close, close.cumsum(axis=1))
    blur = outline_blur(levels, gap)
    left = np.arange(len(reach))
    while True:
        width = np.sqrt(blur[left].diagonal(axis1=1, axis2=2)).max(axis=1)
        short = (width + BESIDE_BLUR > reach[left]) & (reach[left] < 2 * np.sqrt(major[left]))
        left = left[short]
        left = left[_goes_on(levels[:, left])] if len(left) else left
        if not len(left):
            return levels, gap, blur
        reach[left] *= LONGER
        # Each in the middle of what it stands for: of wide blur none shows more than others.
        even = reach[left, None].repeat(PROFILE_SAMPLES, axis=1) / PROFILE_SAMPLES
        place = even.cumsum(axis=1) - (even - 1) / 2
        longer, between = profile_levels(frame, profiles.take(left), even, place)
        wider = outline_blur(longer, between)
        fits = has_inside(minor[left], np.sqrt(wider.diagonal(axis1=1, axis2=2)))
        left = left[fits]
        levels[:, left], gap[left], blur[left] = longer[:, fits], between[fits], wider[fits]


def _goes_on(levels: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(N,) whether blur goes on where profiles end outside: their last colors still change."""
    share = object_share(levels)[..., -2 * ENDS : -ENDS]
    return np.asarray(share.mean(axis=(2, 3, 4)).max(axis=1) > UNSURE)


def profile_levels(
    frame: Frame, profiles: Profiles, gap: NDArray[np.float64], place: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Colors along profiles across the outlines of blobs, from the inside out.

    :param gap: (N, PROFILE_SAMPLES) length of a profile that each sample stands for, outward [px].
    :param place: (N, PROFILE_SAMPLES) pixels from the end of the blob, 1 for the first outside.
    :returns: (channels, N, 2, PROFILES, 2, 2 PROFILE_SAMPLES) levels, BGR or gray, and
        (N, 2 PROFILE_SAMPLES) the lengths [px].
    """
    out = np.rint(place).astype(np.intp).take(BOTH_WAYS, axis=1)
    out[:, :PROFILE_SAMPLES] *= -1
    out[:, :PROFILE_SAMPLES] += 1
    levels = pixels_at(frame, profiles.across(out, *size_of(frame)))
    # Sums over a first axis of three are many times faster than over a last one.
    channels = levels[..., :3].transpose(5, 0, 1, 2, 3, 4).astype(np.float32, order='C')
    if frame.encoding in RED_FIRST:
        channels = channels[::-1]
    return channels, gap.take(BOTH_WAYS, axis=1).astype(np.float32)


def outline_blur(levels: NDArray[np.float32], gap: NDArray[np.float32]) -> NDArray[np.float64]:
    """Square of the width of the transition from a blob to its surroundings, in any direction.

    Along a profile across the outline, the share f of the inside color decreases to 0. For a ramp
    of width w, as caused by motion during the exposure, the integral of f (1 - f) is w / 6,
    wherever the outline lies on the ramp. What UNSURE takes from a ramp is given back. Rows and
    columns are from the middle half, where they cross the outline at nearly a right angle.

    :param levels, gap: of :func:`profile_levels`.
    :returns: (N, 2, 2) matrix B [px^2]: where the normal of the outline is n, its square is n B n.
    """
    f = object_share(levels)
    # Two ends of each of PROFILES rows, and of as many columns.
    blur = (f * (1 - f) * gap[:, None, None, None]).sum(axis=-1).reshape(-1, 2, 2 * PROFILES)
    blur *= 6 / (1 - 2 * UNSURE)
    return _squares(blur)


def _squares(blur: NDArray[np.float32]) -> NDArray[np.float64]:
    """The matrix of :func:`outline_blur` from the widths at the ends of each profile.

    Motion (a, b) during the exposure blurs an outline whose normal is n by |a n_u + b n_v|. Rows
    meet a disc off its middle, at normals that lean by OFF_MIDDLE to one side or to the other, so
    the blur along u is |a + OFF_MIDDLE b| at two diagonally opposite ends, and |a - OFF_MIDDLE b|
    at the others. The difference of their squares is 4 OFF_MIDDLE a b.

    :param blur: (N, 2, 2 PROFILES) [px]; sorted in place.
    """
    both = np.matmul(blur, LEANING)
    uneven = (both[..., 0] * both[..., 1]).sum(axis=1) / (8 * OFF_MIDDLE)
    blur.sort(axis=2)
    middle = np.maximum((blur[..., PROFILES - 1] + blur[..., PROFILES]) / 2, LEAST_BLUR) ** 2
    most = np.sqrt((middle[:, 0] - LEAST_BLUR**2) * (middle[:, 1] - LEAST_BLUR**2))
    squares = np.empty((len(blur), 4))
    squares[:, ::3] = middle
    squares[:, 1:3] = np.minimum(np.maximum(uneven, -most), most)[:, None]
    return squares.reshape(-1, 2, 2)


def has_inside(minor: NDArray[np.float64], blur: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) which blobs do not consist of blurred outline alone.

    :param minor: (N,) second moments along their minor axes [px^2].
    :param blur: (N, 2) widths along u and v [px].
    """
    return np.asarray(blur.max(axis=1) < 2 * np.sqrt(minor))


def object_share(levels: NDArray[np.float32]) -> NDArray[np.float32]:
    """(..., 2 PROFILE_SAMPLES) share of the inside color along profiles, (channels, ...)."""
    outside = levels[..., -ENDS:].sum(axis=-1) / ENDS
    way = levels[..., :ENDS].sum(axis=-1) / ENDS - outside
    way /= np.maximum((way * way).sum(axis=0), 1)
    share = ((levels - outside[..., None]) * way[..., None]).sum(axis=0)
    share -= UNSURE
    share /= 1 - 2 * UNSURE
    return np.minimum(np.maximum(share, 0, out=share), 1, out=share)
