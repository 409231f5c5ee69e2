"""Parameters of color distance: the colors to detect, changing light, and clutter."""

from dataclasses import dataclass

from colortrack_ros.detection.background_model import BackgroundModelConfig
from colortrack_ros.detection.morphology import MorphologyConfig
from colortrack_ros.detection.reference import DEFAULT_COLORS
from colortrack_ros.detection.reference import expect
from colortrack_ros.detection.reference import reference_color_of
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.reference import ReferenceColorConfig
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import named
from colortrack_ros.parameters import parameter

MAX_COLORS = 254
"""Labels are bytes: 0 is no color, and 255 marks a cell whose pixels need an exact test."""
MAX_SMOOTHING = 31
"""Largest side of the square that is averaged [px]. Assumed: wider than most objects."""


def _zero_or_odd(side: int) -> None:
    if side and side % 2 == 0:
        raise ValueError(f'expected 0 or an odd number in 1..{MAX_SMOOTHING}, got {side}')


@dataclass(frozen=True)
class ColorDistanceConfig(BackgroundModelConfig, MorphologyConfig):
    """The colors to detect, and the handling of changing light and clutter.

    A pixel within tolerance of several colors belongs to the nearest. If most pixels of a component
    are also within tolerance of another color, it joins a larger blob of that color next to it.
    """

    colors: tuple[ReferenceColor, ...] = named(
        DEFAULT_COLORS,
        'Names of the reference colors; a detection carries the index into this list.',
        ReferenceColorConfig,
        reference_color_of,
    )
    grow: float = parameter(
        1.0,
        'Of method color: a blob that a pixel within tolerance has started grows by the connected '
        'pixels within grow times the tolerance; 1 for none.',
        limits=(1.0, 10.0),
        audience=EXPERT,
    )
    white_balance: str = parameter(
        'none',
        'Of method color: gray_world keeps the mean of each channel at that of the first frame.',
        choices=('none', 'gray_world'),
    )
    follow_light: float = parameter(
        0.0,
        'Of method color: how far reference colors with a tolerance may follow slow changes of '
        'what is detected; 0 for not at all. Those without one always follow the light.',
        unit='CIELAB units',
        limits=(0.0, 100.0),
    )
    smoothing: int = parameter(
        0,
        'Of method color: side of the square of pixels that are averaged before their color is '
        'looked up, odd; 1 for none; 0 finds it from the noise of the pictures, as the dullest '
        'color without a tolerance needs it, for all colors; if there is no such color, 1.',
        unit='px',
        limits=(0, MAX_SMOOTHING),
        valid=_zero_or_odd,
    )
    moving_only: bool = parameter(
        False,
        'Of method color: whether what stands still is dropped, so that furniture of the '
        'reference colors is not found.',
    )
    threads: int = parameter(
        1,
        'Of method color: threads that work on a picture; 2 help at 3840x2160, with OpenCV 5.',
        limits=(1, 64),
        audience=EXPERT,
    )

    @property
    def erosion_alone(self) -> bool:
        """Whether the erosion is the only step that reads the labels before it."""
        return self.closing_size == self.grow == 1 and not self.moving_only

    @property
    def erodes_at_once(self) -> bool:
        """Whether labels may be eroded while they are made."""
        return self.erosion_alone

    @property
    def of_small_things(self) -> list[int]:
        """The colors without a tolerance, if nothing but the erosion hides small things of them."""
        is_hidden = self.erosion_size > 1 and self.erosion_alone
        return [k for k, color in enumerate(self.colors) if is_hidden and color.is_sought]

    def check(self) -> None:
        """Require 1 to 254 colors with unique names."""
        super().check()
        colors = self.colors
        valid = isinstance(colors, (tuple, list))
        valid = valid and all(isinstance(color, ReferenceColor) for color in colors)
        expect(valid, 'colors', colors, 'a tuple of ReferenceColor')
        names = [color.name for color in self.colors]
        expect(1 <= len(names) <= MAX_COLORS, 'colors', names, f'1 to {MAX_COLORS} names')
        expect(len(set(names)) == len(names), 'colors', names, 'each name once')
