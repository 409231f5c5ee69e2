"""Reference colors: the colors to detect."""

from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import replace
from numbers import Real

import numpy as np

from colortrack_ros.detection.lab import lab_from_linear
from colortrack_ros.detection.lab import linear_from_srgb
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.presets import PRESETS
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

MAX_AREA = 1_000_000_000
"""No limit: more pixels than any picture has."""

MAX_TOLERANCE = 200.0
"""Largest tolerance [CIELAB units]: black and white are 100 apart; blue and green, the extremes of
sRGB, 259."""

MOST_SAMPLES_GIVEN = 256
"""Largest number of samples, or of others: a node's table takes 20 ms for each, and what is taught
has at most 64."""

LAB_RANGES = (('L', 0.0, 100.0), ('a', -128.0, 128.0), ('b', -128.0, 128.0))
"""Axes of CIELAB with their limits, which include all of sRGB."""


def expect(valid: bool, name: str, value: object, expected: str) -> None:
    """Raise ValueError naming the parameter, the value and the range, unless valid."""
    if not valid:
        raise ValueError(f'{name}: expected {expected}, got {value!r}')


def _triples(given: object) -> tuple[Triple, ...] | None:
    """Rows of three numbers as tuples, which can be compared and hashed; None of something else.

    :param given: (N, 3), in lists, tuples, or an array.
    """
    try:
        rows = np.asarray(given)
    except ValueError:  # they differ in length
        return None
    if rows.shape != (0,) and (rows.shape[1:] != (3,) or rows.dtype.kind not in 'iuf'):
        return None
    return tuple(map(tuple, rows.astype(float).tolist()))


def _are_fractions(rgb: Sequence[float]) -> bool:
    """Whether values seem to be fractions of one: nobody means parts of the darkest shades."""
    return max(rgb, default=0) <= 1 and any(value % 1 for value in rgb)


