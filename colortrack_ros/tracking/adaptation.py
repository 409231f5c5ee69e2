"""What is learned of the scene: speed, process noise, maneuvers, clutter and new objects."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Constants marked "assumed" were set by hand; benchmark/ablation.py --constants adaptation.NAME
# shows what IDF1 becomes with half and twice the value.

FIRST_NOISE, FIRST_SPEED = 1000.0, 700.0
"""Process noise [px/s^2] and speed [px/s] before any are learned. Assumed."""

SPEED_FROM = 20
"""Objects whose displacements between their first two frames tell their speed: 20 give the 80 %
quantile of a Rayleigh distribution within 14 % (the asymptotic standard error)."""

QUANTILE = 0.8
"""Of those displacements. The largest fifth may lead to the nearest detection of another object."""

LEAST_SPEED = 100.0
"""An object at rest may start to move this fast at any time [px/s]. Assumed."""

FIRST_RATES = (0.5, 2.0)
"""Maneuvers of an object in sight and out of sight before any are learned [1/s]. Assumed; unseen,
objects are handled or bounce more often."""

FIRST_FALSE, LEAST_NEW = 0.003, 0.003
"""False detections a frame to start from, and new objects a frame, at least. Assumed: one in 11 s
at 30 frames/s."""

FIRST_ALIKE = 0.1
"""Share of the blobs of no track that have the size of one, to start from. Assumed."""

FIRST_AREA = 3e5
"""Least area of the picture while its size is not known [px^2]: about 640 x 480."""

BORDER, ENTERING = 0.05, 0.9
"""Width of the border, a share of the picture, and share of the new objects that begin there.
Assumed."""

NOISE_RANGE = (1.0, 1e5)
RATE_RANGE = (0.01, 20.0)
"""Where the process noise [px/s^2] and the rate of maneuvers [1/s] stay: bounds so wide that they
only keep the learning finite; one maneuver in 100 s to one in nearly every frame."""

GAIN = 0.2
"""Largest share of a frame in what is learned: a memory of five frames. Assumed."""

SLOW = 0.03
"""Share of a frame in the rate of false detections: a memory of 33 frames. Assumed."""

HALF_GAIN_TRACKS = 4.0
"""Number of tracks whose frame has half the share: fewer say less about the scene. Assumed."""

LONG_FRAME = 1.5
"""Tracks unmeasured for longer than this many frames were out of sight; halfway from one to two."""


class Adaptation:
    """Learns from the tracks that have been measured."""

    def __init__(self) -> None:
        self._log_noise = math.log(FIRST_NOISE)
        self._speed2 = FIRST_SPEED**2
        self.alike = FIRST_ALIKE
        """Share of the blobs of no track that have the size of one."""
        self.has_met = False
        """Whether there have been objects."""
        self._nis, self._product, self._predicted = 2.0, 0.0, 0.5
        self.rates = list(FIRST_RATES)
        """How often objects in sight and out of sight maneuver [1/s]."""
        self._false, self._frames, self._births = FIRST_FALSE, 3, LEAST_NEW
        self._low, self._high = np.full(2, np.inf), np.full(2, -np.inf)
        self._area = FIRST_AREA
        self.image_size = (0, 0)
        """Width and height of the picture [px]; 0 while they are not known."""

    @property
    def noise(self) -> float:
        """sigma_s, standard deviation of the acceleration on each axis [px/s^2]."""
        return math.exp(self._log_noise)

    @property
    def speed(self) -> float:
        """Root mean square of the velocity on each axis, but no less than LEAST_SPEED [px/s]."""
        return max(math.sqrt(self._speed2), LEAST_SPEED)

    @property
    def density(self) -> float:
        """Detections a frame that belong to no track yet, false or new [1/px^2]."""
        return (self._false + self._births) / self._area

    def birth_density(self, z: Floats) -> Floats:
        """New objects a frame at z, (K, 2), (K,) [1/px^2]; most come in at the picture's border."""
        if not all(self.image_size):
            return np.full(len(z), self._births / self._area)
        from_border = np.minimum(z, np.array(self.image_size) - z) / self.image_size
        entering = from_border.min(axis=1) < BORDER
        inner = (1 - 2 * BORDER) ** 2
        share = np.where(entering, ENTERING / (1 - inner), (1 - ENTERING) / inner)
        return np.asarray(self._births * share / self._area)

    def chance(self, T: Floats, dt: float) -> Floats:
        """Probability of a maneuver within T, (N,), of tracks last measured T ago [s]."""
        seen, hidden = self.rates
        return -np.expm1(-np.where(LONG_FRAME * dt < T, hidden, seen) * T)

    def learn_size(self, z: Floats, image_size: tuple[int, int]) -> None:
        """Take the detections of a frame, (M, 2) [px]: the box around all so far is the picture.

        :param image_size: of the picture, if it is known; once known it holds on.
        """
        if all(image_size):
            self.image_size = image_size
        if all(self.image_size):
            self._area = float(self.image_size[0] * self.image_size[1])
        elif len(z):
            self._low = np.minimum(self._low, z.min(axis=0))
            self._high = np.maximum(self._high, z.max(axis=0))
            self._area = max(float(np.prod(self._high - self._low)), FIRST_AREA)

    def meet(self, before: Floats, after: Floats, dt: float) -> None:
        """Learn the speed from the first objects, (N, 2), and the next detections, (M, 2) [px].

        For most objects the nearest detection is their own, unless they are so dense and fast that
        they change places. The displacement has a Rayleigh distribution.

        :param dt: between the two [s].
        """
        self.has_met = True
        if min(len(before), len(after)) >= SPEED_FROM:
            way = float(np.quantile(cKDTree(after).query(before)[0], QUANTILE))
            sigma = way / math.sqrt(-2 * math.log(1 - QUANTILE))
            self._speed2 = min(self._speed2, (sigma / dt) ** 2)

    def learn_alike(self, alike: int, count: int) -> None:
        """Take how many of the new blobs of a frame have the size of a track."""
        self.alike += -math.expm1(-SLOW * count) * (alike / count - self.alike)

    def learn_new(self, false: int, true: int) -> None:
        """Take the numbers of tracks that in a frame ended unconfirmed, and were confirmed."""
        self._frames += 1
        self._false += max(SLOW, 1 / self._frames) * (false - self._false)
        self._births += SLOW * (max(true, LEAST_NEW) - self._births)

    def learn_rates(self, known: Bools, maneuvered: Floats, T: Floats, dt: float) -> None:
        """Take the tracks measured in a frame: expectation-maximization of how often they maneuver.

        :param known: (K,) which of them to learn from.
        :param maneuvered: (K,) probability of a maneuver since the track was last measured.
        :param T: (K,) when that was [s].
        :param dt: since the last frame [s].
        """
        part = np.where(known, LONG_FRAME * dt < T, 2)
        counts, times, turns = (np.bincount(part, x, 3).tolist()[:2] for x in (None, T, maneuvered))
        for i, (count, time, turn) in enumerate(zip(counts, times, turns, strict=True)):
            if time > 0:
                share = GAIN * count / (count + HALF_GAIN_TRACKS)
                rate = self.rates[i] + share * (turn / time - self.rates[i])
                self.rates[i] = min(max(rate, RATE_RANGE[0]), RATE_RANGE[1])

    def learn_motion(
        self,
        steady: Bools,
        nis: Floats,
        product: Floats,
        predicted: Floats,
        maneuvered: Floats,
        velocity: Floats,
    ) -> None:
        """Take the tracks measured in a frame.

        With the right process noise innovations are white and NIS is 2 on average (Mehra 1970).
        Successive innovations alike say that the filter lags, the noise is too small; opposite
        ones that it is too large. NIS above 2 says too small as well; below 2 it says too large
        as far as it is the prediction that is uncertain. The measurement noise may be smaller than
        given.

        :param steady: (K,) which of them to learn from: measured in this frame and in the last.
        :param nis: (K,) innovations squared, normalized by their covariance.
        :param product: (K,) the same product of each innovation with the one before.
        :param predicted: (K,) share of the prediction in that covariance.
        :param maneuvered: (K,) probability that the track has maneuvered.
        :param velocity: (K, 2) [px/s].
        """
        count = int(np.count_nonzero(steady))
        if not count:
            return
        share = GAIN * count / (count + HALF_GAIN_TRACKS)
        mean = steady / count
        calm = mean * (1 - maneuvered) / np.maximum(nis / 10, 1)
        self._nis += share * (float(calm @ nis) - self._nis)
        self._product += share * (float(calm @ product) - self._product)
        self._predicted += share * (float(mean @ predicted) - self._predicted)
        excess, fit = self._nis / 2 - 1, self._predicted
        drive = (1 - fit) * self._product / 2 + (excess if excess > 0 else fit * excess)
        low, high = map(math.log, NOISE_RANGE)
        self._log_noise = min(max(self._log_noise + share * drive, low), high)
        speed2 = float((mean @ velocity**2).mean())
        self._speed2 += share * (speed2 - self._speed2) / 2
