"""Objects updated as if the errors of the cameras were known, and what that tells of the errors.

The measurement is linearized again where the last step has led (iterated extended Kalman filter:
Bell and Cathey 1993; Bar-Shalom, Li and Kirubarajan 2001, 10.5.2).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.inverse_depth import to_points
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import columns_of
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import STANDS
from colortrack_ros.world.view import View
from colortrack_ros.world.whitening import log_volume
from colortrack_ros.world.whitening import whitening

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]

LINEARIZATIONS = 4
"""Linearizations of an update at most: where the last one has led."""

LINEAR_WITHIN = 0.02
"""Updated of X/Z, Y/Z, 1/Z [1/m] up to which one linearization is enough: 10 px at f = 500 px, 40
times the noise. Also of smaller ones it would put the noise into both factors of what is told of
the cameras' errors, which then would all seem to be on one side."""

LEAST_PARALLAX = 0.02
"""Share of what an error of a camera does to a measurement that the object's state must leave
unexplained, so that it tells of the error. Less is that of the linearization: a first ray that is
off by 0.5 px puts what is 5 m away 1.2 % too far. `python benchmark/world.py` gives for what stands
on the ground before a robot that stands a NEES of 8 in place of 3.2, of 3, if it is 0."""

COUNTED = 0.5
"""Share of the information about the cameras' errors that is counted, because one picture after the
other is linearized at nearly the same place, which is off. At 1 `python benchmark/world.py` gives
what rolls before a robot that stands a NEES of 6.3 in place of 4.7, of 4, by fused."""

SURELY = 64
"""What stands tells much more of the cameras' errors than what rolls, and what rolls slowly fits
cameras that are off and things that stand, in all pictures alike. So it is counted as far as an
object has stood in so many pictures, were each another chance: its probability to this power. At 1
`python benchmark/world.py --elsewhere --seed 21 --runs 30` gives what rolls at 60 Hz a NEES of 5.8
in place of 3.7, of 4; at 16 4.1, at 256 3.6, but then what rests is off by 2.0, not 1.6 %."""

LEAST_LIKELY = 1e-3
"""Probability that each hypothesis keeps, however badly it fits: a ball that is kicked fits none.
Assumed."""

FARTHER = 4.0
"""How many times farther away a step of an update may take an object: the linearization does not
reach beyond, where 1/Z comes near 0."""


@dataclass
class Updated:
    """An update of N objects, by two hypotheses each; positions in inverse depth.

    :ivar states: after it, if the errors of the cameras stay as estimated.
    :ivar nis: (N,) normalized innovation squared, of the hypothesis that it fits best.
    :ivar information: (N, 8 C, 8 C) of what is measured about the errors of the cameras.
    :ivar vector: (N, 8 C) information times the correction that it asks for.
    :ivar p: (N, 2) of the hypotheses before it.
    :ivar volume: (N, 2) log of the least likely; e: (N, 2, M) their whitened innovations.
    """

    states: Motions
    nis: Floats
    information: Floats
    vector: Floats
    p: Floats
    volume: Floats
    e: Floats

    def likelihoods(self) -> tuple[Floats, Floats]:
        """Logs of how likely what is measured is, and would be as expected, (N,).

        If the errors of the cameras are as estimated.
        """
        nis = np.square(self.e).sum(axis=-1)
        logs = np.stack([self.volume - nis / 2, self.volume])
        most = logs.max(axis=-1)
        density = (self.p * np.exp(logs - most[..., None])).sum(axis=-1)
        log, log_volume = most + np.log(np.maximum(density, TINY))
        return log, log_volume


