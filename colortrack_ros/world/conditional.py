"""Update of objects conditional on the camera errors, and its information about these errors.

The measurement is relinearized at the updated state (iterated extended Kalman filter: Bell and
Cathey 1993; Bar-Shalom, Li and Kirubarajan 2001, 10.5.2).
"""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.cases import PITCH
from colortrack_ros.world.linearized import Linearized
from colortrack_ros.world.linearized import Prior
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import two_ranges
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import MOVES
from colortrack_ros.world.state import OF_CAMERA
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import STANDS
from colortrack_ros.world.view import View
from colortrack_ros.world.whitening import whitening

LINEARIZATIONS = 4
"""Most linearizations of an update, each at the result of the last one. With 8, NEES and RMSE of
`benchmark/world.py` are the same (30 runs, seed 5, driving robot). One is enough for 76 to 89 % of
the updates of rolling and standing objects."""

LINEAR_WITHIN = 0.02
"""Change of X/Z, Y/Z, 1/Z [1/m] up to which one linearization is enough: 10 px at f = 500 px, 40
times the noise. Relinearizing smaller changes as well would correlate both factors of the
information about the camera errors through the noise, and bias these errors."""

LEAST_PARALLAX = 0.02
"""Least share of a camera error's effect on a measurement that the object's state must leave
unexplained for the error to be observable. Smaller shares come from linearization: a first ray that
is off by 0.5 px puts an object 5 m away 1.2 % too far. With 0, `python benchmark/world.py` gives
objects that stand on the ground before a standing robot a NEES of 8 in place of 3.2, of 3."""

COUNTED = 0.5
"""Share of the information about the camera errors that counts, and, where the height of the camera
is split, of what pictures tell of its cases. Successive pictures are linearized at nearly the same,
wrong place. With 1, `python benchmark/world.py` gives rolling objects before a standing robot a
NEES of 6.3 in place of 4.7, of 4, by fused."""

SURELY = 64
"""Standing objects tell much more about the camera errors than rolling ones do, but an object that
rolls slowly looks, in all pictures alike, like a standing object seen with camera errors. So the
weight of the standing hypothesis is its probability to this power: as if the object had to stand in
that many independent pictures. With 1, `python benchmark/world.py --elsewhere --seed 21 --runs 30`
gives rolling objects at 60 Hz a NEES of 5.8 in place of 3.7, of 4; with 16 4.1; with 256 3.6, but
then the error of resting objects is 2.0 instead of 1.6 %. With 1 for what may roll slowly
(`Kinds.slow`), three balls of 0.2 to 0.6 m/s before a robot that drives have 2.0 to 1.7 of 1 on
each axis, and with this 1.6 to 1.4 (10 Hz, 30 runs)."""

LEAST_LIKELY = 1e-3
"""Least probability of each hypothesis, however badly it fits: a ball that is kicked fits none.
Assumed."""

LATE = 0.5
"""Least probability of a throw within a step after a picture, as a share of that before it: what is
thrown late in the step has not moved yet. Of throws at any time of it, a share of atan(R) / R, with
R the way of a throw at its start over the noise, shows as little, 0.2 for 5. The hypothesis, as a
Gaussian in which velocity and way are correlated by 0.87, leaves those 0.4 of their variance."""


