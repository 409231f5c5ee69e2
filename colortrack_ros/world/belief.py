"""What is believed of all objects and cameras: a sum of Gaussians over the pitch of the camera.

How far away what is on the ground seems to be bends with the pitch: by r/h times its error, 17 % at
4 m for one degree and a camera 0.4 m above. What pictures tell of the pitch is linearized where the
objects are believed to be, and all pictures that do so at the same wrong place err alike: counted
as independent, they make the pitch too certain. So it is divided into narrower cases, each with the
states of all objects, weighed by how well they foretell what is measured (the Gaussian sum filter:
Alspach and Sorenson 1972; over ranges of bearings-only targets: Peach 1995). When the pitch is
known as well as within one of them, they become one.
"""

from copy import copy
from typing import Any
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.data import Selection
from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.filter import forget
from colortrack_ros.world.filter import in_front
from colortrack_ros.world.filter import misfit
from colortrack_ros.world.filter import started
from colortrack_ros.world.filter import update
from colortrack_ros.world.inverse_depth import in_inversion
from colortrack_ros.world.inverse_depth import inverted
from colortrack_ros.world.inverse_depth import out_of_inversion
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.motion import drift
from colortrack_ros.world.motion import kicked
from colortrack_ros.world.motion import predict
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import TILT
from colortrack_ros.world.view import View

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Table = TypeVar('Table', bound=Columns)

PITCH = TILT.start - OF_OBJECT + 1
"""Of the errors of the first camera."""

CASE_WIDTH = 0.6
"""Standard deviation of a case's pitch, as a share of that of the whole. Cases are 2.3 of it apart,
as far as their sum has one maximum."""

CASE_PITCHES, CASE_WEIGHTS = np.array([-(3**0.5), 0.0, 3**0.5]), np.array([1 / 6, 2 / 3, 1 / 6])
"""Where the cases are, and their weights: Gauss-Hermite, exact for the moments up to the fifth."""

LEAST_CASE = 1e-9
"""Of a case, so that all may come back."""


