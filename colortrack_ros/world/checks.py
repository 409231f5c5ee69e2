"""What does not fit together where objects are located: each check gives one line, or none."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Detections
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.matching import HIDDEN
from colortrack_ros.world.matching import round_blobs
from colortrack_ros.world.matching import seen_sizes
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.objects import Objects
from colortrack_ros.world.state import columns_of
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.view import View

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

OUT_OF_PLACE = 5.0
"""How many standard deviations an object may be off its height, or its blob off its size, before
somebody is told: of right ones that is one in a million."""

ELSEWHERE = np.log(1.3)
"""Ratio of sizes from which an object cannot be where it is located: its range is off by 30 %. Less
may be a diameter that nobody has measured. Chosen."""

BELOW = 0.1
"""Share of its distance by which an object that is located below the ground is not there, 6
degrees. What is above it may be held, or lie on a table. Chosen."""


def outside(detections: Detections, view: View) -> str:
    """Which detection is not in the picture that the calibration is of."""
    pixels = np.stack([detections.rows['u'], detections.rows['v']], axis=1)
    out = pixels[~view.camera.contains(pixels)]
    if not len(out):
        return ''
    return (
        f'a detection at u {out[0, 0]:.0f}, v {out[0, 1]:.0f} is outside of the '
        f'{view.camera.width}x{view.camera.height} picture of CameraInfo: the calibration is of '
        'another picture'
    )


def beyond(track: int, config: LocatorConfig) -> str:
    """That a track is of nothing that is near enough."""
    return (
        f'track {track}: its ray does not meet the ground, or its size or depth says so, within '
        f'max_range of {config.max_range:g} m: it is not located; if that is so for most, '
        'camera_pose is wrong (positive pitch looks down, roll is near 0)'
    )


def off_height(objects: Objects, view: View, config: LocatorConfig) -> tuple[str, Bools]:
    """Which object is said to be on the ground and is not located there, and which are below it.

    :return: a line, or none; (N,) what is so far below the ground that it cannot be there.
    """
    mean, cov = objects.belief.combined()
    above = mean[:, 2] - config.ground_height - objects.kinds.height
    spread = np.sqrt(cov[:, 2, 2] + cov[:, HEIGHT, HEIGHT])
    off = objects.kinds.bound & (np.abs(above) > OUT_OF_PLACE * spread)
    away = np.linalg.norm(mean[:, POSITION] - view.optical.t, axis=1)
    below = off & (above < -BELOW * away)
    if not off.any():
        return '', below
    return (
        f'object {objects.object_id[off][0]} is {above[off][0]:+.2f} m off the height that it has '
        'on the ground: camera_pose, ground_height, diameter or depth is wrong'
    ), below


def off_size(
    objects: Objects,
    found: NDArray[np.uint32],
    seen: NDArray[np.void],
    view: View,
    camera: int,
    config: LocatorConfig,
) -> tuple[str, Bools, Bools]:
    """Which object is seen larger or smaller than it would be where it is.

    :param found: (K,) the tracks of this camera that are measured.
    :param seen: (K,) their detections.
    :return: a line, or none; (N,) of which objects the size tells something; (N,) which are so much
        larger or smaller that they are elsewhere.
    """
    of, order = objects.track_id[:, camera], np.argsort(found)
    told = np.isin(of, found) & (objects.kinds.diameter > 0)
    seen = seen[order][np.searchsorted(found[order], of[told])]
    sizes = seen_sizes(seen, config)
    told[told] = disc = round_blobs(seen, sizes)
    kinds, belief, sizes = objects.kinds.take(told), objects.belief.take(told), sizes[disc]
    elsewhere, line = np.zeros(len(objects), bool), ''
    blob, variance = expected_blobs(belief, view, kinds, camera, config)
    spread = OUT_OF_PLACE * np.sqrt(variance + config.size_noise**2)
    # what has the shape of a disc may still be hidden by so much
    off = (sizes > blob + spread) | (sizes < (1 - HIDDEN) * (blob - spread))
    elsewhere[told] = off & (np.abs(np.log(sizes / blob)) > ELSEWHERE)
    if off.any():
        one = off.argmax()
        line = (
            f'object {objects.object_id[told][one]} is {sizes[one]:.0f} px large, expected '
            f'{blob[one]:.0f} px where it is located: camera_pose (upside down?), calibration, '
            'ground_height or diameter is wrong'
        )
    return line, told, elsewhere


def expected_blobs(
    belief: Belief, view: View, kinds: Kinds, camera: int, config: LocatorConfig
) -> tuple[Floats, Floats]:
    """The diameters of blobs [px] of objects where they are located, and their variances, (N,)."""
    motion, errors = belief.motion, belief.errors
    mean, _ = motion.combined(errors)
    robot = np.arange(len(mean)) // max(len(kinds), 1)
    kinds = kinds.take(np.arange(len(mean)) % max(len(kinds), 1))
    of = columns_of(camera)[OF_OBJECT:] - OF_OBJECT
    state = np.concatenate([mean, errors.mean[robot][:, of]], axis=1)
    z, H = expected(view, state, kinds.diameter, kinds.height + config.ground_height)
    h, p = H[:, BLOB], motion.probability[:, :, None, None]
    of_object = h[:, None, :OF_OBJECT]
    slope = (of_object @ (p * motion.slope).sum(axis=1))[:, 0]
    slope[:, of] += h[:, OF_OBJECT:]
    variance = (of_object @ (p * motion.cov).sum(axis=1) @ of_object.swapaxes(1, 2))[:, 0, 0]
    variance += (slope[:, None] @ errors.cov[robot] @ slope[..., None])[:, 0, 0]
    size, cov = belief.mixed(z[:, BLOB, None], variance[:, None, None])
    return size[:, 0], cov[:, 0, 0]