@dataclass(frozen=True)
class ReferenceColor:
    """A color to detect: the pixels with D < tolerance, Pegoretti 2021, (2.1) and (2.2).

    :param name: used in parameters and messages.
    :param lab: L 0..100, a and b -128..128, true CIELAB (D65).
    :param tolerance: tau, the radius of the sphere around lab [CIELAB units], at most 200; 0 to
        estimate from the pictures how far the color extends.
    :param tolerance_lab: half axes [dL, da, db] of an ellipsoid around lab, in place of the sphere
        [CIELAB units], each above 0, at most 200: a wide dL with narrow da, db covers both the
        light and the dark side of an object.
    :param samples: more colors that belong to it, as lab: the nearest counts.
    :param others: colors that do not belong to it, as lab: pixels nearer to one of them are
        excluded.
    :param preset: a key of PRESETS, if lab is just what is meant by that name: which color of this
        name the pictures show is found with the tolerance.
    :param inverted: detect everything that is neither this color nor one that is not inverted:
        objects on a cloth, a table or a lawn.
    :param min_area, max_area: range of the area of its blobs [px]; 0 for the detector's limits.
    """

    name: str
    lab: Triple
    tolerance: float = 0.0
    tolerance_lab: Triple | None = None
    samples: tuple[Triple, ...] = ()
    others: tuple[Triple, ...] = ()
    inverted: bool = False
    min_area: int = 0
    max_area: int = 0
    preset: str = ''

    def __post_init__(self) -> None:
        expect(self.name != '', 'colors', self.name, 'a name that is not empty')
        name = f'{self.name}.lab'
        self._keep('lab', 'three numbers [L, a, b]')
        for (axis, low, high), value in zip(LAB_RANGES, self.lab, strict=True):
            expect(low <= value <= high, name, self.lab, f'{axis} in {low}..{high}')
        known = self.preset in ('', *PRESETS)
        expect(known, f'{self.name}.preset', self.preset, f'one of {", ".join(PRESETS)}')
        limits = f'above 0, at most {MAX_TOLERANCE}'
        found = f'{limits}, or 0 to find it in the picture'
        valid = isinstance(self.tolerance, Real) and 0 <= self.tolerance <= MAX_TOLERANCE
        expect(valid, f'{self.name}.tolerance', self.tolerance, found)
        for field in ('samples', 'others'):
            self._keep(field, 'rows of three numbers [L, a, b]', many=True)
        if self.is_sought:
            return
        limits = f'three numbers [dL, da, db], each {limits}'
        if self.tolerance_lab is not None:
            self._keep('tolerance_lab', limits)
        valid = all(0 < axis <= MAX_TOLERANCE for axis in self.axes)
        expect(valid, f'{self.name}.tolerance_lab', self.tolerance_lab, limits)
        if self.tolerance == 0:
            object.__setattr__(self, 'tolerance', max(self.axes))

    def _keep(self, field: str, expected: str, *, many: bool = False) -> None:
        """Keep three numbers, or rows of them, as tuples.

        :raises ValueError: the field is something else.
        """
        given = getattr(self, field)
        triples = _triples(given if many else [given])
        expect(triples is not None, f'{self.name}.{field}', given, expected)
        object.__setattr__(self, field, triples if many or not triples else triples[0])

    @property
    def is_sought(self) -> bool:
        """Whether its tolerance is to be estimated from the pictures."""
        return self.tolerance == 0 and self.tolerance_lab is None

    @property
    def is_sampled(self) -> bool:
        """Whether samples or others help to define it."""
        return bool(self.samples or self.others)

    @property
    def axes(self) -> Triple:
        """Half axes of the tolerance ellipsoid around lab [CIELAB units]."""
        return self.tolerance_lab or (self.tolerance, self.tolerance, self.tolerance)

    def grown(self, factor: float) -> 'ReferenceColor':
        """The color with a larger tolerance; inverted colors are not changed."""
        if self.inverted:
            return self
        first, second, third = (min(factor * axis, MAX_TOLERANCE) for axis in self.axes)
        tolerance = min(factor * self.tolerance, MAX_TOLERANCE)
        return replace(self, tolerance=tolerance, tolerance_lab=(first, second, third))

    @classmethod
    def from_rgb(
        cls,
        name: str,
        rgb: Sequence[float],
        tolerance: float = tolerance,
        tolerance_lab: Triple | None = None,
    ) -> 'ReferenceColor':
        """The reference color of an sRGB value.

        :param rgb: red, green, blue, 0..255.
        :raises ValueError: if rgb is out of range or in fractions of one, or for the reasons of the
            constructor.
        """
        expected = 'three numbers [r, g, b] in 0..255'
        valid = _triples([rgb]) is not None and all(0 <= value <= 255 for value in rgb)
        expect(valid, f'{name}.rgb', rgb, expected)
        expect(not _are_fractions(rgb), f'{name}.rgb', tuple(rgb), f'{expected}, not in 0..1')
        lightness, a, b = lab_from_linear(linear_from_srgb(rgb)).tolist()
        return cls(name, (lightness, a, b), tolerance, tolerance_lab)

    @classmethod
    def from_preset(cls, name: str, preset: str) -> 'ReferenceColor':
        """The color of a common name that the pictures show, as far as it extends there.

        :param preset: a key of PRESETS.
        :raises ValueError: if there is no such preset.
        """
        expect(preset in PRESETS, f'{name}.preset', preset, f'one of {", ".join(PRESETS)}')
        return cls(name, PRESETS[preset][0], preset=preset)


DEFAULT_COLORS = (ReferenceColor.from_preset('red', 'red'),)
"""The balls of the built-in scenes, or whatever else is red."""


