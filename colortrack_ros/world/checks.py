"""Consistency checks of located objects; each returns one line, or an empty one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.matching import HIDDEN
from colortrack_ros.world.matching import round_blobs
from colortrack_ros.world.matching import seen_sizes
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import predicted
from colortrack_ros.world.objects import Objects
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.view import LOWEST
from colortrack_ros.world.view import View

UNCERTAIN = 0.5
"""Largest standard deviation of a range, as a share of it, at which an object starts. Chosen."""

OUT_OF_PLACE = 5.0
"""Standard deviations by which an object's height or blob size may be off before it is reported:
one in a million right ones."""

ELSEWHERE = np.log(1.3)
"""Log ratio of sizes from which an object cannot be where it is located: its range is off by 30 %.
A smaller one may be due to a diameter that nobody measured. Chosen."""

MOST_ROUNDED = 0.005
"""Largest rounding of positions [m], beyond 66 km. Chosen: half of what locates a ball well."""

MISMEASURED = 1e-3
"""Odds that an object has another diameter than its color says, times the ratio of the densities of
its height if so and if not, both at 0. Assumed: one in a hundred, and heights of 10 standard
deviations. Both are as likely from 3.7 standard deviations on."""

NOT_LINEAR = 0.1
"""Standard deviation of an object's height, as a share of how far the camera is above or below it,
up to which positions are linear in it (notes, "Heights that nobody knows well")."""

BELOW = 0.1
"""Height below the ground, over the distance, at which no object can be: 6 degrees. Objects above
the ground may be held, or lie on a table. Chosen."""


def coarse(view: View) -> str:
    """Report a robot so far from the origin of fixed_frame that positions are rounded coarsely."""
    step = rounding(view).max()
    if step < MOST_ROUNDED:
        return ''
    x, y = view.base.t[:2]
    return (
        f'the robot is at {x:.0f}, {y:.0f} m in fixed_frame, where the FLOAT32 x, y, z of '
        f'locations are rounded to {step:.2g} m: choose a frame whose origin is near, as odom'
    )


def rounding(view: View) -> Floats:
    """Return the spacing of x, y, z of dtype LOCATION at the robot's position, (3,) [m]."""
    return np.spacing(np.abs(view.base.t).astype(np.float32)).astype(float)


def beyond(track: int, config: LocatorConfig) -> str:
    """Report a track that is not within range."""
    return (
        f'track {track}: its ray does not meet the ground, or its size or depth says so, within '
        f'max_range of {config.max_range:g} m: it is not located; if that is so for most, '
        'camera_pose is wrong (positive pitch looks down, roll is near 0)'
    )


def unsure(track: int) -> str:
    """Report a track whose range is too uncertain, where no object is located."""
    return (
        f'track {track}: the standard deviation of its range is above {100 * UNCERTAIN:.0f} % of '
        'it: it is not located; it is too far away for how high the camera is above it, or one of '
        'camera_pose_sigma, height_sigma and diameter_sigma is too large'
    )


def unknown(color: int, count: int) -> str:
    """Report a track of a color that is not one of so many."""
    return (
        f'track of color {color}: expected one of the {count} in colors, which are those of the '
        'detector in its order'
    )


