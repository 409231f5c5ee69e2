"""The bank of Kalman filters: of each mode, N states in one array (N, n), and (N, n, n)."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.gaussian import invert
from colortrack_ros.estimation.gaussian import joseph
from colortrack_ros.estimation.gaussian import LOG_2PI
from colortrack_ros.estimation.gaussian import log_density
from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import turned
from colortrack_ros.estimation.motion import MotionModel

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

TINY, LEAST_WEIGHT = 1e-300, 1e-12
"""Next to nothing, and as little as a mode ever weighs: it must be able to come back."""


class Bank:
    """N tracks, with M filters each; the filters' weights are the probabilities of the modes.

    mean: (M, N, n); cov: (M, N, n, n); weight: (M, N). design: (M, N, n, n), covariances of a model
    that sets its gains by other process noise than there is; cov itself where it does not.
    """

    def __init__(self, model: MotionModel) -> None:
        self.model = model
        self.mean = np.zeros((model.modes, 0, model.size))
        self.cov = np.zeros((model.modes, 0, model.size, model.size))
        self.weight = np.zeros((model.modes, 0))
        self.design = self.cov

    def predict(self, dt: float, variance: float) -> None:
        """One step of all filters (Pegoretti 2021, (2.21)-(2.22)).

        F P F^T is linear in the entries of P: with F the same for all, one matrix product.

        :param dt: [s].
        :param variance: sigma_s^2 [px^2/s^4].
        """
        if self.model.modes > 1 and not self.model.selected:
            self._interact(self.model.switching(dt))
        F, Q = self.model.transition(dt), variance * self.model.noise(dt)
        modes, n, _ = F.shape
        FF = F[:, :, None, :, None] * F[:, None, :, None, :]
        FF = FF.reshape(modes, n * n, n * n).swapaxes(1, 2)
        self.mean = self.mean @ F.swapaxes(1, 2) + self.model.drift(dt)
        self.cov = (self.cov.reshape(modes, -1, n * n) @ FF).reshape(self.cov.shape) + Q[:, None]
        if self.model.trust is None:
            self.design = self.cov
        else:
            Q = np.square(self.model.trust)[:, None, None] * Q
            self.design = (self.design.reshape(modes, -1, n * n) @ FF).reshape(self.cov.shape)
            self.design += Q[:, None]

    def _interact(self, switching: Floats) -> None:
        """Mix the modes (Blom and Bar-Shalom 1988; Vidal 2009, 2.3.1.2).

        :param switching: (M, M) probability that mode i has become mode j.
        """
        joint = switching[:, :, None] * self.weight[:, None, :]
        self.weight = joint.sum(axis=0)
        share = joint / np.maximum(self.weight, TINY)
        self.mean, self.cov = mixture(share, self.mean[:, None], self.cov[:, None])

    def estimate(self) -> tuple[Floats, Floats]:
        """Mean (N, n) and covariance (N, n, n) of each track, over its modes."""
        if self.model.modes == 1:
            return self.mean[0], self.cov[0]
        return mixture(self.weight, self.mean, self.cov)

    def compare(
        self, track: Indices, z: Floats, R: Floats, chance: Floats, T: Floats, speed: float
    ) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """How likely measurements are, of tracks that go on or have maneuvered.

        Log of N(z; H x, S), S = H P H^T + R, summed over the modes by their weights, and over going
        on and maneuvering. The determinant counts: what is uncertain pays.

        :param track: (K,) which track.
        :param z: (K, 2) measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :param chance: (K,) probability of a maneuver.
        :param T: (K,) time that there was for it [s], see maneuver().
        :param speed: standard deviation of a new velocity on each axis [px/s].
        :return: the last fields of Pairs: the log, (K,); the probability that it was a maneuver,
            (K,); of the likeliest mode, going on, the squared innovation normalized by S, (K,),
            the share of P in S, (K,), and the innovation over the fourth root of det S, (K, 2).
        """
        mean, cov = self.mean[:, track], self.cov[:, track]
        x, y = z[:, 0] - mean[..., 0], z[:, 1] - mean[..., 1]
        p, q = mean[..., 2] * (T / 2), mean[..., 3] * (T / 2)
        S = cov[..., 0, 0] + R[:, 0, 0], cov[..., 0, 1] + R[:, 0, 1], cov[..., 1, 1] + R[:, 1, 1]
        d2, det, going_on = log_density(x, y, *S)
        s2 = (speed * T) ** 2 / 3
        S = S[0] + p * p / 3 + s2, S[1] + p * q / 3, S[2] + q * q / 3 + s2
        turning = log_density(x + p, y + q, *S)[2]
        going_on += np.log1p(-chance)
        turning += np.log(np.maximum(chance, TINY))
        best: tuple = (0,)
        if self.model.modes > 1:
            weight = np.log(np.maximum(self.weight[:, track], TINY))
            going_on, turning = going_on + weight, turning + weight
            best = going_on.argmax(axis=0), np.arange(len(track))
            going_on, turning = (np.logaddexp.reduce(log, axis=0) for log in (going_on, turning))
        else:
            going_on, turning = going_on[0], turning[0]
        total = np.logaddexp(going_on, turning)
        root = np.sqrt(det[best])
        predicted = 1 - np.sqrt(R[:, 0, 0] * R[:, 1, 1] - R[:, 0, 1] ** 2) / root
        innovation = np.array([x[best], y[best]]) / np.sqrt(root)
        return total, np.exp(turning - total), d2[best], predicted, innovation.T

    def maneuver(self, track: Indices, weight: Floats, T: Floats, speed: float) -> None:
        """Replace predictions by a mixture of going on and of having maneuvered.

        :param track: (K,) which tracks, each once.
        :param weight: (K,) probability of the maneuver.
        :param T: (K,) [s].
        :param speed: standard deviation of the new velocity on each axis [px/s].
        """
        mean, cov = self.mean[:, track], self.cov[:, track]
        new_mean, new_cov = turned(mean, cov, T, speed)
        both = np.array([1 - weight, weight])[:, None]
        self.mean[:, track], self.cov[:, track] = mixture(
            both, np.array([mean, new_mean]), np.array([cov, new_cov])
        )

    def resemblance(
        self, lost: Indices, found: Indices, chance: Floats, T: Floats, speed: float
    ) -> Floats:
        """How likely tracks, with their velocities, are what has become of others.

        :param lost: (K,) tracks unmeasured for a time.
        :param found: (K,) others that have begun since.
        :param chance: (K,) probability that the lost one has maneuvered.
        :param T: (K,) time that there was for it [s].
        :param speed: standard deviation of a new velocity on each axis [px/s].
        :return: (K,) log of the likelihood against that of any velocity, N(0, speed^2) [1/px^2].
        """
        mean, cov = self.estimate()
        one, P = mean[lost, :4], cov[lost, :4, :4]
        other, other_P = mean[found, :4], cov[found, :4, :4]
        log = [np.log1p(-chance), np.log(np.maximum(chance, TINY))]
        for i, (center, spread) in enumerate([(one, P), turned(one, P, T, speed)]):
            S, e = spread + other_P, other - center
            d2 = (e * np.linalg.solve(S, e[..., None])[..., 0]).sum(axis=1)
            log[i] = log[i] - 0.5 * (d2 + np.linalg.slogdet(S)[1]) - 2 * LOG_2PI
        any_S = speed**2 * np.eye(2) + other_P[:, 2:, 2:]
        v = other[:, 2:]
        d2 = (v * np.linalg.solve(any_S, v[..., None])[..., 0]).sum(axis=1)
        any_velocity = -0.5 * (d2 + np.linalg.slogdet(any_S)[1]) - LOG_2PI
        return np.asarray(np.logaddexp(*log) - any_velocity)

    def succeed(self, lost: Indices, found: Indices) -> None:
        """Give tracks the filters of others, which are what has become of them."""
        self.mean[:, lost], self.cov[:, lost] = self.mean[:, found], self.cov[:, found]
        self.design[:, lost], self.weight[:, lost] = self.design[:, found], self.weight[:, found]

    def correct(self, track: Indices, z: Floats, R: Floats, share: Floats | None = None) -> None:
        """Estimation, (2.26)-(2.28), with the covariance in Joseph form (Red object, (7)).

        A track with several measurements, or a doubtful one, becomes the mixture of what each
        would make of it, replaced by mean and covariance (PDA, Bar-Shalom and Tse 1975).

        :param track: (K,) which tracks, ascending; each once if share is None.
        :param z: (K, 2) measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :param share: (K,) probability that it is the track's; what is left is that none is.
        """
        x, cov = self.mean[:, track], self.cov[:, track]
        design = cov if self.model.trust is None else self.design[:, track]
        inverse, det = invert(design[..., :2, :2] + R)
        K = design[..., :2] @ inverse
        e = (z - x[..., :2])[..., None]
        step = (K @ e)[..., 0]
        P = joseph(cov, K, R)
        if self.model.trust is not None:
            self.design[:, track] = joseph(design, K, R)
        if share is None and (self.model.modes == 1 or self.model.selected):
            self.mean[:, track], self.cov[:, track] = x + step, P
        else:
            d2 = (e.swapaxes(-1, -2) @ inverse @ e)[..., 0, 0]
            log = np.log(np.maximum(self.weight[:, track], TINY)) - 0.5 * (d2 + np.log(det))
            weight = np.maximum(np.exp(log - log.max(axis=0)), LEAST_WEIGHT)
            weight /= weight.sum(axis=0)
            share = np.ones(len(track)) if share is None else share
            self._merge(track, step, P, share * weight, share)
        if self.model.selected:
            measured = np.zeros(self.weight.shape[1], bool)
            measured[track] = True
            self.weight = np.stack([measured, ~measured]).astype(float)

    def _merge(
        self, track: Indices, step: Floats, P: Floats, weight: Floats, share: Floats
    ) -> None:
        """Replace each mode's mixture over the measurements by its mean and covariance.

        :param step: (M, K, n) from the prediction to each hypothesis.
        :param P: (M, K, n, n) of the hypotheses.
        :param weight: (M, K) of the hypotheses.
        :param share: (K,) their sum over the modes.
        """
        hit, place = np.unique(track, return_inverse=True)
        missed = np.maximum(1 - np.bincount(place, share), 0.0)
        none = self.weight[:, hit] * missed
        total, shift = none.copy(), np.zeros_like(self.mean[:, hit])
        where = np.arange(len(weight))[:, None], place
        np.add.at(total, where, weight)
        np.add.at(shift, where, weight[..., None] * step)
        total = np.maximum(total, TINY)
        shift /= total[..., None]
        rest = step - shift[:, place]
        spread = none[..., None, None] * (
            self.cov[:, hit] + shift[..., :, None] * shift[..., None, :]
        )
        P = weight[..., None, None] * (P + rest[..., :, None] * rest[..., None, :])
        np.add.at(spread, where, P)
        self.mean[:, hit] += shift
        self.cov[:, hit] = spread / total[..., None, None]
        self.weight[:, hit] = total / total.sum(axis=0)

    def append(self, z: Floats, R: Floats, spread: Floats) -> None:
        """New filters at rest with an honest doubt about it, (2.24)-(2.25).

        With a wide prior the second detection makes the velocity what two-point differencing makes
        it (Bar-Shalom, Li and Kirubarajan 2001, 5.5.3), with its covariance.

        :param z: (K, 2) first measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :param spread: (n,) standard deviations of what is not measured, by element of the state.
        """
        mean = np.zeros((self.model.modes, len(z), self.model.size))
        mean[:, :, :2] = z
        cov = np.zeros((*mean.shape, self.model.size))
        cov[:] = np.diag(spread**2)
        cov[:, :, :2, :2] = R
        weight = np.broadcast_to(self.model.switching(1e3)[0][:, None], mean.shape[:2])
        self._hold(
            np.concatenate([self.mean, mean], axis=1),
            np.concatenate([self.cov, cov], axis=1),
            self.design if self.model.trust is None else np.concatenate([self.design, cov], axis=1),
            np.concatenate([self.weight, weight], axis=1),
        )

    def doubt(self, speed: float) -> None:
        """Change what is known of the velocities of filters at rest: the standard deviation.

        :param speed: on each axis [px/s].
        """
        for cov in (self.cov, self.design):
            cov[:, :, (2, 3), (2, 3)] = speed**2

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Drop the tracks where mask, (N,), is False."""
        design = self.design if self.model.trust is None else self.design[:, mask]
        self._hold(self.mean[:, mask], self.cov[:, mask], design, self.weight[:, mask])

    def _hold(self, mean: Floats, cov: Floats, design: Floats, weight: Floats) -> None:
        self.mean, self.cov, self.weight = mean, cov, weight
        self.design = cov if self.model.trust is None else design
