"""What a person sets: the reference colors, and how a mask becomes blobs."""

from collections.abc import Sequence
from dataclasses import dataclass

from colortrack_ros.detection.lab import lab_from_linear
from colortrack_ros.detection.lab import linear_from_srgb

MAX_COLORS = 254
MAX_TOLERANCE = 200.0
MAX_ELEMENT_SIZE = 99
MAX_THREADS = 64
LAB_RANGES = (('L', 0.0, 100.0), ('a', -128.0, 128.0), ('b', -128.0, 128.0))


def expect(valid: bool, name: str, value: object, expected: str) -> None:
    """Raise ValueError with a reason that names the parameter, the value and the range."""
    if not valid:
        raise ValueError(f'{name} is {value!r}, expected {expected}')


@dataclass(frozen=True)
class ReferenceColor:
    """A color to look for: the pixels with D < tolerance, Pegoretti 2021, (2.1) and (2.2).

    :param name: what the color is called in parameters and messages.
    :param lab: L 0..100, a and b -128..128, true CIELAB (D65).
    :param tolerance: tau, the radius of the sphere around lab [CIELAB units], above 0, at most 200.
    """

    name: str
    lab: tuple[float, float, float]
    tolerance: float = 25.0

    def __post_init__(self) -> None:
        expect(self.name != '', 'colors', self.name, 'a name that is not empty')
        expect(len(self.lab) == 3, f'{self.name}.lab', self.lab, 'three numbers [L, a, b]')
        for (axis, low, high), value in zip(LAB_RANGES, self.lab, strict=True):
            expect(low <= value <= high, f'{self.name}.lab', self.lab, f'{axis} in {low}..{high}')
        expect(
            0 < self.tolerance <= MAX_TOLERANCE,
            f'{self.name}.tolerance',
            self.tolerance,
            f'above 0, at most {MAX_TOLERANCE}',
        )

    @classmethod
    def from_rgb(
        cls, name: str, rgb: Sequence[float], tolerance: float = tolerance
    ) -> 'ReferenceColor':
        """The reference color of an sRGB value.

        :param rgb: red, green, blue, 0..255.
        :raises ValueError: when rgb is out of its range, or as the constructor does.
        """
        valid = len(rgb) == 3 and all(0 <= value <= 255 for value in rgb)
        expect(valid, f'{name}.rgb', tuple(rgb), 'three numbers [r, g, b] in 0..255')
        lightness, a, b = lab_from_linear(linear_from_srgb(rgb)).tolist()
        return cls(name, (lightness, a, b), tolerance)


@dataclass(frozen=True)
class DetectorConfig:
    """How a picture becomes detections.

    :param colors: at least one; a pixel within tolerance of several belongs to the nearest.
    :param min_area: blobs with fewer pixels are dropped [px].
    :param max_area: blobs with more pixels are dropped [px]; by default none.
    :param closing_size: side of the square structuring element of a closing (2.7), first [px],
        odd; 1 leaves the mask as it is. It joins the parts of a striped object.
    :param erosion_size: the same for the erosion (2.4), second [px]. Area, box and centroid are
        those of the eroded mask.
    :param opening_size: the same for an opening (2.6), last [px].
    :param threads: that work on a picture at the same time; 2 help from 1920x1080 on.
    """

    colors: tuple[ReferenceColor, ...] = (ReferenceColor.from_rgb('red', (205, 58, 34), 50.0),)
    min_area: int = 20
    max_area: int = 1_000_000_000
    closing_size: int = 1
    erosion_size: int = 3
    opening_size: int = 1
    threads: int = 1

    def __post_init__(self) -> None:
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
        expect(1 <= self.threads <= MAX_THREADS, 'threads', self.threads, f'1..{MAX_THREADS}')
