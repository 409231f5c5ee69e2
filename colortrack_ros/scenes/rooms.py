"""Scenes on which detectors fail: rooms full of similar colors, changing light, fast small balls.

Points of a path are (x, y, radius): x in widths and y and radius in heights of the picture.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.scenes.curves import arcs
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.curves import polyline
from colortrack_ros.scenes.curves import spline
from colortrack_ros.scenes.harder import SKIN
from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.pegoretti import COLORS
from colortrack_ros.scenes.pegoretti import in_pixels
from colortrack_ros.scenes.pegoretti import wall
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.shapes import Ball
from colortrack_ros.scenes.shapes import Prop
from colortrack_ros.scenes.texture import Color
from colortrack_ros.scenes.texture import plaster

THREE_COLORS: dict[str, Color] = {**COLORS, 'yellow': (214, 170, 40), 'blue': (38, 84, 176)}

WOOD, CARPET, PAINT, CLOTH = (200, 160, 56), (192, 62, 42), (46, 88, 164), (42, 86, 170)
"""Colors of the room, close to the balls' yellow, red, blue and blue."""

ROOM_FLOOR, FRAME, CREAM = (104, 96, 90), (58, 52, 48), (196, 186, 170)
TROUSERS, HAIR = (56, 56, 62), (52, 42, 38)
"""Colors of the rest, chosen: 54 CIELAB units and more from those of the balls."""

FURNITURE: list[tuple[float, float, float, float, Color]] = [
    (0.00, 0.72, 1.00, 1.00, ROOM_FLOOR),
    (0.04, 0.18, 0.17, 0.74, FRAME), (0.05, 0.20, 0.16, 0.74, WOOD),
    (0.07, 0.25, 0.14, 0.42, (184, 146, 50)), (0.07, 0.48, 0.14, 0.68, (184, 146, 50)),
    (0.145, 0.45, 0.152, 0.48, FRAME),
    (0.32, 0.87, 0.76, 0.98, CARPET), (0.34, 0.89, 0.74, 0.90, CREAM),
    (0.34, 0.95, 0.74, 0.96, CREAM),
    (0.28, 0.08, 0.40, 0.30, FRAME), (0.29, 0.10, 0.39, 0.28, PAINT),
    (0.29, 0.22, 0.39, 0.28, CREAM), (0.35, 0.12, 0.375, 0.16, WOOD),
    (0.54, 0.10, 0.64, 0.30, FRAME), (0.55, 0.12, 0.63, 0.28, CREAM),
    (0.56, 0.14, 0.59, 0.22, CARPET), (0.595, 0.18, 0.62, 0.26, PAINT),
    (0.78, 0.07, 0.93, 0.27, FRAME), (0.79, 0.09, 0.92, 0.25, WOOD),
    (0.81, 0.12, 0.85, 0.20, PAINT), (0.87, 0.14, 0.90, 0.23, CARPET),
]  # fmt: skip
"""Left, top, right, bottom and color of floor, door, carpet and three pictures, far to near."""


def clutter(options: Options) -> Scene:
    """Return balls of three colors thrown through a room full of similar colors.

    Nine throws, up to three balls at a time, bouncing on the floor. A wooden door (yellow), a
    carpet (red) and the pictures on the wall (all three) are within 15 CIELAB units of the balls'
    colors; a person in a blue pullover walks back and forth behind the balls.
    """
    background = wall(options).copy()
    for i, (left, top, right, bottom, color) in enumerate(FURNITURE):
        rows = slice(round(top * options.height), round(bottom * options.height))
        columns = slice(round(left * options.width), round(right * options.width))
        size = rows.stop - rows.start, columns.stop - columns.start
        background[rows, columns] = plaster((options.seed, 10, i), *size, color, 0.5)
    balls = []
    for wave in range(3):
        for i, name in enumerate(THREE_COLORS):
            start, high = 0.4 + 6.4 * wave + 1.5 * i, 0.42 + 0.05 * wave
            way = [(-0.03, high), (0.22, 0.80), (0.55, 0.80), (0.82, 0.80), (1.03, 0.55)]
            if (i + wave) % 2:
                way = [(1 - x, y) for x, y in way]
            times = [start, start + 0.85, start + 1.95, start + 2.85, start + 3.55]
            balls.append(Ball(_bouncing(options, times, way, 0.03, 2.4), name))
    things: list[Ball | Prop] = [*_person(options), *balls]
    return Scene('clutter', options, background, THREE_COLORS, things, exposure=0.3)


