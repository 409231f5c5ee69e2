"""Where a template is in the next picture (WM; Vidal 2009, 3.4), and how sure that is (3.2.3)."""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.costs import distances
from colortrack_ros.windows.template import Region
from colortrack_ros.windows.template import Template

Floats = NDArray[np.float64]
Picture = NDArray

TO_GRAY = {
    'bgr8': cv2.COLOR_BGR2GRAY,
    'rgb8': cv2.COLOR_RGB2GRAY,
    'bgra8': cv2.COLOR_BGRA2GRAY,
    'rgba8': cv2.COLOR_RGBA2GRAY,
}

NEIGHBORS: NDArray = np.ones((3, 3), np.uint8)

ROUNDING = 0.02
"""Standard deviation of a place even in a picture without noise [px]: a parabola is no cost."""

NOISE_BEND = 5.0
"""Twice the standard deviation of the second difference of the distance by white noise alone, as a
multiple of E_min / sqrt(n): where E_min = 2 n sigma^2, each distance has 2 sqrt(n) sigma^2, and the
second difference sqrt(6) times that."""

LEAST_SHARE = 0.05
"""Of the least distance on the grid is, at least, left between its points."""


class Match(NamedTuple):
    """What the search for one template has found.

    place: (u, v) of the window's center, whole [px]; around: (3, 3) distances there and beside it,
    by v and u, NaN where there is none; distance: between the place and the one expected [px];
    single: there was no other candidate.
    """

    place: NDArray[np.intp]
    around: Floats
    distance: float
    single: bool


class Findings(NamedTuple):
    """What the search for M templates has found.

    z: (M, 2) u, v of the windows' centers [px], where expected if nothing was found; R: (M, 2, 2)
    its covariance [px^2], NaN without a minimum; similarity, likeness: (M,) of window and template
    (see Template.align), NaN if nothing was found; distance, single: (M,) as of Match; parts: of
    the frame that were searched.
    """

    z: Floats
    R: Floats
    similarity: Floats
    likeness: Floats
    distance: Floats
    single: NDArray[np.bool_]
    parts: list[Region | None]

    def valid(self, before: Floats, config: WindowConfig) -> NDArray[np.bool_]:
        """(M,) which matches are to be trusted (3.4.1, "Validação da Correspondência").

        :param before: (M,) similarity of the last valid match.
        """
        half_sum = (self.R[:, 0, 0] + self.R[:, 1, 1]) / 2
        half_difference = (self.R[:, 0, 0] - self.R[:, 1, 1]) / 2
        widest = half_sum + np.hypot(half_difference, self.R[:, 0, 1])  # the greater eigenvalue
        usual_drop = (1 - before) / 2  # by noise
        least = np.maximum(before - usual_drop - config.max_drop, config.min_similarity)
        return (widest <= config.max_deviation**2) & (self.similarity >= least)


def region(frame: Frame, low: NDArray[np.intp], high: NDArray[np.intp]) -> Region:
    """The part of a frame from pixel low to pixel high, (u, v), both inside and taken along."""
    part: NDArray = frame.image[low[1] : high[1] + 1, low[0] : high[0] + 1]
    if frame.encoding in TO_GRAY:
        part = cv2.cvtColor(part, TO_GRAY[frame.encoding])
    return Region(np.asarray(part, np.float32), low)


def find(
    frame: Frame, templates: Sequence[Template], expected: Floats, half: Floats, usual: Floats,
    config: WindowConfig,
) -> Findings:  # fmt: skip
    """Search for every template around the place where it is expected.

    :param templates: of M targets.
    :param expected: (M, 2) u, v [px].
    :param half: (M, 2) half the width and height of the search regions [px].
    :param usual: (M,) mean distance [px] of earlier matches from where they were expected.
    """
    found = [
        _search(frame, template.picture, expected[i], half[i], float(usual[i]), config)
        for i, template in enumerate(templates)
    ]
    place, around = expected.copy(), np.full((len(found), 3, 3), np.nan)
    far, single = np.full(len(found), np.inf), np.zeros(len(found), bool)
    for i, pair in enumerate(found):
        if pair:
            place[i], around[i], far[i], single[i] = pair[0]
    shift, R = refine(around, np.array([t.picture.size for t in templates]))
    z, alike = place + np.nan_to_num(shift), np.full((len(found), 2), np.nan)
    for i, (pair, template) in enumerate(zip(found, templates, strict=True)):
        if pair and config.drift_compensation:
            z[i], *alike[i] = template.align(pair[1], z[i])
        elif pair:
            alike[i] = template.likeness(pair[1].window(z[i], template.picture.shape))
    return Findings(
        z, R, alike[:, 0], alike[:, 1], far, single, [pair and pair[1] for pair in found]
    )


