"""Odometry whose stamps are late or ahead, by what is said to stand.

Poses of another time are wrong by what the robot drives and turns meanwhile: what stands seems to
move as it speeds up, or begins to turn. One object whose direction hardly changes contradicts that
by less than right set-ups may with other errors, so the search for mistakes does not start. But
poses of the right time leave nothing but noise, which those errors do not. What is said to stand
may have been moved: so this is told, and nothing is held back.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.search import AT_REST
from colortrack_ros.world.search import HELD
from colortrack_ros.world.search import LEAST
from colortrack_ros.world.search import Needed
from colortrack_ros.world.search import Pictures
from colortrack_ros.world.wrong_setups import AS_GIVEN
from colortrack_ros.world.wrong_setups import LATEST
from colortrack_ros.world.wrong_setups import TIME_OF_ODOMETRY
from colortrack_ros.world.wrong_setups import WrongAmount

EXPLAINED = 4.0
"""How many times smaller misfits must be by poses of another time. Chosen: right set-ups reach 1.3,
also if the robot nods as it speeds up, or bumps are not told (notes on the world)."""

MOST_LEFT = AT_REST / 2
"""Largest misfit by poses of another time: right set-ups are left with 0.05 to 0.4."""

OLD_TIMES, AHEAD_TIMES = (
    [wrong for wrong in TIME_OF_ODOMETRY.coarse() if wrong.amount * sign > 0] for sign in (1, -1)
)
"""The times that are tried."""


class LateOdometry:
    """Watch over the looks of one camera; see the module.

    :ivar line: what to tell, or nothing.
    """

    def __init__(self) -> None:
        self.line = ''
        self._sign, self._since = 0, 0

    def see(self, pictures: Pictures, needed: Needed, given: Floats) -> None:
        """Compare how objects stand as given, misfits (K,), with how they do by other poses."""
        found, least = None, AT_REST * needed.misfit / LEAST
        if needed.known and given.mean() > least:
            found = _explained(pictures, OLD_TIMES, least) or _explained(
                pictures, AHEAD_TIMES, least
            )
        sign = np.sign(found.amount) if found else 0
        if sign != self._sign:
            self._sign, self._since = sign, pictures.newest
        held = pictures.newest - self._since >= HELD * NANOSECONDS
        self.line = f'{found.line}, or what is said to stand moves' if found and held else ''


def _explained(pictures: Pictures, wrong: list[WrongAmount], least: float) -> WrongAmount | None:
    """Return by which of these times, old or ahead, objects stand that as given move."""
    some = pictures.with_poses(LATEST if wrong is OLD_TIMES else -LATEST)
    if not len(some.sights):
        return None
    given, *by = some.misfits([AS_GIVEN, *(amount.mistake for amount in wrong)])
    off = np.mean(by, axis=1)
    best = int(off.argmin())
    fits = off[best] < MOST_LEFT and max(least, EXPLAINED * off[best]) < given.mean() < np.inf
    return wrong[best] if fits else None