@dataclass
class _Line:
    """M measurements of N objects, linearized.

    :ivar H: (N, M, 8) by the state.
    :ivar rest: (N, M, 8 C + 1) by the errors of the cameras, and what is expected there, less what
        is measured.
    :ivar seen: (N,) whether the camera would see the object there at all.
    """

    H: Floats
    rest: Floats
    seen: Bools


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
    """Update states in inverse depth as if the errors of the cameras were as estimated."""
    rows = np.flatnonzero(measured.used.any(axis=0))
    P, R = errors.cov[robot], measured.R[:, None, rows][..., rows]
    p, whole, known, falls = part.probability, part.whole, errors.mean[robot], kinds.falls
    at: Floats = (p[:, None] @ part.mean)[:, 0]
    far = np.zeros(len(part), bool)
    for _ in range(LINEARIZATIONS):
        line = _linearized(at, known, measured, rows, view, kinds, ground, camera)
        G, S, W, seen = _innovations(line, at, part, R)
        K = PH = seen[..., :OF_OBJECT].swapaxes(-1, -2)
        if falls.any():
            K = _considered(PH, part.slope, seen[..., OF_OBJECT:-1], P * falls[:, None, None])
        states = Motions(whole - K @ seen, p)
        states.mean[..., 2] = np.maximum(states.mean[..., 2], part.mean[..., 2] / FARTHER)
        ahead = (p[:, None] @ states.mean)[:, 0]
        bent = np.asarray((np.abs(ahead - at)[:, POSITION] > within).any(axis=1))
        if not bent.any():
            break
        at, far = np.where(bent[:, None], ahead, at), far | bent
    if K is not PH or not within:
        _stabilize(states, K, W @ line.H[:, None], W @ R @ W.swapaxes(-1, -2))
    white, e, volume = seen[..., OF_OBJECT:-1], -seen[..., -1], log_volume(W)
    nis = np.where(line.seen, _weigh(states, P, white, volume, e, falls), np.nan)
    counted = np.where(falls | far, 0.0, COUNTED)[:, None] * _shares(states.probability)
    share = _told(G, line.rest[:, None, :, :-1], S)
    return Updated(states, nis, *_learned(counted, share * white, e), p, volume, e)


