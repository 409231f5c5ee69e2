"""Search for a setup mistake that explains why objects that should stand move, a few at a time.

Trying all hypotheses at once takes 15 to 40 ms, more than the time between two pictures.
"""

from dataclasses import dataclass
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.spatial.transform import Slerp

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.standing import drift
from colortrack_ros.world.standing import Looks
from colortrack_ros.world.standing import misfits
from colortrack_ros.world.standing import rays_of
from colortrack_ros.world.standing import Sights
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View
from colortrack_ros.world.wrong_setups import AS_GIVEN
from colortrack_ros.world.wrong_setups import as_given
from colortrack_ros.world.wrong_setups import Mistake
from colortrack_ros.world.wrong_setups import MISTAKES
from colortrack_ros.world.wrong_setups import WRONG_AMOUNTS
from colortrack_ros.world.wrong_setups import WrongAmount

AT_REST = 1.0
"""Misfit up to which an object stands; 1 is the expected one."""

WORSE, LEAST = 20.0, 6.0
"""How many times larger the misfits must be as given than under the mistake, and their least value
as given. In the simulated room a yaw that is off by 10 degrees gives a factor of 30 to 50, and 8.
`python benchmark/world_right.py` tells how often rolling objects seem to stand by chance under some
mistake. Chosen."""

ALONE = 10.0
"""Factor on WORSE and LEAST if the only evidence is a single object that may move. It fits several
mistakes by chance, so it counts only for those of the list. Chosen."""

AS_WELL = 1.5
"""Largest misfit of what rolls alike, over that under a mistake by which it would stand. Before a
robot that drives straight it is 0.5 to 0.9 where objects do roll alike; with a yaw that is off by
10 degrees in the room where three balls stand (`mistakes.py`) 2.1 and more. Chosen."""

VELOCITY_STEPS = 4
"""Gauss-Newton steps for the velocity of what rolls alike: the second changes it by up to 0.1 m/s,
the fourth by less than 1 mm/s. Chosen."""

SEARCH_TIME = 0.4
"""Duration of a search in picture time [s], two looks. At 30 pictures a second it tries 10
hypotheses per picture, 2 to 3 ms; half the duration doubles the time per picture. Chosen."""

HELD = 0.4
"""How long a mistake must explain the motion [s] after the look by which it was found: two more
looks. Chosen."""