@dataclass(frozen=True)
class ReferenceColorConfig(Config):
    """Parameters of each NAME in ``colors``: lab, rgb, preset or samples, and a tolerance."""

    others: tuple[float, ...] = parameter(
        float,
        'Colors that are not it, [r1, g1, b1, r2, g2, b2, ...], sRGB, 0..255: what is nearer to '
        'one of them than to it is not it.',
        limits=(0.0, 255.0),
    )
    samples: tuple[float, ...] = parameter(
        float,
        'Colors that are it, as others; beside lab, rgb or preset, or in place of them.',
        limits=(0.0, 255.0),
    )

    inverted: bool = parameter(
        False,
        'True: everything that is not this color, or another of the list, is looked for, such as '
        'what lies on a table.',
    )
    lab: Triple = parameter(
        float, 'The reference color [L, a, b] in CIELAB (D65); or give rgb or preset.'
    )
    rgb: Triple = parameter(
        float, 'The reference color [r, g, b], sRGB, 0..255; or give lab or preset.'
    )
    preset: str = parameter(
        '',
        'The reference color by its common name: without a tolerance, the one of this name that '
        'the pictures show most. A NAME that is one of these needs nothing else.',
        choices=('', *PRESETS),
    )
    tolerance_lab: Triple = parameter(
        float,
        'Half axes [dL, da, db] of an ellipsoid in place of the sphere of radius tolerance.',
        unit='CIELAB units',
        limits=(0.0, MAX_TOLERANCE),
        audience=EXPERT,
    )
    min_area: int = parameter(
        0,
        'Blobs of this color with fewer pixels are dropped; 0: min_area of the detector.',
        unit='px',
        limits=(0, MAX_AREA),
    )
    max_area: int = parameter(
        0,
        'Blobs of this color with more pixels are dropped; 0: max_area of the detector.',
        unit='px',
        limits=(0, MAX_AREA),
    )
    tolerance: float = parameter(
        0.0,
        'Pixels closer than this to the reference color belong to it; 0 finds in the pictures '
        'where the color ends and others begin, and the least area of its blobs.',
        unit='CIELAB units',
        limits=(0.0, MAX_TOLERANCE),
    )


def reference_color_of(name: str, config: ReferenceColorConfig) -> ReferenceColor:
    """The color described by the parameters of a NAME, which may be a common name itself.

    :raises ValueError: if none or several of lab, rgb and preset are given, or one is out of range.
    """
    samples = _labs_of(f'{name}.samples', config.samples)
    others = _labs_of(f'{name}.others', config.others)
    if samples and not (config.lab or config.rgb or config.preset):
        color = ReferenceColor(name, samples[0], config.tolerance, config.tolerance_lab or None)
        samples = samples[1:]
    else:
        color = _shade_of(name, config)
    return replace(
        color,
        samples=samples,
        others=others,
        inverted=config.inverted,
        min_area=config.min_area,
        max_area=config.max_area,
    )


def _labs_of(name: str, rgb: tuple[float, ...]) -> tuple[Triple, ...]:
    """Convert a flat list of RGB colors to CIELAB."""
    expect(len(rgb) % 3 == 0, name, len(rgb), 'r, g, b of each color, three numbers each')
    most = f'at most {MOST_SAMPLES_GIVEN} colors'
    expect(len(rgb) <= 3 * MOST_SAMPLES_GIVEN, name, len(rgb) // 3, most)
    expect(not _are_fractions(rgb), name, rgb, 'r, g, b in 0..255, not in 0..1')
    lab = lab_from_linear(linear_from_srgb(np.array(rgb).reshape(-1, 3)))
    return tuple((L, a, b) for L, a, b in lab.tolist())


def _shade_of(name: str, config: ReferenceColorConfig) -> ReferenceColor:
    """The color without its samples."""
    given = [key for key in ('lab', 'rgb', 'preset') if getattr(config, key)]
    one = f'one of {name}.lab, {name}.rgb and {name}.preset'
    if len(given) > 1:
        raise ValueError(f'{name}: expected {one}, got {" and ".join(given)}')
    axes = config.tolerance_lab or None
    if config.lab:
        return ReferenceColor(name, config.lab, config.tolerance, axes)
    if config.rgb:
        return ReferenceColor.from_rgb(name, config.rgb, config.tolerance, axes)
    if config.preset or name in PRESETS:
        color = ReferenceColor.from_preset(name, config.preset or name)
        is_fixed = axes or config.tolerance
        return ReferenceColor(name, color.lab, config.tolerance, axes) if is_fixed else color
    names = ', '.join(PRESETS)
    raise ValueError(f'{name}: expected {one}, got none of them, and {name} is none of {names}')


def apart_from(colors: Sequence[ReferenceColor], k: int) -> list[Triple]:
    """All colors but one, which other objects have."""
    return [color.lab for j, color in enumerate(colors) if j != k]