def _innovations(
    line: _Line, at: Floats, part: Motions, R: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """The innovations of states, by both hypotheses.

    :param at: (N, 8) where measurements are linearized; R: (N, 1, M, M) their covariance.
    :return: how they change with the errors of the cameras, (N, 2, M, 8 C), their covariance,
        (N, 2, M, M), what whitens them, alike, and whitened, (N, 2, M, 8 + 8 C + 1), their
        covariance with the states, their change, and they themselves, less than 0 for more.
    """
    H, beside = line.H[:, None], part.whole.copy()
    beside[..., -1] -= at[:, None]
    seen = H @ beside
    seen[..., OF_OBJECT:] += line.rest[:, None]
    S = H @ seen[..., :OF_OBJECT].swapaxes(-1, -2) + R
    W = whitening(S)
    return seen[..., OF_OBJECT:-1], S, W, W @ seen


def _stabilize(states: Motions, K: Floats, H: Floats, R: Floats) -> None:
    """Make (I - KH) P, which states have, (I - KH) P (I - KH)^T + K R K^T (Joseph), in place.

    It holds for other gains than Kalman's as well, and where the prior is so wide that rounding
    counts.
    """
    states.cov[...] += (K @ R - states.cov @ H.swapaxes(-1, -2)) @ K.swapaxes(-1, -2)


def _shares(probability: Floats) -> Floats:
    """How much of what each hypothesis tells of the cameras counts, (N, 2)."""
    surely = probability[:, STANDS] ** SURELY
    return np.stack([surely, 1 - surely], axis=1)


def _learned(counted: Floats, G: Floats, e: Floats) -> tuple[Floats, Floats]:
    """Information and vector of Updated, over both hypotheses.

    :param counted: (N, 2) share of what each tells.
    :param G: (N, 2, M, 8 C) what of whitened innovations, e: (N, 2, M), tells of the errors.
    """
    weighed = (counted[:, :, None, None] * G).swapaxes(-1, -2)
    vector = (weighed @ e[..., None])[..., 0].sum(axis=1)
    return (weighed @ G).sum(axis=1), vector


def _considered(PH: Floats, slope: Floats, G: Floats, P: Floats) -> Floats:
    """Kalman's gain, (N, 2, 8, M), with the errors of the cameras considered (Schmidt), not known.

    For what falls, as its bounces bend too much for the other: it would be certain of what holds
    only if the errors were as estimated.

    :param PH: (N, 2, 8, M) Kalman's gain if they are known, of whitened innovations.
    :param P: (N, 8 C, 8 C) covariance of the errors of the cameras, 0 of what does not fall.
    """
    PG = P[:, None] @ G.swapaxes(-1, -2)
    S = np.eye(G.shape[-2]) + G @ PG
    return np.linalg.solve(S, (PH + slope @ PG).swapaxes(-1, -2)).swapaxes(-1, -2)


def _told(G: Floats, direct: Floats, S: Floats) -> Floats:
    """The share of each error of the cameras that innovations tell of, (N, 2, 1, 8 C).

    :param G: (N, 2, M, 8 C) how innovations change with them; direct: if states did not.
    """
    over = 1 / np.einsum('...ii->...i', S)[..., None, :]
    told = over @ np.square(G)
    least = LEAST_PARALLAX**2 * (over @ np.square(direct))
    return np.asarray(np.maximum(0.0, 1 - least / np.maximum(told, TINY)))


def _weigh(
    states: Motions, P: Floats, G: Floats, volume: Floats, e: Floats, falls: Bools
) -> Floats:
    """Weigh hypotheses by their innovations, in place; the least normalized and squared, (N,).

    :param P: (N, 8 C, 8 C) covariance of the errors of the cameras.
    :param G: (N, 2, M, 8 C) how innovations change with them, whitened as if they were known.
    :param volume: (N, 2) log of what whitens them; e: (N, 2, M) the innovations.
    :param falls: (N,) what keeps no hypothesis that fits badly: it may be thrown again.
    """
    W = whitening(np.eye(e.shape[-1]) + G @ P[:, None] @ G.swapaxes(-1, -2))
    nis = np.square(W @ e[..., None])[..., 0].sum(axis=-1)
    log = volume + log_volume(W) - nis / 2
    p = states.probability * np.exp(log - log.max(axis=1, keepdims=True))
    least = LEAST_LIKELY * (states.probability > 0) * ~falls[:, None]
    p = np.maximum(p / p.sum(axis=1, keepdims=True), least)
    states.probability = p / p.sum(axis=1, keepdims=True)
    return np.asarray(np.where(states.probability > 0, nis, np.inf).min(axis=1))


def _linearized(
    at: Floats,
    known: Floats,
    measured: Measured,
    rows: Indices,
    view: View,
    kinds: Kinds,
    ground: float,
    camera: int,
) -> _Line:
    """What is measured beside what is expected of states in inverse depth.

    :param at: (N, 8); known: (N, 8 C) errors of the cameras, as estimated.
    :param rows: (M,) of what can be measured those that are.
    """
    of = columns_of(camera)[OF_OBJECT:] - OF_OBJECT
    state = np.concatenate([at, known[:, of]], axis=1)
    state[:, POSITION], J = to_points(view.optical, at[:, POSITION])
    z, H = expected(view, state, kinds.diameter, ground + kinds.height, BLOB in rows)
    H[:, :, POSITION] = H[:, :, POSITION] @ J
    off, H, unused = z[:, rows] - measured.z[:, rows], H[:, rows], ~measured.used[:, rows]
    seen = np.asarray(np.isfinite(off).all(axis=1) & np.isfinite(H).all(axis=(1, 2)))
    unused |= ~seen[:, None]
    off[unused], H[unused] = 0.0, 0.0
    rest = np.zeros((*off.shape, known.shape[1] + 1))
    rest[:, :, of], rest[:, :, -1] = H[:, :, OF_OBJECT:], off
    return _Line(H[:, :, :OF_OBJECT], rest, seen)
