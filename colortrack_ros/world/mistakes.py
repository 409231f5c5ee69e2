"""Whether what is seen would stand if the camera were mounted otherwise, as by a common mistake.

A camera that is upside down, that looks elsewhere, or has the calibration of another picture gives
places that move whenever the robot does. Each mistake is tried on the pictures of the last seconds:
where one of them makes half of what they show stand, and the given pose of the camera nothing, it
has been made. What really moves stands by none of them, so nothing has to be known of the objects
but what gives their range. If some are said to stand, only they are looked at; what falls never is.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import ranges_by_size
from colortrack_ros.world.measurement import U
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View
from colortrack_ros.world.wrong_setups import AS_GIVEN
from colortrack_ros.world.wrong_setups import as_given
from colortrack_ros.world.wrong_setups import Mistake
from colortrack_ros.world.wrong_setups import MISTAKES
from colortrack_ros.world.wrong_setups import OF_ABOUT
from colortrack_ros.world.wrong_setups import pitched
from colortrack_ros.world.wrong_setups import WRONG_ANGLES

Floats = NDArray[np.float64]
BETWEEN, LOOKS_BACK = 0.2, 4.0
"""Time between the pictures that are looked at, and how long they are kept [s]: at 0.5 m/s a robot
drives 2 m in it. Chosen."""

LEAST_SEEN = 8
"""Pictures that must show an object: 1.6 s of the 4. Chosen."""

AT_REST = 0.025
"""Spread of the places of what stands, as a share of its distance. By the ground it is 0.011 for
0.5 px at 2.5 to 5 m from a camera 0.5 m high that drives, and more if its pitch is off by a degree
or two; by sizes and depths 0.002."""

WORSE, LEAST = 10.0, 0.05
"""How many times as much the places by the given pose must spread, and how much at least: by the
mistakes of the list they spread 0.1 to 0.8. Of what rolls, seen by right cameras, 5 times has been
seen by chance in 4 of 60 runs of 10 s, 10 times in none of 240."""

WORSE_OF_SEVERAL, LEAST_OF_SEVERAL = 6.0, 0.03
"""The same where two objects and more say so alike. Of 540 runs of 12 s with right cameras 2
were told to be wrong, with 4.0 and more kinds of mistakes 7. Chosen."""

PITCHES_AS_EXPECTED = 5
"""Pitches within 2 standard deviations at which the given pose is looked at: what is that much off
is no mistake. Chosen."""

AGREEING = 3
"""Successive pictures that must say the same. Chosen."""

UNSEEN = 10**18
"""Before the first picture [ns]."""


@dataclass
class _Sights(Columns):
    """What pictures have shown, one row for each object in each.

    :ivar stamp: (M,) of the picture [ns].
    :ivar track: (M,) IDs.
    :ivar measured, kinds: of each.
    :ivar rays: (M, 3) in the optical frame.
    :ivar far: (M,) along the ray, by depth or size [m]; NaN where the ground tells it.
    """

    stamp: NDArray[np.int64]
    track: NDArray[np.int64]
    measured: Measured
    kinds: Kinds
    rays: Floats
    far: Floats

    @classmethod
    def of(
        cls, stamp: int, track: NDArray[np.uint32], measured: Measured, kinds: Kinds, view: View
    ) -> '_Sights':
        """Those of one picture."""
        seen = measured.used[:, U]
        measured, kinds = measured.take(seen), kinds.take(seen)
        rays, far = _rays(measured, kinds, view.camera)
        stamps = np.full(len(rays), stamp, np.int64)
        return cls(stamps, track[seen].astype(np.int64), measured, kinds, rays, far)


def _rays(measured: Measured, kinds: Kinds, camera: CameraModel) -> tuple[Floats, Floats]:
    """The rays of what a camera has measured, and how far along them: see :class:`_Sights`."""
    rays, far = camera.rays(measured.z[:, :2]), np.full(len(kinds), np.nan)
    sized = measured.used[:, BLOB] & ~measured.used[:, PLANE]
    if sized.any():
        by_size = ranges_by_size(camera, rays, measured.z[:, BLOB], kinds.diameter)
        far[sized] = by_size[sized]
    return rays, np.where(measured.used[:, DEPTH], measured.z[:, DEPTH] / rays[:, 2], far)


@dataclass(frozen=True)
class _Needed:
    """How much has to speak for a mistake.

    :ivar objects: as many must stand by it.
    :ivar worse, least: how many times as much these must spread by the given pose, and how much.
    :ivar any_turn: whether it may be a turn by any angle.
    """

    objects: int
    worse: float
    least: float
    any_turn: bool

    @classmethod
    def of(cls, kinds: Kinds, count: int) -> '_Needed':
        """Half of so many objects; one of them is not enough if they may move."""
        may_move = bool(kinds.speed.any())
        if count == 1:
            return cls(1, WORSE, LEAST, not may_move)
        return cls(max((count + 1) // 2, 1 + may_move), WORSE_OF_SEVERAL, LEAST_OF_SEVERAL, True)

    def most(self, spreads: Floats) -> Floats:
        """How much as many objects spread at most, (...), of what all do, (..., K)."""
        return np.asarray(np.sort(spreads, axis=-1)[..., self.objects - 1])

    def met(self, given: Floats, spreads: Floats) -> bool:
        """Whether so many objects stand by a mistake and not by the given pose; (K,) each."""
        stands = (spreads < AT_REST) & (given > self.least) & (given > self.worse * spreads)
        return bool(np.count_nonzero(stands) >= self.objects)


class Mistakes:
    """Watches the pictures of one camera for a mistake.

    :param pitch_sigma: of the camera [degrees]: by that much it may be off, and is estimated.
    """

    def __init__(self, pitch_sigma: float) -> None:
        self._views: dict[int, View] = {}
        self._expected = [
            pitched(share * pitch_sigma) for share in np.linspace(-2, 2, PITCHES_AS_EXPECTED)
        ]
        self._sights: _Sights | None = None
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
        last = max(self._views, default=stamp - UNSEEN)
        if 0 <= stamp - last < BETWEEN * NANOSECONDS:
            return
        new = _Sights.of(stamp, tracks, measured, kinds, view)
        self._judge(self._take(stamp, view, new), ground)

    def _take(self, stamp: int, view: View, new: _Sights) -> _Sights:
        """Keep what a picture shows, and forget what is old."""
        if self._sights is None or stamp < max(self._views):
            self._sights, self._views = new, {}
        else:
            self._sights.extend(new)
        since = stamp - round(LOOKS_BACK * NANOSECONDS)
        self._views = {stamp: view for stamp, view in self._views.items() if stamp > since} | {
            stamp: view
        }
        self._sights.keep(self._sights.stamp > since)
        return self._sights

    def _judge(self, sights: _Sights, ground: float) -> None:
        """Find the mistake that explains what moves, or that it no longer does."""
        sights = _telling(sights)
        if not len(sights):
            return
        (given,) = self._spreads(sights, [AS_GIVEN], ground)
        needed = _Needed.of(sights.kinds, len(given))
        spread = needed.most(given)
        if self.made:
            (other,) = self._spreads(sights, [self._mistake], ground)
            if spread < AT_REST and needed.most(other) > WORSE * spread:
                self.made = ''
        elif given.min() > AT_REST and spread > needed.least:
            self._suspect(sights, needed, ground)

    def _suspect(self, sights: _Sights, needed: _Needed, ground: float) -> None:
        """Look which mistake makes things stand, and note it once that has been so for a while."""
        given = self._spreads(sights, self._expected, ground).min(axis=0)
        line, mistake, spreads = self._likeliest(sights, needed, ground)
        fits = needed.met(given, spreads)
        which = line.split(OF_ABOUT)[0]
        self._looks = self._looks + 1 if fits and which == self._suspected else int(fits)
        self._suspected = which
        if self._looks >= AGREEING:
            self.made, self._mistake = line, mistake

    def _likeliest(
        self, sights: _Sights, needed: _Needed, ground: float
    ) -> tuple[str, Mistake, Floats]:
        """The mistake by which things spread least, what is told of it, and the spreads, (K,)."""
        found = list(MISTAKES.items())
        if needed.any_turn:
            each = [turn for family in WRONG_ANGLES for turn in family.coarse()]
            spreads = needed.most(self._spreads(sights, [t.mistake for t in each], ground))
            best = each[int(np.argmin(spreads))]
            found += [(turn.line, turn.mistake) for turn in best.around()]
        all_spreads = self._spreads(sights, [mistake for _, mistake in found], ground)
        least = int(np.argmin(needed.most(all_spreads)))
        return *found[least], all_spreads[least]

    def _spreads(self, sights: _Sights, mistakes: list[Mistake], ground: float) -> Floats:
        """How much places move if a mistake is made, as a share of their distance: (C, K).

        Infinite if they would be nowhere.

        :param sights: (M,), those of one object after those of another.
        """
        views = list(self._views.values())
        base, mount = (
            Pose(*(np.stack([getattr(getattr(v, of), name) for v in views]) for name in 'tR'))
            for of in ('base', 'mount')
        )
        picture = np.searchsorted(list(self._views), sights.stamp)
        optical = [m.base(base) @ (m.mount(mount) @ OPTICAL) for m in mistakes]
        eyes, R = (np.stack([getattr(o, name) for o in optical])[:, picture] for name in 'tR')
        rays, far = np.stack([sights.rays] * len(R)), np.stack([sights.far] * len(R))
        for row, mistake in enumerate(mistakes):
            if mistake.camera is not as_given:
                camera = mistake.camera(views[-1].camera)
                rays[row], far[row] = _rays(sights.measured, sights.kinds, camera)
        way = (R @ rays[..., None])[..., 0]
        with np.errstate(divide='ignore', invalid='ignore'):
            by_plane = (ground + sights.kinds.height - eyes[..., 2]) / way[..., 2]
        far = np.where(np.isnan(far), by_plane, far)
        far = np.where(far > 0, far, np.nan)
        moved = _spread_of_each(eyes + way * far[..., None], far, sights.track)
        return np.asarray(np.nan_to_num(moved, nan=np.inf))


def _telling(sights: _Sights) -> _Sights:
    """Those of objects that have been seen often, and may stand; only known ones if there are any.

    Those of one object after those of another.
    """
    sights = sights.take(~sights.kinds.falls)
    _, of, count = np.unique(sights.track, return_inverse=True, return_counts=True)
    order = np.argsort(of, kind='stable')
    sights = sights.take(order[count[of[order]] >= LEAST_SEEN])
    known = np.asarray(~sights.kinds.speed.any(axis=1))
    return sights.take(known) if known.any() else sights


def _spread_of_each(places: Floats, far: Floats, track: NDArray[np.int64]) -> Floats:
    """Root mean square of the distances of places from their mean, over that from the camera.

    :param places: (C, M, 3); far: (C, M).
    :param track: (M,) the object of each, those of one after those of another.
    :return: (C, K) of each object.
    """
    first = np.flatnonzero(np.append(True, track[1:] != track[:-1]))
    count = np.diff(np.append(first, len(track)))
    mean = np.add.reduceat(places, first, axis=1) / count[:, None]
    away = np.square(places - np.repeat(mean, count, axis=1)).sum(axis=-1)
    spread = np.sqrt(np.add.reduceat(away, first, axis=1) / count)
    return np.asarray(spread * count / np.add.reduceat(far, first, axis=1))