def _search(
    frame: Frame, template: Picture, expected: Floats, half: Floats, usual: float,
    config: WindowConfig,
) -> tuple[Match, Region] | None:  # fmt: skip
    """Compare a template with the windows of a search region.

    :return: what was found, and the part of the frame that it was found in; None when no window
        of the region is inside the picture.
    """
    rim = np.array(template.shape[::-1]) // 2
    size = np.array(frame.image.shape[1::-1])
    first = np.maximum(np.ceil(expected - half).astype(int), rim)
    last = np.minimum(np.ceil(expected + half).astype(int) - 1, size - 1 - rim)
    if (first > last).any():
        return None
    part = region(frame, first - rim, last + rim)
    matrix = distances(config.cost, template, part.gray)
    match = _choose(matrix, expected - first, usual, config.ambiguity)
    return match._replace(place=match.place + first), part


def _choose(matrix: NDArray, expected: Floats, usual: float, ambiguity: float) -> Match:
    """Choose among the candidates: the local minima of nearly the least distance.

    The candidate nearest to where the target is expected wins, unless even that one is farther
    away than usual: then distance tells nothing, and the most alike wins (the two conditions of
    3.4.1, "Vetor de Candidatos").
    """
    v, u = np.unravel_index(int(matrix.argmin()), matrix.shape)
    least = matrix[v, u]
    lowest = (matrix <= least + ambiguity * abs(least)) & (matrix <= cv2.erode(matrix, NEIGHBORS))
    rows, columns = np.nonzero(lowest)
    if len(rows) > 1:
        far = np.hypot(columns - expected[0], rows - expected[1])
        nearest = int(far.argmin())
        if far[nearest] <= usual:
            v, u = rows[nearest], columns[nearest]
    around = np.full((3, 3), np.nan)
    if 0 < v < matrix.shape[0] - 1 and 0 < u < matrix.shape[1] - 1:
        around[:] = matrix[v - 1 : v + 2, u - 1 : u + 2]
    distance = float(np.hypot(u - expected[0], v - expected[1]))
    return Match(np.array([u, v]), around, distance, len(rows) == 1)


def refine(around: Floats, pixels: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Where between the pixels the distance is least, and the covariance of that place.

    A parabola through the least distance and its neighbors, on each axis. Where the distance is
    E = E_min + d^T H d / 2 and E_min is noise of n pixels, the place has the covariance
    2 E_min / n H^-1 (of least squares, for sums of squares): wide in directions in which the
    distance hardly changes, where the match is not to be trusted (Anandan 1989; 3.2.3). Noise alone
    bends the distance as well; only what is more than twice that counts.

    :param around: (M, 3, 3) distances, by v and u; NaN: none.
    :param pixels: (M,) n, of the template.
    :return: shift (M, 2) by (u, v), within half a pixel, and R (M, 2, 2) [px^2]; NaN where the
        distance has no minimum.
    """
    c = around
    slope = np.stack([c[:, 1, 2] - c[:, 1, 0], c[:, 2, 1] - c[:, 0, 1]], axis=1) / 2
    middle = c[:, 1, 1]
    bend = np.stack([c[:, 1, 2] + c[:, 1, 0], c[:, 2, 1] + c[:, 0, 1]], axis=1)
    bend -= 2 * middle[:, None]
    twist = (c[:, 2, 2] - c[:, 2, 0] - c[:, 0, 2] + c[:, 0, 0]) / 4
    bend[(bend <= 0).any(axis=1)] = np.nan
    shift = np.clip(-slope / bend, -0.5, 0.5)
    least = middle + (slope * shift / 2).sum(axis=1)
    least = np.maximum(least, LEAST_SHARE * np.abs(middle))
    bend = np.maximum(bend - (NOISE_BEND * least / np.sqrt(pixels))[:, None], 0)
    det = bend[:, 0] * bend[:, 1] - twist**2
    det[det <= 0] = np.nan
    R = np.empty((len(c), 2, 2))
    R[:, 0, 0], R[:, 1, 1] = bend[:, 1], bend[:, 0]
    R[:, 0, 1] = R[:, 1, 0] = -twist
    R *= (2 * least / pixels / det)[:, None, None]
    return shift, R + ROUNDING**2 * np.eye(2)
