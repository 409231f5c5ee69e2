"""What a person sets: what to look for, and how a mask becomes blobs."""

from collections.abc import Collection
from dataclasses import dataclass

from colortrack_ros.detection.background import SUBTRACTORS
from colortrack_ros.detection.channel_difference import CHANNELS
from colortrack_ros.detection.methods import METHODS
from colortrack_ros.detection.reference import expect
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.regions import Region
from colortrack_ros.detection.shape import MEASURES

MAX_COLORS = 254
MAX_ELEMENT_SIZE = 99

CHOICES: dict[str, Collection[str]] = {
    'method': METHODS,
    'white_balance': ('none', 'gray_world'),
    'channel': CHANNELS,
    'background_model': ('median', *SUBTRACTORS),
}
RANGES: dict[str, tuple[float, float]] = {
    'grow': (1.0, 10.0),
    'follow_light': (0.0, 100.0),
    **dict.fromkeys(MEASURES, (0.0, 1.0)),
    'channel_threshold': (0, 254),
    'difference_threshold': (0.0, 254.0),
    'blur_sigma': (0.0, 50.0),
    'learn_seconds': (0.0, 3600.0),
    'threads': (1, 64),
}
"""Least and greatest value of parameters that stand for themselves."""


@dataclass(frozen=True)
class DetectorConfig:
    """How a picture becomes detections.

    :param method: color, channel_difference or background.
    :param colors: at least one; a pixel within tolerance of several belongs to the nearest.
    :param grow: of color: how many times the tolerance of the pixels that a blob grows by, once a
        pixel within tolerance has started it; 1 for none.
    :param white_balance: of color: none, or gray_world, which keeps the mean of each channel at
        what it was in the first frame.
    :param follow_light: of color: how far the reference colors may follow slow changes of what is
        found [CIELAB units], 0 for not at all.
    :param min_area: blobs with fewer pixels are dropped [px].
    :param max_area: blobs with more pixels are dropped [px]; by default none.
    :param closing_size: side of the square structuring element of a closing (2.7), first [px],
        odd; 1 leaves the mask as it is. It joins the parts of a striped object.
    :param erosion_size: the same for the erosion (2.4), second [px]. Area, box and centroid are
        those of the eroded mask.
    :param opening_size: the same for an opening (2.6), last [px].
    :param split: cut blobs of touching objects at their necks.
    :param min_aspect: least ratio of a blob's minor to its major axis, 0..1.
    :param min_extent: least ratio of its area to that of its box, 0..1.
    :param min_circularity: least likeness to a disc, 0..1; a ball is above 0.9.
    :param min_solidity: least ratio of its area to that of its convex hull, 0..1.
    :param regions: polygons to look in and to ignore.
    :param mask: path of a picture that is dark where not to look; empty for none.
    :param channel: of channel_difference: red, green or blue, from which the others are taken.
    :param channel_threshold: of channel_difference: what has to be left of it [levels].
    :param background_model: of background: median, mog2 or knn.
    :param moving_only: of color: drop pixels that are like the learned background, so that clutter
        of the reference colors that stands still is not found.
    :param difference_threshold: a pixel moves when it differs from the background by more, in the
        mean of the channels [levels]; of moving_only and the median background.
    :param blur_sigma: of background: of the Gaussian before the threshold [px], 0 for none.
    :param learn_seconds: how long what moves is taken out of a new background [s].
    :param threads: that work on a picture at the same time; 2 help at 3840x2160, with OpenCV 5.
    """

    method: str = 'color'
    colors: tuple[ReferenceColor, ...] = (ReferenceColor.from_rgb('red', (205, 58, 34), 50.0),)
    grow: float = 1.0
    white_balance: str = 'none'
    follow_light: float = 0.0
    min_area: int = 20
    max_area: int = 1_000_000_000
    closing_size: int = 1
    erosion_size: int = 3
    opening_size: int = 1
    split: bool = False
    min_aspect: float = 0.0
    min_extent: float = 0.0
    min_circularity: float = 0.0
    min_solidity: float = 0.0
    regions: tuple[Region, ...] = ()
    mask: str = ''
    channel: str = 'red'
    channel_threshold: int = 60
    background_model: str = 'median'
    moving_only: bool = False
    difference_threshold: float = 8.0
    blur_sigma: float = 1.5
    learn_seconds: float = 1.0
    threads: int = 1

    def __post_init__(self) -> None:
        for name, choices in CHOICES.items():
            value = getattr(self, name)
            expect(value in choices, name, value, f'one of {", ".join(choices)}')
        for name, (low, high) in RANGES.items():
            value = getattr(self, name)
            expect(low <= value <= high, name, value, f'{low}..{high}')
        names = [color.name for color in self.colors]
        expect(1 <= len(names) <= MAX_COLORS, 'colors', names, f'1 to {MAX_COLORS} names')
        expect(len(set(names)) == len(names), 'colors', names, 'each name once')
        expect(self.min_area >= 1, 'min_area', self.min_area, 'at least 1 px')
        least = f'at least min_area, {self.min_area} px'
        expect(self.max_area >= self.min_area, 'max_area', self.max_area, least)
        for name in ('closing_size', 'erosion_size', 'opening_size'):
            size = getattr(self, name)
            valid = 1 <= size <= MAX_ELEMENT_SIZE and size % 2 == 1
            expect(valid, name, size, f'an odd number in 1..{MAX_ELEMENT_SIZE}')
