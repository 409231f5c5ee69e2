"""Matching: where a template is in the next picture (WM; Vidal 2009, 3.4), and how sure (3.2.3)."""

from collections.abc import Collection
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import Indices
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.costs import distances
from colortrack_ros.windows.crop import Crop
from colortrack_ros.windows.template import Template

NEIGHBORS: NDArray = np.ones((3, 3), np.uint8)
"""A pixel and its eight neighbors."""

SUBPIXEL_SIGMA = 0.02
"""Standard deviation of a position even without noise [px], since no cost is a true parabola. On
the scenes `clutter` and `jump` the RMSE is 0.015 px (``benchmark/windows.py --swarm``)."""

NOISE_CURVATURE = 5.0
"""Twice the standard deviation of the second difference of distances under white noise, as a
multiple of E_min / sqrt(n). With E_min = 2 n sigma^2, each distance has 2 sqrt(n) sigma^2, and the
second difference sqrt(6) times that."""

LEAST_REACH = 1.5
"""Least number of positions compared on either side, so that at least one has neighbors. The
smallest search region (3 px) has as many."""

LEAST_RESIDUAL = 0.05
"""Lower bound of the distance between grid points, as a share of the least one on the grid. Without
it the parabola through a match without noise dips below 0, and the variance would be negative.
Assumed: half and twice the value change nothing on five scenes (``benchmark/windows.py --seeds 1
--constants matching.LEAST_RESIDUAL``)."""


class Match(NamedTuple):
    """Result of the search for one template.

    position: (u, v) of the window's center [px]; around: (3, 3) distances at and around it, by v
    and u, NaN where there is none; innovation_norm: distance to the predicted position [px]; alone:
    whether there was no other candidate; surface: distances of all windows, by v and u; corner: (u,
    v) of the first pixel in the middle of the first window.
    """

    position: Floats
    around: Floats
    innovation_norm: float
    alone: bool
    surface: NDArray
    corner: Indices


class Matches(NamedTuple):
    """Results of the search for M templates.

    z: (M, 2) u, v of the windows' centers [px], the prediction if nothing was found; R: (M, 2, 2)
    its covariance [px^2], NaN without a minimum; similarity, correlation: (M,) of window and
    template (see Template.align), NaN if nothing was found; innovation_norm, alone: (M,) as in
    Match; crops: the parts of the frame that were searched; surfaces: corner and surface of each
    Match, and the step between its windows in pixels.
    """

    z: Floats
    R: Floats
    similarity: Floats
    correlation: Floats
    innovation_norm: Floats
    alone: Bools
    crops: list[Crop | None]
    surfaces: list[tuple[Indices, NDArray, int]]

    def are_valid(self, last_similarity: Floats, config: WindowConfig) -> Bools:
        """Which matches are valid, (M,) (3.4.1, "Validação da Correspondência").

        Without drift compensation, those that are found.

        :param last_similarity: (M,) of the last valid match.
        """
        if not config.drift_compensation:
            return np.asarray(~np.isnan(self.similarity))
        drop_by_noise = (1 - last_similarity) / 2
        least = np.maximum(last_similarity - drop_by_noise - config.max_drop, config.min_similarity)
        return self.are_sharp(config.max_deviation) & (self.similarity >= least)

    def are_sharp(self, deviation: float) -> Bools:
        """Which positions have at most this standard deviation [px] in every direction, (M,)."""
        half_sum = (self.R[:, 0, 0] + self.R[:, 1, 1]) / 2
        half_difference = (self.R[:, 0, 0] - self.R[:, 1, 1]) / 2
        widest = half_sum + np.hypot(half_difference, self.R[:, 0, 1])  # the larger eigenvalue
        return np.asarray(widest <= deviation**2)


def match_templates(
    frame: Frame, templates: Sequence[Template], predicted: Floats, half: Floats,
    mean_innovation: Floats, config: WindowConfig, skipped: Collection[int] = (),
) -> Matches:  # fmt: skip
    """Search for each template around its predicted position.

    :param templates: of M targets.
    :param predicted: (M, 2) u, v [px].
    :param half: (M, 2) half the width and height of the search regions [px].
    :param mean_innovation: (M,) mean norm of the innovations so far [px].
    :param skipped: indices of templates that are not searched for, as if they were not found.
    """
    found = [
        None
        if i in skipped
        else _search(frame, t, predicted[i], half[i], float(mean_innovation[i]), config)
        for i, t in enumerate(templates)
    ]
    count = len(found)
    z, around, alike = predicted.copy(), np.full((count, 3, 3), np.nan), np.full((count, 2), np.nan)
    norm, alone = np.full(count, np.inf), np.zeros(count, bool)
    for i, pair in enumerate(found):
        if pair:
            z[i], around[i], norm[i], alone[i] = pair[0][:4]
    shift, R = refine(around, np.array([t.picture.size for t in templates]))
    times = np.array([t.times for t in templates])
    z += np.nan_to_num(shift) * times[:, None]
    R *= np.square(times)[:, None, None]
    for i, (pair, template) in enumerate(zip(found, templates, strict=True)):
        if pair and config.drift_compensation:
            z[i], *alike[i] = template.align(pair[1], z[i])
        elif pair:
            alike[i] = template.correlation(pair[1].window(z[i], template.picture.shape))
    crops = [pair and pair[1] for pair in found]
    surfaces = [(pair[0].corner, pair[0].surface, pair[1].times) for pair in found if pair]
    return Matches(z, R, alike[:, 0], alike[:, 1], norm, alone, crops, surfaces)