@dataclass
class Updated:
    """Update of N objects under two hypotheses each; positions in inverse depth.

    :ivar states: the updated states if the camera errors stay as estimated.
    :ivar nis: (N,) normalized innovation squared of the best-fitting hypothesis.
    :ivar information: (N, 9 C, 9 C) of the measurement about the camera errors.
    :ivar vector: (N, 9 C) information times the correction.
    :ivar p: (N, 2) prior probabilities of the hypotheses.
    :ivar off: (N, 2, M) innovations; S: (N, 2, M, M) their covariances.
    :ivar shown: (N, 2) share of the pitch's effect that cases are told by; see `likelihoods`.
    """

    states: Motions
    nis: Floats
    information: Floats
    vector: Floats
    p: Floats
    off: Floats
    S: Floats
    shown: Floats

    def likelihoods(self, of: Indices, limit: Floats) -> tuple[Floats, Floats]:
        """Return the log likelihoods of the measurements and of some at the edge of the gate, (N,).

        The camera errors are taken as estimated. How widely an object is expected is averaged over
        its cases: speed and wander are in meters, so that in pixels, objects roll the more smoothly
        the farther away they are. Otherwise, what rolls more smoothly than its kind may, or is
        measured better than told, would be taken to be farther away with each picture.

        What may move tells of cases only as far as parallax shows the pitch, as it tells of the
        camera errors. While the robot stands, all that differs is how fast and how evenly things
        roll, in meters, and `speed` and `wander` are guesses.

        :param of: (N,) which object each is, in one case or another.
        :param limit: (N,) gate of the normalized innovation squared.
        """
        W, volume = whitening(_alike(self.S, of))
        nis = np.square(W @ self.off[..., None])[..., 0].sum(axis=-1)
        logs = np.stack([volume - nis / 2, volume - limit[:, None] / 2])
        most = logs.max(axis=-1)
        p = _alike(self.p, of)
        density = (p * np.exp(logs - most[..., None])).sum(axis=-1)
        shown = (p * _alike(self.shown, of)).sum(axis=-1)
        log, at_edge = shown * (most + np.log(np.maximum(density, TINY)))
        return log, at_edge


def conditional(
    part: Motions,
    errors: CameraErrors,
    robot: Indices,
    measured: Measured,
    view: View,
    kinds: Kinds,
    ground: float,
    camera: int,
    within: float = LINEAR_WITHIN,
) -> Updated:
    """Update states in inverse depth as if the camera errors were as estimated."""
    p, P, falls = part.probability, errors.cov[robot], kinds.falls
    rows = measured.used.any(axis=0).nonzero()[0].tolist()
    prior = Prior(part, errors.mean[robot], P, measured, kinds, view, ground, camera, rows)
    at: Floats = (p[:, None] @ part.mean)[:, 0]
    step = prior.updated(at)
    bent, far = np.arange(len(part)), np.zeros(len(part), bool)
    for _ in range(LINEARIZATIONS - 1):
        off = np.abs(step.ahead[bent, POSITION] - at[bent, POSITION]) > within
        bent = bent[off.any(axis=1)]
        if not len(bent):
            break
        at[bent], far[bent] = step.ahead[bent], True
        step.put(bent, prior.take(bent).updated(at[bent]))
    if not within or np.count_nonzero(falls):
        _stabilize(step, prior.R)
    states, volume = step.states, step.volume
    white, e = step.seen[..., OF_OBJECT:-1], -step.seen[..., -1]
    nis = np.where(step.visible, _weigh(states, P, white, volume, e, falls), np.nan)
    # the joint update linearizes these again at the changed errors
    far &= ~two_ranges(measured)
    counted = np.where(falls | far, 0.0, COUNTED)[:, None] * _shares(states.probability)
    share = _told(step.G, step.direct[:, None], step.S)
    if view.parks and P.shape[-1] < 2 * OF_CAMERA:
        share[_by_ground_alone(measured), MOVES] = 0.0
    fixed = np.asarray(~kinds.speed.any(axis=1))
    shown = np.where(fixed[:, None], 1.0, share[..., 0, PITCH])
    return Updated(states, nis, *_learned(counted, share * white, e), p, step.off, step.S, shown)


def _by_ground_alone(measured: Measured) -> Bools:
    """Return which objects, (N,), have no other range than that by the ground.

    To one camera that stands, only how evenly these move would tell anything, and they may be
    picked up.
    """
    return np.asarray(measured.used[:, PLANE] & ~two_ranges(measured))


def _alike(each: Floats, of: Indices) -> Floats:
    """Return values, (N, ...), averaged over the cases of each object."""
    count = np.bincount(of)
    total = summed(each, of, len(count))
    return np.asarray((total.T / np.maximum(count, 1)).T[of])


