"""Edges along measurement lines, with one remap for all samples and one filter for all lines."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices

SIDE_SAMPLES = np.array([[-6, -5, -4, -3, -2], [2, 3, 4, 5, 6]])
"""Samples just inside and just outside of an edge [px], starting where the document's edge
detector, 5 samples wide, ends."""

MAX_COORDINATE = 30_000.0
"""Coordinates are clipped to this [px]: OpenCV's remap has 16 bits, up to 32767."""


@dataclass(frozen=True)
class Edges:
    """One edge on each line, or none.

    :param found: (N, n) whether there is one.
    :param offset: (N, n) from the middle of the line outward [px], 0 where there is none.
    :param sides: (N, n, 2) intensities just inside and outside of it [levels], NaN where there is
        none.
    """

    found: Bools
    offset: Floats
    sides: Floats


def sampled(image: NDArray[np.uint8], points: Floats, normals: Floats, reach: int) -> NDArray:
    """Return intensities along lines: the largest channel (V of HSV, as in the document).

    Where that is the same all along, as of a pure color on white, it is the least channel.

    :param image: (H, W, channels) or (H, W).
    :param points: (M, 2) midpoints of the lines [px].
    :param normals: (M, 2) their unit directions.
    :param reach: samples to each side, 1 px apart.
    :return: (M, 2 reach + 1) uint8, from inside to outside.
    """
    if not len(points) or not image.size:
        return np.zeros((len(points), 2 * reach + 1), np.uint8)
    steps = np.arange(-reach, reach + 1, dtype=np.float32)
    start = np.clip(points, -MAX_COORDINATE, MAX_COORDINATE).astype(np.float32)
    along = normals.astype(np.float32)
    u, v = (start[:, [axis]] + along[:, [axis]] * steps for axis in (0, 1))
    # With fixed-point coordinates, 1/32 px, all versions of OpenCV give the same result.
    fixed = cv2.convertMaps(u, v, cv2.CV_16SC2)
    picture = cv2.remap(image, *fixed, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    if picture.ndim == 2:
        return picture
    most = np.maximum(np.maximum(picture[..., 0], picture[..., 1]), picture[..., 2])
    flat = np.flatnonzero(most.min(axis=1) == most.max(axis=1))
    if len(flat):
        most[flat] = picture[flat, :, :3].min(axis=2)
    return most


def find_edges(
    image: NDArray[np.uint8],
    points: Floats,
    normals: Floats,
    sigma: Floats,
    usual: Floats,
    config: ContourConfig,
) -> Edges:
    """Return the maximum a posteriori edge of each line (De Bem 2007, section 3, Figure 3).

    :param points: (N, n, 2) predicted points [px].
    :param normals: (N, n, 2), outward.
    :param sigma: (N, n) standard deviation of an edge around its prediction [px].
    :param usual: (N, n, 2) usual intensities inside and outside [levels], NaN where unknown.
    """
    half, shape = config.line_length // 2, points.shape[:2]
    margin = max(len(config.mask) // 2, int(SIDE_SAMPLES.max())) + 1
    points, normals = points.reshape(-1, 2), normals.reshape(-1, 2)
    samples = sampled(image, points, normals, half + margin)
    contrast = _responses(samples, config.mask)[:, margin - 1 : margin + 2 * half + 2]
    line, place = _peaks(contrast, config.min_contrast)
    sides = samples[line[:, None, None], (place + margin)[:, None, None] + SIDE_SAMPLES].sum(axis=2)
    sides = sides / SIDE_SAMPLES.shape[1]
    squared = _squared_deviation(sides, usual.reshape(-1, 2)[line], config)
    squared += np.square((place - half) / sigma.reshape(-1)[line])
    score = contrast[line, place + 1] * np.exp(-0.5 * squared)
    best = _strongest(line, score, config.no_edge)
    line = line[best]
    before, at, after = (contrast[line, place[best] + k].astype(float) for k in range(3))
    curvature = np.maximum(2 * at - before - after, 1e-9)
    step = place[best] - half + np.clip((after - before) / (2 * curvature), -0.5, 0.5)
    edges = Edges(np.zeros(shape, bool), np.zeros(shape), np.full((*shape, 2), np.nan))
    where = points[line] + normals[line] * step[:, None]
    seen = ((where >= 0) & (where <= np.array(image.shape[1::-1]) - 1)).all(axis=1)
    line = line[seen]
    edges.found.reshape(-1)[line] = True
    edges.offset.reshape(-1)[line] = step[seen]
    edges.sides.reshape(-1, 2)[line] = sides[best[seen]]
    return edges


def _peaks(contrast: NDArray, least: float) -> tuple[Indices, Indices]:
    """Return line and place, (K,) each, of the inner local maxima of contrasts, (N, m)."""
    here = contrast[:, 1:-1]
    peaks = (here >= contrast[:, :-2]) & (here > contrast[:, 2:]) & (here >= least)
    line, place = np.nonzero(peaks)
    return line, place


def _strongest(line: Indices, score: NDArray, least: float) -> Indices:
    """Return the indices of the best peak of each line that scores more than the least."""
    order = np.lexsort((score, line))
    order = order[score[order] > least]
    return order[np.diff(line[order], append=-1) != 0]


def _squared_deviation(sides: Floats, usual: Floats, config: ContourConfig) -> Floats:
    """Return the squared normalized deviation, (K,), of intensities, (K, 2); 0 where unknown."""
    deviations = np.array([config.inside_deviation, config.outside_deviation])
    weights = np.where(deviations > 0, 1 / np.maximum(deviations, 1e-9), 0.0)
    squared = np.square((sides - usual) * weights)
    return np.asarray(np.fmax(squared, 0.0).sum(axis=1))  # fmax ignores NaN


def _responses(samples: NDArray[np.uint8], mask: tuple[float, ...]) -> NDArray[np.float32]:
    """Return the absolute response of the edge mask at each sample: h for a step by h levels.

    Not with cv2.filter2D: the order of its sums, and so their rounding, depends on its version.
    """
    weights = np.array(mask, np.float32)
    weights /= np.abs(weights).sum() / 2
    width = samples.shape[1]
    padded = np.pad(samples, ((0, 0), (len(mask) // 2,) * 2), mode='edge')
    response = np.zeros(samples.shape, np.float32)
    for k in np.flatnonzero(weights).tolist():
        response += weights[k] * padded[:, k : k + width]
    return np.abs(response, out=response)
