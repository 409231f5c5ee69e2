"""Detections of a scene by a perfect detector, and by a worse one."""

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.texture import normal
from colortrack_ros.scenes.texture import uniform

BLACKOUT: Mapping[str, Any] = {
    'detected': 0.85, 'noise': 1.0, 'clutter': 0.2, 'gap': 10, 'gap_every': 60,
}  # fmt: skip
"""Detection of `blackout`: 85 % found, 20 % clutter, 10 of 60 frames missed."""

PIXEL_SIGMA = 0.1
"""Standard deviation of the centroid of a disc of whole pixels [px]: 0.09 at a radius of 3 px, and
0.03 at one of 32 px, over discs at random places."""


def detections_of(
    scene: Scene,
    k: int,
    detected: float = 1.0,
    noise: float = 0.0,
    clutter: float = 0.0,
    gap: int = 0,
    gap_every: int = 60,
    seed: int = 0,
) -> Detections:
    """Return the detections of frame k; they depend only on the arguments.

    A perfect detector sees the connected components of each color's pixels: no blob of a hidden
    object, one blob of two that touch (about the sum of the areas, one box around both), two blobs
    of an object behind a pole.

    :param detected: probability that a blob is detected, 0..1.
    :param noise: standard deviation of each centroid coordinate [px].
    :param clutter: false detections per object in the frame, uniform over the picture and as large
        as objects.
    :param gap: consecutive frames in which each object is missed, once in `gap_every` frames.
    :param seed: of all random numbers.
    """
    truth = scene.truth(k)
    unseen = [int(i) for i in truth['id'] if _in_gap(seed, int(i), k, gap, gap_every)]
    rows = _blobs(scene.segments(k, unseen), len(scene.colors))
    rows = rows[uniform((seed, k, 1), len(rows)) < detected]
    shift = noise * normal((seed, k, 2), len(rows), 2)
    for axis, (center, corner) in enumerate([('u', 'box_u'), ('v', 'box_v')]):
        rows[center] += shift[:, axis]
        rows[corner] += shift[:, axis]
    rows = np.concatenate([rows, _clutter(scene, truth, clutter, (seed, k, 3))], dtype=DETECTION)
    rows['cov_uu'] = rows['cov_vv'] = noise * noise + PIXEL_SIGMA * PIXEL_SIGMA
    rows['score'] = 1
    order = np.argsort(-rows['area'], kind='stable')
    return Detections(rows[order], round(k * NANOSECONDS / scene.rate))


def _blobs(mask: NDArray[np.uint8], colors: int) -> NDArray[np.void]:
    """Return the connected components of each color, (N,) of dtype DETECTION."""
    parts = [np.zeros(0, DETECTION)]
    for color in range(colors):
        # labels of 16 bits take a third of the time, and no mask of objects has 65,535 parts
        count, _, stats, centroids = cv2.connectedComponentsWithStats(
            (mask == color + 1).view(np.uint8), connectivity=8, ltype=cv2.CV_16U
        )
        rows = np.zeros(count - 1, DETECTION)
        rows['u'], rows['v'] = centroids[1:].T
        for column, name in enumerate(['box_u', 'box_v', 'box_w', 'box_h', 'area']):
            rows[name] = stats[1:, column]
        rows['color'] = color
        parts.append(rows)
    return np.concatenate(parts, dtype=DETECTION)  # without it NumPy repacks the fields


def _clutter(
    scene: Scene, truth: NDArray[np.void], share: float, seed: tuple[int, ...]
) -> NDArray[np.void]:
    """Return false detections: `clutter` for each object, on average."""
    whole = int(share)
    false = np.repeat(truth, whole + (uniform(seed, len(truth)) < share - whole))
    rows = np.zeros(len(false), DETECTION)
    rows['u'], rows['v'] = (
        uniform((*seed, 1), len(false), 2) * [scene.width, scene.height]
    ).T - 0.5
    rows['area'] = np.pi * false['radius'] * false['radius']
    rows['box_w'] = rows['box_h'] = 2 * false['radius']
    rows['box_u'], rows['box_v'] = rows['u'] - false['radius'], rows['v'] - false['radius']
    rows['color'] = false['color']
    return rows


def _in_gap(seed: int, i: int, k: int, gap: int, every: int) -> bool:
    """Return whether object i is missed in frame k: every `every` frames contain one gap,
    anywhere.
    """
    if gap == 0:
        return False
    block, offset = divmod(k, every)
    start = int(uniform((seed, i, block, 4), 1)[0] * (every - gap + 1))
    return start <= offset < start + gap
