"""Detection of setup mistakes: would the objects stand if the robot were set up differently?

With a camera that is upside down, looks elsewhere, or has the calibration of another picture, and
with late odometry, located objects move whenever the robot does. Each mistake is tried on the
pictures of the last seconds: it was made if half of the objects stand under it, and none as given.
Objects that really move stand under no mistake, so the test needs to know nothing about the objects
but what gives their range. If some are said to stand, only these are used; falling ones never are.
"""

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.late import LateOdometry
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.objects import Objects
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.search import AT_REST
from colortrack_ros.world.search import HELD
from colortrack_ros.world.search import LEAST
from colortrack_ros.world.search import Needed
from colortrack_ros.world.search import Pictures
from colortrack_ros.world.search import Search
from colortrack_ros.world.setting_off import SettingOff
from colortrack_ros.world.standing import Sights
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.stuck import StuckOdometry
from colortrack_ros.world.view import View
from colortrack_ros.world.wrong_setups import AS_GIVEN
from colortrack_ros.world.wrong_setups import LATEST
from colortrack_ros.world.wrong_setups import Mistake

BETWEEN, LOOKS_BACK = 0.2, 4.0
"""Time between the pictures used, and how long they are kept [s]; at 0.5 m/s a robot drives 2 m in
it. Chosen."""

LEAST_SEEN = 8
"""Least number of pictures that must show an object: 1.6 s of the 4. Chosen."""

MOST_OBJECTS = 8
"""Most objects used, the most frequently seen ones: more cost time and add nothing. Chosen."""

USUAL_ODOMETRY = 0.005
"""Standard deviation of odometry after 1 m [m] and after 1 rad [rad] up to which LEAST is the least
misfit as given; for worse odometry it grows with the variance. The default of odometry_sigma."""

PAUSE = 1.0
"""Pause after an unsuccessful search [s]: rolling objects would otherwise start one after the
other. Chosen."""

MOVED = (
    'what is said to stand moves whenever the robot does: camera_pose, calibration, odometry, or '
    'that it stands is wrong'
)
"""Message if no mistake of the list explains the motion."""

PARKED = Mistake(
    base=lambda base: Pose(
        np.broadcast_to(base.t[-1], base.t.shape), np.broadcast_to(base.R[-1], base.R.shape)
    )
)
"""Hypothesis that the robot stood still: if it fits worse, standing objects do tell whether the
robot is set up right."""


