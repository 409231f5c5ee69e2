"""The search for what explains that things move which should stand: some hypotheses a picture.

All of them at once take 15 to 40 ms, more than there is between two pictures.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.spatial.transform import Slerp

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.standing import Looks
from colortrack_ros.world.standing import misfits
from colortrack_ros.world.standing import rays_of
from colortrack_ros.world.standing import Sights
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View
from colortrack_ros.world.wrong_setups import as_given
from colortrack_ros.world.wrong_setups import Mistake
from colortrack_ros.world.wrong_setups import MISTAKES
from colortrack_ros.world.wrong_setups import WRONG_AMOUNTS
from colortrack_ros.world.wrong_setups import WrongAmount

Floats = NDArray[np.float64]

AT_REST = 1.0
"""Misfit up to which an object stands: that which is expected of it."""

WORSE, LEAST = 20.0, 6.0
"""How many times as much the misfits must be as given, and at least. In the simulated room yaw off
by 10 degrees gives 30 to 50 times as much, and 8. `python benchmark/world_right.py` tells how often
what rolls by chance seems to stand by a mistake. Chosen."""

ALONE = 10.0
"""By how much more a mistake has to explain where one object that may move is all there is: it fits
several by chance, so it speaks for those of the list alone. Chosen."""

SEARCH_TIME = 0.4
"""How long a search takes [s] of the time of the pictures, two looks. With 30 pictures a second
that is 10 hypotheses in each, 2 to 3 ms; half of it takes twice as long in each. Chosen."""


@dataclass(frozen=True)
class Needed:
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
    def of(cls, kinds: Kinds, count: int, misfit: float) -> 'Needed':
        """Half of so many objects; one of several is not enough if they may move."""
        known = not kinds.speed.any()
        least = 1 if known or count == 1 else 2
        return cls(max((count + 1) // 2, least), known, count == 1 and not known, misfit)

    def most(self, off: Floats) -> Floats:
        """The misfit of so many objects at most, (...), of those of all, (..., K)."""
        return np.asarray(np.sort(off, axis=-1)[..., self.objects - 1])

    def met(self, given: Floats, off: Floats) -> bool:
        """Whether so many objects stand by a mistake and not as given; (K,) each.

        None of them stands as given, and in the mean, as angles of one are much less off than
        those of another, they misfit by enough. One that cannot be where it is seen, by a mistake,
        disproves it.
        """
        more, stands = ALONE if self.alone else 1.0, (off < AT_REST) & (given > AT_REST)
        if not np.isfinite(off).all() or np.count_nonzero(stands) < self.objects:
            return False
        least = max(self.misfit, WORSE * float(off[stands].mean()))
        return bool(given[stands].mean() > more * least)


@dataclass(frozen=True)
class Pictures:
    """What the pictures of the last seconds have shown, and from where.

    :ivar views: by their stamps, ascending [ns].
    :ivar sights: (M,), those of one of K objects after those of another.
    :ivar ground: its height in the fixed frame [m].
    :ivar sigma: (6,) what is expected of the errors of the camera's place on the robot.
    """

    views: dict[int, View]
    sights: Sights
    ground: float
    sigma: Floats

    @property
    def newest(self) -> int:
        """Stamp of the last one [ns]."""
        return next(reversed(self.views))

    def misfits(self, mistakes: list[Mistake]) -> Floats:
        """The misfits of things that stand if a mistake is made, (C, K)."""
        mount, picture, way = self._poses
        bases, bodies, known, rays, far = [], [], [], [], []
        for mistake in mistakes:
            there, told = way.at(mistake.later)
            bases.append(mistake.base(there))
            bodies.append(bases[-1] @ mistake.mount(mount))
            known.append(told[picture])
            ray, along = self._rays(mistake)
            rays.append(ray)
            far.append(along)
        R, R_base = (np.stack([pose.R for pose in poses])[:, picture] for poses in (bodies, bases))
        eyes = np.stack([body.t for body in bodies])[:, picture]
        ways = (R @ OPTICAL.R @ np.stack(rays)[..., None])[..., 0]
        looks = Looks(eyes, ways, R_base, R, np.stack(far), np.stack(known))
        return misfits(looks, self.sights, self.ground, self.sigma)

    def _rays(self, mistake: Mistake) -> tuple[Floats, Floats]:
        """The rays, (M, 3), and how far along them things are, (M,), if a mistake is made."""
        sights = self.sights
        if mistake.camera is as_given:
            return sights.rays, sights.far
        camera = mistake.camera(self.views[self.newest].camera)
        return rays_of(sights.measured, sights.kinds, camera)

    @cached_property
    def _poses(self) -> tuple[Pose, NDArray[np.intp], '_Way']:
        """Of the camera on the robot, which of them each sight is of, and the way of the robot."""
        views, stamps = list(self.views.values()), np.array(list(self.views))
        base, mount = (
            Pose(*(np.stack([getattr(getattr(v, of), name) for v in views]) for name in 'tR'))
            for of in ('base', 'mount')
        )
        return mount, np.searchsorted(stamps, self.sights.stamp), _Way(stamps, base)


class Search:
    """Looks for the mistake that misfits least.

    :ivar pictures: that are to be explained.
    :ivar needed: to explain them.
    :ivar given: (K,) their misfits as given.
    :ivar found: what is told of the mistake, the mistake, and the misfits, (K,); None until then.
    """

    def __init__(self, pictures: Pictures, needed: Needed, given: Floats) -> None:
        self.found: tuple[str, Mistake, Floats] | None = None
        self.pictures, self.needed, self.given = pictures, needed, given
        self._coarse = [] if needed.alone else [w for f in WRONG_AMOUNTS for w in f.coarse()]
        self._hypotheses = _told(self._coarse) or list(MISTAKES.items())
        self._share = (len(self._coarse) + len(MISTAKES)) / (SEARCH_TIME * NANOSECONDS)
        self._off: list[Floats] = []
        self._stamp = pictures.newest

    def go_on(self, stamp: int) -> None:
        """Try as many hypotheses as are due at the time of a picture [ns].

        One of the same stamp as the last, of another camera or message, brings none.
        """
        due = int(np.ceil(self._share * (stamp - self._stamp)))
        if not due:
            return
        tried, self._stamp = sum(len(off) for off in self._off), stamp
        next_ones = [mistake for _, mistake in self._hypotheses[tried : tried + due]]
        self._off.append(self.pictures.misfits(next_ones))
        if tried + due >= len(self._hypotheses):
            self._choose()

    def _choose(self) -> None:
        """The best of all; after a coarse look at amounts, look around the best."""
        off, self._off = np.concatenate(self._off), []
        least = int(np.argmin(self.needed.most(off)))
        if self._coarse:
            around, self._coarse = self._coarse[least].around(), []
            self._hypotheses = [*MISTAKES.items(), *_told(around)]
        else:
            self.found = *self._hypotheses[least], off[least]


def _told(amounts: list[WrongAmount]) -> list[tuple[str, Mistake]]:
    """What is told of each, and what would mend it."""
    return [(wrong.line, wrong.mistake) for wrong in amounts]


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
