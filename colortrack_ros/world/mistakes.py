"""Whether what is seen would stand if the robot were set up otherwise, as by a common mistake.

A camera that is upside down, that looks elsewhere, or has the calibration of another picture, and
odometry that is late, give places that move whenever the robot does. Each mistake is tried on the
pictures of the last seconds: where one of them makes half of what they show stand, and the robot as
given nothing, it has been made. What really moves stands by none of them, so nothing has to be
known of the objects but what gives their range. If some are said to stand, only they are looked at;
what falls never is.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.spatial.transform import Slerp

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.standing import Looks
from colortrack_ros.world.standing import misfits
from colortrack_ros.world.standing import rays_of
from colortrack_ros.world.standing import Sights
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View
from colortrack_ros.world.wrong_setups import AS_GIVEN
from colortrack_ros.world.wrong_setups import as_given
from colortrack_ros.world.wrong_setups import LATEST
from colortrack_ros.world.wrong_setups import Mistake
from colortrack_ros.world.wrong_setups import MISTAKES
from colortrack_ros.world.wrong_setups import OF_ABOUT
from colortrack_ros.world.wrong_setups import WRONG_AMOUNTS

Floats = NDArray[np.float64]
BETWEEN, LOOKS_BACK = 0.2, 4.0
"""Time between the pictures that are looked at, and how long they are kept [s]: at 0.5 m/s a robot
drives 2 m in it. Chosen."""

LEAST_SEEN = 8
"""Pictures that must show an object: 1.6 s of the 4. Chosen."""

MOST_OBJECTS = 8
"""Objects that are looked at, those that have been seen most often: more cost time and tell the
same. Chosen."""

AT_REST = 1.0
"""Misfit up to which an object stands: that which is expected of it."""

WORSE, LEAST = 20.0, 6.0
"""How many times as much the misfits must be as given, and at least. In the simulated room yaw off
by 10 degrees gives 30 to 50 times as much, and 8. `python benchmark/world_right.py` tells how often
what rolls by chance seems to stand by a mistake. Chosen."""

USUAL_ODOMETRY = 0.005
"""Standard deviation of odometry [m] after 1 m, and [rad] after 1 rad, up to which the misfits as
given must be LEAST; that of worse odometry adds its square. The default of odometry_sigma."""

PAUSE = 1.0
"""After a search that found nothing the next one is so much later [s]: it takes 15 to 30 ms, and
what rolls would ask for one in every look. Chosen."""

ALONE = 10.0
"""By how much more a mistake has to explain where one object that may move is all there is: it fits
several by chance, so it speaks for those of the list alone. Chosen."""

AGREEING = 3
"""Successive pictures that must say the same. Chosen."""

MOVED = (
    'what is said to stand moves whenever the robot does: camera_pose, calibration, odometry, or '
    'that it stands is wrong'
)
"""What is told where no mistake of the list explains it."""

PARKED = Mistake(
    base=lambda base: Pose(
        np.broadcast_to(base.t[-1], base.t.shape), np.broadcast_to(base.R[-1], base.R.shape)
    )
)
"""The robot has stood: where that fits worse, what stands tells whether it is seen rightly."""


@dataclass(frozen=True)
class _Needed:
    """How much has to speak for a mistake.

    :ivar objects: as many must stand by it.
    :ivar known: whether they are said to stand.
    :ivar alone: whether it is one that may move.
    :ivar misfit: as given, at least.
    """

    objects: int
    known: bool
    alone: bool
    misfit: float

    @classmethod
    def of(cls, kinds: Kinds, count: int, misfit: float) -> '_Needed':
        """Half of so many objects; one of several is not enough if they may move."""
        known = not kinds.speed.any()
        least = 1 if known or count == 1 else 2
        return cls(max((count + 1) // 2, least), known, count == 1 and not known, misfit)

    def most(self, off: Floats) -> Floats:
        """The misfit of so many objects at most, (...), of those of all, (..., K)."""
        return np.asarray(np.sort(off, axis=-1)[..., self.objects - 1])

    def met(self, given: Floats, off: Floats) -> bool:
        """Whether so many objects stand by a mistake and not as given; (K,) each.

        One that cannot be where it is seen, by a mistake, disproves it.
        """
        more = ALONE if self.alone else 1.0
        stands = (off < AT_REST) & (given > more * self.misfit) & (given > more * WORSE * off)
        return bool(np.isfinite(off).all() and np.count_nonzero(stands) >= self.objects)


class Mistakes:
    """Watches the pictures of one camera for a mistake.

    :param sigma: (6,) of the place of the camera: by that much it may be off, and is estimated.
    :param odometry: its standard deviations after 1 m [m] and after 1 rad [rad].
    """

    def __init__(
        self, sigma: ArrayLike, odometry: ArrayLike = (USUAL_ODOMETRY, USUAL_ODOMETRY)
    ) -> None:
        self._sigma = np.asarray(sigma, float)
        self._least = LEAST * max(float(np.max(odometry)) / USUAL_ODOMETRY, 1.0) ** 2
        self._views: dict[int, View] = {}
        self._sights: Sights | None = None
        self._looked: int | None = None
        self._searches_from = 0
        self._suspected, self._looks, self._mistake = '', 0, AS_GIVEN
        self.made = ''

    def see(
        self,
        stamp: int,
        view: View,
        tracks: NDArray[np.uint32],
        measured: Measured,
        kinds: Kinds,
        ground: float,
    ) -> None:
        """Take a picture, and find out whether a mistake is made, or is no longer.

        :param tracks: (K,) IDs; measured, kinds: of each.
        :param ground: its height in the fixed frame [m].
        """
        if stamp < max(self._views, default=0):
            self._sights, self._looked, self._views, self._searches_from = None, None, {}, 0
        self._views[stamp] = view
        if self._looked is not None and stamp - self._looked < BETWEEN * NANOSECONDS:
            return
        self._looked = stamp
        new = Sights.of(stamp, tracks, measured, kinds, view.camera)
        self._judge(self._take(stamp, new), ground)

    def _take(self, stamp: int, new: Sights) -> Sights:
        """Keep what a picture shows, and forget what is old."""
        if self._sights is None:
            self._sights = new
        else:
            self._sights.extend(new)
        since = stamp - round(LOOKS_BACK * NANOSECONDS)
        poses_since = since - round(LATEST * NANOSECONDS)
        self._views = {stamp: view for stamp, view in self._views.items() if stamp > poses_since}
        self._sights.keep(self._sights.stamp > since)
        return self._sights

    def _judge(self, sights: Sights, ground: float) -> None:
        """Find the mistake that explains what moves, or that it no longer does."""
        sights = _telling(sights)
        if not len(sights):
            return
        (given,) = self._misfits(sights, [AS_GIVEN], ground)
        needed = _Needed.of(sights.kinds, len(given), self._least)
        if self.made:
            (other,) = self._misfits(sights, [self._mistake], ground)
            if needed.met(other, given):
                self.made = ''
        elif (
            sights.stamp.max() >= self._searches_from
            and given.min() > AT_REST
            and needed.most(given) > self._least
        ):
            self._suspect(sights, needed, given, ground)

    def _suspect(self, sights: Sights, needed: _Needed, given: Floats, ground: float) -> None:
        """Look which mistake makes things stand, and note it once that has been so for a while."""
        line, mistake, off = self._likeliest(sights, needed, ground)
        fits = needed.met(given, off)
        if not fits and needed.known and len(given) > 1 and given.min() > self._least:
            line, mistake, fits = MOVED, PARKED, True
        which = line.split(OF_ABOUT)[0]
        self._looks = self._looks + 1 if fits and which == self._suspected else int(fits)
        self._suspected = which
        if not fits:
            self._searches_from = int(sights.stamp.max()) + round(PAUSE * NANOSECONDS)
        if self._looks >= AGREEING:
            self.made, self._mistake = line, mistake

    def _likeliest(
        self, sights: Sights, needed: _Needed, ground: float
    ) -> tuple[str, Mistake, Floats]:
        """The mistake that misfits least, what is told of it, and the misfits, (K,)."""
        found = list(MISTAKES.items())
        if needed.alone:
            off = self._misfits(sights, [mistake for _, mistake in found], ground)
            least = int(np.argmin(needed.most(off)))
            return *found[least], off[least]
        each = [wrong for family in WRONG_AMOUNTS for wrong in family.coarse()]
        off = needed.most(self._misfits(sights, [wrong.mistake for wrong in each], ground))
        best = each[int(np.argmin(off))]
        found += [(wrong.line, wrong.mistake) for wrong in best.around()]
        all_off = self._misfits(sights, [mistake for _, mistake in found], ground)
        least = int(np.argmin(needed.most(all_off)))
        return *found[least], all_off[least]

    def _misfits(self, sights: Sights, mistakes: list[Mistake], ground: float) -> Floats:
        """The misfits of things that stand if a mistake is made, (C, K).

        :param sights: (M,), those of one object after those of another.
        """
        views, stamps = list(self._views.values()), np.array(list(self._views))
        base, mount = (
            Pose(*(np.stack([getattr(getattr(v, of), name) for v in views]) for name in 'tR'))
            for of in ('base', 'mount')
        )
        picture, way = np.searchsorted(stamps, sights.stamp), _Way(stamps, base)
        bases, bodies, known, rays, far = [], [], [], [], []
        for mistake in mistakes:
            there, told = way.at(mistake.later)
            bases.append(mistake.base(there))
            bodies.append(bases[-1] @ mistake.mount(mount))
            known.append(told[picture])
            if mistake.camera is as_given:
                ray, along = sights.rays, sights.far
            else:
                camera = mistake.camera(views[-1].camera)
                ray, along = rays_of(sights.measured, sights.kinds, camera)
            rays.append(ray)
            far.append(along)
        R, R_base = (np.stack([pose.R for pose in poses])[:, picture] for poses in (bodies, bases))
        eyes = np.stack([body.t for body in bodies])[:, picture]
        ways = (R @ OPTICAL.R @ np.stack(rays)[..., None])[..., 0]
        looks = Looks(eyes, ways, R_base, R, np.stack(far), np.stack(known))
        return misfits(looks, sights, ground, self._sigma)


class _Way:
    """Where the robot was, of V pictures.

    :param stamps: (V,) ascending [ns], two at least; poses: of the robot, t (V, 3), R (V, 3, 3).
    """

    def __init__(self, stamps: NDArray[np.int64], poses: Pose) -> None:
        self._seconds, self._poses = 1e-9 * (stamps - stamps[0]), poses
        self._stamps = stamps

    @cached_property
    def _turns(self) -> Slerp:
        return Slerp(self._seconds, Rotation.from_matrix(self._poses.R))

    def at(self, later: float) -> tuple[Pose, NDArray[np.bool_]]:
        """The poses so much later [s], and which of them are between known ones, (V,)."""
        if not later:
            return self._poses, np.ones(len(self._stamps), bool)
        wanted = self._stamps + round(later * NANOSECONDS)
        inside = np.clip(wanted, self._stamps[0], self._stamps[-1])
        at = 1e-9 * (inside - self._stamps[0])
        t = np.stack([np.interp(at, self._seconds, axis) for axis in self._poses.t.T], axis=1)
        return Pose(t, self._turns(at).as_matrix()), inside == wanted


def _telling(sights: Sights) -> Sights:
    """Those of objects that have been seen often, and may stand; only known ones if there are any.

    Those of one object after those of another.
    """
    sights = _often(sights.take(~sights.kinds.falls))
    known = np.asarray(~sights.kinds.speed.any(axis=1))
    return sights.take(known) if known.any() else sights


def _often(sights: Sights) -> Sights:
    """Those of the objects that have been seen most often."""
    _, of, count = np.unique(sights.track, return_inverse=True, return_counts=True)
    rank = np.argsort(np.argsort(-count, kind='stable'))
    order = np.argsort(of, kind='stable')
    often = (count >= LEAST_SEEN) & (rank < MOST_OBJECTS)
    return sights.take(order[often[of[order]]])