def light(options: Options) -> Scene:
    """Return three red balls that roll back and forth while the light fades and turns yellow.

    From 2 s to 16 s all pixel values fall to a third: red to 0.42, green to 0.34, blue to 0.16.
    """
    seconds = np.arange(-1.0, 25.0, 3.0)
    balls: list[Ball] = []
    for i, (y, radius) in enumerate([(0.2, 0.045), (0.5, 0.05), (0.8, 0.055)]):
        turns = [(0.12 if (n + i) % 2 else 0.88, y + 0.04 * (n % 3 - 1), radius) for n in range(9)]
        balls.append(Ball(spline(seconds + 0.7 * i, in_pixels(options, turns)), 'red'))
    dim = (0.16, 0.34, 0.42)
    fade = polyline([-1.0, 2.0, 16.0, 17.0], [(1.0, 1.0, 1.0), (1.0, 1.0, 1.0), dim, dim])
    return Scene('light', options, wall(options), COLORS, balls, light=fade)


def fast(options: Options) -> Scene:
    """Return ten small red balls that bounce through the picture, two at a time.

    They move two diameters a frame, and motion blur extends each by about one.
    """
    balls = []
    for i in range(10):
        start, floor = 0.3 + 1.9 * i, 0.82 + 0.12 * (i % 2)
        way = [(-0.02, 0.30), (0.30, floor), (0.80, floor), (1.02, floor - 0.25)]
        if i % 3 == 1:
            way = [(1 - x, y) for x, y in way]
        times = [start, start + 0.65, start + 1.66, start + 2.10]
        balls.append(Ball(_bouncing(options, times, way, 0.011, 2.2), 'red'))
    return Scene('fast', options, wall(options), COLORS, balls, exposure=0.4)


def _bouncing(
    options: Options,
    times: Sequence[float],
    way: Sequence[tuple[float, float]],
    radius: float,
    gravity: float,
) -> Curve:
    """Return the path of a ball that falls freely from each point to the next.

    :param gravity: in heights of the picture per second squared.
    """
    points = in_pixels(options, [(x, y, radius) for x, y in way])
    return arcs(times, points, [0.0, gravity * options.height, 0.0])


def _person(options: Options) -> list[Prop]:
    """Return a walking person: legs, pullover, head and hair."""
    seconds = np.arange(-1.0, 25.0, 0.4)
    way = np.abs((seconds / 7.0) % 2 - 1)  # from 1 to 0 and back in 14 s
    x = 0.30 + 0.55 * way * way * (3 - 2 * way)
    step = np.where(np.arange(len(seconds)) % 2, 0.018, -0.018)

    def part(shift: NDArray | float, y: float, half_width: float, half_height: float) -> Curve:
        columns = np.broadcast_arrays(x + shift, y, half_width, half_height)
        scale = [options.width, *3 * [options.height]]
        return spline(seconds, np.stack(columns, axis=1) * scale - [0.5, 0.5, 0, 0])

    return [
        Prop(part(step, 0.78, 0.028, 0.13), TROUSERS),
        Prop(part(-step, 0.78, 0.028, 0.13), TROUSERS),
        Prop(part(0.0, 0.54, 0.075, 0.14), CLOTH),
        Prop(part(0.0, 0.325, 0.058, 0.058), HAIR, round=True),
        Prop(part(0.004, 0.345, 0.050, 0.050), SKIN, round=True),
    ]
