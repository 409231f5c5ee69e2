"""The five example videos of Pegoretti 2021, chapter 4: round objects of one plain color.

Points of a path are (x, y, radius): x in widths and y and radius in heights of the picture.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.curves import polyline
from colortrack_ros.scenes.curves import spline
from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.shapes import Ball
from colortrack_ros.scenes.shapes import Cover
from colortrack_ros.scenes.texture import Color
from colortrack_ros.scenes.texture import plaster

COLORS: dict[str, Color] = {'red': (205, 58, 34)}
WALL: Color = (128, 134, 142)
BAR_COLOR: Color = (52, 124, 66)
RADIUS = 0.045
"""Radius of a ball, in heights of the picture. Size and colors are chosen; the document shows
pictures of its videos but gives neither."""


def in_pixels(options: Options, points: ArrayLike) -> NDArray[np.float64]:
    """Return points (n, 3) of (x, y, radius), fractions of the picture, as u, v, radius [px]."""
    scale = np.array([options.width, options.height, options.height], float)
    return np.asarray(points, float) * scale - [0.5, 0.5, 0.0]


def wall(options: Options) -> NDArray[np.uint8]:
    """Return the textured background (H, W, 3), read-only, since scenes of one size share it."""
    return _wall(options.seed, options.height, options.width)


@lru_cache(maxsize=1)
def _wall(seed: int, height: int, width: int) -> NDArray[np.uint8]:
    picture = plaster((seed, 0), height, width, WALL)
    picture.flags.writeable = False
    return picture


def scene_of(
    name: str, options: Options, paths: Sequence[Curve], covers: Sequence[Cover] = ()
) -> Scene:
    """Return a scene of red balls on the paths [px] before the wall."""
    balls = [Ball(path, 'red') for path in paths]
    return Scene(name, options, wall(options), COLORS, balls, covers)


def single(options: Options) -> Scene:
    """Return example 1 (4.1): one object, in the picture from the first frame to the last.

    It rises to the top right corner at 8 s, coming nearer, and rests at the end.
    """
    times = [-1.0, 0.0, 4.0, 8.1, 12.0, 16.0, 19.5, 20.5, 21.5]
    points = [
        (0.08, 0.86, 0.040), (0.10, 0.80, 0.040), (0.42, 0.60, 0.044), (0.86, 0.18, 0.050),
        (0.70, 0.62, 0.056), (0.35, 0.72, 0.060), (0.22, 0.36, 0.060), (0.22, 0.34, 0.060),
        (0.22, 0.34, 0.060),
    ]  # fmt: skip
    return scene_of('single', options, [spline(times, in_pixels(options, points))])


def enter_exit(options: Options) -> Scene:
    """Return example 2 (4.2): one object enters at about 3 s and leaves before the end."""
    times = [2.0, 4.0, 8.0, 12.0, 16.0, 18.5, 20.5, 22.5]
    points = [
        (-0.09, 0.30, RADIUS), (0.10, 0.34, RADIUS), (0.40, 0.72, RADIUS), (0.62, 0.30, RADIUS),
        (0.82, 0.58, RADIUS), (0.92, 0.50, RADIUS), (1.07, 0.42, RADIUS), (1.25, 0.34, RADIUS),
    ]  # fmt: skip
    return scene_of('enter_exit', options, [spline(times, in_pixels(options, points))])


def five(options: Options) -> Scene:
    """Return example 3 (4.3): five objects, one after the other, nearly level, left to right."""
    return scene_of('five', options, _five_paths(options))


def crossing(options: Options) -> Scene:
    """Return example 4 (4.4): two objects on uneven paths that cross; both leave before the end.

    The first passes the crossing point shortly before the second: they come close but never touch.
    """
    first = [
        (-0.12, 0.20, RADIUS), (0.14, 0.22, RADIUS), (0.40, 0.38, RADIUS), (0.58, 0.66, RADIUS),
        (0.82, 0.80, RADIUS), (1.10, 0.72, RADIUS), (1.40, 0.64, RADIUS),
    ]  # fmt: skip
    second = [
        (-0.12, 0.84, RADIUS), (0.16, 0.80, RADIUS), (0.40, 0.66, RADIUS), (0.58, 0.40, RADIUS),
        (0.80, 0.22, RADIUS), (1.10, 0.30, RADIUS), (1.40, 0.38, RADIUS),
    ]  # fmt: skip
    paths = [
        spline([1.5, 4.0, 7.0, 9.6, 12.6, 16.0, 19.4], in_pixels(options, first)),
        spline([4.4, 6.6, 9.0, 11.2, 14.0, 17.6, 21.2], in_pixels(options, second)),
    ]
    return scene_of('crossing', options, paths)


def occlusion(options: Options) -> Scene:
    """Return example 5 (4.5): like five, behind a green bar that hides each for about 0.7 s."""
    left, right = (round(x * options.width) for x in (0.44, 0.57))
    bar = plaster((options.seed, 3), options.height, right - left, BAR_COLOR, 0.4)
    return scene_of('occlusion', options, _five_paths(options), [Cover(0, left, bar)])


def _five_paths(options: Options) -> list[Curve]:
    starts = [1.2, 3.4, 5.3, 7.5, 9.6]
    crossing_times = [9.6, 9.2, 9.8, 9.0, 9.5]
    heights = [(0.30, 0.34), (0.62, 0.56), (0.44, 0.46), (0.80, 0.76), (0.18, 0.24)]
    return [
        polyline(
            [start, start + seconds],
            in_pixels(options, [(-0.03, y0, RADIUS), (1.03, y1, RADIUS)]),
        )
        for start, seconds, (y0, y1) in zip(starts, crossing_times, heights, strict=True)
    ]
