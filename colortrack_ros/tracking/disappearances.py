"""Disappearances: where lost objects have reappeared, and where they have not."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.estimation.existence import HIDDEN_SHARE
from colortrack_ros.estimation.existence import weigh_hidden
from colortrack_ros.estimation.records import Records

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

REMEMBERED = 200
"""Number of recent disappearances that are kept: at one a second, those of three minutes."""

BESIDE = 30.0
"""Width of the kernel around each disappearance [px]: its weight is 61 % there. Assumed."""

ANYWHERE_WEIGHT = 2.0
"""Number of disappearances of each kind that count as anywhere in the picture. Assumed."""

OWN_SHARE = 0.4
"""Share of the objects lost by a network that are hidden, and not second tracks of other objects.
Assumed: with two detectors, 0.34 and 0.33 of the coasting tracks of pedestrians are on somebody who
has no other track. With 0.2 and 0.8, IDF1 of all published tracks is 0.1 and 2 points lower."""


class Disappearances:
    """Learns what became of lost tracks."""

    def __init__(self) -> None:
        self._place = np.zeros((0, 2))
        self._returned = np.zeros(0)

    def learn(self, place: Floats, *, returned: bool) -> None:
        """Add tracks that have reappeared, or have not before their deletion.

        :param place: (K, 2) where each was last measured before [px].
        """
        if not len(place):
            return
        self._place = np.concatenate([self._place, place])[-REMEMBERED:]
        some = np.full(len(place), float(returned))
        self._returned = np.concatenate([self._returned, some])[-REMEMBERED:]

    def share(self, place: Floats, area: float, lost: Floats | None = None) -> Floats:
        """Probability, (K,), that each lost object is hidden rather than gone.

        By the densities of both kinds, each a sum of kernels and a uniform part: an occluder hides
        whatever passes there, again and again; where none is known, objects that reappeared
        elsewhere say little.

        :param place: (K, 2) where each was last measured [px].
        :param area: of the picture [px^2].
        :param lost: (K, 2) probabilities so far that each is hidden, and gone, if they are to
            count as evidence for each other; else None.
        """
        lost = np.zeros((len(place), 2)) if lost is None else lost
        known = np.concatenate([np.stack([self._returned, 1 - self._returned], axis=1), lost])
        every = np.concatenate([self._place, place])
        d2 = ((place[:, None] - every) ** 2).sum(axis=2) / BESIDE**2
        weight = np.exp(-d2 / 2) / (2 * np.pi * BESIDE**2)
        np.fill_diagonal(weight[:, len(self._place) :], 0.0)
        count = known.sum(axis=0) - lost
        share = np.array([HIDDEN_SHARE, 1 - HIDDEN_SHARE])
        density = weight @ known + ANYWHERE_WEIGHT * (count + share) / (count + 1) / area
        return np.asarray(density[:, 0] / density.sum(axis=1))

    def existence(self, records: Records, area: float, *, finds_whole: bool) -> Floats:
        """Probabilities of existence, (N,), given what seems to have become of all lost objects.

        If none of several has reappeared yet, that says more with every frame, long before they are
        deleted (expectation maximization, Dempster, Laird and Rubin 1977, one step a frame).

        :param records: (N,) of all tracks, see records.FIELDS.
        :param area: of the picture [px^2].
        :param finds_whole: see Adaptation.
        """
        visible, hidden = records['visible'], records['hidden']
        existence = visible + hidden
        lost = (records['state'] == COASTING).nonzero()[0]
        if len(lost):
            lost = lost[(records['hidden_share'][lost] > 0) & ~records['outside'][lost]]
            lost = lost[records['updated'][lost].argsort(kind='stable')[-REMEMBERED:]]
            visible, hidden, at_loss = visible[lost], hidden[lost], records['hidden_share'][lost]
            seen, unseen = weigh_hidden(visible, hidden, records['believed_share'][lost], at_loss)
            kinds = np.stack([unseen, np.maximum(1 - seen - unseen, 0.0)], axis=1)
            share = self.share(records['seen'][lost], area, kinds)
            records['believed_share'][lost] = share
            seen, unseen = weigh_hidden(visible, hidden, share, at_loss)
            existence[lost] = seen + unseen * (OWN_SHARE if finds_whole else 1.0)
        return existence
