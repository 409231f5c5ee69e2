"""Least-squares test of whether objects seen from several places stand.

The angles to a standing object follow from the camera poses. For each object, one Gauss-Newton step
estimates its position and the camera errors from all pictures of the last seconds (bundle
adjustment of one point with known poses: Triggs et al. 2000). The remaining error of the angles
tells whether the object stood and whether poses and calibration are right.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import PLANE_SIGMA
from colortrack_ros.world.measurement import ranges_by_size
from colortrack_ros.world.measurement import U
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

ANGLE_SIGMA = 0.001
"""Standard deviation of a direction [rad] beside the pixel noise: 0.5 px at f = 500 px, or a stamp
that is off by 1 ms while the camera turns at 60 degrees/s. Assumed. For right setups, simulated
with 0.5 px, the misfit is then 0.05 to 0.4, where 1 is expected."""

RANGE_SIGMA = 0.05
"""Relative standard deviation of a distance by depth or size. Assumed."""

AT_HORIZON = 50.0
"""Initial distance of objects seen above the horizon [m], and the largest of all: 2.5 times the
default of max_range. Chosen."""

LEAST_EXPECTED = 1e-6
"""Least standard deviation of a camera error configured as 0, [m] and [rad], so that the equations
have a solution: a thousandth of ANGLE_SIGMA."""

FORWARD = np.repeat([1.0, -1.0], 3)
"""Signs of the errors of the camera pose in the equations here, over those in View."""

LEAST_AWAY = 1e-3
"""Least distance of an object from the camera [m], so that it has a direction: a camera that looks
straight down from the object's own height has it nowhere else. Assumed: inside any lens."""

NOT_KNOWN = 1e3
"""Prior standard deviation of an unknown position [m], large against AT_HORIZON."""


@dataclass
class Sights(Columns):
    """Objects as seen in several pictures, one row per object and picture.

    :ivar stamp: (M,) of the picture [ns].
    :ivar track: (M,) IDs.
    :ivar measured, kinds: of each.
    :ivar rays: (M, 3) in the optical frame.
    :ivar far: (M,) distance along the ray, by depth or size [m]; NaN if the ground gives it.
    :ivar sigma: (M,) standard deviation of the ray's direction [rad].
    :ivar moves: (M, 6) velocity of the camera's pose in terms of its errors.
    """

    stamp: NDArray[np.int64]
    track: NDArray[np.int64]
    measured: Measured
    kinds: Kinds
    rays: Floats
    far: Floats
    sigma: Floats
    moves: Floats

    @classmethod
    def of(
        cls,
        stamp: int,
        track: NDArray[np.uint32],
        measured: Measured,
        kinds: Kinds,
        view: View,
    ) -> 'Sights':
        """Return the sights of one picture."""
        seen, camera = measured.used[:, U], view.camera
        measured, kinds = measured.take(seen), kinds.take(seen)
        rays, far = rays_of(measured, kinds, camera)
        stamps = np.full(len(rays), stamp, np.int64)
        noise = np.trace(measured.R[:, :PLANE, :PLANE], 0, 1, 2) / 2
        sigma = np.sqrt(noise / (camera.K[0, 0] * camera.K[1, 1]) + ANGLE_SIGMA**2)
        ids, moves = track[seen].astype(np.int64), np.tile(view.moves * FORWARD, (len(rays), 1))
        return cls(stamps, ids, measured, kinds, rays, far, sigma, moves)


@dataclass
class Looks:
    """Geometry of M sights under each of C hypotheses.

    :ivar eyes: (C, M, 3) position of the camera in the fixed frame [m].
    :ivar ways: (C, M, 3) unit vectors from there to the objects.
    :ivar bases, bodies: (C, M, 3, 3) rotations of the robot and of the camera's body.
    :ivar far: (C, M) as in Sights.
    :ivar known: (C, M) whether the pose is known.
    """

    eyes: Floats
    ways: Floats
    bases: Floats
    bodies: Floats
    far: Floats
    known: Bools


def rays_of(measured: Measured, kinds: Kinds, camera: CameraModel) -> tuple[Floats, Floats]:
    """Return the rays of measurements, and the distances along them; see :class:`Sights`."""
    rays, far = camera.rays(measured.z[:, :2]), np.full(len(kinds), np.nan)
    sized = measured.used[:, BLOB] & ~measured.used[:, PLANE]
    if sized.any():
        by_size = ranges_by_size(camera, rays, measured.z[:, BLOB], kinds.diameter)
        far[sized] = by_size[sized]
    return rays, np.where(measured.used[:, DEPTH], measured.z[:, DEPTH] / rays[:, 2], far)


@dataclass
class _Solved:
    """Normal equations of K objects under each of C hypotheses, at their assumed positions.

    :ivar A: (C, M, 4, 11), y: (C, M, 4), of each sight; N: (C, K, 11, 11) with the priors.
    :ivar first: (K,) first sight of each; count: (C, K) of its sights.
    :ivar there: (C, K) whether objects can be where they are seen.
    """

    A: Floats
    y: Floats
    N: Floats
    first: Indices
    count: Floats
    there: Bools

    def summed(self, each: Floats) -> Floats:
        """Return sums over the sights of each object, (C, K, ...), of (C, M, ...)."""
        return np.asarray(np.add.reduceat(each, self.first, axis=1))


