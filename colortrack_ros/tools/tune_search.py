"""The search of ``tune``: parameters with their ranges, and differential evolution."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import math
from typing import Any
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.tracking import TrackerConfig

LEARNED_SHARE = 0.15
"""Share of a slider that means 0: the detector or the tracker learns the value. Assumed: one in
seven random candidates tries it; with half and twice the value one in 13 and one in 3."""

POPULATION = 12
"""Candidates in a generation, twice the number of parameters of one color; half of the first
generation is near the current values."""

START_SPREAD = 0.15
"""Standard deviation of these around the current values, in shares of a slider. Assumed: 95 % of
them lie within a third of a slider; with half of it within a sixth, with twice as much nearly
anywhere."""

LEAST_WORTH = 0.002
"""A parameter whose change improves the score by less is reset: it would be fitted to chance.
Assumed; it is a change of one frame in 500."""

Values = dict[tuple[str, str], Any]
"""Values by node and name of the parameter."""


class Slider(NamedTuple):
    """A parameter and its range.

    :param node: that has it.
    :param low, high: the sensible range; if low is above 0, the scale is logarithmic.
    :param start: the current value.
    :param learned: whether 0 means that the value is learned.
    :param odd: whether only odd numbers are valid, as for sizes of structuring elements.
    """

    node: str
    name: str
    low: float
    high: float
    start: Any
    learned: bool = False
    odd: bool = False

    def value(self, place: float) -> Any:
        """The value at a position, 0..1, rounded to two digits, the resolution of such a search."""
        if self.learned:
            if place < LEARNED_SHARE:
                return 0.0
            place = (place - LEARNED_SHARE) / (1 - LEARNED_SHARE)
        if self.low > 0:
            value = self.low * (self.high / self.low) ** place
        else:
            value = self.low + (self.high - self.low) * place
        if isinstance(self.start, tuple):  # half axes of a color, all scaled by the same factor
            return [float(f'{axis * value:.2g}') for axis in self.start]
        if self.odd:
            return 2 * round((value - 1) / 2) + 1
        return round(value) if isinstance(self.start, int) else float(f'{value:.2g}')

    @property
    def place(self) -> float:
        """The position of the current value."""
        value = 1.0 if isinstance(self.start, tuple) else float(self.start)
        if self.learned and value == 0:
            return LEARNED_SHARE / 2
        value = min(max(value, self.low), self.high)
        if self.low > 0:
            place = math.log(value / self.low) / math.log(self.high / self.low)
        else:
            place = (value - self.low) / (self.high - self.low)
        return LEARNED_SHARE + (1 - LEARNED_SHARE) * place if self.learned else place

    def is_at_bound(self, value: Any) -> bool:
        """Whether the value is at the end of the range."""
        return value in (self.value(1.0), self.value(LEARNED_SHARE if self.learned else 0.0))


def sliders_of(detector: DetectorConfig, tracker: TrackerConfig) -> Iterator[Slider]:
    """The sliders of the tuner that affect detections and identities."""
    for color in detector.colors:
        yield _slider_of(color)
    largest = min(4000, detector.max_area)
    yield Slider('detector', 'min_area', min(4, largest), largest, detector.min_area)
    for name, high in (('erosion_size', 7), ('closing_size', 21)):
        yield Slider('detector', name, 1, high, getattr(detector, name), odd=True)
    yield Slider('tracker', 'process_noise', 100.0, 1e5, tracker.process_noise, learned=True)
    limit = tracker.max_time_since_update
    yield Slider('tracker', 'max_time_since_update', 0.1, 5.0, limit)
    yield Slider('tracker', 'min_score', 0.0, 0.95, tracker.min_score)


def _slider_of(color: ReferenceColor) -> Slider:
    if color.tolerance_lab:
        return Slider('detector', f'{color.name}.tolerance_lab', 0.4, 2.5, color.tolerance_lab)
    name = f'{color.name}.tolerance'
    return Slider('detector', name, 8.0, 100.0, color.tolerance, learned=not color.is_sampled)


Judge = Callable[[Sequence[Values]], Sequence[float]]
"""Returns the scores of candidates; higher is better."""


def search(sliders: Sequence[Slider], judge: Judge, trials: int, seed: int) -> Values:
    """The best values found, for all sliders. :param trials:

    approximate number of candidates.
    """
    rng = np.random.default_rng(seed)
    start = np.array([slider.place for slider in sliders])
    first = rng.random((POPULATION, len(sliders)))
    near = POPULATION // 2
    first[:near] = start + START_SPREAD * rng.standard_normal((near, len(sliders)))
    first[0] = start

    def losses(_: object, places: NDArray[np.float64]) -> list[float]:
        return [-good for good in judge([values_at(sliders, place) for place in places])]

    result = differential_evolution(
        lambda place: losses(None, place[None])[0],
        [(0.0, 1.0)] * len(sliders),
        init=np.clip(first, 0.0, 1.0),
        maxiter=max(round(trials / POPULATION) - 1, 1),
        tol=0.0,
        polish=False,
        updating='deferred',
        workers=losses,
        seed=seed,
    )
    return values_at(sliders, result.x)


def values_at(sliders: Sequence[Slider], places: NDArray[np.float64]) -> Values:
    """The values at the positions."""
    pairs = zip(sliders, places.tolist(), strict=True)
    return {(slider.node, slider.name): slider.value(place) for slider, place in pairs}


def pruned(values: Values, judge: Judge) -> tuple[Values, dict[tuple[str, str], float]]:
    """The changes that are worth it, and what each gains; those that gain least are removed
    first.
    """
    kept = dict(values)
    while kept:
        without = [{k: v for k, v in kept.items() if k != name} for name in kept]
        whole, *parts = judge([kept, *without])
        worth = dict(zip(kept, (whole - part for part in parts), strict=True))
        least = min(worth, key=lambda name: worth[name])
        if worth[least] >= LEAST_WORTH:
            return kept, worth
        del kept[least]
    return {}, {}


def changed(values: Values, sliders: Sequence[Slider]) -> Values:
    """The values without those that are unchanged."""
    before: Mapping[tuple[str, str], Any] = {(s.node, s.name): s.start for s in sliders}
    return {name: value for name, value in values.items() if value != before[name]}