def off_height(objects: Objects, view: View, config: LocatorConfig) -> tuple[str, Bools]:
    """Report an object that should be on the ground and is not, and return which ones are below it.

    :return: a line, or none; (N,) objects so far below the ground that they cannot be there.
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


def unsaid(
    mean: Floats, cov: Floats, kinds: Kinds, view: View, config: LocatorConfig, shares: Floats
) -> Floats:
    """Return what to add to the covariances of positions, (N, 3, 3), beside what is estimated.

    :param mean: (N, 8), cov: (N, 8, 8) of the objects, of these kinds.
    :param shares: (N,) of :func:`other_diameters`.
    """
    if config.method == 'size':
        shares = _either_way(mean, cov, kinds, view, config)
    if config.vague:
        shares = np.hypot(shares, _by_heights(kinds, view, config))
    d = (mean[:, POSITION] - view.optical.t) * shares[:, None]
    return np.asarray(np.diag(rounding(view) ** 2 / 12) + d[:, :, None] * d[:, None, :])


def _by_heights(kinds: Kinds, view: View, config: LocatorConfig) -> Floats:
    """Return the spread of positions by heights that nobody knows well, as shares of ranges, (N,).

    These do not shrink as pictures come, which took noise for information about such heights.
    """
    below = view.optical.t[2] - config.ground_height - kinds.height
    share = kinds.sigma[:, 0] / np.maximum(np.abs(below), LOWEST)
    alone = kinds.bound & ((config.method == 'ground') | (kinds.diameter == 0))
    return np.where(alone & (share > NOT_LINEAR), np.minimum(share, 1.0), 0.0)


def _either_way(
    mean: Floats, cov: Floats, kinds: Kinds, view: View, config: LocatorConfig
) -> Floats:
    """Return the spread of positions if diameters may be wrong, as shares of the ranges, (N,).

    An object that should be on the ground, and by its size is not, is on a table, or it is where
    its ray meets the ground and its diameter is wrong. The mixture of both is moment-matched about
    the first.
    """
    above = mean[:, 2] - config.ground_height - kinds.height
    variance = np.maximum(cov[:, 2, 2] + cov[:, HEIGHT, HEIGHT] - 2 * cov[:, 2, HEIGHT], TINY)
    ray = mean[:, POSITION] - view.optical.t
    low = kinds.bound & (np.abs(ray[:, 2]) > LOWEST)
    share = np.where(low, above / np.where(low, ray[:, 2], 1.0), 0.0)
    share = np.clip(share, 1 - config.max_range / np.linalg.norm(ray, axis=1), 1.0)
    return np.asarray(share * _doubtful(np.square(above) / variance))


def _doubtful(squares: Floats) -> Floats:
    """Return the root of the probability of another diameter by normalized squares, (N,)."""
    odds = MISMEASURED * np.exp(np.minimum(squares / 2, 100.0))
    return np.sqrt(odds / (1 + odds))


@dataclass(frozen=True)
class BlobSizes:
    """Measured blob sizes, and those expected at the objects' locations.

    :ivar of: (N,) which K of the N objects these are.
    :ivar seen, expected: (K,) diameters of their blobs [px].
    :ivar cov: (K, K) of the difference [px^2]; the camera errors correlate the objects.
    """

    of: Bools
    seen: Floats
    expected: Floats
    cov: Floats

    @classmethod
    def of_picture(
        cls,
        objects: Objects,
        found: NDArray[np.uint32],
        rows: NDArray[np.void],
        view: View,
        camera: int,
        config: LocatorConfig,
    ) -> 'BlobSizes':
        """Return the sizes of objects that are seen as whole discs.

        :param found: (K,) the tracks of this camera that are measured.
        :param rows: (K,) their detections.
        """
        of, order = objects.track_id[:, camera], np.argsort(found)
        told = np.isin(of, found) & (objects.kinds.diameter > 0)
        rows = rows[order][np.searchsorted(found[order], of[told])]
        sizes = seen_sizes(rows, config)
        told[told] = disc = round_blobs(rows, sizes)
        sizes, rows = sizes[disc], rows[disc]
        kinds, belief = objects.kinds.take(told), objects.belief.take(told)
        blobs, cov = expected_blobs(belief, view, kinds, camera, config)
        # a blob slightly longer than wide may be hidden by the difference
        lacks = sizes * np.log(rows['box_w'].astype(float) / rows['box_h'])
        cov += np.diag(config.size_noise**2 + np.square(lacks))
        # objects located outside the view are not finite
        return cls(told, sizes, blobs, cov).take(_of(told, np.isfinite(blobs)))

    def take(self, of: Bools) -> 'BlobSizes':
        """Return the sizes of a selection of the objects, (N,)."""
        kept = of[self.of]
        return BlobSizes(
            self.of & of, self.seen[kept], self.expected[kept], self.cov[np.ix_(kept, kept)]
        )


def _of(rows: Bools, chosen: Bools) -> Bools:
    """Return rows, (N,), reduced to the chosen ones among them."""
    rows = rows.copy()
    rows[rows] = chosen
    return rows


def off_size(sizes: BlobSizes, ids: NDArray[np.int64]) -> tuple[str, Bools]:
    """Report an object that is seen larger or smaller than it should be where it is located.

    :param ids: (N,) of all objects.
    :return: a line, or none; (N,) objects whose size is off so much that they are elsewhere.
    """
    elsewhere, spread = np.zeros(len(ids), bool), OUT_OF_PLACE * np.sqrt(np.diag(sizes.cov))
    # a blob that passes as a disc may still be hidden by this share
    off = (sizes.seen > sizes.expected + spread) | (
        sizes.seen < (1 - HIDDEN) * (sizes.expected - spread)
    )
    elsewhere[sizes.of] = off & (np.abs(np.log(sizes.seen / sizes.expected)) > ELSEWHERE)
    if not off.any():
        return '', elsewhere
    one = off.argmax()
    return (
        f'object {ids[sizes.of][one]} is {sizes.seen[one]:.0f} px large, expected '
        f'{sizes.expected[one]:.0f} px where it is located: camera_pose (upside down?), '
        'calibration, ground_height or diameter is wrong'
    ), elsewhere


def other_diameters(
    sizes: BlobSizes, objects: Objects, view: View, config: LocatorConfig
) -> dict[int, float]:
    """Return the spread of objects on the ground if diameters may be wrong, as shares of ranges.

    What lies on the ground and is seen q times as large as expected is by (q - 1) D/2 higher, and
    nearer: with the camera H above the ground at H / (H + (q - 1) D/2) of the range.

    :return: by object ID.
    """
    kinds, ids = objects.kinds.take(sizes.of), objects.object_id[sizes.of].tolist()
    off = sizes.seen - sizes.expected
    higher = (sizes.seen / sizes.expected - 1) * kinds.diameter / 2
    above = view.optical.t[2] - config.ground_height
    share = kinds.bound * higher / np.maximum(np.abs(above + higher), LOWEST)
    share = np.clip(share, -1.0, 1.0) * _doubtful(np.square(off) / np.diag(sizes.cov))
    return dict(zip(ids, share.tolist(), strict=True))


def expected_blobs(
    belief: Belief, view: View, kinds: Kinds, camera: int, config: LocatorConfig
) -> tuple[Floats, Floats]:
    """Return the expected blob diameters [px] of N located objects, and their covariance.

    For one robot. The camera errors correlate the diameters.
    """
    errors, count, cases = belief.errors, len(kinds), len(belief.errors.mean)
    kinds = kinds.take(np.tile(np.arange(count), cases))
    size, slope, own = blobs_of(belief.motion, errors, view, kinds, config.ground_height, camera)
    slope = slope.reshape(cases, count, slope.shape[1])
    cov = slope @ errors.cov @ slope.swapaxes(1, 2)
    cov[:, np.arange(count), np.arange(count)] += own.reshape(cases, count)
    size, cov = mixture(np.exp(belief.log_weight), size.reshape(cases, 1, count), cov[:, None])
    return size[0], cov[0]


def blobs_of(
    motion: Motions, errors: CameraErrors, view: View, kinds: Kinds, ground: float, camera: int
) -> tuple[Floats, Floats, Floats]:
    """Return the expected blob diameters of N objects at the estimated camera errors, (N,) [px].

    :return: them, their derivative by the errors, (N, 9 C), and their variance if the errors were
        as estimated, (N,) [px^2].
    """
    mean, _ = motion.combined(errors)
    known = np.repeat(errors.mean, len(mean) // len(errors.mean), axis=0)
    H, rest = predicted(view, mean, known, kinds, ground, camera)
    of_object, p = H[:, BLOB, None], motion.probability[:, :, None, None]
    slope = (of_object @ (p * motion.slope).sum(axis=1))[:, 0] + rest[:, BLOB, :-1]
    own = (of_object @ (p * motion.cov).sum(axis=1) @ of_object.swapaxes(1, 2))[:, 0, 0]
    return rest[:, BLOB, -1], slope, own
