"""Scenes after figures 8 and 11 to 14 of the document Red object: the largest red object.

The document shows pictures of a webcam and gives no numbers. Points of a path are (x, y, radius): x
in widths and y and radius in heights of the picture.
"""

from collections.abc import Sequence

import numpy as np

from colortrack_ros.scenes.curves import arcs
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.curves import polyline
from colortrack_ros.scenes.curves import spline
from colortrack_ros.scenes.curves import to_and_fro
from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.pegoretti import COLORS
from colortrack_ros.scenes.pegoretti import in_pixels
from colortrack_ros.scenes.pegoretti import wall
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.shapes import Ball
from colortrack_ros.scenes.shapes import Cover
from colortrack_ros.scenes.shapes import Prop
from colortrack_ros.scenes.silhouettes import normalized
from colortrack_ros.scenes.silhouettes import Silhouette
from colortrack_ros.scenes.texture import Color
from colortrack_ros.scenes.texture import plaster

BOARD_COLOR: Color = (96, 104, 84)
"""Color of what hides the object; chosen."""

RED_DETAILS = ((0.10, 0.12, 0.012), (0.93, 0.25, 0.016), (0.06, 0.80, 0.014))
"""Places and radii of small red things on the wall, as the document expects; chosen."""

BALL_RADIUS, CLOSE_RADIUS = 0.06, 0.25
"""Radius of the object far away, and right before the camera: there it is 2.5 times as high as the
region of interest, which at 640x480 holds 27 % of it."""

BEHIND_BOARD = 0.5
"""How long the board hides all of the object [s]. Chosen; the document says fast occlusions."""

THROW_SECONDS = 1.6
"""Duration of a throw [s]; chosen."""


def red_object(options: Options) -> Scene:
    """Return one object that is moved around, and held close to the camera (figure 11)."""
    times = [-1.0, 0.0, 3.0, 6.0, 8.0, 10.0, 12.5, 15.0, 18.0, 21.0, 22.0]
    size = [BALL_RADIUS, 0.16, CLOSE_RADIUS, 0.12, 0.08, 0.10]
    points = [
        (0.20, 0.70, size[0]), (0.25, 0.60, size[0]), (0.70, 0.30, size[0]), (0.55, 0.50, size[1]),
        (0.45, 0.52, size[2]), (0.60, 0.46, size[2]), (0.40, 0.40, size[3]), (0.25, 0.60, size[0]),
        (0.70, 0.70, size[4]), (0.60, 0.40, size[5]), (0.55, 0.35, size[5]),
    ]  # fmt: skip
    return _with_details('red_object', options, [_ball(spline(times, in_pixels(options, points)))])


def red_pair(options: Options) -> Scene:
    """Return two objects, the larger one tall and the smaller one wide (figures 8 and 9).

    The larger one is the first. The row sums peak at the wide one, the column sums at the tall one,
    and the two pass each other at a distance.
    """
    tall = _rectangle(options, [(0.22, 0.60), (0.30, 0.40), (0.22, 0.45), (0.28, 0.60)], 0.6, 2.2)
    wide = _rectangle(options, [(0.70, 0.80), (0.60, 0.25), (0.72, 0.30), (0.62, 0.78)], 2.4, 0.4)
    return _with_details('red_pair', options, [tall, wide])


def red_hidden(options: Options) -> Scene:
    """Return one object on straight paths that a board hides for half a second (figures 12, 13)."""
    way, turn, rows = 2.6, 0.9, (0.32, 0.68)
    ends = in_pixels(options, [(0.15, rows[0], BALL_RADIUS), (0.85, rows[1], BALL_RADIUS)])
    path = to_and_fro(-0.5, ends, way, turn, 7)
    speed = 0.7 * options.width / way
    return _hiding('red_hidden', options, path, speed)


def red_throw(options: Options) -> Scene:
    """Return one object that is thrown back and forth, and hidden at the top of its path (13).

    It is uniformly accelerated, as the document's model says.
    """
    ends = in_pixels(options, [(0.15, 0.75, BALL_RADIUS), (0.85, 0.75, BALL_RADIUS)])
    times = np.arange(-0.5, 22.0, THROW_SECONDS)
    points = [ends[n % 2] for n in range(len(times))]
    fall = [0.0, 8 * 0.55 * options.height / THROW_SECONDS**2, 0.0]
    speed = 0.7 * options.width / THROW_SECONDS
    return _hiding('red_throw', options, arcs(times, points, fall), speed)


def red_curve(options: Options) -> Scene:
    """Return one object that is moved in loops, always visible (figure 14)."""
    loop = [(0.50, 0.22), (0.72, 0.36), (0.74, 0.62), (0.50, 0.78), (0.28, 0.62), (0.30, 0.36)]
    points = [(*loop[n % len(loop)], BALL_RADIUS) for n in range(70)]
    path = spline(np.arange(-1.0, 34.0, 0.5)[: len(points)], in_pixels(options, points))
    return _with_details('red_curve', options, [_ball(path)])


def _ball(path: Curve) -> Ball:
    return Ball(path, 'red')


def _rectangle(
    options: Options, places: Sequence[tuple[float, float]], width: float, height: float
) -> Silhouette:
    """Return a red rectangle that is moved from place to place, sides in tenths of the height."""
    corners = [(-width, -height), (width, -height), (width, height), (-width, height)]
    outline, _, scale = normalized(corners)
    path = polyline(
        np.linspace(-0.5, 22.0, len(places)),
        in_pixels(options, [(*place, 0.1 * scale) for place in places]),
    )
    return Silhouette(path, 'red', outline=outline)


def _board(options: Options, speed: float) -> Cover:
    """Return the board that hides an object passing the middle at that speed [px/s]."""
    half = BALL_RADIUS * options.height + speed * BEHIND_BOARD / 2
    left, right = (round(options.width / 2 + side * half) for side in (-1, 1))
    left, right = max(left, 0), min(right, options.width)
    picture = plaster((options.seed, 30), options.height, right - left, BOARD_COLOR)
    return Cover(0, left, picture)


def _hiding(name: str, options: Options, path: Curve, speed: float) -> Scene:
    """Return a scene of one object behind a board that it passes at that speed [px/s]."""
    return Scene(name, options, wall(options), COLORS, [_ball(path)], [_board(options, speed)])


def _with_details(name: str, options: Options, objects: Sequence[Ball]) -> Scene:
    """Return a scene of red objects before a wall with small red details."""
    x, y, radius = in_pixels(options, RED_DETAILS).T
    details = [
        Prop(polyline([0.0, 1.0], [(u, v, r), (u, v, r)]), COLORS['red'], round=True)
        for u, v, r in zip(x, y, radius, strict=True)
    ]
    return Scene(name, options, wall(options), COLORS, [*details, *objects])