class Belief(Columns):
    """Of N objects, those of one robot after those of another, and the cameras of R robots.

    :ivar motion: (C N,) their states in each of C cases, one case after the other.
    :ivar errors: (C R) how the cameras are off, in the same order.
    :ivar log_weight: (C, R) of the cases.
    """

    def __init__(self, motion: Motions, errors: CameraErrors, log_weight: Floats) -> None:
        self.motion, self.errors, self.log_weight = motion, errors, log_weight
        self._whole, self._united = errors.first, np.zeros(log_weight.shape[1], bool)
        self._eye = np.zeros(3)

    @classmethod
    def of(cls, config: LocatorConfig, cameras: int = 1, robots: int = 1) -> 'Belief':
        """Of no object yet."""
        errors = CameraErrors.of(config, cameras, robots)
        belief = cls(Motions.none(cameras), errors, np.zeros((1, robots)))
        # where sizes tell the range as well, one linearization is enough
        bound = Kinds.of(config).bound.any() and config.method == 'ground'
        if bound and cameras == 1:
            belief._divide()
        return belief

    def __len__(self) -> int:
        return len(self.motion) // len(self.log_weight)

    def take(self, rows: Selection) -> 'Belief':
        """See Columns.take(); of the same cameras."""
        taken = copy(self)
        taken.motion = self.motion.take(self._all(rows))
        return taken

    def keep(self, rows: Selection) -> None:
        """See Columns.keep()."""
        self.motion.keep(self._all(rows))

    def extend(self, other: 'Belief') -> None:
        """See Columns.extend(); of the same cameras."""
        cases, own, more = len(self.log_weight), len(self), len(other)
        self.motion.extend(other.motion)
        old, new = (np.arange(cases * n).reshape(cases, n) for n in (own, more))
        self.motion.keep(np.concatenate([old, new + cases * own], axis=1).ravel())

    def combined(self) -> tuple[Floats, Floats]:
        """Estimate, (N, 8), and its mean squared error, (N, 8, 8), with all that is not known.

        Over the cases the mean is taken of one over the distance from the camera, in which the
        pitch is linear: with a pitch as given, things are where their rays meet the ground.
        """
        each, cov = self.motion.combined(self.errors)
        mean, cov = self.mixed(each, cov)
        if len(self.log_weight) == 1:
            return mean, cov
        near = _parted(inverted(each[:, POSITION] - self._eye)[0], len(self.log_weight))
        near = (self._of_objects()[..., None] * near).sum(axis=0)
        there = self._eye + inverted(near)[0]
        off = mean[:, POSITION] - there
        cov[:, POSITION, POSITION] += off[:, :, None] * off[:, None, :]
        mean[:, POSITION] = there
        return mean, cov

    def combined_errors(self) -> tuple[Floats, Floats]:
        """How the cameras of each robot are off, (R, 8 C), and its covariance, over the cases."""
        mean, cov = (_parted(a, len(self.log_weight)) for a in (self.errors.mean, self.errors.cov))
        return mixture(np.exp(self.log_weight), mean, cov)

    def mixed(self, mean: Floats, cov: Floats) -> tuple[Floats, Floats]:
        """What is (C N, n) and (C N, n, n) in the cases, over all of them: (N, n), (N, n, n)."""
        if len(self.log_weight) == 1:
            return mean, cov
        cases = len(self.log_weight)
        return mixture(self._of_objects(), _parted(mean, cases), _parted(cov, cases))

    def started(
        self,
        position: Floats,
        reach: Floats,
        measured: Measured,
        view: View,
        kinds: Kinds,
        ground: float,
        camera: int = 0,
    ) -> 'Belief':
        """Of objects that are seen for the first time; see filter.started()."""
        cases = self._cases(len(position))
        motion = started(
            position[cases], reach[cases], self._in_cases(measured), view, self._in_cases(kinds),
            self.errors, ground, camera,
        )  # fmt: skip
        belief = copy(self)
        belief.motion, belief._eye = motion, view.optical.t
        return belief

    def forget(self, dt: float) -> None:
        """Let the errors of the cameras be less certain after dt [s]."""
        forget(self.errors, dt)

    def predict(self, kinds: Kinds, ground: float, dt: float, unseen: Bools) -> None:
        """Let dt [s] go by; see motion.predict()."""
        unseen = unseen[self._cases(len(self))]
        predict(self.motion, self.errors, self._in_cases(kinds), ground, dt, unseen)

    def drift(self, robot: Floats, moved: float, turned: float, sigma: Floats) -> None:
        """Add what odometry adds; see motion.drift()."""
        drift(self.motion, robot, moved, turned, sigma)

    def misfit(
        self, measured: Measured, view: View, kinds: Kinds, ground: float, camera: int = 0
    ) -> Floats:
        """How far measurements, (N,), are from what is expected; see filter.misfit()."""
        off = misfit(
            self.motion, self.errors, self._in_cases(measured), view, self._in_cases(kinds),
            ground, camera,
        )  # fmt: skip
        return np.asarray(_parted(off, len(self.log_weight)).min(axis=0))

    def update(
        self, measured: Measured, view: View, kinds: Kinds, ground: float, camera: int = 0
    ) -> Bools:
        """Update all by measurements, (N,).

        :return: (N,) which measurements have been refused, by most of the weight.
        """
        self._eye = view.optical.t
        refused, likely = update(
            self.motion, self.errors, self._in_cases(measured), view, self._in_cases(kinds),
            ground, camera, weigh=len(self.log_weight) > 1,
        )  # fmt: skip
        if len(self.log_weight) == 1:
            return refused
        log = self.log_weight + likely.reshape(self.log_weight.shape)
        log -= log.max(axis=0)
        log = np.maximum(log - np.log(np.exp(log).sum(axis=0)), np.log(LEAST_CASE))
        self.log_weight = log - np.log(np.exp(log).sum(axis=0))
        most = (self._of_objects() * _parted(refused, len(log))).sum(axis=0) > 1 / 2
        self._unite()
        return np.asarray(most)

    def in_front(self, view: View) -> Bools:
        """Which objects, (N,), are in front of the camera, by all cases."""
        return np.asarray(_parted(in_front(self.motion, view), len(self.log_weight)).all(axis=0))

    def kick(
        self,
        rows: NDArray[np.intp],
        since: Floats,
        measured: Measured,
        view: View,
        kinds: Kinds,
        ground: float,
        camera: int,
    ) -> Bools:
        """Let those of some objects, (K,), that fit a kick have been kicked.

        :param since: (K,) time in which they may have been [s].
        :param measured, kinds: of each, (K,).
        :return: (K,) which do.
        """
        part, cases = self.take(rows), self._cases(len(rows))
        part.motion = kicked(part.motion, kinds.speed[cases], since[cases])
        fits = part.misfit(measured, view, kinds, ground, camera) <= 1
        fits &= part.in_front(view)
        self.motion.put(self._all(rows[fits]), part.take(fits).motion)
        return np.asarray(fits)

    def _all(self, rows: Selection) -> NDArray[np.intp]:
        """The rows of objects in all cases."""
        (chosen,) = rows.nonzero() if rows.dtype == bool else (rows,)
        starts = len(self) * np.arange(len(self.log_weight))
        return np.asarray((starts[:, None] + chosen).ravel())

    def _in_cases(self, table: Table) -> Table:
        """What is of each object, once for each case."""
        return table if len(self.log_weight) == 1 else table.take(self._cases(len(table)))

    def _cases(self, count: int) -> NDArray[np.intp]:
        """The rows of so many objects, once for each case."""
        return np.tile(np.arange(count), len(self.log_weight))

    def _of_objects(self) -> Floats:
        """The weights of the cases, (C, N), by the robot of each object."""
        robots = self.log_weight.shape[1]
        return np.asarray(np.repeat(np.exp(self.log_weight), len(self) // robots, axis=1))

    def _divide(self) -> None:
        """Make cases of the pitch, of which nothing has been seen yet."""
        robots, count = self.log_weight.shape[1], len(CASE_PITCHES)
        first = self._whole.copy()
        sigma = np.sqrt(first[PITCH, PITCH])
        first[PITCH, PITCH] *= CASE_WIDTH**2
        errors = CameraErrors(
            np.zeros((count * robots, len(first))), np.tile(first, (count * robots, 1, 1)), first
        )
        errors.mean[:, PITCH] = np.repeat(np.sqrt(1 - CASE_WIDTH**2) * sigma * CASE_PITCHES, robots)
        self.errors = errors
        self.log_weight = np.repeat(np.log(CASE_WEIGHTS)[:, None], robots, axis=1)

    def _unite(self) -> None:
        """Make one of the cases of robots whose pitch is known as well as within one at first."""
        cases, errors = len(self.log_weight), self.errors
        means = errors.mean.reshape(cases, -1, errors.mean.shape[1])
        mean, cov = self.combined_errors()
        narrow = cov[:, PITCH, PITCH] <= CASE_WIDTH**2 * self._whole[PITCH, PITCH]
        narrow &= ~self._united
        if not narrow.any():
            return
        self._united |= narrow
        change = (mean - means).reshape(errors.mean.shape)
        one = self._united_motion(np.repeat(change, len(self) // len(mean), axis=0))
        (of,) = np.repeat(narrow, len(self) // len(mean)).nonzero()
        for case in range(cases):
            self.motion.put(case * len(self) + of, one.take(of))
            errors.mean[case * len(mean) :][: len(mean)][narrow] = mean[narrow]
            errors.cov[case * len(mean) :][: len(mean)][narrow] = cov[narrow]
        if self._united.all():
            self.motion = one
            self.errors = CameraErrors(mean, cov, self._whole)
            self.log_weight = np.zeros((1, len(mean)))

    def _united_motion(self, change: Floats) -> Motions:
        """The states over all cases, (N,), once the cameras' errors have changed, (C N, 8)."""
        cases = len(self.log_weight)
        motion = in_inversion(self.motion, self._eye).shifted(change)
        weight = self._of_objects()[..., None]
        share = weight * _parted(motion.probability, cases)
        p = share.sum(axis=0)
        # of what has just begun to fall one hypothesis has none
        share = np.where(p > 0, share / np.maximum(p, TINY), weight)
        mean, cov = mixture(share, _parted(motion.mean, cases), _parted(motion.cov, cases))
        slope = (share[..., None, None] * _parted(motion.slope, cases)).sum(axis=0)
        return out_of_inversion(Motions.of(mean, slope, cov, p), self._eye)


def _parted(a: NDArray[Any], cases: int) -> NDArray[Any]:
    """By case, and by row within it."""
    return a.reshape(cases, len(a) // cases, *a.shape[1:])
