"""Silhouettes before any background, behind covers, and how well they are followed."""

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import Frame
from colortrack_ros.data import TENTATIVE
from colortrack_ros.scenes.outlines import PERSON
from colortrack_ros.scenes.outlines import QUADRILATERAL
from colortrack_ros.scenes.silhouettes import draw_polygon
from colortrack_ros.scenes.silhouettes import normalized
from colortrack_ros.scenes.silhouettes import placed

SHAPES = {'person': normalized(PERSON)[0], 'quadrilateral': normalized(QUADRILATERAL)[0]}
RATE = 24.0
QUICK = ContourConfig(learn_seconds=0.0)
EMPTY = 6
"""Pictures of the background alone, before the target is there."""


def texture(seed, height=240, width=320, contrast=30.0, cell=4.0):
    """Smooth random gray levels around 170, (height, width)."""
    noise = np.random.default_rng(seed).normal(size=(height, width))
    smooth = cv2.GaussianBlur(noise, (0, 0), cell)
    return np.clip(170 + contrast * smooth / smooth.std(), 60, 255)


def picture(shape, center, radius, turn=0.0, background=None, cover=None, level=45, seed=0):
    """A gray picture with a silhouette.

    :param cover: slices of what is in front of it, and its level.
    """
    gray = np.full((240, 320), 215.0) if background is None else background
    image = cv2.merge([gray.astype(np.uint8)] * 3)
    if center is not None:
        corners = placed(SHAPES[shape], np.asarray(center, float), radius, turn)
        draw_polygon(image, corners, [level] * 3)
    if cover is not None:
        image[cover[0]] = cover[1]
    return cv2.add(image[..., 0], noise(seed, image.shape[:2]), dtype=cv2.CV_8U)


@lru_cache(maxsize=500)
def noise(seed, shape):
    """Whole gray levels to add; drawn once, since each test has the same for its k-th picture."""
    normal = np.random.default_rng((7, seed)).normal(0, 2, shape)
    return np.floor(normal).astype(np.int8)


def frame(image, k=0, rate=RATE):
    encoding = 'mono8' if image.ndim == 2 else 'bgr8'
    return Frame(image, encoding, round(k * 1e9 / rate))


def follow(pictures, config, each=lambda k, tracks: None):
    """The tracks of each picture."""
    tracker = ContourTracker(config)
    result = []
    for k, image in enumerate(pictures):
        result.append(tracker.update(frame(image, k)))
        each(k, result[-1])
    return result


def overlap(one, other, shape=(240, 320)):
    """Intersection over union of two polygons (P, 2) in a picture of a shape."""
    corners = [np.rint(polygon * 16).astype(np.int32) for polygon in (one, other)]
    both = np.concatenate(corners)
    size = np.array(shape[::-1])
    low = np.clip(both.min(axis=0) // 16 - 1, 0, size - 1)
    wide, high = np.clip(both.max(axis=0) // 16 + 3, low + 1, size) - low
    masks = np.zeros((2, high, wide), np.uint8)
    for mask, polygon in zip(masks, corners, strict=True):
        cv2.fillPoly(mask, [polygon - 16 * low], 1, shift=4)
    return (masks[0] & masks[1]).sum() / max((masks[0] | masks[1]).sum(), 1)


def corners_of(shape, center, radius, turn=0.0):
    """The true outline."""
    return placed(SHAPES[shape], np.asarray(center, float), radius, turn)


def straight(k, start=(40.0, 120.0), speed=(2.5, 0.3), radius=26.0):
    """Where a target is, from the first picture that it is in, as arguments of picture()."""
    j = max(k - EMPTY, 0)
    return (start[0] + j * speed[0], start[1] + j * speed[1]), radius


def known(tracks):
    """Which tracks are confirmed."""
    return tracks.rows['state'] != TENTATIVE


def only(track_id, tracks):
    """One of the tracks."""
    own = tracks.rows['track_id'] == track_id
    return replace(tracks, rows=tracks.rows[own], outlines=tracks.outlines[own])


def errors(shape, results, place):
    """(frame, error [px], overlap) of the only confirmed track of each picture."""
    out = []
    for k, tracks in enumerate(results):
        if known(tracks).any():
            (row,), center = tracks.rows[known(tracks)], place(k)[0]
            (outline,) = tracks.outlines[known(tracks)]
            far = np.hypot(row['u'] - center[0], row['v'] - center[1])
            out.append((k, far, overlap(outline, corners_of(shape, *place(k)))))
    return np.array(out)


def pictures(shape, count, place=straight, **options):
    return [
        picture(shape, *(place(k) if k >= EMPTY else (None, 0)), seed=k, **options)
        for k in range(count)
    ]
