"""Selection of the target among the objects."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Locations
from colortrack_ros.data import TENTATIVE

RULES = ('nearest', 'largest', 'oldest', 'most_certain')

BETTER = 0.8
"""Another object becomes the target if its cost is below this share, say if it is a fifth nearer,
so that two similar objects do not alternate. Assumed."""

MOST_DIGITS = 10
"""Length of the greatest track_id, 2^32 - 1, in digits."""


def rule_of(text: str, colors: list[str]) -> str:
    """Return the text if it is a rule, a color, or an ID.

    :raises ValueError: it is none of these.
    """
    if text not in RULES and text not in colors and not _is_id(text):
        raise ValueError(
            f'select: expected one of {", ".join((*RULES, *colors))}, or a track_id, got {text!r}'
        )
    return text


def _is_id(text: str) -> bool:
    # not isdigit: it takes superscripts, too
    return text.isdecimal() and len(text) <= MOST_DIGITS


class Selector:
    """Selects one object per message, and keeps it unless another is clearly better.

    :param rule: see :func:`rule_of`.
    :param colors: names of the colors.
    """

    def __init__(self, rule: str, colors: list[str]) -> None:
        self._rule, self._colors, self._last = rule_of(rule, colors), colors, 0

    def choose(self, locations: Locations, robot: Floats) -> int | None:
        """Return the row of the target, None if there is none.

        :param robot: (3,) position of the robot in the same frame [m].
        """
        rows = locations.rows
        fits = rows['state'] != TENTATIVE
        if _is_id(self._rule):
            fits &= rows['track_id'] == int(self._rule)
        elif self._rule in self._colors:
            fits &= rows['color'] == self._colors.index(self._rule)
        (candidates,) = fits.nonzero()
        if not len(candidates):
            return None
        cost = self._costs()(rows[candidates], robot)
        best = candidates[cost.argmin()]
        (same,) = (rows['track_id'][candidates] == self._last).nonzero()
        if len(same) and cost.min() > BETTER * cost[same[0]]:
            best = candidates[same[0]]
        self._last = int(rows['track_id'][best])
        return int(best)

    def _costs(self) -> Callable[[NDArray[np.void], Floats], Floats]:
        """Return the cost function of the rule; the target has the least cost."""
        if self._rule == 'largest':
            return lambda rows, _: 1 / np.maximum(rows['diameter'], 1e-3)
        if self._rule == 'oldest':
            return lambda rows, _: rows['track_id'].astype(float)
        if self._rule == 'most_certain':
            return lambda rows, _: np.trace(rows['covariance'][:, :3, :3], axis1=1, axis2=2)
        return lambda rows, robot: np.hypot(rows['x'] - robot[0], rows['y'] - robot[1])