def misfits(looks: Looks, sights: Sights, ground: float, sigma: Floats) -> Floats:
    """Return the mean squared errors of the angles to standing objects, (C, K).

    They are normalized by their variances; about 1 or less is expected. The result is infinite for
    objects that cannot be where they are seen: behind the camera, or above the horizon.

    :param sights: (M,), grouped by their K objects.
    :param ground: its height in the fixed frame [m].
    :param sigma: (8,) standard deviations of the camera pose on the robot, of the time of pictures,
        and of the scale of ways.
    """
    solved = _solved(looks, sights, ground, sigma)
    A, y = solved.A, solved.y
    told = solved.summed(A.swapaxes(-1, -2) @ y[..., None])
    left = solved.summed(np.square(y).sum(axis=-1))
    left -= (told * np.linalg.solve(solved.N, told)).sum(axis=(-1, -2))
    return np.asarray(np.where(solved.there, left / (2 * solved.count), np.inf))


def drift(looks: Looks, sights: Sights, ground: float, sigma: Floats, seconds: Floats) -> Floats:
    """Return the one horizontal velocity, (C, 2) [m/s], with which all objects fit best.

    One Gauss-Newton step from standing; for the parameters see :func:`misfits`.

    :param seconds: (M,) time of each sight [s].
    """
    solved = _solved(looks, sights, ground, sigma)
    A, y = solved.A, solved.y
    B = A[..., :2] * seconds[:, None, None]
    At = A.swapaxes(-1, -2)
    across = solved.summed(At @ B)
    by_place = np.linalg.solve(solved.N, across).swapaxes(-1, -2)
    Bt = B.swapaxes(-1, -2)
    S = solved.summed(Bt @ B) - by_place @ across
    r = solved.summed(Bt @ y[..., None]) - by_place @ solved.summed(At @ y[..., None])
    S, r = S.sum(axis=1) + np.eye(2) / NOT_KNOWN**2, r.sum(axis=1)
    return np.asarray(np.linalg.solve(S, r)[..., 0])


def _solved(looks: Looks, sights: Sights, ground: float, sigma: Floats) -> _Solved:
    first = np.flatnonzero(np.append(True, sights.track[1:] != sights.track[:-1]))
    of = np.repeat(np.arange(len(first)), np.diff(np.append(first, len(sights.track))))
    height, by_plane = ground + sights.kinds.height, np.isnan(looks.far)
    with np.errstate(divide='ignore', invalid='ignore'):
        far = np.where(by_plane, (height - looks.eyes[..., 2]) / looks.ways[..., 2], looks.far)
        near = (far > 0) & (far < AT_HORIZON)
    there, far = near | ~looks.known, np.where(near, far, AT_HORIZON)
    known = looks.known[..., None]
    count = np.maximum(np.add.reduceat(known, first, axis=1, dtype=float), 1.0)
    places = np.add.reduceat(known * (looks.eyes + far[..., None] * looks.ways), first, axis=1)
    places /= count
    places[..., 2] = np.where(by_plane[:, first], height[first], places[..., 2])
    A, y, front = _equations(looks, places[:, of] - looks.eyes, far, sights)
    N = np.add.reduceat(A.swapaxes(-1, -2) @ A, first, axis=1)
    N[..., np.arange(11), np.arange(11)] += (
        np.concatenate([np.full(3, NOT_KNOWN), np.maximum(sigma, LEAST_EXPECTED)]) ** -2.0
    )
    variance = np.square(sights.kinds.sigma[first, 0]) + PLANE_SIGMA**2
    N[..., 2, 2] += by_plane[:, first] / variance
    there &= front | ~looks.known
    there = np.logical_and.reduceat(there, first, axis=1)
    return _Solved(A, y, N, first, count[..., 0], there)


def _equations(
    looks: Looks, arms: Floats, far: Floats, sights: Sights
) -> tuple[Floats, Floats, Bools]:
    """Return the normalized equations of each sight: three angles and a distance.

    The unknowns are the position of the object, (3,), the errors of the camera pose, x to yaw,
    (6,), that of the time of pictures, and that of the scale of ways.

    :param arms: (C, M, 3) from the camera to the assumed position of the object [m].
    :param far: (C, M) measured distance [m].
    :param sights: (M,).
    :return: Jacobian, (C, M, 4, 11), residual, (C, M, 4), and what is in front of the camera.
    """
    w, sigma = looks.ways, sights.sigma
    away = np.maximum(np.linalg.norm(arms, axis=-1), LEAST_AWAY)
    to = arms / away[..., None]
    across = (np.eye(3) - to[..., :, None] * to[..., None, :]) / (sigma * away)[..., None, None]
    A, y = np.zeros((*away.shape, 4, 11)), np.zeros((*away.shape, 4))
    ways = (looks.eyes - looks.eyes[:, :1])[..., None]
    A[..., :3, :3], A[..., :3, 3:6] = across, -across @ looks.bases
    # the columns are w x tilt, the error of the measured ray per tilt
    tilts = looks.bodies.swapaxes(-1, -2)
    A[..., :3, 6:9] = np.cross(w[..., None, :], tilts).swapaxes(-1, -2) / sigma[:, None, None]
    A[..., :3, 10:] = -across @ ways
    along, sized = (w * arms).sum(axis=-1), ~np.isnan(looks.far)
    y[..., :3] = (w - to * (along / away)[..., None]) / sigma[:, None]
    over = sized / (RANGE_SIGMA * far)
    A[..., 3, :3] = w * over[..., None]
    A[..., 3, 3:6] = -(w[..., None, :] @ looks.bases)[..., 0, :] * over[..., None]
    A[..., 3, 10:] = -(w[..., None, :] @ ways)[..., 0, :] * over[..., None]
    y[..., 3] = (far - along) * over
    A[..., 9] = (A[..., 3:9] @ sights.moves[..., None])[..., 0]
    A[~looks.known], y[~looks.known] = 0.0, 0.0
    return A, y, along > 0
