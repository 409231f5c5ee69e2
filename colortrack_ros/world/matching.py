"""Assignment of a picture's detections to tracks, and their conversion to measurements."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Detections
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import PLANE_SIGMA
from colortrack_ros.world.measurement import U
from colortrack_ros.world.measurement import V
from colortrack_ros.world.state import Kinds

RAY = slice(U, PLANE)
"""The rows U and V of a measurement."""

DISC = np.pi / 4
"""Share of its box that a disc fills."""

HIDDEN = 0.15
"""Relative deviation from a disc, in filled share of the box or in length over width, from which a
blob is partly hidden or merged and tells nothing about a diameter. A sphere of 20 degrees, 30
degrees off the axis, is longer than wide by 0.13."""

HALF = 0.5
"""Share of the blob's box in which depths are read; at the blob's edge, depths mix with those of
the background. Chosen."""

BULGE = np.sqrt(1 - HALF**2 / 2)
"""Distance of a sphere's center behind the median depth there, in radii: half of the disc of radius
HALF lies within HALF / sqrt(2)."""

LEAST_VALID = 0.3
"""Least share of valid depths; only at edges and on mirrors are there more holes. Chosen."""


def taken_detections(ours: NDArray[np.void], detections: Detections) -> Indices:
    """Return, for each track, the row of its detection in this picture, -1 for none.

    A track has the color, area and box of its last detection; among several such, the nearest is
    taken. Tracks that share a blob keep theirs, so they have no detection.

    :param ours: (N,) of dtype TRACK.
    """
    theirs = detections.rows
    if not len(ours) or not len(theirs):
        return np.full(len(ours), -1)
    same = (ours['time_since_update'] == 0)[:, None]
    for name in ('color', 'area', 'box_w', 'box_h'):
        same = same & (ours[name][:, None] == theirs[name])
    one, other = same.nonzero()
    away = np.full(same.shape, np.inf)
    away[one, other] = np.hypot(
        ours['u'][one] - theirs['u'][other], ours['v'][one] - theirs['v'][other]
    )
    nearest, each = away.argmin(axis=1), np.arange(len(ours))
    mutual = away.argmin(axis=0)[nearest] == each
    return np.where(mutual & np.isfinite(away[each, nearest]), nearest, -1)


def measured_of(
    rows: NDArray[np.void],
    kinds: Kinds,
    config: LocatorConfig,
    camera: CameraModel,
    depth: NDArray[np.float32] | None,
) -> Measured:
    """Return the measurements of detections.

    :param rows: (N,) of dtype DETECTION.
    :param depth: (H, W) [m], aligned with the picture; NaN or 0 in its holes.
    """
    count = len(rows)
    z, used, R = np.zeros((count, 5)), np.zeros((count, 5), bool), np.zeros((count, 5, 5))
    whole = _are_whole(rows, camera)
    z[:, U], z[:, V] = rows['u'], rows['v']
    R[:, U, U] = rows['cov_uu'] + config.pixel_noise**2
    R[:, V, V] = rows['cov_vv'] + config.pixel_noise**2
    R[:, U, V] = R[:, V, U] = rows['cov_uv']
    z[:, BLOB] = seen_sizes(rows, config)
    known, discs = kinds.diameter > 0, round_blobs(rows, z[:, BLOB])
    lasting = hidden_halves(rows, known) ** 2
    used[:, RAY] = whole[:, None]
    used[:, PLANE] = whole & kinds.bound & (config.method in ('ground', 'fused'))
    R[:, PLANE, PLANE] = PLANE_SIGMA**2
    R[:, BLOB, BLOB] = config.size_noise**2
    by_size = (config.method in ('size', 'fused')) | ((config.method == 'ground') & ~kinds.bound)
    used[:, BLOB] = whole & by_size & known & discs
    if depth is not None and config.method in ('depth', 'fused'):
        measured, spread = _centers(rows, z[:, BLOB], known | discs, camera, depth)
        used[:, DEPTH] = whole & np.isfinite(measured)
        z[:, DEPTH] = np.where(used[:, DEPTH], measured, 0.0)
        R[:, DEPTH, DEPTH] = np.square(config.depth_noise * z[:, DEPTH])
        lasting[:, DEPTH] = np.square(spread * z[:, DEPTH])
    own = R.reshape(-1, 25)[:, ::6]  # a view of the diagonals
    own += lasting
    R[~whole] = np.eye(5)
    own[~used] = 1.0
    return Measured(z, R, used, lasting * used)


def _are_whole(rows: NDArray[np.void], camera: CameraModel) -> Bools:
    """Return which boxes, (N,), the border of the picture does not cut."""
    left, top = rows['box_u'], rows['box_v']
    right, bottom = left + rows['box_w'], top + rows['box_h']
    inside = (right < camera.width - 1) & (bottom < camera.height - 1)
    return np.asarray((left > 0) & (top > 0) & inside)


def seen_sizes(rows: NDArray[np.void], config: LocatorConfig) -> Floats:
    """Return the diameters of discs with the area of the blobs before erosion [px], (N,).

    Erosion by a square of 2 s + 1 px takes s (|cos| + |sin|) off an outline of any direction, 4 s /
    pi on average over a disc.
    """
    return np.sqrt(4 * rows['area'].astype(float) / np.pi) + config.eroded


def round_blobs(rows: NDArray[np.void], size: Floats) -> Bools:
    """Return which detections have the shape of a disc, (N,); small ones are too coarse to tell.

    Boxes are those of the eroded blobs, or, if the detector has found the color's tolerance, those
    of the objects.

    :param size: (N,) of :func:`seen_sizes`.
    """
    width, height = rows['box_w'].astype(float), rows['box_h'].astype(float)
    pixel = 2 / np.maximum(np.minimum(width, height), 1.0)
    even = np.abs(np.log(width / height)) < HIDDEN + pixel
    full = np.abs(rows['area'] / (width * height) / DISC - 1) < HIDDEN + pixel
    full |= np.abs(np.square(size) / (width * height) - 1) < pixel
    return np.asarray(even & full)


def hidden_halves(rows: NDArray[np.void], discs: Bools) -> Floats:
    """Return how far measurements of discs may be off because they are partly hidden, (N, 5) [px].

    One side may be covered: the center is off by up to half of what the box lacks, and so is the
    diameter of a disc of the same area. Boxes are whole pixels, so one pixel is no evidence.

    :param discs: (N,) which objects are seen as discs.
    """
    width, height = rows['box_w'].astype(float), rows['box_h'].astype(float)
    longer = np.maximum(width, height)
    off = np.zeros((len(rows), 5))
    for axis, side in ((U, width), (V, height)):
        lacks = (longer - side) * discs
        off[:, axis] = np.where(lacks > 1, lacks / 2, 0.0)
    np.maximum(off[:, U], off[:, V], out=off[:, BLOB])
    return off


def _centers(
    rows: NDArray[np.void],
    size: Floats,
    spheres: Bools,
    camera: CameraModel,
    depth: NDArray[np.float32],
) -> tuple[Floats, Floats]:
    """Return the depths of centers, (N,) [m], NaN if too few are valid, and what lasts in them.

    The size of a blob tells how far the center of a sphere lies behind its surface. What may be
    none may be as flat as a sheet or as thick as that sphere; its standard deviation is a share of
    the depth.

    :param size: (N,) diameter of the blobs [px].
    :param spheres: (N,) which are discs, or have a known diameter.
    """
    radius = size / (2 * np.sqrt(camera.K[0, 0] * camera.K[1, 1]))
    behind = BULGE * np.minimum(radius, 0.5)
    centers = depths_of(rows, depth) / (1 - np.where(spheres, behind, behind / 2))
    return centers, ~spheres * behind / np.sqrt(12)


def depths_of(rows: NDArray[np.void], depth: NDArray[np.float32]) -> Floats:
    """Return the median depths of the middles of blobs, (N,) [m]; NaN if too few are valid."""
    found = np.full(len(rows), np.nan)
    for i, row in enumerate(rows):
        half_w, half_h = HALF * row['box_w'] / 2, HALF * row['box_h'] / 2
        left, right = round(row['u'] - half_w), round(row['u'] + half_w) + 1
        top, bottom = round(row['v'] - half_h), round(row['v'] + half_h) + 1
        part = depth[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)]
        valid = part[np.isfinite(part) & (part > 0)]
        if valid.size and valid.size >= LEAST_VALID * part.size:
            found[i] = np.median(valid)
    return found
