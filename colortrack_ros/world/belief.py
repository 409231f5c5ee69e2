"""Belief: the states of all objects and cameras, as a Gaussian sum over the pitch of the camera.

The range of an object on the ground is nonlinear in the pitch: its relative error is r/h times the
pitch error, 17 % at 4 m for one degree and a camera 0.4 m above. Pictures linearized at the same
wrong object positions share one error. Treated as independent, they make the pitch overconfident.
If the camera is little above the objects, so is its height: 1 cm of 0.1 m is 10 % of the range.
Both are therefore split into narrower cases, each with the states of all objects, weighted by the
likelihood of the measurements (Gaussian sum filter: Alspach and Sorenson 1972; over ranges for
bearings-only targets: Peach 1995). Once the pitch is as certain as within one case, they are
merged.
"""

from copy import copy
from typing import Any
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.columns import Selection
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.cases import CASE_PITCHES
from colortrack_ros.world.cases import CASE_WIDTH
from colortrack_ros.world.cases import divided
from colortrack_ros.world.cases import is_low
from colortrack_ros.world.cases import LIFT
from colortrack_ros.world.cases import PITCH
from colortrack_ros.world.cases import weighed
from colortrack_ros.world.conditional import COUNTED
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.filter import doubt
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
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.view import View

Table = TypeVar('Table', bound=Columns)


