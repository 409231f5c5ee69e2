"""Whether the stamps of pictures and those of odometry are apart by a constant that nobody told.

A driver that stamps pictures as they arrive is late by 20 to 100 ms, while odometry is not. Where a
robot turns by 60 degrees/s, 50 ms are 3 degrees. To expect that of all robots would make the errors
of right ones larger: what stands takes longer to tell from what rolls. So two hypotheses are
compared: stamps are as far apart as configured, or farther. In both, the time is Gaussian, so what
pictures tell of it follows from its estimate and its variance.
"""

from collections.abc import Callable
import math

from colortrack_ros.world.belief import Belief
from colortrack_ros.world.state import OF_CAMERA
from colortrack_ros.world.state import time_of
from colortrack_ros.world.view import View

FARTHER_APART = 0.05
"""Standard deviation of how far stamps are apart if they are not as configured [s]."""

LIKELIER = math.log(100)
"""Log ratio of the likelihoods from which on they are not. Of right ones, at most one in a hundred
reaches it (Markov's inequality); of 100 runs of robots of others that are set up right, 0.4 is the
most. Chosen."""

RESTARTS = (
    'pictures fit odometry, or TF, or those of other cameras, better if their stamps are apart by '
    'a constant: objects restart, and how much it is will be estimated'
)

SURELY_APART = 4.0
"""Standard deviations of its estimate from which on the time is told. Chosen."""


class Timing:
    """Watch over the estimated times of the pictures of all cameras.

    :param tell: receives what is noticed, one line at a time.
    :ivar sigma: standard deviation of the time that is expected now [s].
    """

    def __init__(self, sigma: float, cameras: int, tell: Callable[[str], object]) -> None:
        self.sigma, self._tell = sigma, tell
        self._apart, self._told = sigma >= FARTHER_APART, [False] * cameras
        self._moves = [False] * cameras

    def changes(self, belief: Belief, view: View, camera: int) -> bool:
        """Return whether objects have to start anew, as stamps are farther apart than expected.

        :param belief: before a picture; view: at it.
        """
        before, self._moves[camera] = self._moves[camera], view.way is not None
        if view.way is None:
            return False
        errors, slope = belief.errors, belief.motion.slope
        time = time_of(camera, slope.shape[-1])
        if not before:
            # what is there was seen before it was known how the robot moves: as it does now
            own = OF_CAMERA * camera
            slope[..., time] = slope[..., own : own + len(view.moves)] @ view.moves
        means, covs = errors.mean, errors.cov
        if len(means) > 1:
            means, covs = belief.combined_errors()
        mean, variance = float(means[0, time]), float(covs[0, time, time])
        if self._apart:
            self._amount(camera, mean, variance)
            return False
        self._apart = self._farther(mean, variance)
        if self._apart:
            self.sigma = FARTHER_APART
            self._tell(RESTARTS)
        return self._apart

    def _farther(self, mean: float, variance: float) -> bool:
        """Return whether stamps are likelier to be farther apart than as expected.

        :param mean: of the time [s], and its variance, if it is as expected.
        """
        learned = self.sigma**2 - variance
        # what is seen has a square of mean^2 / learned, and the logarithm is half of it at most;
        # of a robot that hardly moves nothing is learned, and rounding alone moves the mean
        if learned <= 0 or mean * mean <= 2 * LIKELIER * learned:
            return False
        narrow = self.sigma**4 / learned
        share = narrow / (narrow - self.sigma**2 + FARTHER_APART**2)
        return math.log(share) + mean * mean / learned * (1 - share) > 2 * LIKELIER

    def _amount(self, camera: int, mean: float, variance: float) -> None:
        """Tell the time once, when it is surely known."""
        if self._told[camera] or mean**2 < SURELY_APART**2 * variance:
            return
        self._told[camera] = True
        self._tell(
            f'stamps of pictures are {abs(mean):.2f} s {"early" if mean > 0 else "late"} against '
            'those of odometry or TF: estimated from what is seen, and taken into account; better '
            'let the driver of the camera stamp them when they are taken'
        )
