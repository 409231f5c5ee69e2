"""One color given by its name: which color it is in the pictures, from look to look."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.extent import measure
from colortrack_ros.detection.extent import pixels_near
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.named import ALL_OF_ITS_HUES
from colortrack_ros.detection.named import are_free
from colortrack_ros.detection.named import assess
from colortrack_ros.detection.named import candidates
from colortrack_ros.detection.named import Choice
from colortrack_ros.detection.named import choose
from colortrack_ros.detection.named import TYPICAL
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.shade_follower import ShadeFollower
from colortrack_ros.detection.sought_color import FEWEST_LEFT
from colortrack_ros.detection.sought_color import SoughtColor
from colortrack_ros.detection.strangers import Strangers

AWAY_SECONDS = 5.0
"""Time after which a thing that is not seen makes way for another of the same name [s]. Assumed:
what something hides is back by then."""


class NamedColor(SoughtColor):
    """Estimates which color is meant by a name, and its tolerance.

    :param color: as configured, with a preset.
    """

    def __init__(self, color: ReferenceColor) -> None:
        super().__init__(color)
        self._choice: Choice | None = None
        self._rank, self._seen = 0, 0

    def read(self, cells: NDArray[np.uint16], counts: NDArray[np.float64], is_due: bool) -> float:
        """Choose what a picture shows by the name, before it is sought there.

        :param cells, counts, is_due: as for :meth:`SoughtColor.read`.
        :returns: how far that is from what is meant; infinite if nothing shows it.
        """
        reach = ALL_OF_ITS_HUES if is_due else TYPICAL
        find = partial(self._find, counts)
        self._choice = choose(cells, counts, self.color, self.taken, find, reach=reach)
        if self._choice is None:
            return np.inf
        self.color = replace(self.color, lab=self._choice.lab)
        return self._choice.misfit

    def seek(self, counts: NDArray[np.float64], stamp: int) -> bool:
        """See :meth:`SoughtColor.seek`: what read() has chosen."""
        if (choice := self._choice) is None:  # what the name is typical of may be another's color
            return bool(self.color.samples) and super().seek(counts, stamp)
        self._rank, self._seen = choice.rank, stamp
        return self._start(choice.extent, stamp)

    def is_in(self, counts: NDArray[np.float64]) -> bool:
        """See :meth:`SoughtColor.is_in`."""
        return self._choice is not None

    def is_crossed(self) -> bool:
        """See :meth:`SoughtColor.is_crossed`: whether it is another's by now, or includes one."""
        if (choice := self._choice) is None:
            return False
        is_free = are_free(np.array([choice.lab]), self.taken)[0]
        extent = choice.extent
        return not is_free or bool(extent and _is_one_of(extent.lab, self.apart, extent.axes))

    def outshone(self, cells: NDArray[np.uint16], now: NDArray[np.float64], stamp: int) -> float:
        """Choose another color of its name if that is more likely to be what is meant.

        :param cells, now: as for :meth:`SoughtColor.outshone`.
        :returns: how far that is from what is meant; infinite if there is none.
        """
        self._choice = self._outshining(cells, now, stamp)
        return np.inf if self._choice is None else self._choice.misfit

    def goes_over(self, stamp: int) -> bool:
        """See :meth:`SoughtColor.goes_over`: to what outshone() has chosen."""
        if (choice := self._choice) is None:
            return False
        self.color = replace(self.color, lab=choice.lab)
        self._strangers, self._shades = Strangers(), ShadeFollower()
        self._rank, self._seen = choice.rank, stamp
        return self._start(choice.extent, stamp)

    def _outshining(
        self, cells: NDArray[np.uint16], now: NDArray[np.float64], stamp: int
    ) -> Choice | None:
        """A color of higher rank, or of which there is far more, or any if the known is gone."""
        known = self.found
        assert known is not None
        if measure(now, known).pixels > FEWEST_LEFT * known.pixels or stamp < self._seen:
            self._seen = stamp
        is_gone = stamp - self._seen > AWAY_SECONDS * NANOSECONDS
        reach = TYPICAL if self._rank == 2 and not is_gone else ALL_OF_ITS_HUES
        for lab, misfit in candidates(now, self.color.preset, self.taken, reach=reach):
            is_own, highest = self._is_own(lab), 2 if misfit < 1 else 1
            is_more = is_gone or pixels_near(now, lab) > known.pixels / FEWEST_LEFT
            if highest > self._rank or (is_more and not is_own):
                extent = known if is_own else self._find(now, lab)
                choice = assess(cells, now, self.color, lab, misfit, extent)
                if is_own:
                    self._rank = max(self._rank, choice.rank)
                elif choice.extent and (
                    is_gone
                    or choice.rank > self._rank
                    or (is_more and choice.rank == self._rank > 0)
                ):
                    return choice
            if is_own and self._rank >= highest:
                return None
        return None

    def _is_own(self, lab: Triple) -> bool:
        """Whether a color is within what is known of this one."""
        assert self.found is not None
        whole = self._shades.whole(self.found)
        return _is_one_of(lab, (whole.lab, *(self._shades.shades or ())), whole.axes)


def _is_one_of(lab: Triple, colors: Sequence[Triple], axes: Triple) -> bool:
    """Whether a color is within an ellipsoid with these axes around any of some colors."""
    return bool(nearest_sample(np.array([lab]), colors, np.array(axes))[0] < 1)