class Belief(Columns):
    """States of N objects, grouped by robot, and the errors of the cameras of R robots.

    :ivar motion: (C N,) states of the objects in each of C cases, grouped by case.
    :ivar errors: (C R) errors of the cameras, in the same order.
    :ivar log_weight: (C, R) log weights of the cases.
    :ivar eye: (3,) position of the camera in the last picture [m].
    """

    def __init__(self, motion: Motions, errors: CameraErrors, log_weight: Floats) -> None:
        self.motion, self.errors, self.log_weight = motion, errors, log_weight
        self._united = np.zeros(log_weight.shape[1], bool)
        self.eye, self._fresh, self._divided = np.zeros(3), True, list[int]()

    @classmethod
    def of(cls, config: LocatorConfig, cameras: int = 1, robots: int = 1) -> 'Belief':
        """Create a belief without objects."""
        errors = CameraErrors.of(config, cameras, robots)
        belief = cls(Motions.none(len(errors.first)), errors, np.zeros((1, robots)))
        # if sizes measure the range too, a single case is enough
        bound = Kinds.of(config).bound.any() and config.method == 'ground'
        if bound and cameras == 1:
            belief._divide(PITCH)
        return belief

    def __len__(self) -> int:
        return len(self.motion) // len(self.log_weight)

    def take(self, rows: Selection) -> 'Belief':
        """See Columns.take(); the cameras stay the same."""
        taken = copy(self)
        taken.motion = self.motion.take(self._all(rows))
        return taken

    def keep(self, rows: Selection) -> None:
        """See Columns.keep()."""
        self.motion.keep(self._all(rows))

    def extend(self, other: 'Belief') -> None:
        """See Columns.extend(); other has the same cameras."""
        cases, own, more = len(self.log_weight), len(self), len(other)
        self.motion.extend(other.motion)
        old, new = (np.arange(cases * n).reshape(cases, n) for n in (own, more))
        self.motion.keep(np.concatenate([old, new + cases * own], axis=1).ravel())

    def combined(self) -> tuple[Floats, Floats]:
        """Return the estimates, (N, 8), and their mean squared errors, (N, 8, 8), of all sources.

        Over the cases, the inverse distance from the camera is averaged, which is linear in the
        pitch: for a given pitch, objects are where their rays meet the ground.
        """
        each, cov = self.motion.combined(self.errors)
        mean, cov = self.mixed(each, cov)
        if len(self.log_weight) == 1:
            return mean, cov
        near = _parted(inverted(each[:, POSITION] - self.eye)[0], len(self.log_weight))
        near = (self.of_objects()[..., None] * near).sum(axis=0)
        there = self.eye + inverted(near)[0]
        off = mean[:, POSITION] - there
        cov[:, POSITION, POSITION] += off[:, :, None] * off[:, None, :]
        mean[:, POSITION] = there
        return mean, cov

    def combined_errors(self) -> tuple[Floats, Floats]:
        """Return the camera errors of each robot, (R, 9 C), and their covariance, (R, 9 C, 9 C)."""
        mean, cov = (_parted(a, len(self.log_weight)) for a in (self.errors.mean, self.errors.cov))
        return mixture(np.exp(self.log_weight), mean, cov)

    def mixed(self, mean: Floats, cov: Floats) -> tuple[Floats, Floats]:
        """Return mean and covariance over all cases, (N, n), (N, n, n), from those of each case."""
        if len(self.log_weight) == 1:
            return mean, cov
        cases = len(self.log_weight)
        return mixture(self.of_objects(), _parted(mean, cases), _parted(cov, cases))

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
        """Return a belief with new objects; see filter.started()."""
        may = self._fresh and not len(self) and len(self.log_weight) == len(CASE_PITCHES)
        if may and is_low(view, kinds, ground, self.errors.first):
            self._divide(LIFT)
        cases = self._cases(len(position))
        motion = started(
            position[cases], reach[cases], self._in_cases(measured), view, self._in_cases(kinds),
            self.errors, ground, camera,
        )  # fmt: skip
        belief = copy(self)
        belief.motion, belief.eye = motion, view.optical.t
        return belief

    def forget(self, dt: float) -> None:
        """Let the camera errors change for dt [s]; see filter.forget()."""
        forget(self.motion, self.errors, dt)

    def predict(self, kinds: Kinds, ground: float, dt: float, unseen: Bools) -> None:
        """Predict by dt [s]; see motion.predict()."""
        if len(self.log_weight) > 1:
            unseen = unseen[self._cases(len(self))]
        predict(self.motion, self.errors, self._in_cases(kinds), ground, dt, unseen)

    def drift(self, robot: Floats, way: Floats, turned: float, sigma: Floats) -> None:
        """Add the errors of odometry; see motion.drift()."""
        drift(self.motion, self.errors, robot, way, turned, sigma)

    def misfit(
        self, measured: Measured, view: View, kinds: Kinds, ground: float, camera: int = 0
    ) -> Floats:
        """Return the misfits of measurements, (N,), from the predictions; see filter.misfit()."""
        off = misfit(
            self.motion, self.errors, self._in_cases(measured), view, self._in_cases(kinds),
            ground, camera,
        )  # fmt: skip
        return np.asarray(_parted(off, len(self.log_weight)).min(axis=0))

    def update(
        self, measured: Measured, view: View, kinds: Kinds, ground: float, camera: int = 0
    ) -> Bools:
        """Update all objects by measurements, (N,).

        :return: (N,) which measurements were refused, by most of the weight.
        """
        self.eye, self._fresh = view.optical.t, self._fresh and not measured.used.any()
        refused, likely = update(
            self.motion, self.errors, self._in_cases(measured), view, self._in_cases(kinds),
            ground, camera, cases=len(self.log_weight),
        )  # fmt: skip
        doubt(self.motion, refused & self._in_cases(kinds).falls)
        if len(self.log_weight) == 1:
            return refused
        # beside a height, pictures that are linearized at one wrong place tell of cases alike, too
        counted = COUNTED if LIFT in self._divided else 1.0
        self.log_weight = weighed(self.log_weight, counted * likely)
        most = self.of_objects() * _parted(refused, len(self.log_weight))
        self._unite()
        return np.asarray(most.sum(axis=0) > 1 / 2)

    def in_front(self, view: View) -> Bools:
        """Which objects, (N,), are in front of the camera in all cases."""
        return np.asarray(_parted(in_front(self.motion, view), len(self.log_weight)).all(axis=0))

    def kick(
        self,
        may: Bools,
        since: Floats,
        measured: Measured,
        view: View,
        kinds: Kinds,
        ground: float,
        camera: int,
    ) -> Bools:
        """Apply a kick to those of some objects, (N,), whose measurements it fits.

        :param since: (N,) time span in which the kick may have happened [s].
        :return: (N,) which objects it fits.
        """
        after, cases = copy(self), self._cases(len(self))
        after.motion = kicked(self.motion, kinds.speed[cases], since[cases])
        fits = may & (after.misfit(measured, view, kinds, ground, camera) <= 1)
        fits &= after.in_front(view)
        self.motion.put(self._all(fits), after.take(fits).motion)
        return np.asarray(fits)

    def _all(self, rows: Selection) -> Indices:
        """Return the rows of objects in all cases."""
        (chosen,) = rows.nonzero() if rows.dtype == bool else (rows,)
        starts = len(self) * np.arange(len(self.log_weight))
        return np.asarray((starts[:, None] + chosen).ravel())

    def _in_cases(self, table: Table) -> Table:
        """Repeat a table of objects for each case."""
        return table if len(self.log_weight) == 1 else table.take(self._cases(len(table)))

    def _cases(self, count: int) -> Indices:
        """Return the rows of count objects, repeated for each case."""
        return np.tile(np.arange(count), len(self.log_weight))

    def of_objects(self) -> Floats:
        """Return the weights of the cases, (C, N), of each object's robot."""
        robots = self.log_weight.shape[1]
        return np.asarray(np.repeat(np.exp(self.log_weight), len(self) // robots, axis=1))

    def _divide(self, error: int) -> None:
        """Split an error, before any measurement and any object, into cases."""
        self.errors, self.log_weight = divided(self.errors, self.log_weight, error)
        self._divided.append(error)

    def _unite(self) -> None:
        """Merge the cases of robots whose pitch is known as well as initially within one case."""
        cases, errors = len(self.log_weight), self.errors
        means = errors.mean.reshape(cases, -1, errors.mean.shape[1])
        mean, cov = self.combined_errors()
        parts = self._divided
        narrow = (cov[:, parts, parts] <= CASE_WIDTH**2 * errors.first[parts, parts]).all(axis=1)
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
            self.errors = CameraErrors(mean, cov, errors.first)
            self.log_weight = np.zeros((1, len(mean)))

    def _united_motion(self, change: Floats) -> Motions:
        """Return the states, (N,), merged after a change of the camera errors, (C N, 8)."""
        cases = len(self.log_weight)
        motion = in_inversion(self.motion, self.eye).shifted(change)
        weight = self.of_objects()[..., None]
        share = weight * _parted(motion.probability, cases)
        p = share.sum(axis=0)
        # objects that have just begun to fall have a hypothesis of probability 0
        share = np.where(p > 0, share / np.maximum(p, TINY), weight)
        mean, cov = mixture(share, _parted(motion.mean, cases), _parted(motion.cov, cases))
        slope = (share[..., None, None] * _parted(motion.slope, cases)).sum(axis=0)
        return out_of_inversion(Motions.of(mean, slope, cov, p), self.eye)


def _parted(a: NDArray[Any], cases: int) -> NDArray[Any]:
    """Reshape an array to cases and rows within each."""
    return a.reshape(cases, len(a) // cases, *a.shape[1:])
