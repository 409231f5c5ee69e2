"""What ``tune`` searches: parameters with their ranges, by differential evolution."""

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
"""Share of a slider where 0 stands: what the detector or the tracker finds out by itself. Assumed:
one candidate in seven that is drawn at random tries it, with half and twice the value one in 13 and
in 3."""

POPULATION = 12
"""Candidates of a generation, twice the parameters of one color; half of the first is near what is
there already."""

START_SPREAD = 0.15
"""Standard deviation of these around it, in shares of a slider. Assumed: 95 % of them lie within a
third of a slider, with half within a sixth, with twice as much nearly anywhere."""

LEAST_WORTH = 0.002
"""A parameter whose change brings less goes back to what it was: it would be fitted to chance."""

Values = dict[tuple[str, str], Any]
"""By node and name of the parameter."""


class Slider(NamedTuple):
    """A parameter and its range.

    :param node: whose it is.
    :param low, high: where it makes sense; low above 0: in equal ratios.
    :param start: what is there already.
    :param learned: whether 0 stands for what is found out.
    :param odd: whether only odd numbers are: sizes of structuring elements.
    """

    node: str
    name: str
    low: float
    high: float
    start: Any
    learned: bool = False
    odd: bool = False

    def value(self, place: float) -> Any:
        """What a place, 0..1, stands for; two digits, which is what such a search can tell."""
        if self.learned:
            if place < LEARNED_SHARE:
                return 0.0
            place = (place - LEARNED_SHARE) / (1 - LEARNED_SHARE)
        if self.low > 0:
            value = self.low * (self.high / self.low) ** place
        else:
            value = self.low + (self.high - self.low) * place
        if isinstance(self.start, tuple):  # half axes of a color, all by the same factor
            return [float(f'{axis * value:.2g}') for axis in self.start]
        if self.odd:
            return 2 * round((value - 1) / 2) + 1
        return round(value) if isinstance(self.start, int) else float(f'{value:.2g}')

    @property
    def place(self) -> float:
        """Of what is there already."""
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
        """Whether it would go on if its range did."""
        return value in (self.value(1.0), self.value(LEARNED_SHARE if self.learned else 0.0))


def sliders_of(detector: DetectorConfig, tracker: TrackerConfig) -> Iterator[Slider]:
    """Those of the tuner that change what is found and who is who."""
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
"""How good each of some candidates is; more is better."""


def search(sliders: Sequence[Slider], judge: Judge, trials: int, seed: int) -> Values:
    """The best values found: of all sliders.

    :param trials: candidates that are judged, about.
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
    """What the places stand for."""
    pairs = zip(sliders, places.tolist(), strict=True)
    return {(slider.node, slider.name): slider.value(place) for slider, place in pairs}


def pruned(values: Values, judge: Judge) -> tuple[Values, dict[tuple[str, str], float]]:
    """Those that are worth it, and what each brings: those that bring least go first."""
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
    """Without those that are what they were."""
    before: Mapping[tuple[str, str], Any] = {(s.node, s.name): s.start for s in sliders}
    return {name: value for name, value in values.items() if value != before[name]}
