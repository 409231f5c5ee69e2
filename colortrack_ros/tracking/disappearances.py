"""Disappearances: where lost objects have reappeared, after how long, and where they have not."""

from collections.abc import Callable
import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import COASTING
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.existence import DISAPPEARING
from colortrack_ros.estimation.existence import HIDDEN_SHARE
from colortrack_ros.estimation.existence import weigh_hidden
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.estimation.records import Records
from colortrack_ros.tracking.flicker import are_seldom
from colortrack_ros.tracking.flicker import Flicker
from colortrack_ros.tracking.flicker import TELLING_HITS
from colortrack_ros.tracking.traffic import share_staying

REMEMBERED = 200
"""Number of recent disappearances that are kept: at one a second, those of three minutes."""

LOST = 4.5
"""Frames after which an object was hidden rather than missed: with 95 % detected, four misses in a
row happen once in 160,000."""

BESIDE = 45.0
"""Width of the kernel around each disappearance [px]: its weight is 61 % there. Assumed."""

ANYWHERE_WEIGHT = 2.0
"""Number of disappearances of each kind that count as anywhere in the picture. Assumed."""

FIRST_SHARES = np.array([HIDDEN_SHARE, 1 - HIDDEN_SHARE])
"""Of both kinds, hidden and gone, before any is known."""

PRIOR_COUNT, PRIOR_SPREAD = np.array([30.0, 2.0]), np.array([0.0, 1.0])
"""Weight of the prior on the share of each kind, hidden and gone, that may happen anywhere, and the
number of them that did. Assumed: what hides objects stays in its place."""

SPREAD_STEPS = 5
"""Steps of expectation maximization whenever something has disappeared. Assumed."""

FIRST_TIMES = 3.0
"""Times out of sight that the first guess of their median is worth. Assumed."""

OWN_SHARE = 0.4
"""Share of the objects lost by a network that are hidden, and not second tracks of other objects.
Assumed: with two detectors, 0.34 and 0.33 of the coasting tracks of pedestrians are on somebody who
has no other track. With 0.2 and 0.8, IDF1 of all published tracks is 0.1 and 2 points lower."""