class Mistakes:
    """Watch over the pictures of one camera for mistakes.

    :param sigma: (6,) standard deviations of the camera pose, whose errors are estimated.
    :param odometry: its standard deviations after 1 m [m] and after 1 rad [rad].
    :param way: standard deviation of the scale of its ways, whose error is estimated, too.
    :param time: that of the time by which its stamps and those of pictures are apart [s].
    """

    def __init__(
        self,
        sigma: ArrayLike,
        odometry: ArrayLike = (USUAL_ODOMETRY, USUAL_ODOMETRY),
        way: float = 0.0,
        time: float = 0.0,
    ) -> None:
        self._sigma = np.concatenate([sigma, [time, way]])
        self._least = LEAST * max(float(np.max(odometry)) / USUAL_ODOMETRY, 1.0) ** 2
        self._views: dict[int, View] = {}
        self._sights: Sights | None = None
        self._looked: int | None = None
        self._searches_from = 0
        self._search: Search | None = None
        self._line, self._mistake = '', AS_GIVEN
        self._suspected_at: int | None = None
        self.made, self._late = '', LateOdometry()
        self._stuck, self._setting_off = StuckOdometry(), SettingOff()

    @property
    def odometry(self) -> str:
        """What contradicts odometry and may have another cause; empty if nothing does."""
        return self._stuck.line or self._setting_off.line or self._late.line

    def see(
        self,
        stamp: int,
        view: View,
        tracks: NDArray[np.uint32],
        measured: Measured,
        kinds: Kinds,
        ground: float,
        objects: Objects | None = None,
        camera: int = 0,
    ) -> None:
        """Add a picture, and update which mistake has been made.

        :param tracks: (K,) IDs; measured, kinds: of each.
        :param ground: its height in the fixed frame [m].
        :param objects: after this picture; camera: index of the camera that took it.
        """
        if stamp < max(self._views, default=0):
            self._sights, self._looked, self._views, self._searches_from = None, None, {}, 0
            self._search = self._suspected_at = None
            self._late = LateOdometry()
        self._views[stamp] = view
        if self._search:
            self._search.go_on(stamp)
            if self._search.found:
                self._conclude(self._search)
        if self._looked is not None and stamp - self._looked < BETWEEN * NANOSECONDS:
            return
        self._looked = stamp
        new = Sights.of(stamp, tracks, measured, kinds, view)
        self._stuck.see(stamp, view, new)
        if objects is not None:
            self._setting_off.see(stamp, view, new, objects, camera)
        sights = _telling(self._take(stamp, new))
        if not len(sights):
            self._late = LateOdometry()
        elif not self._search:
            self._judge(Pictures(dict(self._views), sights, ground, self._sigma))

    def _take(self, stamp: int, new: Sights) -> Sights:
        """Store the sights of a picture, and drop old ones."""
        if self._sights is None:
            self._sights = new
        else:
            self._sights.extend(new)
        since = stamp - round(LOOKS_BACK * NANOSECONDS)
        poses_since = since - round(LATEST * NANOSECONDS)
        self._views = {stamp: view for stamp, view in self._views.items() if stamp > poses_since}
        self._sights.keep(self._sights.stamp > since)
        return self._sights

    def _judge(self, pictures: Pictures) -> None:
        """Start a search if objects move, follow up a suspicion, or clear a disproved mistake."""
        given = pictures.given()
        needed = Needed.of(pictures.sights.kinds, len(given), self._least)
        self._late.see(pictures, needed, given)
        if self.made:
            (other,) = pictures.misfits([self._mistake])
            if needed.met(other, given):
                self.made = ''
        elif self._suspected_at is not None:
            (off,) = pictures.misfits([self._mistake])
            self._agree(pictures, needed, off)
        elif (
            pictures.newest >= self._searches_from
            and given.min() > AT_REST
            and needed.most(given) > self._least
        ):
            self._search = Search(pictures, needed)

    def _conclude(self, search: Search) -> None:
        """Suspect the result of a search, if there is one."""
        self._search = None
        if search.found is None:
            return
        self._line, self._mistake, off = search.found
        given = search.pictures.with_poses(self._mistake.later).given()
        if not search.needed.met(given, off) and search.needed.known:
            self._line, self._mistake = MOVED, PARKED
        self._agree(search.pictures, search.needed, off)

    def _agree(self, pictures: Pictures, needed: Needed, off: Floats) -> None:
        """Confirm or drop the suspected mistake; it is confirmed once several looks agree.

        :param off: (K,) misfits under the suspected mistake.
        """
        given = pictures.with_poses(self._mistake.later).given()
        if self._line == MOVED:
            fits = needed.known and len(given) > 1 and given.min() > self._least
        else:
            fits = needed.met(given, off)
            if fits and not (needed.known or self._setting_off.line):
                fits = not pictures.rolls_alike(off)
        stamp = pictures.newest
        if not fits:
            self._suspected_at = None
            self._searches_from = stamp + round(PAUSE * NANOSECONDS)
        elif self._suspected_at is None:
            self._suspected_at = stamp
        elif stamp - self._suspected_at >= HELD * NANOSECONDS:
            self.made, self._suspected_at = self._line, None


def _telling(sights: Sights) -> Sights:
    """Return the sights of objects seen often that may stand, only known ones if there are any.

    They are grouped by object.
    """
    sights = _often(sights.take(~sights.kinds.falls))
    known = np.asarray(~sights.kinds.speed.any(axis=1))
    return sights.take(known) if known.any() else sights


def _often(sights: Sights) -> Sights:
    """Return the sights of the most frequently seen objects."""
    order = np.argsort(sights.track, kind='stable')
    track = sights.track[order]
    first = np.append(True, track[1:] != track[:-1])[: len(track)].nonzero()[0]
    count = np.diff(np.append(first, len(track)))
    rank = np.argsort(np.argsort(-count, kind='stable'))
    often = (count >= LEAST_SEEN) & (rank < MOST_OBJECTS)
    return sights.take(order[np.repeat(often, count)])