@dataclass(frozen=True)
class Needed:
    """Evidence needed for a mistake.

    :ivar objects: least number of objects that must stand under it.
    :ivar known: whether the objects are said to stand.
    :ivar alone: whether there is one object only, which may move.
    :ivar misfit: least misfit as given.
    """

    objects: int
    known: bool
    alone: bool
    misfit: float

    @classmethod
    def of(cls, kinds: Kinds, count: int, misfit: float) -> 'Needed':
        """Require half of count objects, and more than one of several that may move."""
        known = not kinds.speed.any()
        least = 1 if known or count == 1 else 2
        return cls(max((count + 1) // 2, least), known, count == 1 and not known, misfit)

    def most(self, off: Floats) -> Floats:
        """Return the largest misfit, (...), among the best-fitting objects; of all, (..., K)."""
        return np.asarray(np.sort(off, axis=-1)[..., self.objects - 1])

    def met(self, given: Floats, off: Floats) -> bool:
        """Return whether enough objects stand under a mistake and not as given; (K,) each.

        None of these may stand as given. Their mean misfit must be large enough: the angles to one
        may be off much less than those to another. An object that cannot be where it is seen
        disproves a mistake.
        """
        more, stands = ALONE if self.alone else 1.0, (off < AT_REST) & (given > AT_REST)
        if not np.isfinite(off).all() or np.count_nonzero(stands) < self.objects:
            return False
        least = max(self.misfit, WORSE * float(off[stands].mean()))
        return bool(given[stands].mean() > more * least)


@dataclass(frozen=True)
class Pictures:
    """Pictures of the last seconds, with the views from which they were taken.

    :ivar views: by their stamps, ascending [ns].
    :ivar sights: (M,), grouped by their K objects.
    :ivar ground: its height in the fixed frame [m].
    :ivar sigma: (8,) standard deviations of the camera pose on the robot, of the time of pictures,
        and of the scale of ways.
    """

    views: dict[int, View]
    sights: Sights
    ground: float
    sigma: Floats

    @property
    def newest(self) -> int:
        """Stamp of the last picture [ns]."""
        return next(reversed(self.views))

    def misfits(self, mistakes: list[Mistake]) -> Floats:
        """Return the misfits of standing objects under each mistake, (C, K)."""
        return misfits(self._looks(mistakes), self.sights, self.ground, self.sigma)

    def given(self) -> Floats:
        """Return the misfits of standing objects as given, (K,).

        For these, views between those of the sights are not needed.
        """
        views = {stamp: self.views[stamp] for stamp in sorted(set(self.sights.stamp.tolist()))}
        return np.asarray(replace(self, views=views).misfits([AS_GIVEN])[0])

    def with_poses(self, later: float) -> 'Pictures':
        """Return the sights for which the poses that much later [s] are known.

        Under a mistake of time the others are left out, so what is odd in them seems explained: how
        it fits is to be compared with how these fit as given.
        """
        stamp = self.sights.stamp + round(later * NANOSECONDS)
        known = (stamp >= next(iter(self.views))) & (stamp <= self.newest)
        return replace(self, sights=self.sights.take(known))

    def rolls_alike(self, off: Floats) -> bool:
        """Return whether what stands under a mistake may, as given, roll by one velocity.

        Before a robot that drives straight, both may look the same.

        :param off: (K,) misfits under the mistake.
        """
        objects = off < AT_REST
        _, of = np.unique(self.sights.track, return_inverse=True)
        some = replace(self, sights=self.sights.take(objects[of]))
        seconds = (np.array(list(self.views)) - self.newest) / NANOSECONDS
        then = (some.sights.stamp - self.newest) / NANOSECONDS
        velocity, alike = np.zeros(2), AS_GIVEN
        for _ in range(VELOCITY_STEPS):
            looks = some._looks([alike])
            velocity = velocity + drift(looks, some.sights, self.ground, self.sigma, then)[0]
            way = seconds[:, None] * np.append(velocity, 0.0)
            alike = _without(way)
        return bool(some.misfits([alike])[0].mean() < AS_WELL * off[objects].mean())

    def _looks(self, mistakes: list[Mistake]) -> Looks:
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
        return Looks(eyes, ways, R_base, R, np.stack(far), np.stack(known))

    def _rays(self, mistake: Mistake) -> tuple[Floats, Floats]:
        """Return rays, (M, 3), and distances along them, (M,), under a mistake."""
        sights = self.sights
        if mistake.camera is as_given:
            return sights.rays, sights.far
        camera = mistake.camera(self.views[self.newest].camera)
        return rays_of(sights.measured, sights.kinds, camera)

    @cached_property
    def _poses(self) -> tuple[Pose, Indices, '_Way']:
        """Camera poses on the robot, the picture index of each sight, and the path of the robot."""
        views, stamps = list(self.views.values()), np.array(list(self.views))
        base, mount = (
            Pose(*(np.array([getattr(getattr(v, of), name) for v in views]) for name in 'tR'))
            for of in ('base', 'mount')
        )
        return mount, np.searchsorted(stamps, self.sights.stamp), _Way(stamps, base)


class Search:
    """Search for the mistake with the least misfit.

    :ivar pictures: pictures to explain.
    :ivar needed: evidence needed.
    :ivar found: message, mistake, and misfits, (K,); None until the search ends.
    """

    def __init__(self, pictures: Pictures, needed: Needed) -> None:
        self.found: tuple[str, Mistake, Floats] | None = None
        self.pictures, self.needed = pictures, needed
        self._coarse = [] if needed.alone else [w for f in WRONG_AMOUNTS for w in f.coarse()]
        self._hypotheses = _told(self._coarse) or list(MISTAKES.items())
        self._share = (len(self._coarse) + len(MISTAKES)) / (SEARCH_TIME * NANOSECONDS)
        self._off: list[Floats] = []
        self._stamp = pictures.newest

    def go_on(self, stamp: int) -> None:
        """Try the hypotheses that are due at the time of a picture [ns].

        None are due for a picture with the same stamp as the last one, from another camera or
        message.
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
        """Take the best hypothesis; after coarse amounts, continue with finer ones around it."""
        off, self._off = np.concatenate(self._off), []
        least = int(np.argmin(self.needed.most(off)))
        if self._coarse:
            around, self._coarse = self._coarse[least].around(), []
            self._hypotheses = [*MISTAKES.items(), *_told(around)]
        else:
            self.found = *self._hypotheses[least], off[least]


def _told(amounts: list[WrongAmount]) -> list[tuple[str, Mistake]]:
    """Return the message of each, and the mistake that it describes."""
    return [(wrong.line, wrong.mistake) for wrong in amounts]


def _without(way: Floats) -> Mistake:
    """Return a robot that has driven less by a way, (V, 3), which objects have rolled."""
    return Mistake(base=lambda base: Pose(base.t - way, base.R))


class _Way:
    """Path of the robot over V pictures.

    :param stamps: (V,) ascending [ns], at least two; poses: of the robot, t (V, 3), R (V, 3, 3).
    """

    def __init__(self, stamps: NDArray[np.int64], poses: Pose) -> None:
        self._seconds, self._poses = 1e-9 * (stamps - stamps[0]), poses
        self._stamps = stamps

    @cached_property
    def _turns(self) -> Slerp:
        return Slerp(self._seconds, Rotation.from_matrix(self._poses.R))

    def at(self, later: float) -> tuple[Pose, Bools]:
        """Return the poses at stamps shifted by later [s], and which are not extrapolated, (V,)."""
        if not later:
            return self._poses, np.ones(len(self._stamps), bool)
        wanted = self._stamps + round(later * NANOSECONDS)
        inside = np.clip(wanted, self._stamps[0], self._stamps[-1])
        at = 1e-9 * (inside - self._stamps[0])
        t = np.stack([np.interp(at, self._seconds, axis) for axis in self._poses.t.T], axis=1)
        return Pose(t, self._turns(at).as_matrix()), inside == wanted