def summed(each: Floats, of: Indices, count: int) -> Floats:
    """Sum values, (N, ...), of each of count things.

    :param of: (N,) which of them each belongs to.
    """
    if count == 1:
        return np.asarray(each.sum(axis=0, keepdims=True))
    total = np.zeros((count, *each.shape[1:]))
    np.add.at(total, of, each)
    return total


def _stabilize(step: Linearized, R: Floats) -> None:
    """Turn the covariance (I - KH) P of the updated states into Joseph form, in place.

    (I - KH) P (I - KH)^T + K R K^T also holds for other gains than Kalman's, and for priors so wide
    that rounding matters.

    :param R: (N, 1, M, M) covariance of the measurements.
    """
    K, H = step.gain, step.W @ step.H[:, None]
    R, cov = step.W @ R @ step.W.swapaxes(-1, -2), step.states.cov
    cov[...] += (K @ R - cov @ H.swapaxes(-1, -2)) @ K.swapaxes(-1, -2)


def _shares(probability: Floats) -> Floats:
    """Return the weight of each hypothesis in the information about the cameras, (N, 2)."""
    surely = probability[:, STANDS, None] ** SURELY
    return np.concatenate([surely, 1 - surely], axis=1)


def _learned(counted: Floats, G: Floats, e: Floats) -> tuple[Floats, Floats]:
    """Return information and vector of Updated, summed over both hypotheses.

    :param counted: (N, 2) weight of each hypothesis.
    :param G: (N, 2, M, 9 C) derivative of the whitened innovations by the camera errors, as far as
        it is observable; e: (N, 2, M) whitened innovations.
    """
    weighed = (counted[:, :, None, None] * G).swapaxes(-1, -2)
    vector = (weighed @ e[..., None])[..., 0].sum(axis=1)
    return (weighed @ G).sum(axis=1), vector


def _told(G: Floats, direct: Floats, S: Floats) -> Floats:
    """Return the observable share of each camera error, (N, 2, 1, 9 C).

    :param G: (N, 2, M, 9 C) derivative of the innovations by the errors; direct: with states fixed.
    """
    count = S.shape[-1]
    over = 1 / S.reshape(*S.shape[:2], 1, count * count)[..., :: count + 1]
    told = over @ np.square(G)
    least = LEAST_PARALLAX**2 * (over @ np.square(direct))
    return np.asarray(np.maximum(0.0, 1 - least / np.maximum(told, TINY)))


def _weigh(
    states: Motions, P: Floats, G: Floats, volume: Floats, e: Floats, falls: Bools
) -> Floats:
    """Weigh the hypotheses by innovations, in place; return the least NIS of each object, (N,).

    :param P: (N, 9 C, 9 C) covariance of the camera errors.
    :param G: (N, 2, M, 9 C) derivative of the innovations by the camera errors, whitened as if
        these were known.
    :param volume: (N, 2) log determinant of the whitening matrix; e: (N, 2, M) innovations.
    :param falls: (N,) objects of which only throws have a least probability; see LATE.
    """
    W, explained = whitening(np.eye(e.shape[-1]) + G @ P[:, None] @ G.swapaxes(-1, -2))
    nis = np.square(W @ e[..., None])[..., 0].sum(axis=-1)
    log = volume + explained - nis / 2
    p = states.probability * np.exp(log - np.maximum(log[:, :1], log[:, 1:]))
    least = LEAST_LIKELY * (states.probability > 0) * ~falls[:, None]
    least[:, STANDS] += LATE * states.probability[:, STANDS] * falls
    p = np.maximum(p / (p[:, :1] + p[:, 1:]), least)
    states.probability = p / (p[:, :1] + p[:, 1:])
    nis = np.where(states.probability > 0, nis, np.inf)
    return np.minimum(nis[:, STANDS], nis[:, MOVES])
