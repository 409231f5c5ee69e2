"""Edges along measurement lines: one remap for all samples, one filter for all lines."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.config import ContourConfig

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

BESIDE = 2, 6
"""How far to a side of an edge [px] what tells what is there begins and ends."""

FAR = 30_000.0
"""Points farther out [px] are looked for here: OpenCV's coordinates end somewhere."""


@dataclass(frozen=True)
class Edges:
    """One edge on each line, or none.

    :param found: (N, n).
    :param offset: (N, n) from the middle of the line outward [px], 0 where there is none.
    :param sides: (N, n, 2) intensities just inside and outside of it [levels], NaN where there is
        none.
    """

    found: Bools
    offset: Floats
    sides: Floats


def sampled(image: NDArray[np.uint8], points: Floats, normals: Floats, reach: int) -> NDArray:
    """Intensities along lines, the greatest of the channels (V of HSV, as in the document).

    :param image: (H, W, channels) or (H, W).
    :param points: (M, 2) middles of the lines [px].
    :param normals: (M, 2) their directions, of length 1.
    :param reach: samples to each side, 1 px apart.
    :return: (M, 2 reach + 1) uint8, from inside to outside.
    """
    if not len(points) or not image.size:
        return np.zeros((len(points), 2 * reach + 1), np.uint8)
    steps = np.arange(-reach, reach + 1)[:, None]
    place = points[:, None] + normals[:, None] * steps
    place = np.clip(place, -FAR, FAR).astype(np.float32)
    picture = cv2.remap(image, place, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    if picture.ndim == 2:
        return picture
    return np.maximum(np.maximum(picture[..., 0], picture[..., 1]), picture[..., 2])


def find_edges(
    image: NDArray[np.uint8],
    points: Floats,
    normals: Floats,
    sigma: Floats,
    usual: Floats,
    config: ContourConfig,
) -> Edges:
    """The edge of maximum a posteriori probability on each line (De Bem 2007, section 3, Figure 3).

    :param points: (N, n, 2) predicted [px].
    :param normals: (N, n, 2), outward.
    :param sigma: (N, n) standard deviation of an edge around its prediction [px].
    :param usual: (N, n, 2) intensities inside and outside [levels], NaN where not known.
    """
    half, shape = config.line_length // 2, points.shape[:2]
    margin = max(len(config.mask) // 2, BESIDE[1]) + 1
    flat = points.reshape(-1, 2), normals.reshape(-1, 2)
    samples = sampled(image, *flat, half + margin)
    contrast = _responses(samples, config.mask)[:, margin - 1 : margin + 2 * half + 2]
    sides = [side[:, margin : margin + 2 * half + 1] for side in _sides(samples)]
    here = contrast[:, 1:-1]
    steps = np.arange(-half, half + 1, dtype=np.float32)
    gauss = np.exp(-0.5 * np.square(steps / sigma.reshape(-1, 1).astype(np.float32)))
    score = here * gauss
    deviations = config.inside_deviation, config.outside_deviation
    for side, known, deviation in zip(sides, usual.reshape(-1, 2).T, deviations, strict=True):
        if deviation > 0:
            unlike = np.square((side - known[:, None]) / np.float32(deviation))
            score *= np.exp(-0.5 * np.nan_to_num(unlike))
    peak = (here >= contrast[:, :-2]) & (here > contrast[:, 2:]) & (here >= config.min_contrast)
    score[~peak] = -1.0
    best, line = score.argmax(axis=1), np.arange(len(score))
    found = (score[line, best] > config.no_edge) & _within(image, *flat, steps[best])
    before, at, after = (contrast[line, best + k].astype(float) for k in range(3))
    bend = np.maximum(2 * at - before - after, 1e-9)
    offset = steps[best] + np.clip((after - before) / (2 * bend), -0.5, 0.5)
    return Edges(
        found.reshape(shape),
        np.where(found, offset, 0.0).reshape(shape),
        np.stack([np.where(found, s[line, best], np.nan) for s in sides], axis=1).reshape(*shape, 2),
    )


def _responses(samples: NDArray[np.uint8], mask: tuple[float, ...]) -> NDArray[np.float32]:
    """The edge mask at each sample, without its sign: h for a step by h levels."""
    if not len(samples):
        return samples.astype(np.float32)
    weights = np.array([mask], np.float32)
    weights /= np.abs(weights).sum() / 2
    return np.abs(cv2.filter2D(samples, cv2.CV_32F, weights, borderType=cv2.BORDER_REPLICATE))


def _sides(samples: NDArray[np.uint8]) -> list[NDArray[np.float32]]:
    """Mean intensities BESIDE each sample, towards the inside and the outside."""
    first, last = BESIDE
    weights = np.zeros((1, 2 * last + 1), np.float32)
    weights[0, : last - first + 1] = 1 / (last - first + 1)
    if not len(samples):
        return [samples.astype(np.float32)] * 2
    kernels = weights, np.ascontiguousarray(weights[:, ::-1])
    return [
        np.asarray(cv2.filter2D(samples, cv2.CV_32F, k, borderType=cv2.BORDER_REPLICATE))
        for k in kernels
    ]


def _within(image: NDArray, points: Floats, normals: Floats, offset: NDArray) -> Bools:
    """Whether edges are inside the picture."""
    place = points + normals * offset[:, None]
    size = np.array(image.shape[1::-1])
    return np.asarray(((place >= 0) & (place <= size - 1)).all(axis=1))