def reliability_map(
    surfaces: list[tuple[Indices, NDArray, int]], shape: tuple[int, ...]
) -> NDArray[np.uint8]:
    """Picture of how much windows resemble the templates (3.2.3): an isolated peak is reliable.

    :param surfaces: see Matches.
    :param shape: height and width of the picture.
    :return: array of that shape. The center of each compared window has a value from 0, the least
        similar of its search region, to 255, the most similar; the rest is 0.
    """
    picture = np.zeros(shape, np.uint8)
    for (u, v), surface, times in surfaces:
        alike = 255 * (surface.max() - surface) / max(float(np.ptp(surface)), 1e-9)
        alike = alike.astype(np.uint8).repeat(times, axis=0).repeat(times, axis=1)
        part = picture[v : v + alike.shape[0], u : u + alike.shape[1]]
        np.maximum(part, alike, out=part)
    return picture


def _search(
    frame: Frame, template: Template, predicted: Floats, half: Floats, mean_innovation: float,
    config: WindowConfig,
) -> tuple[Match, Crop] | None:  # fmt: skip
    """Compare a template with the windows of a search region.

    :return: the match, and the part of the frame that contains it; None if no window of the region
        is inside the picture.
    """
    times = template.times
    rim = np.array(template.picture.shape[::-1]) // 2 * times
    half = np.maximum(half, LEAST_REACH * times)
    size = np.array(frame.image.shape[1::-1])
    first = np.maximum(np.ceil(predicted - half).astype(int), rim)
    last = np.minimum(np.ceil(predicted + half).astype(int) - 1, size - times - rim)
    if (first > last).any():
        return None
    crop = Crop.of(frame, first - rim, last + rim + times - 1, times)
    matrix = distances(config.cost, template.picture, crop.gray)
    middle = first + (times - 1) / 2
    match = _choose(matrix, (predicted - middle) / times, mean_innovation / times, config.ambiguity)
    match = match._replace(innovation_norm=times * match.innovation_norm, corner=first)
    return match._replace(position=middle + times * match.position), crop


def _choose(matrix: NDArray, predicted: Floats, mean_innovation: float, ambiguity: float) -> Match:
    """Choose among the candidates, the local minima close to the least distance.

    The candidate nearest to the prediction wins, unless even its innovation is larger than the
    mean. In that case the innovation is no evidence, and the most similar one wins (the two
    conditions of 3.4.1, "Vetor de Candidatos").
    """
    v, u = np.unravel_index(int(matrix.argmin()), matrix.shape)
    least = matrix[v, u]
    lowest = (matrix <= least + ambiguity * abs(least)) & (matrix <= cv2.erode(matrix, NEIGHBORS))
    rows, columns = np.nonzero(lowest)
    if len(rows) > 1:
        norm = np.hypot(columns - predicted[0], rows - predicted[1])
        nearest = int(norm.argmin())
        if norm[nearest] <= mean_innovation:
            v, u = rows[nearest], columns[nearest]
    around = np.full((3, 3), np.nan)
    if 0 < v < matrix.shape[0] - 1 and 0 < u < matrix.shape[1] - 1:
        around[:] = matrix[v - 1 : v + 2, u - 1 : u + 2]
    innovation_norm = float(np.hypot(u - predicted[0], v - predicted[1]))
    place = np.array([u, v], float)
    return Match(place, around, innovation_norm, len(rows) == 1, matrix, np.zeros(2, np.intp))


def refine(around: Floats, pixels: Indices) -> tuple[Floats, Floats]:
    """Subpixel position of the least distance, and its covariance.

    Fits a parabola through the least distance and its neighbors on each axis. If the distance is E
    = E_min + d^T H d / 2 and E_min is noise of n pixels, the covariance of the position is 2 E_min
    / n H^-1 (by least squares, for sums of squares). It is large in directions in which the
    distance hardly changes, where the match is unreliable (Anandan 1989; 3.2.3). Noise alone curves
    the distance, too; only curvature beyond twice that counts.

    :param around: (M, 3, 3) distances, by v and u; NaN: none.
    :param pixels: (M,) n, number of pixels of the template.
    :return: shift (M, 2) by (u, v), within half a pixel, and R (M, 2, 2) [px^2]; NaN where the
        distance has no minimum.
    """
    c = around
    slope = np.stack([c[:, 1, 2] - c[:, 1, 0], c[:, 2, 1] - c[:, 0, 1]], axis=1) / 2
    middle = c[:, 1, 1]
    curvature = np.stack([c[:, 1, 2] + c[:, 1, 0], c[:, 2, 1] + c[:, 0, 1]], axis=1)
    curvature -= 2 * middle[:, None]
    mixed = (c[:, 2, 2] - c[:, 2, 0] - c[:, 0, 2] + c[:, 0, 0]) / 4
    curvature[(curvature <= 0).any(axis=1)] = np.nan
    shift = np.clip(-slope / curvature, -0.5, 0.5)
    least = middle + (slope * shift / 2).sum(axis=1)
    least = np.maximum(least, LEAST_RESIDUAL * np.abs(middle))
    by_noise = NOISE_CURVATURE * least / np.sqrt(pixels)
    curvature = np.maximum(curvature - by_noise[:, None], 0)
    det = curvature[:, 0] * curvature[:, 1] - mixed**2
    det[det <= 0] = np.nan
    R = np.empty((len(c), 2, 2))
    R[:, 0, 0], R[:, 1, 1] = curvature[:, 1], curvature[:, 0]
    R[:, 0, 1] = R[:, 1, 0] = -mixed
    R *= (2 * least / pixels / det)[:, None, None]
    return shift, R + SUBPIXEL_SIGMA**2 * np.eye(2)
