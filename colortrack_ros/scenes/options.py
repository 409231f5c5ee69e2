"""The options of every scene, and how `NAME?width=640&noise=0` is parsed."""

from dataclasses import dataclass
from fractions import Fraction
import math

OPTION_LIMITS = {
    'width': (16, 7680),
    'height': (16, 4320),
    'rate': (1.0, 1000.0),
    'noise': (0.0, 20.0),
    'seed': (0, 2**32 - 1),
    'duration': (0.01, 20.8),
}
"""Least and greatest value of each option: pictures up to 8K UHD; durations up to the end of the
scenes' paths, 500 frames at 24 Hz."""


@dataclass(frozen=True)
class Options:
    """Options of a scene.

    :param width, height: of the picture [px]; the motion scales with it.
    :param rate: frames per second; the motion in pixels per second is unchanged.
    :param noise: standard deviation of the sensor noise [grey levels].
    :param seed: of all random numbers: texture, noise, and random choices of a scene.
    :param duration: of the part that is played [s].
    """

    width: int = 1280
    height: int = 720
    rate: float = 24.0
    noise: float = 2.5
    seed: int = 0
    duration: float = 20.8

    def __post_init__(self) -> None:
        for name, (low, high) in OPTION_LIMITS.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueError(f'scene option {name}={value}: expected {low} to {high}')

    @property
    def count(self) -> int:
        """The number of frames k with k / rate < duration."""
        return math.ceil(Fraction(str(self.duration)) * Fraction(str(self.rate)))


def parse_options(query: str) -> Options:
    """Return the options of a query such as `width=640&height=480`.

    :raises ValueError: for an unknown name or an invalid value; the message names what was given
        and what is possible.
    """
    kinds = {name: type(low) for name, (low, _) in OPTION_LIMITS.items()}
    values: dict[str, float] = {}
    for part in query.split('&') if query else ():
        name, _, text = part.partition('=')
        if name not in kinds:
            raise ValueError(f'unknown scene option {part!r}: there are {", ".join(kinds)}')
        try:
            values[name] = kinds[name](text)
        except ValueError:
            expected = 'a whole number' if kinds[name] is int else 'a number'
            raise ValueError(f'scene option {part!r}: expected {expected}') from None
    return Options(**values)  # type: ignore[arg-type]