class Disappearances:
    """Learns what became of lost tracks.

    :param longest: time that a track may coast [s]; the median of the times out of sight is a third
        of it to begin with.
    """

    def __init__(self, longest: float) -> None:
        self._first_log_median = math.log(max(longest, 1e-3) / 3)
        self._place, self._time = np.zeros((0, 2)), np.zeros(0)
        self._returned = np.zeros((0, 2), bool)
        self._kinds, self._spread = np.zeros((0, 2)), PRIOR_SPREAD / PRIOR_COUNT
        self._in_time, self._count = np.zeros((0, 2)), np.zeros(2)
        self._is_new, self._flicker = True, Flicker()

    @property
    def median(self) -> float:
        """Of the times that objects are out of sight before they reappear [s]."""
        known = np.log(self._time[self._returned[:, 0]])
        total = FIRST_TIMES * self._first_log_median + float(known.sum())
        return math.exp(total / (FIRST_TIMES + len(known)))

    def learn(self, place: Floats, time: Floats, *, returned: bool, in_time: bool = True) -> None:
        """Add tracks that have reappeared, or have not before their deletion.

        :param place: (K, 2) where each was last measured before [px].
        :param time: (K,) for which it was out of sight [s].
        :param in_time: whether those that have reappeared did so before their deletion.
        """
        if len(place):
            self._place = np.concatenate([self._place, place])[-REMEMBERED:]
            self._time = np.concatenate([self._time, time])[-REMEMBERED:]
            kind = np.repeat([[returned, returned and in_time]], len(place), axis=0)
            self._returned = np.concatenate([self._returned, kind])[-REMEMBERED:]
            self._is_new = True

    def rejoin(self, place: Floats, time: Floats, period: float, *, in_time: bool) -> None:
        """Add tracks that others continue, and which may have been deleted.

        Out of sight for no more than a few frames, they were missed by chance.

        :param place, time, in_time: see learn().
        :param period: of the frames [s].
        """
        left = self._returned[:, 0] | ~_is_one_of(self._place, place).any(axis=1)
        self._place, self._time = self._place[left], self._time[left]
        self._returned = self._returned[left]
        self._is_new = True
        hidden = time > LOST * period
        self.learn(place[hidden], time[hidden], returned=True, in_time=in_time)

    def share(
        self,
        place: Floats,
        area: float,
        lost: Floats | None = None,
        leaving: Floats | float = 0.0,
    ) -> Floats:
        """Probability, (K,), that each lost object is hidden and returns before it is deleted.

        By the densities of both kinds, each a sum of kernels and a uniform part: an occluder hides
        whatever passes there, again and again; where none is known, objects that reappeared
        elsewhere say little, unless many did so anywhere.

        :param place: (K, 2) where each was last measured [px].
        :param area: of the picture [px^2].
        :param lost: (K, 2) probabilities so far that each is hidden, and gone, if they are to
            count as evidence for each other; else None.
        :param leaving: (K,) see traffic.leaving_rate().
        """
        if self._is_new:
            self._conclude(area)
        lost = np.zeros((len(place), 2)) if lost is None else lost
        near = _kernel(place, self._place) @ self._in_time
        if np.count_nonzero(lost):
            beside = _kernel(place, place)
            np.fill_diagonal(beside, 0.0)
            near += beside @ lost
        count = self._count + lost.sum(axis=0) - lost
        return share_staying(_share(near, count, self._spread, area), leaving)

    def share_of_deleted(self, place: Floats, area: float, leaving: Floats | float = 0.0) -> Floats:
        """The same, (K,), for tracks that have been deleted, and of ever being seen again.

        :param place, area, leaving: see share().
        """
        if self._is_new:
            self._conclude(area)
        weight = _kernel(place, self._place)
        own = ~self._returned[:, 0] & _is_one_of(place, self._place)
        weight[own] = 0.0
        share = _share(weight @ self._kinds, ~own @ self._kinds, self._spread, area)
        return share_staying(share, leaving)

    def _conclude(self, area: float) -> None:
        """Estimate which of the deleted tracks are hidden still, and what appears anywhere.

        What hides behind covers disappears near others that did. By expectation maximization, each
        disappearance judged by all others.
        """
        self._is_new, returned, spread = False, self._returned[:, 0], np.full(2, 0.5)
        weight = _kernel(self._place, self._place)
        np.fill_diagonal(weight, 0.0)
        kinds = np.stack([returned, ~returned], axis=1).astype(float)
        still = self.still_hidden(self._time)
        for _ in range(SPREAD_STEPS):
            near, count = weight @ kinds, kinds.sum(axis=0) - kinds
            share = _share(near, count, self._spread, area)
            hidden = share * still
            hidden /= hidden + 1 - share
            kinds[:, 0] = np.where(returned, 1.0, hidden)
            kinds[:, 1] = 1 - kinds[:, 0]
            uniform = spread * count / area
            alone = kinds * uniform / np.maximum(uniform + (1 - spread) * near, TINY)
            told = alone.sum(axis=0), kinds.sum(axis=0)
            spread = (1 + told[0]) / (2 + told[1])
            self._spread = (PRIOR_SPREAD + told[0]) / (PRIOR_COUNT + told[1])
        self._kinds, in_time = kinds, self._returned[:, 1]
        self._in_time = np.stack([in_time, ~in_time], axis=1).astype(float)
        self._count = self._in_time.sum(axis=0)

    def still_hidden(self, time: Floats) -> Floats:
        """Probability, (K,), that what is hidden has not come back within a time, (K,) [s].

        It is m / (m + t) of median m, which has no scale of its own: what has been hidden for long
        may stay so for as long again.
        """
        return np.asarray(self.median / (self.median + time))

    def return_odds(
        self, share: Floats, gap: Floats, T: Floats, detected: float, period: float
    ) -> Floats:
        """Odds, (K,), that lost objects appear just after a gap rather than are still out of sight.

        Either they were missed by chance in between, or they were hidden, and come back.

        :param share: (K,) of those lost there that are hidden.
        :param gap: (K,) from their last measurement to the first of what may be them [s].
        :param T: (K,) since their last measurement [s].
        :param detected: probability of detecting a visible object.
        :param period: of the frames [s].
        """
        gap = np.maximum(gap, period)
        lost = DISAPPEARING * period
        back = lost * share * (self.still_hidden(gap - period) - self.still_hidden(gap))
        away = lost * (share * self.still_hidden(T) + 1 - share)
        missed = detected * (1 - detected) ** (np.round(gap / period) - 1)
        return np.asarray((missed + back) / away)

    def existence(
        self,
        records: Records,
        area: float,
        now: int,
        period: float,
        detector: Callable[[], tuple[float, bool]],
    ) -> Floats:
        """Probabilities of existence, (N,), given what seems to have become of all lost objects.

        The records of those that are lost are updated. If none of several has reappeared yet, that
        says more with every frame, long before they are deleted (expectation maximization,
        Dempster, Laird and Rubin 1977, one step a frame).

        :param records: (N,) of all tracks, see records.FIELDS.
        :param area: of the picture [px^2].
        :param now: stamp of the last frame [ns].
        :param period: of the frames [s].
        :param detector: asked if something is lost, or seldom measured: probability of detecting a
            visible object, and whether it finds whole objects, see Adaptation.finds_whole.
        """
        existence: Floats = records['visible'] + records['hidden']
        doubted = records['state'] == COASTING
        if not (np.count_nonzero(records['misses']) or np.count_nonzero(doubted)):
            return existence
        detected, whole = detector()
        doubted |= are_seldom(records, whole=whole)
        if np.count_nonzero(doubted):
            self._weigh_lost(records, existence, area, OWN_SHARE if whole else 1.0)
            # What is found in most frames is shown when it is: the dim and the half covered ones
            # are found less often than others.
            track = (doubted & (records['state'] != TENTATIVE)).nonzero()[0]
            gap = (now - records['updated'][track]) / (period * NANOSECONDS)
            existence[track] *= 1 - self._flicker.chance(records, track, gap, detected, whole=whole)
        return existence

    def _weigh_lost(self, records: Records, existence: Floats, area: float, own: float) -> None:
        """Update the records of lost tracks and their existence, (N,), by what became of others.

        :param own: share of hidden objects that have no other track.
        """
        lost = (records['state'] == COASTING) & (records['hidden_share'] > 0) & ~records['outside']
        track = lost.nonzero()[0]
        if not track.size:
            return
        track = track[records['updated'][track].argsort(kind='stable')[-REMEMBERED:]]
        seen, unseen = records['visible'][track], records['hidden'][track]
        kinds = np.array([unseen, np.maximum(1 - seen - unseen, 0.0)])
        kinds *= records['hits'][track] >= TELLING_HITS
        place, leaving = records['seen'].take(track, axis=0), records['leaving'][track]
        share = self.share(place, area, kinds.T.copy(), leaving)
        seen, unseen = weigh_hidden(seen, unseen, share, records['hidden_share'][track])
        for name, values in (('visible', seen), ('hidden', unseen), ('hidden_share', share)):
            records[name][track] = values
        existence[track] = seen + unseen * own


def _kernel(one: Floats, other: Floats) -> Floats:
    """Density, (K, M) [1/px^2], of a disappearance at one, (K, 2), by those at other, (M, 2)."""
    u, v = one[:, :1] - other[:, 0], one[:, 1:] - other[:, 1]
    d2 = (u * u + v * v) / BESIDE**2
    return np.asarray(np.exp(-d2 / 2) / (2 * np.pi * BESIDE**2))


def _is_one_of(one: Floats, other: Floats) -> Bools:
    """Which places, (K, 2), are which of others, (M, 2), to the bit: (K, M)."""
    return np.asarray((one[:, None] == other).all(axis=2))


def _share(near: Floats, count: Floats, spread: Floats, area: float) -> Floats:
    """Probability, (K,), of the first of two kinds.

    :param near: (K, 2) density of kernels of each kind [1/px^2].
    :param count: (K, 2) number of each kind.
    :param spread: (2,) share of each kind that may be anywhere.
    :param area: of the picture [px^2].
    """
    uniform = ANYWHERE_WEIGHT * (count + FIRST_SHARES) / (count + 1) + spread * count
    density = (1 - spread) * near + uniform / area
    return np.asarray(density[:, 0] / density.sum(axis=1))
